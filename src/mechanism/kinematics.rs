//! Kinematics of any mechanism from its closure equations.

use std::ops::AddAssign;

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};

use super::{KinematicsError, Linearization, Mechanism, MotionBlock};
use crate::conditions::Conditions;
use crate::pose::Pose;
use crate::solve::{
    EvaluationError, LeastSquaresMethod, LeastSquaresOptions, LeastSquaresProblem, LeastSquaresSolution, NewtonError,
    NewtonOptions, NewtonProblem, NewtonSolution, SolveError, least_squares, newton,
};

/// Smallest part of the way that [`continuation`] tries in one step.
const SHORTEST_PART: f64 = 1.0 / 256.0;
/// Cosine of a radian: a solution that turned farther from its seed is taken for another branch until it was
/// followed there.
const COS_FAR_TURN: f64 = 0.540_302_305_868_139_8;

/// Solves for the pose of `joints` on the branch of `seed`.
///
/// `solve(joints, seed)` is one Newton run. Its answer is taken as it is if the platform turned by less than
/// a radian and `det J₁` has the sign `side` (that of home; between the two signs lies a singularity). If
/// not, the joints are led from those of the seed to the wanted ones in steps, so that the solution stays on
/// the branch; steps are halved when one fails.
///
/// # Errors
/// [`KinematicsError::OutOfReach`] with the part of the way that could be followed.
pub fn continuation(
    joints: &[f64],
    seed: &Pose,
    seed_joints: impl FnOnce() -> Result<Vec<f64>, KinematicsError>,
    side: f64,
    mut solve: impl FnMut(&[f64], &Pose) -> Result<NewtonSolution<Pose>, NewtonError>,
) -> Result<Pose, KinematicsError> {
    if joints.iter().any(|v| !v.is_finite()) || !seed.is_finite() {
        return Err(KinematicsError::NotFinite { what: "a joint coordinate or the starting pose".into() });
    }
    let near = |from: &Pose, to: &NewtonSolution<Pose>| on_branch(from, &to.point, to.determinant, side);
    match solve(joints, seed) {
        Ok(found) if near(seed, &found) => return Ok(found.point),
        Err(NewtonError::NotFinite { .. }) => {
            return Err(KinematicsError::NotFinite { what: "the closure at these joints".into() });
        }
        _ => {}
    }
    let start = seed_joints()?;
    let (mut pose, mut done, mut part) = (*seed, 0.0_f64, 0.25_f64);
    let mut between = start.clone();
    while done < 1.0 {
        let next = (done + part).min(1.0);
        for ((value, from), to) in between.iter_mut().zip(&start).zip(joints) {
            *value = from + next * (to - from);
        }
        let cause = match solve(&between, &pose) {
            Ok(found) if near(&pose, &found) => {
                pose = found.point;
                done = next;
                part *= 2.0;
                continue;
            }
            Ok(found) => NewtonError::Singular { iterations: found.iterations, pivot_ratio: 0.0 },
            Err(cause) => cause,
        };
        part *= 0.5;
        if part < SHORTEST_PART {
            return Err(KinematicsError::OutOfReach { percent: 100.0 * done, cause });
        }
    }
    Ok(pose)
}

/// True if a root belongs to the branch of the seed as far as one look can tell: the platform turned by less than a radian, and
/// `determinant`, that of `J₁`, has the sign `side`.
pub(super) fn on_branch(seed: &Pose, root: &Pose, determinant: f64, side: f64) -> bool {
    // The sum of the products of entries is the trace of RᵀR', which is 1 + 2 cos of the turn between them.
    let cos = 0.5 * (root.rotation.matrix().dot(seed.rotation.matrix()) - 1.0);
    determinant * side >= 0.0 && cos > COS_FAR_TURN
}

/// Step (m and rad) or residual (m) at which more than six equations are settled.
const SETTLED: f64 = 1e-9;

/// Six closure equations.
struct SixRows<'a, F> {
    rows: &'a mut F,
    joints: &'a [f64],
}

