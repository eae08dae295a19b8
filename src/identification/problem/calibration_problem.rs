//! The least-squares problem behind every identifier.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix6, Matrix6xX};

use crate::identification::error::IdentifyError;
use crate::identification::problem::prior::Prior;
use crate::identification::problem::redundancy::Redundancy;
use crate::identification::problem::whitening::Whitening;
use crate::identification::task::{Task, Weights};
use crate::measurement::{Dataset, RowKind, Rows};
use crate::mechanism::{KinematicsError, Mechanism, MotionBlock};
use crate::pose::Pose;
use crate::solve::{EvaluationError, LeastSquaresProblem};

/// Whitened residual `W(ŷ(x) - y)` of a dataset, with prior rows `(x - x₀)/σ₀` below it.
///
/// Unknowns: the parameters of the mechanism, then those of the measurement. Forward kinematics of each sample
/// starts where it ended the time before.
pub struct CalibrationProblem<'a> {
    mechanism: &'a dyn Mechanism,
    data: &'a Dataset,
    prior: Option<Prior>,
    /// Covariance of each reading (k × k), joints included, for the noise as stated.
    covariances: Vec<DMatrix<f64>>,
    whitening: Vec<Whitening>,
    /// Square root of the weight of each sample; one but for robust fits.
    sample_weights: Vec<f64>,
    /// Rows that more than six closure equations add to each sample.
    redundancy: Option<Redundancy>,
    poses: Vec<Pose>,
    /// Poses at the start.
    first_poses: Vec<Pose>,
    kinds: Vec<Vec<RowKind>>,
    start: DVector<f64>,
    block: MotionBlock,
    /// Readings of the sample at hand; their number rarely changes from one sample to the next.
    rows: Rows,
}

impl<'a> CalibrationProblem<'a> {
    /// The problem of a task with this prior; `noise_scale` multiplies every σ of the readings.
    ///
    /// # Errors
    /// [`IdentifyError`] if a sample has no pose at the start or its noise is not positive.
    pub fn new(task: &Task<'a>, prior: Option<Prior>, noise_scale: f64) -> Result<Self, IdentifyError> {
        let (mechanism, data) = (task.mechanism, task.data);
        if data.is_empty() {
            return Err(IdentifyError::Empty);
        }
        let own = data.model().nuisance_parameters().len();
        let redundancy = Redundancy::of(mechanism, data.noise.joint);
        // Closure residuals are lengths.
        let extra = vec![RowKind::Position; redundancy.as_ref().map_or(0, Redundancy::rows)];
        let kinds: Vec<Vec<RowKind>> = (0..data.len()).map(|k| [data.rows(k), extra.clone()].concat()).collect();
        let (specs, c) = (mechanism.parameters().len(), mechanism.values());
        let mut problem = Self {
            mechanism,
            data,
            prior,
            covariances: Vec::new(),
            whitening: Vec::new(),
            sample_weights: vec![1.0; data.len()],
            poses: Vec::new(),
            first_poses: Vec::new(),
            start: DVector::from_column_slice(c),
            block: MotionBlock::sized_for(mechanism),
            rows: Rows::sized(kinds[0].len() - extra.len(), own),
            redundancy,
            kinds,
        };
        problem.poses = start_poses(mechanism, data)?;
        problem.first_poses.clone_from(&problem.poses);
        if own > 0 {
            let found = own_start(data, &problem.poses);
            if found.len() != own || found.iter().any(|v| !v.is_finite()) {
                return Err(IdentifyError::Start { expected: own, found: found.len() });
            }
            problem.start = DVector::from_iterator(specs + own, c.iter().chain(&found).copied());
        }
        for k in 0..data.len() {
            let covariance = problem.covariance_of(k)?;
            let whitening = problem.whitening_of(k, &covariance, task.weights, noise_scale)?;
            problem.covariances.push(covariance);
            problem.whitening.push(whitening);
        }
        Ok(problem)
    }

