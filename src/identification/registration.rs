//! Where the tracker and the target are, from any orientation.
//!
//! A full pose is measured as `Mₙ = B Tₙ A` with `Tₙ` the pose that the nominal mechanism predicts. Turns
//! between samples do not know `A`: `log(R_Mₙ R_M₀⁻¹) = R_B log(R_Tₙ R_T₀⁻¹)`, and
//! displacements nearly do not: `pₙ - p₀ ≈ R_B (tₙ - t₀)`. Each gives `R_B` in closed form (Kabsch), then
//! `R_A` is a mean and the two positions a linear problem. The best of these starts is refined by
//! Levenberg–Marquardt, with samples that do not fit counting less, so that a few gross errors cannot move a frame.
//!
//! The simplest frames that explain the data are taken: none, then a target that sits elsewhere, then both.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3, Vector6};

use crate::identification::error::IdentifyError;
use crate::identification::problem::start::poses_from_home;
use crate::measurement::{Dataset, Frames, TargetFrame};
use crate::mechanism::{Linearization, Mechanism, ParameterRole, characteristic_length, motion_of_point, nearest_pose};
use crate::pose::{Pose, kabsch, rotation_vector};
use crate::solve::{EvaluationError, LeastSquaresMethod, LeastSquaresOptions, LeastSquaresProblem, least_squares, svd};
use crate::units::Dimension;

/// Result of a registration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Registration {
    /// Where the tracker and the target are; identities if the data are in the base frame already.
    pub frames: Frames,
    /// True if the frames are used.
    pub applied: bool,
    /// Median over the samples of the distance between measured and nominal poses (angles times the size) before, m.
    pub before: f64,
    /// Median distance between measured and nominal poses after registration, m.
    pub after: f64,
}

/// One sample: the nominal pose, and what was measured.
struct Pair {
    nominal: Pose,
    /// Measured position, and its place in the target's frame.
    point: Vector3<f64>,
    place: Vector3<f64>,
    rotation: Option<Rotation3<f64>>,
}

/// Which frames are looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Free {
    Base,
    Target,
    Both,
}

/// Data whose nominal misfit is below this many tolerances need no registration; the parameters absorb it.
const TOLERANCES: f64 = 10.0;
/// The same for a mechanism without tolerances, as a part of its size.
const PART_OF_SIZE: f64 = 0.02;
/// Frames must take away half of the misfit; what errors of the parameters bend is not moved back by them.
const EXPLAINS: f64 = 0.5;
/// Misfits by more than this many times its size are those of frames in any mechanism.
const MOST_OF_SIZE: f64 = 1.0;
/// Misfits up to this many times what the tolerances cause need none either.
const SPREADS: f64 = 3.0;
const FEWEST: usize = 3;
/// Samples farther out than this many medians count less.
const FAR: f64 = 3.0;
const ROUNDS: usize = 4;
/// Weight of the rows that hold the target where its start is: nothing where the data say anything of it.
const HELD: f64 = 1e-4;
/// How much farther away the tracker is than the target, where the data cannot tell.
const TRACKER: f64 = 100.0;

/// Finds the frames of the data, if they are not near the base frame and the platform frame already.
///
/// Samples of which neither the pose nor a point is complete do not take part; with fewer than three others the data are taken
/// to be in the base frame.
pub fn register(mechanism: &dyn Mechanism, data: &Dataset) -> Registration {
    register_poses(mechanism, data, &poses_from_home(mechanism, data))
}

