//! The rows of a problem at a point: forward kinematics first, then readings and derivatives, sample by sample.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix6, Matrix6xX};

use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::prior::Prior;
use crate::identification::problem::redundancy::Redundancy;
use crate::identification::problem::start::sample_error;
use crate::measurement::Rows;
use crate::mechanism::{ForwardQuery, KinematicsError};
use crate::solve::{EvaluationError, LeastSquaresProblem};

impl CalibrationProblem<'_> {
    /// Brings the poses of the samples to the values `x`, where an iteration may have looked farther. Where that fails, they
    /// stay near.
    pub(crate) fn move_to(&mut self, x: &DVector<f64>) {
        // The rows at the same values are evaluated next and report the failure.
        let _ = self.solve_poses(&x.as_slice()[..self.mechanism_parameters()]);
    }

    /// Brings the poses of the samples to the parameters `c` of the mechanism. On failure they are those of no parameters,
    /// and starts for the next time.
    fn solve_poses(&mut self, c: &[f64]) -> Result<(), EvaluationError> {
        if self.solved_at.as_deref() == Some(c) {
            return Ok(());
        }
        self.solved_at = None;
        let query = |(k, seed)| {
            let sample = self.data.sample(k);
            ForwardQuery::new(&sample.joints, &sample.conditions, seed)
        };
        let queries: Vec<ForwardQuery<'_>> = self.poses.iter().copied().enumerate().map(query).collect();
        for (k, found) in self.mechanism.forward_batch(c, &queries).into_iter().enumerate() {
            let first = &self.samples[self.kept[k]].pose;
            // The pose of the time before may be that of a trial that was given up.
            let again = |cause| {
                let sample = self.data.sample(k);
                self.mechanism.forward(c, &sample.joints, &sample.conditions, first).map_err(|_| cause)
            };
            self.poses[k] = found
                .or_else(again)
                .map_err(|cause| -> EvaluationError { Arc::new(sample_error(&self.data, k, cause)) })?;
        }
        self.solved_at = Some(c.to_vec());
        Ok(())
    }

    /// Reading and derivatives of the `k`-th sample at its pose.
    fn evaluate_sample(&mut self, k: usize, c: &[f64], own: &[f64]) -> Result<(), KinematicsError> {
        let (sample, pose) = (self.data.sample(k), self.poses[k]);
        self.mechanism.motion_block(c, &sample.joints, &pose, &sample.conditions, &mut self.block)?;
        let prepared = &self.samples[self.kept[k]];
        let n = prepared.kinds.len() - self.redundancy.as_ref().map_or(0, Redundancy::rows);
        if self.rows.residual.len() != n {
            self.rows = Rows::sized(n, own.len());
        }
        self.rows.clear();
        self.data.evaluate(k, &pose, own, &mut self.rows);
        if let (Some(extra), Some(combinations)) = (&mut self.redundancy, &prepared.combinations) {
            extra.evaluate(self.mechanism, c, combinations, sample, &pose);
        }
        Ok(())
    }

    /// Writes the whitened rows of the `k`-th sample, which was evaluated, from row `first` on.
    fn write(&mut self, k: usize, first: usize, residual: &mut DVector<f64>, jacobian: &mut DMatrix<f64>) {
        let prepared = &self.samples[self.kept[k]];
        let (n, weight) = (prepared.kinds.len(), self.sample_weights[k] * self.row_factor());
        let (specs, own) = (self.block.parameters.ncols(), self.rows.own.ncols());
        if let Some(extra) = &self.redundancy {
            let all = stacked_with(&self.rows, &self.block.parameters, extra);
            let white = prepared.whitening.to_matrix() * all * weight;
            residual.rows_mut(first, n).copy_from(&white.column(0));
            jacobian.view_mut((first, 0), (n, specs + own)).copy_from(&white.columns(1, specs + own));
            return;
        }
        // W H J_b with the small product first.
        prepared.whitening.apply(weight, &mut self.rows);
        let (rows, block) = (&self.rows, &self.block.parameters);
        let mut out = jacobian.view_mut((first, 0), (n, specs));
        if n == 6 {
            // Full poses, the usual case, with a static size: a general product packs its factors first.
            let wh: Matrix6<f64> = rows.motion.fixed_view::<6, 6>(0, 0).into_owned();
            for (mut to, column) in out.column_iter_mut().zip(block.column_iter()) {
                to.copy_from(&(wh * column));
            }
        } else {
            out.gemm(1.0, &rows.motion, block, 0.0);
        }
        if own > 0 {
            jacobian.view_mut((first, specs), (n, own)).copy_from(&rows.own);
        }
        residual.rows_mut(first, n).copy_from(&rows.residual);
    }
}

/// Residual and all derivatives of a sample (columns) of a redundant mechanism: rows of the reading, then those of the
/// closure.
fn stacked_with(rows: &Rows, block: &Matrix6xX<f64>, extra: &Redundancy) -> DMatrix<f64> {
    let (k, e) = (rows.residual.len(), extra.rows());
    let (specs, own) = (block.ncols(), rows.own.ncols());
    let mut all = DMatrix::zeros(k + e, 1 + specs + own);
    all.view_mut((0, 0), (k, 1)).copy_from(&rows.residual);
    all.view_mut((0, 1), (k, specs)).copy_from(&(&rows.motion * block));
    all.view_mut((0, 1 + specs), (k, own)).copy_from(&rows.own);
    all.view_mut((k, 0), (e, 1)).copy_from(&extra.residual);
    all.view_mut((k, 1), (e, specs)).copy_from(&extra.parameters);
    all
}

impl LeastSquaresProblem for CalibrationProblem<'_> {
    fn shape(&self) -> (usize, usize) {
        let prior = self.prior.as_ref().map_or(0, Prior::rows);
        (self.data_rows() + prior, self.mechanism_parameters() + self.data.model().nuisance_parameters().len())
    }

    fn linearize(
        &mut self,
        x: &DVector<f64>,
        residual: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) -> Result<(), EvaluationError> {
        let (c, own) = x.as_slice().split_at(self.mechanism_parameters());
        self.solve_poses(c)?;
        let mut first = 0;
        for k in 0..self.data.len() {
            self.evaluate_sample(k, c, own)
                .map_err(|cause| -> EvaluationError { Arc::new(sample_error(&self.data, k, cause)) })?;
            let n = self.samples[self.kept[k]].kinds.len();
            if n > 0 {
                self.write(k, first, residual, jacobian);
            }
            first += n;
        }
        if let Some(prior) = &self.prior {
            prior.write(x, first, residual, jacobian);
        }
        Ok(())
    }
}