    fn covariance_of(&mut self, k: usize) -> Result<DMatrix<f64>, IdentifyError> {
        let mut covariance = self.data.covariance(k);
        let joint = self.data.noise.joint;
        if joint > 0.0 {
            // The closure residual has covariance J1 Σq J1ᵀ + Jj Σj Jjᵀ; seen from the reading the second term
            // is H (J1⁻¹ Jj) Σj (J1⁻¹ Jj)ᵀ Hᵀ.
            self.evaluate_sample(k, &self.start.clone()).map_err(|cause| sample_error(self.data, k, cause))?;
            let mut seen = &self.rows.motion * &self.block.joints;
            if let Some(extra) = &self.redundancy {
                let (k, e) = (seen.nrows(), extra.rows());
                covariance = covariance.resize(k + e, k + e, 0.0);
                seen = seen.insert_rows(k, e, 0.0);
                seen.rows_mut(k, e).copy_from(&extra.joints);
            }
            covariance += &seen * seen.transpose() * (joint * joint);
        }
        Ok(covariance)
    }

    fn whitening_of(
        &self,
        k: usize,
        covariance: &DMatrix<f64>,
        weights: Weights,
        noise_scale: f64,
    ) -> Result<Whitening, IdentifyError> {
        let kinds = &self.kinds[k];
        if weights == Weights::MillimetresAndRadians {
            let unit = kinds.iter().map(|kind| if *kind == RowKind::Position { 1e3 } else { 1.0 });
            return Ok(Whitening::Diagonal(DVector::from_iterator(kinds.len(), unit)));
        }
        let row = self.data.sample(k).row;
        Whitening::of(covariance, noise_scale).ok_or(IdentifyError::Covariance { row })
    }

    /// `Σₖ Aₖ Σₖ Aₖᵀ`: covariance of `A r` for the whitened residual `r`, with the columns of `a` in the
    /// order of the rows. Rows of a prior have unit covariance.
    pub fn covariance_through(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(a.nrows(), a.nrows());
        let mut next = 0;
        for (k, (first, n)) in self.sample_rows().into_iter().enumerate() {
            let part = a.columns(first, n) * self.whitening[k].to_matrix() * self.sample_weights[k];
            sum += &part * &self.covariances[k] * part.transpose();
            next = first + n;
        }
        let rest = a.columns(next, a.ncols() - next);
        sum + rest * rest.transpose()
    }

    /// Where the iteration starts: the values of the mechanism, then those of the measurement.
    pub fn start(&self) -> DVector<f64> {
        self.start.clone()
    }

    /// Data rows, without those of the prior.
    pub fn data_rows(&self) -> usize {
        self.kinds.iter().map(Vec::len).sum()
    }

    /// Number of parameters of the mechanism.
    pub fn mechanism_parameters(&self) -> usize {
        self.mechanism.parameters().len()
    }

    /// The prior, if there is one.
    pub fn prior(&self) -> Option<&Prior> {
        self.prior.as_ref()
    }

    /// First data row of each sample, and the number of its rows.
    pub fn sample_rows(&self) -> Vec<(usize, usize)> {
        let mut first = 0;
        let next = |kinds: &Vec<RowKind>| {
            let range = (first, kinds.len());
            first += kinds.len();
            range
        };
        self.kinds.iter().map(next).collect()
    }

    /// What each data row measures.
    pub fn row_kinds(&self) -> Vec<RowKind> {
        self.kinds.iter().flatten().copied().collect()
    }

    /// For each sample the matrix (k × k) that turns whitened rows back into SI.
    pub fn unwhitening(&self) -> Vec<DMatrix<f64>> {
        let back = |w: &Whitening| match w {
            Whitening::Diagonal(factors) => DMatrix::from_diagonal(&factors.map(|f| 1.0 / f)),
            // Lower triangular with a positive diagonal.
            Whitening::Lower(w) => w
                .solve_lower_triangular(&DMatrix::identity(w.nrows(), w.nrows()))
                .unwrap_or_else(|| DMatrix::zeros(w.nrows(), w.nrows())),
        };
        self.whitening.iter().map(back).collect()
    }

    /// Multiplies the rows of each sample by the square root of its weight.
    pub fn weigh_samples(&mut self, weights: &[f64]) {
        self.sample_weights = weights.iter().map(|w| w.sqrt()).collect();
    }

    /// Forward kinematics of the next evaluation starts at these poses, one for each sample.
    pub fn start_from(&mut self, poses: impl IntoIterator<Item = Pose>) {
        for (pose, start) in self.poses.iter_mut().zip(poses) {
            *pose = start;
        }
    }

