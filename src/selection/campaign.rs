//! A planned campaign: the block of rows of a pose, from a mechanism, a workspace and a scaling, and whether the pose
//! can be measured.

use nalgebra::{Cholesky, DMatrix, Dim, Dyn, Matrix, Matrix6, Matrix6xX, StorageMut, Vector3};

use super::SelectionError;
use crate::conditions::Conditions;
use crate::measurement::Noise;
use crate::mechanism::{
    KinematicsError, Linearization, Mechanism, MotionBlock, ParameterSpec, Workspace, characteristic_length,
    consistent, motion_of_point,
};
use crate::observability::{Block, Scaling};
use crate::pose::{Pose, PoseConvention};
use crate::solve::{inverse6, singular_values};

/// Poses with a worse condition of `J₁` (angles times the platform radius) are not measured.
const WORST_CONDITION: f64 = 1e3;

/// Where poses are measured, and in which units indices are taken.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    /// The mechanism.
    pub mechanism: &'a dyn Mechanism,
    /// The box that poses are chosen from.
    pub workspace: Workspace,
    /// How rows and columns are scaled.
    pub scaling: Scaling,
    columns: Vec<f64>,
    /// Covariance of the six measured coordinates in units of the scaling.
    covariance: Matrix6<f64>,
    joint: f64,
    size: f64,
    /// Sign of `det J₁` at home.
    side: f64,
}

/// Why a pose is not measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Infeasible {
    /// It has no joints, or lies beyond a singularity as seen from home.
    Unreachable,
    /// A joint would leave its stroke.
    OutsideStroke,
    /// It is too near to a singularity.
    IllConditioned,
}

impl<'a> Campaign<'a> {
    /// Measuring full poses with this noise.
    ///
    /// # Errors
    /// [`SelectionError`] if the scaling needs a noise or tolerances that are not known.
    pub fn new(
        mechanism: &'a dyn Mechanism,
        workspace: &Workspace,
        noise: Option<&Noise>,
        scaling: Scaling,
    ) -> Result<Self, SelectionError> {
        let column = |s: &ParameterSpec| {
            let missing = || SelectionError::NoTolerance { parameter: s.name.clone() };
            scaling.column(s.dimension, s.tolerance).ok_or_else(missing)
        };
        let columns: Result<Vec<f64>, SelectionError> = mechanism.parameters().iter().map(column).collect();
        Self::with_columns(mechanism, workspace, noise, scaling, columns?)
    }

    /// A campaign with these column factors, for mechanisms without tolerances.
    ///
    /// # Errors
    /// [`SelectionError::NoNoise`] if whitened rows have no noise.
    pub fn with_columns(
        mechanism: &'a dyn Mechanism,
        workspace: &Workspace,
        noise: Option<&Noise>,
        scaling: Scaling,
        columns: Vec<f64>,
    ) -> Result<Self, SelectionError> {
        let (position, rotation, joint) = match (scaling, noise) {
            // Rows in mm and in rad: their units take the place of the noise.
            (Scaling::Paper, _) => (1e-3, 1.0, 0.0),
            (Scaling::Whitened, Some(n)) if n.position > 0.0 && n.rotation > 0.0 => (n.position, n.rotation, n.joint),
            (Scaling::Whitened, _) => return Err(SelectionError::NoNoise),
        };
        let sigma = [position, position, position, rotation, rotation, rotation];
        let mut campaign = Self {
            mechanism,
            workspace: *workspace,
            scaling,
            columns,
            covariance: Matrix6::from_diagonal(&sigma.map(|s: f64| s * s).into()),
            joint,
            size: characteristic_length(mechanism),
            side: 0.0,
        };
        if let Ok((_, at_home)) = campaign.linearize(&mechanism.home())
            && at_home.motion.nrows() == 6
        {
            campaign.side = at_home.motion.determinant().signum();
        }
        Ok(campaign)
    }

    fn linearize(&self, pose: &Pose) -> Result<(Vec<f64>, Linearization), KinematicsError> {
        let (m, at) = (self.mechanism, Conditions::unknown());
        let joints = m.inverse(m.values(), pose, &at)?;
        let mut out = Linearization::sized_for(m);
        m.linearize(m.values(), &joints, pose, &at, &mut out);
        let numbers = out.motion.iter().chain(out.parameters.iter()).chain(out.joints.iter());
        if numbers.chain(&joints).any(|v| !v.is_finite()) {
            return Err(KinematicsError::NotFinite { what: "a derivative of the closure".into() });
        }
        Ok((joints, out))
    }

    /// The pose that the mechanism takes when its controlled coordinates are those of `pose`; `pose` itself if there is
    /// none.
    pub fn consistent(&self, pose: &Pose) -> Pose {
        if self.mechanism.controlled() == [true; 6] {
            return *pose;
        }
        let (m, at) = (self.mechanism, Conditions::unknown());
        consistent(m, m.values(), pose, &at).map_or(*pose, |(taken, _)| taken)
    }

    /// Whether the platform can be measured at a pose: joints in their strokes, reached from home without passing a
    /// singularity, well conditioned; and its block if so.
    ///
    /// # Errors
    /// [`Infeasible`] with the reason.
    pub fn feasible(&self, pose: &Pose) -> Result<Block, Infeasible> {
        self.placed(pose).map(|(_, block)| block)
    }