impl<F: FnMut(&[f64], &Pose) -> (DVector<f64>, DMatrix<f64>)> NewtonProblem for SixRows<'_, F> {
    type Point = Pose;

    fn linearize(&mut self, pose: &Pose, residual: &mut Vector6<f64>, jacobian: &mut Matrix6<f64>) {
        let (rows, motion) = (self.rows)(self.joints, pose);
        residual.copy_from(&rows);
        jacobian.copy_from(&motion);
    }

    fn step(&self, pose: &Pose, delta: &Vector6<f64>) -> Pose {
        pose.moved(delta)
    }
}

/// More than six closure equations, by the motion from a seed.
struct ManyRows<'a, F> {
    rows: &'a mut F,
    joints: &'a [f64],
    seed: Pose,
    equations: usize,
}

impl<F: FnMut(&[f64], &Pose) -> (DVector<f64>, DMatrix<f64>)> LeastSquaresProblem for ManyRows<'_, F> {
    fn shape(&self) -> (usize, usize) {
        (self.equations, 6)
    }

    fn linearize(
        &mut self,
        x: &DVector<f64>,
        residual: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) -> Result<(), EvaluationError> {
        let (rows, motion) = self.at(&x.fixed_rows::<6>(0).into_owned());
        residual.copy_from(&rows);
        jacobian.copy_from(&motion);
        Ok(())
    }
}

/// Newton steps that end the search for the pose of more than six equations.
const NEWTON_STEPS: usize = 20;
/// Change of the motion, m and rad, for second derivatives.
const DIFFERENCE: f64 = 1e-5;
/// A step by less than this, m and rad, is rounding.
const ROUNDING: f64 = 1e-13;

impl<F: FnMut(&[f64], &Pose) -> (DVector<f64>, DMatrix<f64>)> ManyRows<'_, F> {
    /// Residual and Jacobian at a motion from the seed.
    fn at(&mut self, x: &Vector6<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let (residual, mut jacobian) = (self.rows)(self.joints, &self.seed.moved(x));
        // Small turns on top of the rotation vector ω: exp(ω + dω) = exp(J dω) exp(ω).
        let w = Vector3::new(x[3], x[4], x[5]);
        let (angle, cross) = (w.norm(), w.cross_matrix());
        let (b, c) = if angle > 1e-4 {
            ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3))
        } else {
            (0.5, 1.0 / 6.0)
        };
        let turns = Matrix3::identity() + cross * b + cross * cross * c;
        let turned = jacobian.columns(3, 3) * turns;
        jacobian.columns_mut(3, 3).copy_from(&turned);
        (residual, jacobian)
    }

    /// The minimum near `x`. Equations that contradict each other leave a residual `f`, with which Gauss–Newton only creeps;
    /// with `Σ fᵢ ∇²fᵢ`, from differences of the Jacobian, the steps are Newton's.
    fn minimum(&mut self, mut x: Vector6<f64>) -> Option<Vector6<f64>> {
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let (f, jacobian) = self.at(&x);
            let mut bent = Matrix6::zeros();
            if f.amax() > SETTLED {
                for k in 0..6 {
                    let step = Vector6::ith(k, DIFFERENCE);
                    let change = self.at(&(x + step)).1 - self.at(&(x - step)).1;
                    bent.set_column(k, &(change.tr_mul(&f) / (2.0 * DIFFERENCE)).fixed_rows::<6>(0));
                }
            }
            let hessian = jacobian.tr_mul(&jacobian).fixed_view::<6, 6>(0, 0) + 0.5 * (bent + bent.transpose());
            let step = hessian.cholesky()?.solve(&jacobian.tr_mul(&f).fixed_rows::<6>(0).into_owned());
            let size = step.amax();
            let grows = size >= last;
            if !size.is_finite() || grows && size > SETTLED {
                return None;
            }
            x -= step;
            last = size;
            if size <= ROUNDING || grows {
                break;
            }
        }
        (last <= SETTLED).then_some(x)
    }
}

