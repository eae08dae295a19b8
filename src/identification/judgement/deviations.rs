//! Deviations of readings from a model, as motions of the platform and as changes of the joints.

use nalgebra::{DMatrix, DVector, Vector6};

use crate::identification::error::IdentifyError;
use crate::identification::judgement::samples::each_sample;
use crate::measurement::{DataRow, Dataset, RowKind, Rows};
use crate::mechanism::{Mechanism, MotionBlock, characteristic_length};
use crate::pose::Pose;
use crate::solve::minimum_norm;

/// Deviation of one sample from the model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Deviation {
    /// The sample.
    pub row: DataRow,
    /// The pose that the model predicts, base frame.
    pub pose: Pose,
    /// The smallest motion `(δt, δω)` from the predicted platform to the measured one, m and rad in base axes. Directions that
    /// the reading does not see are zero.
    pub motion: Vector6<f64>,
    /// The change of each joint that would make this motion, SI; zero where joints cannot.
    pub joints: Vec<f64>,
    /// Measured minus predicted, m and rad, by row of the reading.
    pub readings: Vec<(RowKind, f64)>,
    /// Which of these is each quantity of a complete reading, `None` for one that was not measured.
    pub row_of_each: Vec<Option<usize>>,
}

/// Deviations of all samples from a model, in the order of the data. `own` as for [`evaluate`](crate::identification::evaluate).
///
/// The change of the joints is of first order: `J_h δh = δ` in the least-squares sense, with the motion per joint of
/// [`MotionBlock::joints`].
///
/// # Errors
/// [`IdentifyError::Sample`] if a sample has no pose.
pub fn deviations(mechanism: &dyn Mechanism, own: &[f64], data: &Dataset) -> Result<Vec<Deviation>, IdentifyError> {
    let arm = characteristic_length(mechanism);
    each_sample(mechanism, own, data, |k, pose, rows| {
        let motion = motion(rows, arm);
        Deviation {
            row: data.sample(k).row,
            pose: *pose,
            motion,
            joints: in_joints(mechanism, data, k, pose, &motion, arm),
            row_of_each: data.row_of_each(k),
            readings: data.rows(k).into_iter().zip(rows.residual.iter().map(|r| -r)).collect(),
        }
    })
}

/// The smallest motion that the readings ask for, angles counted by the arm.
fn motion(rows: &Rows, arm: f64) -> Vector6<f64> {
    let mut a = rows.motion.clone();
    a.columns_mut(3, 3).unscale_mut(arm);
    let mut motion = minimum_norm(a, &-&rows.residual);
    motion.rows_mut(3, 3).unscale_mut(arm);
    Vector6::from_iterator(motion.iter().copied())
}

fn in_joints(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    k: usize,
    pose: &Pose,
    motion: &Vector6<f64>,
    arm: f64,
) -> Vec<f64> {
    let sample = data.sample(k);
    let mut block = MotionBlock::sized_for(mechanism);
    if mechanism.motion_block(mechanism.values(), &sample.joints, pose, &sample.conditions, &mut block).is_err() {
        return vec![f64::NAN; sample.joints.len()];
    }
    let mut a = DMatrix::from_iterator(6, block.joints.ncols(), block.joints.iter().copied());
    a.rows_mut(3, 3).scale_mut(arm);
    let mut b = DVector::from_column_slice(motion.as_slice());
    b.rows_mut(3, 3).scale_mut(arm);
    minimum_norm(a, &b).iter().copied().collect()
}