/// As [`register`], where the mechanism puts the samples at these poses.
pub(crate) fn register_poses(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    poses: &[Result<Pose, IdentifyError>],
) -> Registration {
    let pairs = pairs(mechanism, data, poses);
    let unregistered = |before| Registration { frames: Frames::default(), applied: false, before, after: before };
    if pairs.len() < FEWEST || !takes_frames(mechanism) {
        return unregistered(f64::NAN);
    }
    let size = characteristic_length(mechanism);
    let tolerance = mechanism
        .parameters()
        .iter()
        .filter(|s| s.dimension == Dimension::Length)
        .filter_map(|s| s.tolerance)
        .fold(0.0, f64::max);
    let near = if tolerance > 0.0 { (TOLERANCES * tolerance).min(PART_OF_SIZE * size) } else { PART_OF_SIZE * size };
    let target = data.model().target_frame();
    let before = misfit(&pairs, &Frames::default(), size);
    if before <= near && target != TargetFrame::Identified {
        return unregistered(before);
    }
    // Small platforms tilt far for their size: what the tolerances themselves do to the pose is no frame.
    // Near a singularity that is nothing to go by.
    let near = near.max((SPREADS * spread_by_tolerance(mechanism, &pairs, size)).min(MOST_OF_SIZE * size));
    // Points at unknown places have no meaning in the platform frame until their places are found.
    if (before <= near || closes(mechanism, data)) && target != TargetFrame::Identified {
        return unregistered(before);
    }
    let steps: &[Free] = if target == TargetFrame::Known { &[Free::Base] } else { &[Free::Target, Free::Both] };
    let mut best: Option<(f64, Frames)> = None;
    for free in steps {
        let found = starts(&pairs, *free).into_iter().map(|start| {
            let frames = refine(&pairs, start, size, *free);
            (misfit(&pairs, &frames, size), frames)
        });
        let found = found.min_by(|a, b| a.0.total_cmp(&b.0));
        // In a small workspace a target alone takes up any frame but for the small moves, so that being near says nothing;
        // more freedom must pay.
        let pays =
            |after: f64| best.as_ref().is_none_or(|(least, _)| after < PAYS * least || *least > near && after < *least);
        if let Some(found) = found.filter(|(after, _)| pays(*after)) {
            best = Some(found);
        }
    }
    match best {
        Some((after, mut frames)) if after < EXPLAINS * before || target == TargetFrame::Identified => {
            if target == TargetFrame::Identified {
                // The identified places take the place of a target frame.
                frames.target = Pose::identity();
            }
            Registration { frames, applied: !frames.is_identity(), before, after }
        }
        _ => unregistered(before),
    }
}

/// What was seen of a pose: a point at a place in the target's frame, and the attitude if it was measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenPose {
    pub(crate) nominal: Pose,
    /// Where the point was seen, tracker's frame, m.
    pub(crate) point: Vector3<f64>,
    /// Its place in the target's frame, m.
    pub(crate) place: Vector3<f64>,
    pub(crate) rotation: Option<Rotation3<f64>>,
}

/// The frames that carry nominal poses nearest to those that were seen, and the median distance (angles times the size) that
/// they leave, m. With `known` the target is the platform. `None` for fewer than three poses, and for a mechanism in which
/// frames have no meaning.
pub(crate) fn frames_between(mechanism: &dyn Mechanism, seen: &[SeenPose], known: bool) -> Option<(Frames, f64)> {
    if seen.len() < FEWEST || !takes_frames(mechanism) {
        return None;
    }
    let size = characteristic_length(mechanism);
    let pair = |s: &SeenPose| Pair { nominal: s.nominal, point: s.point, place: s.place, rotation: s.rotation };
    let pairs: Vec<Pair> = seen.iter().map(pair).collect();
    let free = if known { Free::Base } else { Free::Both };
    let distance = |frames: &Frames| misfit(&pairs, frames, size);
    let nearest = starts(&pairs, free).into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let refined = refine(&pairs, nearest, size, free);
    Some((refined, distance(&refined)))
}