/// The pose in which more than six closure equations hold best.
fn best_pose(
    joints: &[f64],
    seed: &Pose,
    equations: usize,
    rows: &mut impl FnMut(&[f64], &Pose) -> (DVector<f64>, DMatrix<f64>),
) -> Result<NewtonSolution<Pose>, NewtonError> {
    let mut problem = ManyRows { rows, joints, seed: *seed, equations };
    let options = LeastSquaresOptions { residual_floor: 3e-16, max_iterations: 50, ..Default::default() };
    let method = LeastSquaresMethod::LevenbergMarquardt;
    let (near, iterations, left) = match least_squares(&mut problem, DVector::zeros(6), method, &options) {
        Ok(LeastSquaresSolution { x, history, .. }) => (x, history.len(), (0.0, 0.0)),
        // The way from here is that of Newton's steps, if it is near.
        Err(SolveError::NoConvergence { iterations, cost, step, last }) => (last.x, iterations, (cost, step)),
        Err(SolveError::NotFinite { iterations }) => {
            return Err(NewtonError::NotFinite { iterations: iterations as u64 });
        }
        Err(_) => return Err(NewtonError::Singular { iterations: 0, pivot_ratio: 0.0 }),
    };
    let iterations = iterations as u64;
    match problem.minimum(near.fixed_rows::<6>(0).into_owned()) {
        // With more than six rows there is no sign that tells the sides of a singularity apart.
        Some(x) => Ok(NewtonSolution { point: seed.moved(&x), iterations, determinant: 0.0 }),
        None => Err(NewtonError::NoConvergence {
            iterations,
            residual: (2.0 * left.0).sqrt(),
            step: left.1,
            residuals: Vector6::repeat(f64::NAN),
        }),
    }
}

/// The pose near a seed that misses the closure equations least, for joints that lead to none; a rough one, and no root.
pub(crate) fn nearest_pose(mechanism: &dyn Mechanism, joints: &[f64], at: &Conditions, seed: &Pose) -> Option<Pose> {
    let mut work = Linearization::sized_for(mechanism);
    let mut rows = |joints: &[f64], pose: &Pose| {
        mechanism.linearize(mechanism.values(), joints, pose, at, &mut work);
        (work.residual.clone(), work.motion.clone())
    };
    let mut problem = ManyRows { rows: &mut rows, joints, seed: *seed, equations: mechanism.equations() };
    let options = LeastSquaresOptions { max_iterations: 50, ..Default::default() };
    match least_squares(&mut problem, DVector::zeros(6), LeastSquaresMethod::LevenbergMarquardt, &options) {
        Ok(LeastSquaresSolution { x, .. }) => Some(x),
        Err(SolveError::NoConvergence { last, .. }) => Some(last.x),
        Err(_) => None,
    }
    .map(|x| seed.moved(&x.fixed_rows::<6>(0).into_owned()))
}

/// Forward kinematics from closure equations: `rows` gives the residual (m) and `J₁` (m × 6) for joints and a pose,
/// `seed_joints` those of the seed.
///
/// # Errors
/// [`KinematicsError`]; see [`Mechanism::forward`].
pub fn forward_by_rows(
    joints: &[f64],
    seed: &Pose,
    seed_joints: impl FnOnce() -> Result<Vec<f64>, KinematicsError>,
    mut rows: impl FnMut(&[f64], &Pose) -> (DVector<f64>, DMatrix<f64>),
) -> Result<Pose, KinematicsError> {
    let (_, motion) = rows(joints, seed);
    if motion.nrows() > 6 {
        let solve = |joints: &[f64], seed: &Pose| best_pose(joints, seed, motion.nrows(), &mut rows);
        return continuation(joints, seed, seed_joints, 0.0, solve);
    }
    // The starting pose tells on which side of the singularities the mechanism works.
    let side = motion.determinant().signum();
    continuation(joints, seed, seed_joints, side, |joints, seed| {
        newton(SixRows { rows: &mut rows, joints }, *seed, NewtonOptions::default())
    })
}

