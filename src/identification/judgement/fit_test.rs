//! The test of a model against the noise, from the rows of its problem.

use nalgebra::{DMatrix, DVector};

use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::measurement::SamplePosition;
use crate::solve::Triangle;

impl GoodnessOfFit {
    /// The test of a fit, without the samples that it takes for gross errors.
    pub(crate) fn of(problem: &CalibrationProblem<'_>, fit: &Fit) -> Result<Self, IdentifyError> {
        match problem.data_at(&fit.values) {
            Ok((residual, jacobian)) => Ok(Self::of_rows(problem, &Self::rows(problem, fit, &residual, &jacobian))),
            // Data that were misread can lead to a model that does not reach its own samples.
            Err(IdentifyError::Solve(_)) => Ok(Self::beyond_measure(problem)),
            Err(other) => Err(other),
        }
    }

    /// The rows that are tested, folded together: those of the data, for the noise as stated, without gross errors.
    pub(crate) fn rows(
        problem: &CalibrationProblem<'_>,
        fit: &Fit,
        residual: &DVector<f64>,
        jacobian: &DMatrix<f64>,
    ) -> Triangle {
        let mut rows = Triangle::empty(fit.values.len());
        let mut next = 0;
        for (k, (first, n)) in problem.sample_rows().into_iter().enumerate() {
            if fit.gross.contains(&SamplePosition(k)) {
                rows.add(jacobian, residual, next..first, 1.0);
                next = first + n;
            }
        }
        rows.add(jacobian, residual, next..residual.len(), 1.0);
        rows
    }

    /// The test of these rows.
    pub(crate) fn of_rows(problem: &CalibrationProblem<'_>, rows: &Triangle) -> Self {
        let (chi_square, rank) = rows.misfit();
        let noise_known = problem.data().noise.known;
        Self { chi_square, degrees_of_freedom: rows.rows().saturating_sub(rank), noise_known }
    }

    /// The verdict on a model that cannot even be evaluated at its samples.
    pub(crate) fn beyond_measure(problem: &CalibrationProblem<'_>) -> Self {
        let free = problem.data().row_count().saturating_sub(problem.mechanism_parameters());
        Self { chi_square: f64::INFINITY, degrees_of_freedom: free, noise_known: problem.data().noise.known }
    }
}
