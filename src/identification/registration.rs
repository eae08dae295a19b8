//! Where the tracker and the target are, from any orientation.
//!
//! A full pose is measured as `Mₙ = B Tₙ A` with `Tₙ` the pose that the nominal mechanism predicts. Turns
//! between samples do not know `A`: `log(R_Mₙ R_M₀⁻¹) = R_B log(R_Tₙ R_T₀⁻¹)`, and
//! displacements nearly do not: `pₙ - p₀ ≈ R_B (tₙ - t₀)`. Each gives `R_B` in closed form (Kabsch), then
//! `R_A` is a mean and the two positions a linear problem. The best of these starts is refined by
//! Levenberg–Marquardt on all twelve unknowns.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3, Vector6};

use super::IdentifyError;
use super::problem::sample_error;
use crate::measurement::{Dataset, Frames};
use crate::mechanism::{Mechanism, characteristic_length};
use crate::pose::{Pose, rotation_from_spread, rotation_vector};
use crate::solve::{EvaluationError, LeastSquaresMethod, LeastSquaresOptions, LeastSquaresProblem, least_squares};

/// Result of a registration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration {
    /// Where the tracker and the target are; identities if the data are in the base frame already.
    pub frames: Frames,
    /// True if the frames are used.
    pub applied: bool,
    /// RMS distance between measured and nominal positions before, m.
    pub before: f64,
    /// The same with the frames, m.
    pub after: f64,
}

/// One sample: the nominal pose, and what was measured.
struct Pair {
    nominal: Pose,
    point: Vector3<f64>,
    rotation: Option<Rotation3<f64>>,
}

/// Data whose nominal misfit is below this many tolerances need no registration; the parameters absorb it.
const TOLERANCES: f64 = 10.0;
/// The same for a mechanism without tolerances, as a part of its size.
const PART_OF_SIZE: f64 = 0.02;
const FEWEST: usize = 3;

/// Finds the frames of the data, if they are not near the base frame and the platform frame already.
///
/// Samples of which neither the pose nor a point is complete do not take part; with fewer than three others the
/// data are taken to be in the base frame.
///
/// # Errors
/// [`IdentifyError::Sample`] if the nominal mechanism has no pose for a sample.
pub fn register(mechanism: &dyn Mechanism, data: &Dataset) -> Result<Registration, IdentifyError> {
    let mut pairs = Vec::new();
    for k in 0..data.len() {
        let sample = data.sample(k);
        let (model, index) = data.reading(k);
        let full = model.rigid_pose(index);
        let Some(point) = full.map(|p| p.position).or_else(|| model.point(index)) else { continue };
        let nominal = mechanism
            .forward(mechanism.values(), &sample.joints, &sample.conditions, &mechanism.home())
            .map_err(|cause| sample_error(data, k, cause))?;
        pairs.push(Pair { nominal, point, rotation: full.map(|p| p.rotation) });
    }
    let unregistered = |before| Registration { frames: Frames::default(), applied: false, before, after: before };
    // Attitudes are worth more than points: samples without one are left out while enough others have one.
    let full = pairs.iter().filter(|p| p.rotation.is_some()).count();
    if full >= FEWEST {
        pairs.retain(|p| p.rotation.is_some());
    }
    if pairs.len() < FEWEST {
        return Ok(unregistered(f64::NAN));
    }
    let size = characteristic_length(mechanism);
    let before = misfit(&pairs, &Frames::default(), size);
    let tolerance = mechanism.parameters().iter().filter_map(|s| s.tolerance).fold(0.0, f64::max);
    let near = if tolerance > 0.0 { (TOLERANCES * tolerance).min(PART_OF_SIZE * size) } else { PART_OF_SIZE * size };
    if before <= near {
        return Ok(unregistered(before));
    }
    let best = starts(&pairs)
        .into_iter()
        .map(|start| refine(&pairs, start, size))
        .map(|frames| (misfit(&pairs, &frames, size), frames))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((after, frames)) if after < before => Ok(Registration { frames, applied: true, before, after }),
        _ => Ok(unregistered(before)),
    }
}

/// RMS of position differences and of rotation differences times `size`, together.
fn misfit(pairs: &[Pair], frames: &Frames, size: f64) -> f64 {
    let sum: f64 = pairs.iter().map(|p| residual(p, frames, size).norm_squared()).sum();
    (sum / pairs.len() as f64).sqrt()
}

fn residual(pair: &Pair, frames: &Frames, size: f64) -> Vector6<f64> {
    let seen = frames.measured(&pair.nominal);
    let t = seen.position - pair.point;
    let w = pair.rotation.map_or(Vector3::zeros(), |r| rotation_vector(&(seen.rotation * r.inverse())) * size);
    Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
}