/// Forward kinematics of any mechanism from its closure equations.
///
/// # Errors
/// [`KinematicsError`]; see [`Mechanism::forward`].
pub fn forward_by_closure<M: Mechanism + ?Sized>(
    mechanism: &M,
    c: &[f64],
    joints: &[f64],
    at: &Conditions,
    seed: &Pose,
) -> Result<Pose, KinematicsError> {
    let expected = mechanism.joints().len();
    if joints.len() != expected {
        return Err(KinematicsError::JointCount { expected, found: joints.len() });
    }
    let mut work = Linearization::sized_for(mechanism);
    forward_by_rows(
        joints,
        seed,
        || mechanism.inverse(c, seed, at),
        |joints, pose| {
            mechanism.linearize(c, joints, pose, at, &mut work);
            (work.residual.clone(), work.motion.clone())
        },
    )
}

/// The pose that a mechanism takes when its controlled coordinates are those of `pose`, and its joints. Mechanisms that
/// control all six take every pose as it is.
///
/// # Errors
/// [`KinematicsError`] if there is none.
pub fn consistent<M: Mechanism + ?Sized>(
    mechanism: &M,
    c: &[f64],
    pose: &Pose,
    at: &Conditions,
) -> Result<(Pose, Vec<f64>), KinematicsError> {
    let joints = mechanism.inverse(c, pose, at)?;
    if mechanism.controlled() == [true; 6] {
        return Ok((*pose, joints));
    }
    Ok((mechanism.forward(c, &joints, at, pose)?, joints))
}

/// Motion (6 × L) at a pose, per unit of each parameter: of the platform point `pivot` (platform frame, m), and the
/// small rotation of the platform (rad).
///
/// # Errors
/// [`KinematicsError`] if the pose has no joints or no motion block.
pub fn motion_of_point(
    mechanism: &dyn Mechanism,
    pose: &Pose,
    pivot: &Vector3<f64>,
) -> Result<DMatrix<f64>, KinematicsError> {
    let (c, at) = (mechanism.values(), Conditions::unknown());
    let (pose, joints) = consistent(mechanism, c, pose, &at)?;
    let mut block = MotionBlock::sized_for(mechanism);
    mechanism.motion_block(c, &joints, &pose, &at, &mut block)?;
    let mut moved = DMatrix::from_column_slice(6, block.parameters.ncols(), block.parameters.as_slice());
    carry_to_point(&mut moved, &(pose.rotation * pivot));
    Ok(moved)
}

/// Turns small motions of the platform (columns) into those of a point of it, at `lever` from its origin in base axes.
pub(crate) fn carry_to_point(motions: &mut DMatrix<f64>, lever: &Vector3<f64>) {
    for mut column in motions.column_iter_mut() {
        let shift = Vector3::new(column[3], column[4], column[5]).cross(lever);
        column.rows_mut(0, 3).add_assign(&shift);
    }
}

/// Motion block of any mechanism from its closure equations: `-J₁⁺ [J₂, Jⱼ]`.
///
/// # Errors
/// [`KinematicsError::Singular`] where `J₁` has no full rank.
pub fn motion_block_by_closure<M: Mechanism + ?Sized>(
    mechanism: &M,
    c: &[f64],
    joints: &[f64],
    pose: &Pose,
    at: &Conditions,
    out: &mut MotionBlock,
) -> Result<(), KinematicsError> {
    let mut work = Linearization::sized_for(mechanism);
    mechanism.linearize(c, joints, pose, at, &mut work);
    let qr = work.motion.qr();
    let upper = qr.r();
    let pivots = upper.diagonal().abs();
    let pivot_ratio = pivots.min() / pivots.max();
    if !(pivot_ratio > 1e-12) {
        return Err(KinematicsError::Singular { pivot_ratio });
    }
    let apply = |mut rhs: DMatrix<f64>| {
        qr.q_tr_mul(&mut rhs);
        upper.solve_upper_triangular(&rhs.rows(0, 6).into_owned())
    };
    if work.parameters.iter().chain(work.joints.iter()).any(|v| !v.is_finite()) {
        return Err(KinematicsError::NotFinite { what: "a derivative of the closure".into() });
    }
    let singular = || KinematicsError::Singular { pivot_ratio };
    out.parameters.copy_from(&-apply(work.parameters).ok_or_else(singular)?);
    out.joints.copy_from(&-apply(work.joints).ok_or_else(singular)?);
    Ok(())
}