    /// Poses that the last evaluation predicted.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    fn evaluate_sample(&mut self, k: usize, x: &DVector<f64>) -> Result<(), KinematicsError> {
        let (c, own) = x.as_slice().split_at(self.mechanism.parameters().len());
        let sample = self.data.sample(k);
        let forward = |seed: &Pose| self.mechanism.forward(c, &sample.joints, &sample.conditions, seed);
        // The pose of the time before may be that of a trial that was given up.
        let pose = forward(&self.poses[k]).or_else(|cause| forward(&self.first_poses[k]).map_err(|_| cause))?;
        self.poses[k] = pose;
        self.mechanism.motion_block(c, &sample.joints, &pose, &sample.conditions, &mut self.block)?;
        let n = self.kinds[k].len() - self.redundancy.as_ref().map_or(0, Redundancy::rows);
        if self.rows.residual.len() != n {
            self.rows = Rows::sized(n, own.len());
        }
        self.rows.clear();
        self.data.evaluate(k, &pose, own, &mut self.rows);
        if let Some(extra) = &mut self.redundancy {
            extra.evaluate(self.mechanism, c, k, sample, &pose);
        }
        Ok(())
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

/// Forward kinematics of each sample at the mechanism's values, from home or, if that fails, from the reading.
fn start_poses(mechanism: &dyn Mechanism, data: &Dataset) -> Result<Vec<Pose>, IdentifyError> {
    let solve = |k: usize| {
        pose_from_home(mechanism, data, k).or_else(|error| {
            let (sample, (model, index)) = (data.sample(k), data.reading(k));
            let seed = model.rigid_pose(index).map(|p| data.frames.platform(&p)).ok_or_else(|| error.clone())?;
            mechanism.forward(mechanism.values(), &sample.joints, &sample.conditions, &seed).map_err(|_| error)
        })
    };
    (0..data.len()).map(solve).collect()
}

/// Forward kinematics of the `k`-th sample at the mechanism's values, from home.
pub(crate) fn pose_from_home(mechanism: &dyn Mechanism, data: &Dataset, k: usize) -> Result<Pose, IdentifyError> {
    let sample = data.sample(k);
    mechanism
        .forward(mechanism.values(), &sample.joints, &sample.conditions, &mechanism.home())
        .map_err(|cause| sample_error(data, k, cause))
}

/// Start values of the measurement's own parameters, for the poses of the samples of `data`.
pub(crate) fn own_start(data: &Dataset, poses: &[Pose]) -> Vec<f64> {
    let mut all = vec![None; data.model().samples()];
    for (k, pose) in poses.iter().enumerate() {
        all[data.reading(k).1] = Some(*pose);
    }
    data.model().start(&all, &data.frames)
}

fn sample_error(data: &Dataset, k: usize, cause: KinematicsError) -> IdentifyError {
    let sample = data.sample(k);
    let label = sample.id.as_ref().map_or(String::new(), |id| format!(" ({id})"));
    IdentifyError::Sample { row: sample.row, label, cause }
}

impl LeastSquaresProblem for CalibrationProblem<'_> {
    fn shape(&self) -> (usize, usize) {
        let prior = self.prior.as_ref().map_or(0, Prior::rows);
        (self.data_rows() + prior, self.start.len())
    }

    fn linearize(
        &mut self,
        x: &DVector<f64>,
        residual: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) -> Result<(), EvaluationError> {
        let specs = self.mechanism_parameters();
        let own = x.len() - specs;
        let mut first = 0;
        for k in 0..self.data.len() {
            self.evaluate_sample(k, x)
                .map_err(|cause| -> EvaluationError { Arc::new(sample_error(self.data, k, cause)) })?;
            let n = self.kinds[k].len();
            if n == 0 {
                continue;
            }
            if let Some(extra) = &self.redundancy {
                let all = stacked_with(&self.rows, &self.block.parameters, extra);
                let white = self.whitening[k].to_matrix() * all * self.sample_weights[k];
                residual.rows_mut(first, n).copy_from(&white.column(0));
                jacobian.view_mut((first, 0), (n, specs + own)).copy_from(&white.columns(1, specs + own));
                first += n;
                continue;
            }
            // W H J_b with the small product first.
            self.whitening[k].apply(self.sample_weights[k], &mut self.rows);
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
            first += n;
        }
        if let Some(prior) = &self.prior {
            prior.write(x, first, residual, jacobian);
        }
        Ok(())
    }
}