    /// The joints of a pose that can be measured, and its block.
    pub(super) fn placed(&self, pose: &Pose) -> Result<(Vec<f64>, Block), Infeasible> {
        let (joints, rows) = self.linearize(pose).map_err(|_| Infeasible::Unreachable)?;
        if !(rows.residual.amax() <= 1e-8 * self.size.max(1.0)) {
            return Err(Infeasible::Unreachable);
        }
        if !self.mechanism.within_strokes(&joints) {
            return Err(Infeasible::OutsideStroke);
        }
        let mut motion = rows.motion.clone();
        if self.side != 0.0 && motion.determinant() * self.side <= 0.0 {
            return Err(Infeasible::Unreachable);
        }
        for k in 3..6 {
            motion.column_mut(k).unscale_mut(self.size);
        }
        if !well_conditioned(motion) {
            return Err(Infeasible::IllConditioned);
        }
        let block = self.block_of(pose, &joints, &rows).map_err(|_| Infeasible::IllConditioned)?;
        Ok((joints, block))
    }

    /// The scaled block of a pose.
    ///
    /// # Errors
    /// [`KinematicsError`] where it has none.
    pub fn block(&self, pose: &Pose) -> Result<Block, KinematicsError> {
        let (joints, rows) = self.linearize(pose)?;
        self.block_of(pose, &joints, &rows)
    }

    fn block_of(&self, pose: &Pose, joints: &[f64], rows: &Linearization) -> Result<Block, KinematicsError> {
        let rates = self.workspace.rates(pose);
        let singular = || KinematicsError::Singular { pivot_ratio: 0.0 };
        let block = if rows.motion.nrows() == 6 {
            let motion: Matrix6<f64> = rows.motion.fixed_view::<6, 6>(0, 0).into_owned();
            let seen = motion * rates.try_inverse().ok_or_else(singular)?;
            let mut noise = seen * self.covariance * seen.transpose();
            if self.joint > 0.0 {
                let joints = &rows.joints * rows.joints.transpose() * self.joint.powi(2);
                noise += joints.fixed_view::<6, 6>(0, 0);
            }
            let mut derivatives = Matrix6xX::from_iterator(self.columns.len(), rows.parameters.iter().copied());
            self.scale_columns(&mut derivatives);
            Block { noise, derivatives }
        } else {
            let mut motion = MotionBlock::sized_for(self.mechanism);
            let (m, at) = (self.mechanism, Conditions::unknown());
            m.motion_block(m.values(), joints, pose, &at, &mut motion)?;
            let by_joints = rates * motion.joints * self.joint;
            let covariance = self.covariance + by_joints.clone() * by_joints.transpose();
            let lower = Cholesky::new(covariance).ok_or_else(singular)?.unpack();
            let mut derivatives = rates * motion.parameters;
            if !lower.solve_lower_triangular_mut(&mut derivatives) {
                return Err(singular());
            }
            self.scale_columns(&mut derivatives);
            Block { noise: Matrix6::identity(), derivatives }
        };
        let finite = block.noise.iter().chain(block.derivatives.iter()).all(|v| v.is_finite());
        if finite && Cholesky::new(block.noise).is_some() { Ok(block) } else { Err(singular()) }
    }

    fn scale_columns<R: Dim, S: StorageMut<f64, R, Dyn>>(&self, derivatives: &mut Matrix<f64, R, Dyn, S>) {
        for (mut column, scale) in derivatives.column_iter_mut().zip(&self.columns) {
            column.scale_mut(*scale);
        }
    }

    /// Factor of each column, SI per scaled parameter.
    pub fn columns(&self) -> &[f64] {
        &self.columns
    }

    /// Motion (6 × L) of the point whose position is stated, and small rotation of the platform, per scaled parameter:
    /// m and rad.
    ///
    /// # Errors
    /// [`KinematicsError`] where it has none.
    pub fn motion(&self, pose: &Pose) -> Result<DMatrix<f64>, KinematicsError> {
        let mut moved = motion_of_point(self.mechanism, pose, &self.workspace.convention.pivot)?;
        self.scale_columns(&mut moved);
        Ok(moved)
    }

    /// Motion (6 × L) of the six coordinates in units of their noise, per scaled parameter.
    ///
    /// # Errors
    /// [`KinematicsError`] where it has none.
    pub fn weighted_rates(&self, pose: &Pose) -> Result<DMatrix<f64>, KinematicsError> {
        let rates = self.workspace.rates(pose);
        let mut moved = rates * motion_of_point(self.mechanism, pose, &Vector3::zeros())?;
        self.scale_columns(&mut moved);
        for (k, mut row) in moved.row_iter_mut().enumerate() {
            row.unscale_mut(self.covariance[(k, k)].sqrt());
        }
        Ok(DMatrix::from_iterator(6, moved.ncols(), moved.iter().copied()))
    }

    /// The convention in which poses are stated and measured.
    pub fn convention(&self) -> &PoseConvention {
        &self.workspace.convention
    }
}

/// Whether the condition number is below the limit. It is at most `|A|_F |A⁻¹|_F`, which needs no decomposition and
/// decides nearly every pose.
fn well_conditioned(motion: DMatrix<f64>) -> bool {
    if motion.shape() == (6, 6) {
        let square: Matrix6<f64> = motion.fixed_view::<6, 6>(0, 0).into_owned();
        // Far from the limit, so that rounding in the inverse cannot matter.
        if inverse6(&square).is_some_and(|inverse| square.norm() * inverse.norm() < 0.5 * WORST_CONDITION) {
            return true;
        }
    }
    let sigma = singular_values(motion);
    sigma.max() < WORST_CONDITION * sigma.min()
}
