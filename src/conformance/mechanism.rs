//! Laws of a [`Mechanism`].

use nalgebra::{DVector, Vector6};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::{Violation, violation};
use crate::conditions::Conditions;
use crate::mechanism::{Linearization, Mechanism, MotionBlock, Workspace, characteristic_length, consistent};
use crate::pose::Pose;

const POSES: usize = 20;
/// Step of central differences, m and rad.
pub(super) const STEP: f64 = 1e-6;
/// Names of the six small motions.
pub(super) const MOTIONS: [&str; 6] = ["δt x", "δt y", "δt z", "δω x", "δω y", "δω z"];
/// Agreement of an analytic with a numeric derivative, relative to the larger of its size and one.
const AGREES: f64 = 1e-6;

/// Checks a mechanism over a workspace.
///
/// * specifications, values and sizes agree, names are unique;
/// * the coordinates that it controls are reached, and the others follow;
/// * forward kinematics undoes inverse kinematics, and gives the same bits twice;
/// * the closure residual is zero there, and `J₁`, `J₂` and `∂f/∂h` agree with central differences;
/// * the motion block agrees with central differences of forward kinematics, parameter by parameter;
/// * joints that are not numbers, or far out of reach, give an error and never a pose.
///
/// # Errors
/// The first [`Violation`].
pub fn mechanism(m: &dyn Mechanism, workspace: &Workspace) -> Result<(), Violation> {
    sizes(m)?;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..POSES {
        let pose = reachable(m, &workspace.random(&mut rng))?;
        let joints = round_trip(m, &pose)?;
        closure_derivatives(m, &pose, &joints)?;
        motion_blocks(m, &pose, &joints)?;
    }
    refusals(m)
}

fn sizes(m: &dyn Mechanism) -> Result<(), Violation> {
    const LAW: &str = "specifications and values agree";
    let (specs, values) = (m.parameters(), m.values());
    if specs.len() != values.len() {
        return Err(violation(LAW, format!("{} specifications, {} values", specs.len(), values.len())));
    }
    if m.equations() < 6 {
        return Err(violation(
            LAW,
            format!("{} closure equations cannot hold a platform; state structural rows", m.equations()),
        ));
    }
    for (k, (spec, value)) in specs.iter().zip(values).enumerate() {
        if specs[..k].iter().any(|s| s.name == spec.name) {
            return Err(violation(LAW, format!("two parameters are called {}", spec.name)));
        }
        if !value.is_finite() {
            return Err(violation(LAW, format!("{} is {value}", spec.name)));
        }
    }
    let again =
        m.with_values(values, m.home()).map_err(|e| violation(LAW, format!("its own values are refused: {e}")))?;
    if again.values() != values {
        return Err(violation(LAW, "with_values changes the values"));
    }
    let elsewhere = m.home().moved(&Vector6::new(1e-3, -2e-3, 1e-3, 1e-3, 2e-3, -1e-3));
    let moved =
        m.with_values(values, elsewhere).map_err(|e| violation(LAW, format!("another home is refused: {e}")))?;
    if elsewhere.motion_to(&moved.home()).amax() > 1e-12 {
        return Err(violation(LAW, "with_values does not take the home that it is given"));
    }
    if m.joints().is_empty() {
        return Err(violation(LAW, "there is no joint"));
    }
    Ok(())
}

/// The pose with the coordinates that the joints do not control where the closure puts them.
fn reachable(m: &dyn Mechanism, pose: &Pose) -> Result<Pose, Violation> {
    let failed = |e| violation("a pose of the workspace can be taken", format!("{}: {e}", shown(pose)));
    let (taken, _) = consistent(m, m.values(), pose, &Conditions::unknown()).map_err(failed)?;
    let (wanted, found) = (pose.coordinates(), taken.coordinates());
    for k in (0..6).filter(|k| m.controlled()[*k]) {
        if !((wanted[k] - found[k]).abs() <= 1e-9) {
            let name = ["x", "y", "z", "alpha", "beta", "gamma"][k];
            let detail = format!("{name} is {:.9} instead of {:.9} at {}", found[k], wanted[k], shown(pose));
            return Err(violation("controlled coordinates are reached", detail));
        }
    }
    Ok(taken)
}

fn round_trip(m: &dyn Mechanism, pose: &Pose) -> Result<Vec<f64>, Violation> {
    const LAW: &str = "forward kinematics undoes inverse kinematics";
    let at = Conditions::unknown();
    let c = m.values();
    let joints = m.inverse(c, pose, &at).map_err(|e| violation(LAW, format!("{}: {e}", shown(pose))))?;
    if joints.len() != m.joints().len() {
        return Err(violation(LAW, format!("{} joints, {} specifications", joints.len(), m.joints().len())));
    }
    let forward = || m.forward(c, &joints, &at, &m.home()).map_err(|e| violation(LAW, format!("{}: {e}", shown(pose))));
    let (back, again) = (forward()?, forward()?);
    let error = pose.motion_to(&back).amax();
    if !(error <= 1e-9 * characteristic_length(m).max(1.0)) {
        return Err(violation(LAW, format!("{} comes back {error:.3e} away", shown(pose))));
    }
    if back != again {
        return Err(violation("the same input gives the same bits", shown(pose)));
    }
    Ok(joints)
}

