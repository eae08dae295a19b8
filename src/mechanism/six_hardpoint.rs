//! Six legs of variable length between points of the platform and of the base, in closed form.
//!
//! Leg `i` has `lᵢ = t + R aᵢ - bᵢ` (eq. 1). In the length form of eq. (12) its closure is
//! `fᵢ = |lᵢ| - (command + dhᵢ)`, with `dhᵢ = hᵢ - nominal hᵢ`: the true length is the commanded length
//! plus the error. With `uᵢ = lᵢ/|lᵢ|`
//!
//! * `J₁` row: `[uᵢᵀ, (R aᵢ × uᵢ)ᵀ]` (eq. 19, along small motions),
//! * `J₂` row, in the columns of leg `i`: `[uᵢᵀ R, -1, -uᵢᵀ]` (eq. 21 with the sign of eq. 17),
//! * `∂f/∂h = -I` along the commands.
//!
//! The parameters stand in the order of eq. (15), `x_A y_A z_A h x_B y_B z_B` per leg; the paper's
//! tables print `h` last.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::kinematics::on_branch;
use super::six_legs::{SixLegs, leg_row};
use super::six_legs_batch::SixLegsBatch;
use super::{
    Axis, ForwardQuery, GeometryError, JointSpec, KinematicsError, Linearization, Mechanism, MechanismCore,
    MotionBlock, ParameterRole, ParameterSpec, check_held, continuation, inverse_motion,
};
use crate::conditions::Conditions;
use crate::pose::Pose;
use crate::solve::{NewtonOptions, newton};
use crate::units::Dimension;

/// One leg of a [`SixHardpoint`].
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// `aᵢ`: where it meets the platform, platform frame, m.
    pub platform: Vector3<f64>,
    /// `bᵢ`: where it meets the base, base frame, m.
    pub base: Vector3<f64>,
    /// `hᵢ` at home, m.
    pub length: f64,
    /// `dhᵢ`: true length minus commanded length, m.
    pub length_offset: f64,
    /// Shortest and longest commanded length, m.
    pub stroke: Option<[f64; 2]>,
}

/// The paper's mechanism: six hardpoints, 42 parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SixHardpoint {
    core: MechanismCore,
    /// Sign of `det J₁` at home: which side of the singularities the mechanism works on.
    side: f64,
}

pub(super) const PER_LEG: usize = 7;
pub(super) const LEGS: usize = 6;
const NAMES: [&str; PER_LEG] = ["xA", "yA", "zA", "h", "xB", "yB", "zB"];

impl SixHardpoint {
    /// A mechanism of six legs. Without `home` it is solved from the lengths, starting at zero attitude above
    /// the base. `tolerance` is 1σ of the anchors and of the lengths, m.
    ///
    /// # Errors
    /// [`GeometryError`] for anything but six legs with finite points and positive lengths that hold the
    /// platform at home.
    pub fn new(
        name: impl Into<String>,
        legs: &[Leg],
        home: Option<Pose>,
        tolerance: Option<(f64, f64)>,
    ) -> Result<Self, GeometryError> {
        check_legs(legs)?;
        let mut specs = Vec::with_capacity(LEGS * PER_LEG);
        let mut values = Vec::with_capacity(LEGS * PER_LEG);
        for (leg, l) in legs.iter().enumerate() {
            let numbers = [l.platform.x, l.platform.y, l.platform.z, l.length, l.base.x, l.base.y, l.base.z];
            for (k, (prefix, nominal)) in NAMES.iter().zip(numbers).enumerate() {
                let role = match k {
                    0..3 => ParameterRole::PlatformPoint { leg, axis: Axis::ALL[k] },
                    3 => ParameterRole::JointOffset { leg },
                    _ => ParameterRole::BasePoint { leg, axis: Axis::ALL[k - 4] },
                };
                let tolerance = tolerance.map(|(anchor, length)| if k == 3 { length } else { anchor });
                let name = format!("{prefix}{}", leg + 1);
                specs.push(ParameterSpec { name, dimension: Dimension::Length, nominal, tolerance, role });
                values.push(if k == 3 { nominal + l.length_offset } else { nominal });
            }
        }
        let joints = legs.iter().enumerate().map(|(i, l)| JointSpec {
            name: format!("leg{}", i + 1),
            dimension: Dimension::Length,
            stroke: l.stroke,
        });
        let home_or_above = home.unwrap_or_else(|| pose_above_base(legs));
        let core = MechanismCore { values, ..MechanismCore::new(name, specs, joints.collect(), home_or_above) };
        let mut mechanism = Self { core, side: 0.0 };
        if home.is_none() {
            let lengths: Vec<f64> = legs.iter().map(|l| l.length).collect();
            let seed = mechanism.home();
            mechanism.core.home = mechanism
                .forward(mechanism.values(), &lengths, &Conditions::unknown(), &seed)
                .map_err(GeometryError::Home)?;
        }
        mechanism.hold_at_home()?;
        Ok(mechanism)
    }

