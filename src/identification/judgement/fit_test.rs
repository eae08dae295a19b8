//! The test of a model against the noise, from the rows of its problem.

use nalgebra::DVector;

use crate::identification::error::IdentifyError;
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::task::{Task, Weights};
use crate::measurement::SamplePosition;
use crate::pose::Pose;
use crate::solve::{linearized, with_unit_columns};

impl GoodnessOfFit {
    /// The test at `x`, where the samples have these `poses`, without the samples at the positions `left_out`.
    pub(crate) fn at(
        task: &Task<'_>,
        x: &DVector<f64>,
        poses: &[Pose],
        left_out: &[SamplePosition],
    ) -> Result<Self, IdentifyError> {
        let weighted = Task { weights: Weights::Noise, ..*task };
        let kept: Vec<usize> = (0..task.data.len()).filter(|k| !left_out.contains(&SamplePosition(*k))).collect();
        let data = task.data.subset(&kept);
        let mut problem = CalibrationProblem::new(&Task { data: &data, ..weighted }, None, 1.0)?;
        problem.start_from(kept.iter().map(|k| poses[*k]));
        let (mut r, j) = linearized(&mut problem, x)?;
        let (j, _) = with_unit_columns(j);
        let (m, n) = j.shape();
        let svd = j.svd(true, false);
        let largest = svd.singular_values.max();
        let mut rank = 0;
        if let Some(u) = &svd.u {
            for k in (0..n.min(m)).filter(|k| svd.singular_values[*k] > 1e-10 * largest) {
                rank += 1;
                let along = u.column(k).dot(&r);
                r.axpy(-along, &u.column(k), 1.0);
            }
        }
        Ok(Self { chi_square: r.norm_squared(), degrees_of_freedom: m - rank, noise_known: task.data.noise.known })
    }

    /// The verdict on a model that cannot even be evaluated at its samples.
    pub(crate) fn beyond_measure(task: &Task<'_>) -> Self {
        let free = task.data.row_count().saturating_sub(task.mechanism.parameters().len());
        Self { chi_square: f64::INFINITY, degrees_of_freedom: free, noise_known: task.data.noise.known }
    }
}