/// True if the closure of the mechanism as it is given nearly holds at the measured poses: its residual, which is no larger near
/// a singularity than elsewhere, is that of its tolerances. False where nothing tells.
fn closes(mechanism: &dyn Mechanism, data: &Dataset) -> bool {
    let mut work = Linearization::sized_for(mechanism);
    let tolerances: Vec<f64> = mechanism.parameters().iter().map(|p| p.tolerance.unwrap_or(0.0)).collect();
    let ratio = |k: usize| {
        let ((model, index), sample) = (data.reading(k), data.sample(k));
        let pose = model.rigid_pose(index)?;
        mechanism.linearize(mechanism.values(), &sample.joints, &pose, &sample.conditions, &mut work);
        let spread = work.parameters.column_iter().zip(&tolerances).map(|(c, t)| c.norm_squared() * t * t);
        Some(work.residual.norm_squared() / spread.sum::<f64>())
    };
    let mut ratios: Vec<f64> = (0..data.len()).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).is_some_and(|ratio| *ratio < SPREADS * SPREADS)
}

/// A tracker elsewhere is believed beside a target elsewhere if it leaves at most this part.
const PAYS: f64 = 0.2;

/// False for a positioner in pose space, which cannot be carried into other frames or mounted in them: its offsets take up a
/// constant difference.
fn takes_frames(mechanism: &dyn Mechanism) -> bool {
    !mechanism.parameters().iter().any(|p| matches!(p.role, ParameterRole::PoseOffset { .. }))
}

fn pairs(mechanism: &dyn Mechanism, data: &Dataset, poses: &[Result<Pose, IdentifyError>]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (k, nominal) in poses.iter().enumerate() {
        let (model, index) = data.reading(k);
        let full = model.rigid_pose(index);
        let point = model.point(index).map(|p| (p.position, p.place));
        let Some((point, place)) = full.map(|p| (p.position, Vector3::zeros())).or(point) else { continue };
        // A mechanism near a singularity reaches few poses before its errors are known, but it comes near them.
        let sample = data.sample(k);
        let near = || nearest_pose(mechanism, &sample.joints, &sample.conditions, &mechanism.home());
        let Some(nominal) = nominal.as_ref().ok().copied().or_else(near) else { continue };
        pairs.push(Pair { nominal, point, place, rotation: full.map(|p| p.rotation) });
    }
    // Attitudes are worth more than points: samples without one are left out while enough others have one.
    if pairs.iter().filter(|p| p.rotation.is_some()).count() >= FEWEST {
        pairs.retain(|p| p.rotation.is_some());
    }
    pairs
}

/// Median over the samples of the size of [`residual`] that parameters as uncertain as their tolerances cause.
fn spread_by_tolerance(mechanism: &dyn Mechanism, pairs: &[Pair], size: f64) -> f64 {
    let spread = |pair: &Pair| {
        let moved = motion_of_point(mechanism, &pair.nominal, &pair.place).ok()?;
        let columns = mechanism.parameters().iter().zip(moved.column_iter());
        let squares = columns.map(|(spec, c)| {
            let c = c.rows(0, 3).norm_squared() + c.rows(3, 3).norm_squared() * size * size;
            c * spec.tolerance.unwrap_or(0.0).powi(2)
        });
        Some(squares.sum::<f64>().sqrt())
    };
    let mut spreads: Vec<f64> = pairs.iter().filter_map(spread).collect();
    spreads.sort_by(f64::total_cmp);
    spreads.get(spreads.len() / 2).copied().unwrap_or(0.0)
}

/// Median over the samples of the length of [`residual`].
fn misfit(pairs: &[Pair], frames: &Frames, size: f64) -> f64 {
    let mut lengths: Vec<f64> = pairs.iter().map(|p| residual(p, frames, size).norm()).collect();
    lengths.sort_by(f64::total_cmp);
    lengths[lengths.len() / 2]
}

/// Position difference, m, and rotation difference times `size`.
fn residual(pair: &Pair, frames: &Frames, size: f64) -> Vector6<f64> {
    let seen = frames.measured(&pair.nominal);
    let t = seen.place(&pair.place) - pair.point;
    let w = pair.rotation.map_or(Vector3::zeros(), |r| rotation_vector(&(seen.rotation * r.inverse())) * size);
    Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
}