    /// Finds on which side of the singularities home lies, or refuses a home that the legs do not hold.
    fn hold_at_home(&mut self) -> Result<(), GeometryError> {
        let joints = self.inverse(self.values(), &self.home(), &Conditions::unknown()).map_err(GeometryError::Home)?;
        check_held(self, &joints)?;
        let (mut residual, mut jacobian) = (Vector6::zeros(), Matrix6::zeros());
        self.legs(self.values(), &joints).equations(&self.home(), &mut residual, &mut jacobian);
        self.side = jacobian.determinant().signum();
        Ok(())
    }

    /// The legs as they are now.
    pub fn to_legs(&self) -> Vec<Leg> {
        let leg = |i: usize| {
            let c = &self.core.values[PER_LEG * i..PER_LEG * (i + 1)];
            let length = self.core.parameters[PER_LEG * i + 3].nominal;
            Leg {
                platform: Vector3::new(c[0], c[1], c[2]),
                base: Vector3::new(c[4], c[5], c[6]),
                length,
                length_offset: c[3] - length,
                stroke: self.core.joints[i].stroke,
            }
        };
        (0..LEGS).map(leg).collect()
    }

    /// The equations for these parameters and commanded lengths, unpacked.
    fn legs(&self, c: &[f64], joints: &[f64]) -> SixLegs {
        let mut legs = SixLegs { a: [Vector3::zeros(); LEGS], b: [Vector3::zeros(); LEGS], length: [0.0; LEGS] };
        for i in 0..LEGS {
            let p = &c[PER_LEG * i..PER_LEG * (i + 1)];
            legs.a[i] = Vector3::new(p[0], p[1], p[2]);
            legs.b[i] = Vector3::new(p[4], p[5], p[6]);
            legs.length[i] = joints[i] + (p[3] - self.core.parameters[PER_LEG * i + 3].nominal);
        }
        legs
    }
}

fn check_legs(legs: &[Leg]) -> Result<(), GeometryError> {
    if legs.len() != LEGS {
        return Err(GeometryError::LegCount { found: legs.len() });
    }
    for (i, l) in legs.iter().enumerate() {
        let leg = i + 1;
        let named = [("platform", &l.platform), ("base", &l.base)];
        for (what, value) in named.iter().flat_map(|(what, p)| p.iter().map(move |v| (*what, *v))) {
            if !value.is_finite() {
                return Err(GeometryError::NotFinite { leg, what: format!("a coordinate of `{what}`"), value });
            }
        }
        for (what, value) in [("length", l.length), ("length_offset", l.length_offset)] {
            if !value.is_finite() {
                return Err(GeometryError::NotFinite { leg, what: format!("`{what}`"), value });
            }
        }
        if l.length <= 0.0 {
            return Err(GeometryError::Length { leg, length: l.length });
        }
        if let Some([from, to]) = l.stroke
            && !(0.0 < from && from < to && to.is_finite())
        {
            return Err(GeometryError::Stroke { leg, from, to });
        }
    }
    Ok(())
}

