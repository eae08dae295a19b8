//! How the noise of positions compares with that of angles, where none is stated.

use crate::identification::estimators::fit::Fit;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::task::Weights;
use crate::measurement::RowKind;
use crate::solve::Triangle;

/// Fewest degrees of freedom from which a noise is estimated.
const FEWEST: f64 = 6.0;
/// Scales that differ by less than this part are taken as one.
const ALIKE: f64 = 0.05;

/// σ of positions and of angles over what they were taken as, for a fit of data whose noise is not stated: of each kind the
/// squares of its residuals over the rows that the parameters leave of it, `Σ r² / (n - Σ h)` with the leverages `h`
/// (restricted maximum likelihood). `None` where the noise is known, where there is one kind, or where they are alike.
pub(crate) fn noise_of_kinds(problem: &CalibrationProblem<'_>, fit: &Fit) -> Option<[f64; 2]> {
    if problem.data().noise.known || problem.weights() != Weights::Noise {
        return None;
    }
    let (r, j) = problem.all_at(&fit.values).ok()?;
    let (covariance, ..) = Triangle::of(&j, &r).covariance();
    let (mut squares, mut free) = ([0.0; 2], [0.0; 2]);
    let weights = problem.sample_rows().into_iter().zip(&fit.weights).flat_map(|((_, n), w)| vec![*w; n]);
    for (row, (kind, weight)) in problem.row_kinds().into_iter().zip(weights).enumerate() {
        let kind = usize::from(kind == RowKind::Rotation);
        squares[kind] += r[row] * r[row];
        let columns = j.row(row);
        free[kind] += weight - (columns * &covariance).dot(&columns);
    }
    let scales = [0, 1].map(|kind| (squares[kind] / free[kind]).sqrt());
    let usable = scales.iter().all(|s| s.is_finite() && *s > 0.0) && free.iter().all(|n| *n >= FEWEST);
    let alike = (scales[0] / scales[1] - 1.0).abs() < ALIKE;
    (usable && !alike).then(|| scales.map(|s| s * problem.noise_scale()))
}