/// Closed-form starts.
fn starts(pairs: &[Pair], free: Free) -> Vec<Frames> {
    if free == Free::Target {
        return complete(pairs, Rotation3::identity(), free).into_iter().collect();
    }
    let n = pairs.len() as f64;
    let moved = |p: &Pair| {
        p.nominal.position + if free == Free::Base { p.nominal.rotation * p.place } else { Vector3::zeros() }
    };
    let mean_nominal = pairs.iter().map(moved).sum::<Vector3<f64>>() / n;
    let mean_point = pairs.iter().map(|p| p.point).sum::<Vector3<f64>>() / n;
    let (mut by_shift, mut by_turn) = (Matrix3::zeros(), Matrix3::zeros());
    let first = &pairs[0];
    for pair in pairs {
        by_shift += (pair.point - mean_point) * (moved(pair) - mean_nominal).transpose();
        if let (Some(r), Some(r0)) = (pair.rotation, first.rotation) {
            let measured = rotation_vector(&(r * r0.inverse()));
            let nominal = rotation_vector(&(pair.nominal.rotation * first.nominal.rotation.inverse()));
            by_turn += measured * nominal.transpose();
        }
    }
    let both = by_shift / by_shift.norm().max(f64::MIN_POSITIVE) + by_turn / by_turn.norm().max(f64::MIN_POSITIVE);
    let mut turns: Vec<Rotation3<f64>> = [both, by_turn, by_shift].iter().filter_map(kabsch).collect();
    if free == Free::Base {
        // The target is the platform: one sample's attitude is the whole answer.
        turns.extend(first.rotation.map(|r| r * first.nominal.rotation.inverse()));
    }
    turns.push(Rotation3::identity());
    turns.into_iter().filter_map(|turn| complete(pairs, turn, free)).collect()
}

/// The other unknowns for a given `R_B`: `R_A` as the mean of `R_T⁻¹ R_B⁻¹ R_M`, then both positions from
/// `pₙ = R_B tₙ + R_B R_Tₙ (p_A + R_A place) + t_B`.
fn complete(pairs: &[Pair], turn: Rotation3<f64>, free: Free) -> Option<Frames> {
    let mut spread = Matrix3::zeros();
    for pair in pairs {
        if let Some(r) = pair.rotation {
            spread += (pair.nominal.rotation.inverse() * turn.inverse() * r).into_inner();
        }
    }
    let fixed = spread == Matrix3::zeros() || free == Free::Base;
    let turned = if fixed { Rotation3::identity() } else { kabsch(&spread)? };
    let (for_target, for_base) = (f64::from(u8::from(free != Free::Base)), f64::from(u8::from(free != Free::Target)));
    let n = pairs.len();
    let (mut a, mut b) = (DMatrix::zeros(3 * n, 6), DVector::zeros(3 * n));
    for (k, pair) in pairs.iter().enumerate() {
        a.fixed_view_mut::<3, 3>(3 * k, 0).copy_from(&((turn * pair.nominal.rotation).matrix() * for_target));
        a.fixed_view_mut::<3, 3>(3 * k, 3).copy_from(&(Matrix3::identity() * for_base));
        b.fixed_rows_mut::<3>(3 * k).copy_from(&(pair.point - turn * pair.nominal.place(&(turned * pair.place))));
    }
    // Where the platform hardly turns, p_A and t_B are the same thing: the target is then taken to sit near the platform,
    // and the tracker to stand far away, by counting lengths of t_B in units of TRACKER.
    a.columns_mut(3, 3).scale_mut(TRACKER);
    let svd = svd(a, true, true);
    let mut x = svd.solve(&b, 1e-6 * svd.singular_values.max()).ok()?;
    x.rows_mut(3, 3).scale_mut(TRACKER);
    Some(Frames {
        base: Pose { position: Vector3::new(x[3], x[4], x[5]), rotation: turn },
        target: Pose { position: Vector3::new(x[0], x[1], x[2]), rotation: turned },
    })
}