/// Closed-form starts.
fn starts(pairs: &[Pair]) -> Vec<Frames> {
    let n = pairs.len() as f64;
    let mean_nominal = pairs.iter().map(|p| p.nominal.position).sum::<Vector3<f64>>() / n;
    let mean_point = pairs.iter().map(|p| p.point).sum::<Vector3<f64>>() / n;
    let (mut by_shift, mut by_turn) = (Matrix3::zeros(), Matrix3::zeros());
    let first = &pairs[0];
    for pair in pairs {
        by_shift += (pair.point - mean_point) * (pair.nominal.position - mean_nominal).transpose();
        if let (Some(r), Some(r0)) = (pair.rotation, first.rotation) {
            let measured = rotation_vector(&(r * r0.inverse()));
            let nominal = rotation_vector(&(pair.nominal.rotation * first.nominal.rotation.inverse()));
            by_turn += measured * nominal.transpose();
        }
    }
    let both = by_shift / by_shift.norm().max(f64::MIN_POSITIVE) + by_turn / by_turn.norm().max(f64::MIN_POSITIVE);
    let mut turns: Vec<Rotation3<f64>> = [both, by_turn, by_shift].iter().filter_map(rotation_from_spread).collect();
    turns.push(Rotation3::identity());
    turns.into_iter().filter_map(|turn| complete(pairs, turn)).collect()
}

/// The other unknowns for a given `R_B`: `R_A` as the mean of `R_T⁻¹ R_B⁻¹ R_M`, then both positions from
/// `pₙ = R_B tₙ + R_B R_Tₙ p_A + t_B`.
fn complete(pairs: &[Pair], turn: Rotation3<f64>) -> Option<Frames> {
    let mut spread = Matrix3::zeros();
    let n = pairs.len();
    let (mut a, mut b) = (DMatrix::zeros(3 * n, 6), DVector::zeros(3 * n));
    for (k, pair) in pairs.iter().enumerate() {
        if let Some(r) = pair.rotation {
            spread += (pair.nominal.rotation.inverse() * turn.inverse() * r).into_inner();
        }
        a.fixed_view_mut::<3, 3>(3 * k, 0).copy_from((turn * pair.nominal.rotation).matrix());
        a.fixed_view_mut::<3, 3>(3 * k, 3).copy_from(&Matrix3::identity());
        b.fixed_rows_mut::<3>(3 * k).copy_from(&(pair.point - turn * pair.nominal.position));
    }
    let turned = if spread == Matrix3::zeros() { Rotation3::identity() } else { rotation_from_spread(&spread)? };
    // Where the platform hardly turns, p_A and t_B are the same thing; the short solution is as good as any.
    let svd = a.svd(true, true);
    let x = svd.solve(&b, 1e-6 * svd.singular_values.max()).ok()?;
    Some(Frames {
        base: Pose { position: Vector3::new(x[3], x[4], x[5]), rotation: turn },
        target: Pose { position: Vector3::new(x[0], x[1], x[2]), rotation: turned },
    })
}

/// Twelve small motions about a start.
struct Refinement<'a> {
    pairs: &'a [Pair],
    start: Frames,
    size: f64,
}

impl Refinement<'_> {
    fn frames(&self, x: &DVector<f64>) -> Frames {
        let motion = |first: usize| Vector6::from_iterator(x.rows(first, 6).iter().copied());
        Frames { base: self.start.base.moved(&motion(0)), target: self.start.target.moved(&motion(6)) }
    }

    fn residuals(&self, x: &DVector<f64>) -> DVector<f64> {
        let frames = self.frames(x);
        let all = self.pairs.iter().map(|p| residual(p, &frames, self.size));
        DVector::from_iterator(6 * self.pairs.len(), all.flat_map(|r| [r[0], r[1], r[2], r[3], r[4], r[5]]))
    }
}

impl LeastSquaresProblem for Refinement<'_> {
    fn shape(&self) -> (usize, usize) {
        (6 * self.pairs.len(), 12)
    }

    fn linearize(
        &mut self,
        x: &DVector<f64>,
        r: &mut DVector<f64>,
        j: &mut DMatrix<f64>,
    ) -> Result<(), EvaluationError> {
        // Twelve columns of a start value: differences are exact enough and need no second set of formulas.
        const STEP: f64 = 1e-6;
        r.copy_from(&self.residuals(x));
        for k in 0..12 {
            let (mut plus, mut minus) = (x.clone(), x.clone());
            plus[k] += STEP;
            minus[k] -= STEP;
            j.set_column(k, &((self.residuals(&plus) - self.residuals(&minus)) / (2.0 * STEP)));
        }
        Ok(())
    }
}

fn refine(pairs: &[Pair], start: Frames, size: f64) -> Frames {
    let mut problem = Refinement { pairs, start, size };
    let options = LeastSquaresOptions {
        initial_damping: 1e-6,
        step_tolerance: 1e-7,
        gradient_tolerance: 1e-5,
        max_iterations: 60,
        ..Default::default()
    };
    // A start that cannot be refined is still a start; the identification judges it.
    match least_squares(&mut problem, DVector::zeros(12), LeastSquaresMethod::LevenbergMarquardt, &options) {
        Ok(solution) => problem.frames(&solution.x),
        Err(crate::solve::SolveError::NoConvergence { last, .. }) => problem.frames(&last.x),
        Err(_) => start,
    }
}