fn closure_derivatives(m: &dyn Mechanism, pose: &Pose, joints: &[f64]) -> Result<(), Violation> {
    let at = Conditions::unknown();
    let c = m.values();
    let mut here = Linearization::sized_for(m);
    m.linearize(c, joints, pose, &at, &mut here);
    let scale = characteristic_length(m).max(1.0);
    if !(here.residual.amax() <= 1e-9 * scale * here.motion.amax().max(1.0)) {
        let detail = format!("{}: residual {:.3e}", shown(pose), here.residual.amax());
        return Err(violation("the closure is zero at the joints of a pose", detail));
    }
    let mut work = here.clone();
    let mut residual = |c: &[f64], joints: &[f64], pose: &Pose| -> DVector<f64> {
        m.linearize(c, joints, pose, &at, &mut work);
        work.residual.clone()
    };
    for k in 0..6 {
        let mut d = Vector6::zeros();
        d[k] = STEP;
        let numeric = (residual(c, joints, &pose.moved(&d)) - residual(c, joints, &pose.moved(&-d))) / (2.0 * STEP);
        let name = MOTIONS[k];
        compare("J1 agrees with differences", name, pose, &here.motion.column(k).into_owned(), &numeric)?;
    }
    for (k, spec) in m.parameters().iter().enumerate() {
        let numeric = differences(c, k, |c| residual(c, joints, pose));
        compare("J2 agrees with differences", &spec.name, pose, &here.parameters.column(k).into_owned(), &numeric)?;
    }
    for (k, spec) in m.joints().iter().enumerate() {
        let numeric = differences(joints, k, |joints| residual(c, joints, pose));
        compare("df/dh agrees with differences", &spec.name, pose, &here.joints.column(k).into_owned(), &numeric)?;
    }
    Ok(())
}

fn motion_blocks(m: &dyn Mechanism, pose: &Pose, joints: &[f64]) -> Result<(), Violation> {
    let at = Conditions::unknown();
    let c = m.values();
    let mut block = MotionBlock::sized_for(m);
    m.motion_block(c, joints, pose, &at, &mut block)
        .map_err(|e| violation("a regular pose has a motion block", format!("{}: {e}", shown(pose))))?;
    let motion = |c: &[f64], joints: &[f64]| match m.forward(c, joints, &at, pose) {
        Ok(moved) => DVector::from_column_slice(pose.motion_to(&moved).as_slice()),
        Err(_) => DVector::repeat(6, f64::NAN),
    };
    for (k, spec) in m.parameters().iter().enumerate() {
        let numeric = differences(c, k, |c| motion(c, joints));
        let analytic = DVector::from_column_slice(block.parameters.column(k).as_slice());
        compare("J_b agrees with forward kinematics", &spec.name, pose, &analytic, &numeric)?;
    }
    for (k, spec) in m.joints().iter().enumerate() {
        // A mechanism of lower mobility has joints that cannot move alone; its block is then a projection.
        if m.joints().len() == 6 && m.equations() == 6 {
            let numeric = differences(joints, k, |joints| motion(c, joints));
            let analytic = DVector::from_column_slice(block.joints.column(k).as_slice());
            compare("joint motion agrees with forward kinematics", &spec.name, pose, &analytic, &numeric)?;
        }
    }
    Ok(())
}

fn refusals(m: &dyn Mechanism) -> Result<(), Violation> {
    const LAW: &str = "joints without a pose are refused";
    let at = Conditions::unknown();
    let c = m.values();
    let home = m.inverse(c, &m.home(), &at).map_err(|e| violation(LAW, format!("home has no joints: {e}")))?;
    for (k, spec) in m.joints().iter().enumerate() {
        let mut joints = home.clone();
        joints[k] = f64::NAN;
        if m.forward(c, &joints, &at, &m.home()).is_ok() {
            return Err(violation(LAW, format!("{} = NaN gives a pose", spec.name)));
        }
    }
    let mut far: Vec<f64> = home.iter().map(|v| v + 1e3).collect();
    far[0] = -1e6;
    if let Ok(pose) = m.forward(c, &far, &at, &m.home()) {
        let mut there = Linearization::sized_for(m);
        m.linearize(c, &far, &pose, &at, &mut there);
        if !(there.residual.amax() <= 1e-6) {
            return Err(violation(
                LAW,
                format!("joints far out of reach give a pose that misses by {:.3e}", there.residual.amax()),
            ));
        }
    }
    Ok(())
}

/// Derivative of `f` along entry `k` of `at` by central differences of one and two steps: near a singularity, and of the radius
/// of a drum that has turned often, the square of the step is not small.
pub(super) fn differences(at: &[f64], k: usize, mut f: impl FnMut(&[f64]) -> DVector<f64>) -> DVector<f64> {
    let mut shifted = at.to_vec();
    let mut across = |steps: f64| {
        shifted[k] = at[k] + steps * STEP;
        let ahead = f(&shifted);
        shifted[k] = at[k] - steps * STEP;
        ahead - f(&shifted)
    };
    (across(1.0) * 8.0 - across(2.0)) / (12.0 * STEP)
}

pub(super) fn compare(
    law: &'static str,
    name: &str,
    pose: &Pose,
    analytic: &DVector<f64>,
    numeric: &DVector<f64>,
) -> Result<(), Violation> {
    let scale = analytic.amax().max(numeric.amax()).max(1.0);
    for (row, (a, n)) in analytic.iter().zip(numeric.iter()).enumerate() {
        if !((a - n).abs() <= AGREES * scale) {
            let detail = format!("{name}, row {}: analytic {a:.9}, numeric {n:.9} at {}", row + 1, shown(pose));
            return Err(violation(law, detail));
        }
    }
    Ok(())
}

pub(super) fn shown(pose: &Pose) -> String {
    let q = pose.coordinates().map(|v| format!("{v:.6}"));
    format!("pose ({})", q.join(", "))
}