/// Small motions of the free frames about a start.
struct Refinement<'a> {
    pairs: &'a [Pair],
    /// Square root of the weight of each pair.
    weights: Vec<f64>,
    start: Frames,
    size: f64,
    /// Which of the twelve numbers (base, then target) are free.
    free: Vec<usize>,
}

impl Refinement<'_> {
    fn frames(&self, x: &DVector<f64>) -> Frames {
        let mut motion = [0.0; 12];
        for (value, k) in x.iter().zip(&self.free) {
            motion[*k] = *value;
        }
        let part = |first: usize| Vector6::from_column_slice(&motion[first..first + 6]);
        Frames { base: self.start.base.moved(&part(0)), target: self.start.target.moved(&part(6)) }
    }

    fn residuals(&self, x: &DVector<f64>) -> DVector<f64> {
        let frames = self.frames(x);
        let all = self.pairs.iter().zip(&self.weights).map(|(p, w)| residual(p, &frames, self.size) * *w);
        let held = (frames.target.position - self.start.target.position) * HELD;
        let rows = all.flat_map(|r| [r[0], r[1], r[2], r[3], r[4], r[5]]).chain([held.x, held.y, held.z]);
        DVector::from_iterator(6 * self.pairs.len() + 3, rows)
    }
}

impl LeastSquaresProblem for Refinement<'_> {
    fn shape(&self) -> (usize, usize) {
        (6 * self.pairs.len() + 3, self.free.len())
    }

    fn linearize(
        &mut self,
        x: &DVector<f64>,
        r: &mut DVector<f64>,
        j: &mut DMatrix<f64>,
    ) -> Result<(), EvaluationError> {
        // A few columns of a start value: differences are exact enough and need no second set of formulas.
        const STEP: f64 = 1e-6;
        r.copy_from(&self.residuals(x));
        for k in 0..self.free.len() {
            let (mut plus, mut minus) = (x.clone(), x.clone());
            plus[k] += STEP;
            minus[k] -= STEP;
            j.set_column(k, &((self.residuals(&plus) - self.residuals(&minus)) / (2.0 * STEP)));
        }
        Ok(())
    }
}

fn refine(pairs: &[Pair], start: Frames, size: f64, free: Free) -> Frames {
    let attitudes = pairs.iter().any(|p| p.rotation.is_some());
    let base = if free == Free::Target { 0..0 } else { 0..6 };
    let target = match free {
        Free::Base => 6..6,
        _ if attitudes => 6..12,
        _ => 6..9,
    };
    let free: Vec<usize> = base.chain(target).collect();
    let options = LeastSquaresOptions {
        initial_damping: 1e-6,
        step_tolerance: 1e-7,
        gradient_tolerance: 1e-5,
        max_iterations: 60,
        ..Default::default()
    };
    let mut frames = start;
    for _ in 0..ROUNDS {
        let lengths: Vec<f64> = pairs.iter().map(|p| residual(p, &frames, size).norm()).collect();
        let limit = FAR * misfit(pairs, &frames, size);
        let weights = lengths.iter().map(|l| if *l > limit { (limit / l).sqrt() } else { 1.0 }).collect();
        let mut problem = Refinement { pairs, weights, start: frames, size, free: free.clone() };
        let zero = DVector::zeros(free.len());
        // A start that cannot be refined is still a start; the identification judges it.
        frames = match least_squares(&mut problem, zero, LeastSquaresMethod::LevenbergMarquardt, &options) {
            Ok(solution) => problem.frames(&solution.x),
            Err(crate::solve::SolveError::NoConvergence { last, .. }) => problem.frames(&last.x),
            Err(_) => return frames,
        };
        if lengths.iter().all(|l| *l <= limit) {
            break;
        }
    }
    frames
}