/// Refuses two legs that meet in a point of the platform or of the base, which in a file is nearly always a line
/// copied twice. Where all legs meet in pairs, as in the 6-3 and 3-3 platforms, they are meant to.
#[cfg(feature = "files")]
pub(crate) fn check_distinct_anchors(legs: &[Leg]) -> Result<(), GeometryError> {
    type Point = fn(&Leg) -> Vector3<f64>;
    let bodies: [(&'static str, Point); 2] = [("platform", |l| l.platform), ("base", |l| l.base)];
    for (body, point) in bodies {
        let meet = |i: usize, j: usize| (point(&legs[i]) - point(&legs[j])).norm() <= 1e-9;
        let partners = |i: usize| (0..legs.len()).filter(|j| *j != i && meet(i, *j)).count();
        if (0..legs.len()).all(|i| partners(i) == 1) {
            continue;
        }
        for i in 0..legs.len() {
            if let Some(j) = (i + 1..legs.len()).find(|j| meet(i, *j)) {
                let p = point(&legs[i]);
                return Err(GeometryError::EqualAnchors { first: i + 1, second: j + 1, body, x: p.x, y: p.y, z: p.z });
            }
        }
    }
    Ok(())
}

/// Zero attitude, the mean of b − a in x and y, and in z where the legs reach above the base.
fn pose_above_base(legs: &[Leg]) -> Pose {
    let n = legs.len() as f64;
    let mean = legs.iter().map(|l| l.base - l.platform).sum::<Vector3<f64>>() / n;
    let rise = |l: &Leg| {
        let d = l.base - l.platform - mean;
        (l.length.powi(2) - d.xy().norm_squared()).max(0.04 * l.length.powi(2)).sqrt()
    };
    let z = legs.iter().map(rise).sum::<f64>() / n;
    Pose { position: mean + Vector3::new(0.0, 0.0, z), ..Pose::identity() }
}

impl Mechanism for SixHardpoint {
    fn core(&self) -> &MechanismCore {
        &self.core
    }

    fn with_values(&self, c: &[f64], home: Pose) -> Result<Box<dyn Mechanism>, GeometryError> {
        let other = Self { core: self.core.with_values(c, home)?, ..*self };
        check_legs(&other.to_legs())?;
        Ok(Box::new(other))
    }

    fn equations(&self) -> usize {
        LEGS
    }

    fn linearize(&self, c: &[f64], joints: &[f64], pose: &Pose, _at: &Conditions, out: &mut Linearization) {
        let legs = self.legs(c, joints);
        let (mut residual, mut motion) = (Vector6::zeros(), Matrix6::zeros());
        legs.equations(pose, &mut residual, &mut motion);
        out.residual.copy_from(&residual);
        out.motion.copy_from(&motion);
        out.parameters.fill(0.0);
        out.joints.fill(0.0);
        for i in 0..LEGS {
            let row = leg_row(&motion, i, pose);
            for (k, value) in row.iter().enumerate() {
                out.parameters[(i, PER_LEG * i + k)] = *value;
            }
            out.joints[(i, i)] = -1.0;
        }
    }

    fn inverse(&self, c: &[f64], pose: &Pose, _at: &Conditions) -> Result<Vec<f64>, KinematicsError> {
        if !pose.is_finite() {
            return Err(KinematicsError::NotFinite { what: "the pose".into() });
        }
        let legs = self.legs(c, &[0.0; LEGS]);
        // With a joint of zero, `length` holds dh: the command is the true length less dh.
        Ok((0..LEGS).map(|i| (pose.place(&legs.a[i]) - legs.b[i]).norm() - legs.length[i]).collect())
    }

    fn forward(&self, c: &[f64], joints: &[f64], at: &Conditions, seed: &Pose) -> Result<Pose, KinematicsError> {
        if joints.len() != LEGS {
            return Err(KinematicsError::JointCount { expected: LEGS, found: joints.len() });
        }
        continuation(
            joints,
            seed,
            || self.inverse(c, seed, at),
            self.side,
            |joints, seed| newton(self.legs(c, joints), *seed, NewtonOptions::default()),
        )
    }

    fn forward_batch(&self, c: &[f64], queries: &[ForwardQuery<'_>]) -> Vec<Result<Pose, KinematicsError>> {
        let one = |q: &ForwardQuery<'_>| self.forward(c, q.joints, q.at, &q.seed);
        let (Some(first), true) = (queries.first(), queries.iter().all(|q| q.joints.len() == LEGS)) else {
            return queries.iter().map(one).collect();
        };
        let legs = self.legs(c, first.joints);
        let (mut residual, mut motion) = (Vector6::zeros(), Matrix6::zeros());
        legs.equations(&first.seed, &mut residual, &mut motion);
        let (lengths, seeds): (Vec<_>, Vec<_>) =
            queries.iter().map(|q| (self.legs(c, q.joints).length, q.seed)).unzip();
        let found = SixLegsBatch::new(legs.a, legs.b, &motion).solve(&lengths, &seeds);
        let checked = |(found, query): (Option<(Pose, f64)>, &ForwardQuery<'_>)| match found {
            Some((pose, determinant)) if on_branch(&query.seed, &pose, determinant, self.side) => Ok(pose),
            _ => one(query),
        };
        found.into_iter().zip(queries).map(checked).collect()
    }

    fn motion_block(
        &self,
        c: &[f64],
        joints: &[f64],
        pose: &Pose,
        _at: &Conditions,
        out: &mut MotionBlock,
    ) -> Result<(), KinematicsError> {
        let legs = self.legs(c, joints);
        let (mut residual, mut motion) = (Vector6::zeros(), Matrix6::zeros());
        legs.equations(pose, &mut residual, &mut motion);
        let inverse = inverse_motion(&motion)?;
        for i in 0..LEGS {
            let (row, held) = (leg_row(&motion, i, pose), inverse.column(i));
            for (k, value) in row.iter().enumerate() {
                out.parameters.set_column(PER_LEG * i + k, &(held * -value));
            }
            out.joints.set_column(i, &held);
        }
        Ok(())
    }
}
