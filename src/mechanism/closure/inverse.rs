//! Inverse kinematics of a closure: the joints, and the coordinates of the pose that the joints do not control.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::evaluation::Derivatives;
use crate::mechanism::KinematicsError;
use crate::pose::{Pose, PoseConvention};
use crate::solve::{
    EvaluationError, LeastSquaresMethod, LeastSquaresOptions, LeastSquaresProblem, SolveError, least_squares,
};

/// Residual and derivatives along motion and joints at a pose.
pub(super) trait Rows {
    /// Closure equations without passive ones.
    fn equations(&self) -> usize;
    /// Residual, motion and columns of the joints.
    fn rows(&self, joints: &[f64], pose: &Pose) -> Derivatives;
}

/// A root of the closure: the pose (its controlled coordinates are those asked for) and its joints.
#[derive(Clone, Debug)]
pub(super) struct Root {
    pub(super) pose: Pose,
    pub(super) joints: Vec<f64>,
}

struct Problem<'a> {
    rows: &'a dyn Rows,
    target: [f64; 6],
    /// Coordinates of the pose that are unknown.
    dependent: &'a [usize],
    joints: usize,
}

impl Problem<'_> {
    fn split(&self, x: &DVector<f64>) -> (Vec<f64>, Pose) {
        let mut q = self.target;
        for (k, value) in self.dependent.iter().zip(x.iter().skip(self.joints)) {
            q[*k] = *value;
        }
        (x.as_slice()[..self.joints].to_vec(), Pose::from_coordinates(&q))
    }
}

impl LeastSquaresProblem for Problem<'_> {
    fn shape(&self) -> (usize, usize) {
        (self.rows.equations(), self.joints + self.dependent.len())
    }

    fn linearize(
        &mut self,
        x: &DVector<f64>,
        residual: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) -> Result<(), EvaluationError> {
        let (joints, pose) = self.split(x);
        let d = self.rows.rows(&joints, &pose);
        residual.copy_from(&d.residual);
        jacobian.columns_mut(0, self.joints).copy_from(&d.columns);
        if !self.dependent.is_empty() {
            let back = PoseConvention::default()
                .rates(&pose)
                .try_inverse()
                .ok_or_else(|| -> EvaluationError { Arc::new(KinematicsError::Singular { pivot_ratio: 0.0 }) })?;
            for (column, k) in self.dependent.iter().enumerate() {
                jacobian.set_column(self.joints + column, &(&d.motion * back.column(*k)));
            }
        }
        Ok(())
    }
}

/// Parts of the way from home in which a far pose is approached.
const PARTS: [usize; 3] = [1, 4, 16];
/// What is left of the closure when it is closed, m per m of size.
const CLOSED: f64 = 1e-9;

/// The root at which the coordinates of `pose` that are not dependent hold, on the branch of `home`.
///
/// # Errors
/// [`KinematicsError::NoRoot`] if the loops do not close there.
pub(super) fn root(
    rows: &dyn Rows,
    pose: &Pose,
    dependent: &[usize],
    home: &Root,
    size: f64,
) -> Result<Root, KinematicsError> {
    let (from, to) = (home.pose.coordinates(), pose.coordinates());
    let mut failure = KinematicsError::NoRoot { residual: f64::NAN };
    for parts in PARTS {
        let mut here = Root { pose: home.pose, joints: home.joints.clone() };
        let mut reached = true;
        for part in 1..=parts {
            let s = part as f64 / parts as f64;
            // On the last part exactly the coordinates that were asked for.
            let target = std::array::from_fn(|k| if part == parts { to[k] } else { from[k] + s * (to[k] - from[k]) });
            match step(rows, target, dependent, &here, size) {
                Ok(next) => here = next,
                Err(cause) => {
                    failure = cause;
                    reached = false;
                    break;
                }
            }
        }
        if reached {
            return Ok(here);
        }
    }
    Err(failure)
}

fn step(
    rows: &dyn Rows,
    target: [f64; 6],
    dependent: &[usize],
    from: &Root,
    size: f64,
) -> Result<Root, KinematicsError> {
    let joints = from.joints.len();
    let mut problem = Problem { rows, target, dependent, joints };
    let q = from.pose.coordinates();
    let start = DVector::from_iterator(
        joints + dependent.len(),
        from.joints.iter().copied().chain(dependent.iter().map(|k| q[*k])),
    );
    let options = LeastSquaresOptions { residual_floor: 1e-15 * size, max_iterations: 60, ..Default::default() };
    let solution = match least_squares(&mut problem, start, LeastSquaresMethod::LevenbergMarquardt, &options) {
        Ok(solution) => solution,
        Err(SolveError::NoConvergence { last, .. }) => *last,
        Err(SolveError::NotFinite { .. }) => {
            return Err(KinematicsError::NotFinite { what: "the closure at this pose".into() });
        }
        Err(_) => return Err(KinematicsError::NoRoot { residual: f64::NAN }),
    };
    let residual = solution.residual.amax();
    if !(residual <= CLOSED * size) {
        return Err(KinematicsError::NoRoot { residual });
    }
    let (found, pose) = problem.split(&solution.x);
    // Where a joint's effect on the loops turned round, its way led past a dead point to another branch.
    let effect = |joints: &[f64], pose: &Pose| {
        let d = rows.rows(joints, pose);
        d.unreduced.unwrap_or(d.columns)
    };
    let (before, after) = (effect(&from.joints, &from.pose), effect(&found, &pose));
    if (0..joints).any(|k| before.column(k).dot(&after.column(k)) <= 0.0) {
        return Err(KinematicsError::OtherBranch);
    }
    Ok(Root { pose, joints: found })
}
