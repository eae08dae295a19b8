//! Identification that gross errors cannot pull away.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF};

use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::estimators::identifiers::Identifier;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::measurement::SamplePosition;
use crate::solve::{
    IterationRecord, LeastSquaresMethod, LeastSquaresOptions, LeastSquaresSolution, SolveError, least_squares,
    linearized, with_unit_columns,
};

/// How much a sample counts, by its whitened length `d` over the scale.
///
/// | loss | weight | far away |
/// |---|---|---|
/// | Huber | `min(1, c/d)` | keeps some influence; the minimum is unique |
/// | Tukey | `(1 - (d/c)²)²`, 0 beyond `c` | none; needs a start that is not itself pulled away |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loss {
    /// Bounded influence.
    Huber,
    /// Vanishing influence; the iteration begins with Huber.
    #[default]
    Tukey,
}

/// Iteratively reweighted least squares: a sample (a whole pose, since gross errors are those of a pose) gets a
/// weight by the length of its whitened residual, relative to a scale that is estimated from the median.
///
/// The tuning constant is computed for each number of rows `k`, so that 95 % of the efficiency of least
/// squares is kept when the noise is normal. Reference: Maronna, Martin, Yohai, *Robust Statistics*, 2006,
/// chapters 4 and 6.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Robust {
    /// The loss.
    pub loss: Loss,
    /// When the inner iterations stop.
    pub options: LeastSquaresOptions,
}

/// A sample farther out than this quantile of the noise, shared over all samples, is called a gross error.
const OUTLIER_LEVEL: f64 = 0.01;
const EFFICIENCY: f64 = 0.95;
const MAX_ROUNDS: usize = 60;
const SETTLED: f64 = 1e-4;
/// A sample that misses the mechanism as it is given by this many medians stands out.
const STANDS_OUT: f64 = 5.0;
/// Part of its noise that a sample of the highest leverage is taken to leave.
const SMALLEST_LEFT: f64 = 0.05;

impl Loss {
    /// Weight of a sample at distance `d` with tuning constant `c`.
    pub fn weight(self, d: f64, c: f64) -> f64 {
        match self {
            Self::Huber => {
                if d <= c {
                    1.0
                } else {
                    c / d
                }
            }
            Self::Tukey => {
                if d < c {
                    (1.0 - (d / c).powi(2)).powi(2)
                } else {
                    0.0
                }
            }
        }
    }

    /// Efficiency for `k`-dimensional normal residuals: `k η² / E[ψ²]` with `ψ = w(d) d` and
    /// `η = E[ψ' + (k-1) ψ/d]/k`, by the midpoint rule over the χ distribution.
    fn efficiency(self, k: usize, c: f64) -> f64 {
        let Ok(chi) = ChiSquared::new(k as f64) else { return f64::NAN };
        let (mut square, mut slope) = (0.0, 0.0);
        let step = 0.01;
        let psi = |d: f64| self.weight(d, c) * d;
        for i in 0..1200 {
            let d = (f64::from(i) + 0.5) * step;
            let density = 2.0 * d * chi.pdf(d * d) * step;
            let derivative = (psi(d + 1e-5) - psi(d - 1e-5)) / 2e-5;
            square += psi(d).powi(2) * density;
            slope += (derivative + (k as f64 - 1.0) * self.weight(d, c)) * density;
        }
        slope * slope / (k as f64 * square)
    }

    /// The tuning constant that keeps 95 % efficiency for samples of `k` rows.
    pub fn tuning(self, k: usize) -> f64 {
        let (mut low, mut high) = (0.1, 12.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if self.efficiency(k, middle) < EFFICIENCY {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

impl Identifier for Robust {
    fn name(&self) -> &str {
        "robust"
    }

    fn estimate(&self, problem: &mut CalibrationProblem<'_>) -> Result<Fit, IdentifyError> {
        problem.weigh_by_noise()?;
        let mut history = Vec::new();
        let losses: &[Loss] = match self.loss {
            Loss::Huber => &[Loss::Huber],
            Loss::Tukey => &[Loss::Huber, Loss::Tukey],
        };
        // The loss, unlike a sum of squares, may have other minima: every run begins at the start.
        problem.begin_at(problem.first_guess());
        let (mut scale, mut weights) = (1.0, first_weights(problem)?);
        for loss in losses {
            for _ in 0..MAX_ROUNDS {
                prepare(problem, scale, &weights)?;
                // A round that runs out of iterations still moves on; only the last one has to converge.
                let solution = match self.minimise(problem) {
                    Err(SolveError::NoConvergence { last, .. }) => *last,
                    other => other?,
                };
                history.extend_from_slice(&solution.history);
                let distances = distances(problem, &solution, &weights)?;
                // A stated noise is not improved upon: a scale below one would only make good samples look bad.
                let least = if problem.data().noise.known { 1.0 / scale } else { 0.0 };
                let shift = median_scale(&distances).max(least);
                let next: Vec<f64> = distances
                    .iter()
                    .map(|d| if d.rows == 0 { 1.0 } else { loss.weight(d.length / shift, tuned(*loss, d.rows)) })
                    .collect();
                let change = next.iter().zip(&weights).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                weights = next;
                scale *= shift;
                problem.begin_at(solution.x);
                if change < SETTLED && (shift - 1.0).abs() < 1e-3 {
                    break;
                }
            }
        }
        prepare(problem, scale, &weights)?;
        self.finish(problem, weights, history)
    }
}

/// The problem with the noise at `scale`. Gross errors blow the scale up while they still pull at the fit, and
/// must not talk the prior into it: with a stated noise the prior is the one that this noise asks for.
fn prepare(problem: &mut CalibrationProblem<'_>, scale: f64, weights: &[f64]) -> Result<(), IdentifyError> {
    problem.scale_noise(scale);
    problem.choose_prior(if problem.data().noise.known { 1.0 } else { scale })?;
    problem.weigh_samples(weights);
    Ok(())
}

impl Robust {
    fn minimise(&self, problem: &mut CalibrationProblem<'_>) -> Result<LeastSquaresSolution, SolveError> {
        let guess = problem.guess();
        least_squares(problem, guess, LeastSquaresMethod::LevenbergMarquardt, &self.options)
    }

    fn finish(
        &self,
        problem: &mut CalibrationProblem<'_>,
        weights: Vec<f64>,
        history: Vec<IterationRecord>,
    ) -> Result<Fit, IdentifyError> {
        let (solution, failure) = match self.minimise(problem) {
            Ok(solution) => (solution, None),
            Err(SolveError::NoConvergence { iterations, cost, step, last }) => {
                (*last.clone(), Some(SolveError::NoConvergence { iterations, cost, step, last }))
            }
            Err(cause) => return Err(cause.into()),
        };
        let level = OUTLIER_LEVEL / problem.data().len() as f64;
        let gross = |(k, d): (usize, &Distance)| {
            let limit = ChiSquared::new(d.rows as f64).map_or(f64::INFINITY, |chi| chi.inverse_cdf(1.0 - level));
            (d.length.powi(2) > limit).then_some(SamplePosition(k))
        };
        let gross = distances(problem, &solution, &weights)?.iter().enumerate().filter_map(gross).collect();
        let fit = Fit { weights, gross, history, ..Fit::new(&solution, 0) };
        match failure {
            None => Ok(fit),
            Some(cause) => Err(IdentifyError::NotConverged { cause, last: Box::new(fit) }),
        }
    }
}

/// Tuning constants are the same for all samples of a size; they are computed once.
fn tuned(loss: Loss, k: usize) -> f64 {
    use std::collections::HashMap;
    use std::sync::{Mutex, OnceLock};
    static KNOWN: OnceLock<Mutex<HashMap<(bool, usize), f64>>> = OnceLock::new();
    let known = KNOWN.get_or_init(Mutex::default);
    let key = (loss == Loss::Huber, k);
    // A poisoned lock only means that another thread panicked between two insertions of constants.
    let mut known = known.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    *known.entry(key).or_insert_with(|| loss.tuning(k))
}

/// Length of the whitened residual of a sample, for the noise at the scale of the problem.
struct Distance {
    /// Its length over what the fit leaves of the noise.
    length: f64,
    /// Its rows.
    rows: usize,
}

/// Distances of the samples at a solution. Each is divided by `√(1 - h/k)` with the leverage `h` of its `k` rows: a
/// sample that the fit follows closely leaves less of its noise.
fn distances(
    problem: &mut CalibrationProblem<'_>,
    solution: &LeastSquaresSolution,
    weights: &[f64],
) -> Result<Vec<Distance>, IdentifyError> {
    let (weighted, _) = with_unit_columns(solution.jacobian.clone());
    let q = weighted.qr().q();
    problem.weigh_samples(&vec![1.0; weights.len()]);
    let (residual, _) = linearized(problem, &solution.x)?;
    problem.weigh_samples(weights);
    let distance = |(k, (first, rows)): (usize, (usize, usize))| {
        // A sample that the fit does not follow keeps all of its noise, whatever its place.
        let leverage = weights[k].min(1.0) * q.rows(first, rows).norm_squared();
        let left = (1.0 - leverage / rows.max(1) as f64).max(SMALLEST_LEFT);
        Distance { length: residual.rows(first, rows).norm() / left.sqrt(), rows }
    };
    Ok(problem.sample_rows().into_iter().enumerate().map(distance).collect())
}

/// Scale of the noise: the median of `d²/mₖ` with `mₖ` the median of `χ²ₖ`.
fn median_scale(distances: &[Distance]) -> f64 {
    let ratio = |d: &Distance| {
        ChiSquared::new(d.rows as f64).ok().map(|chi| d.length.powi(2) / chi.inverse_cdf(0.5)).filter(|_| d.rows > 0)
    };
    let mut ratios: Vec<f64> = distances.iter().filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied().unwrap_or(1.0).sqrt().max(1e-12)
}

/// Weights for the first fit: none for samples whose misfit against the mechanism as it is given stands out of all
/// the others', so that errors larger than those of the mechanism never enter.
fn first_weights(problem: &CalibrationProblem<'_>) -> Result<Vec<f64>, IdentifyError> {
    let (residual, _) = problem.data_at(&problem.first_guess())?;
    let lengths: Vec<f64> =
        problem.sample_rows().into_iter().map(|(first, n)| residual.rows(first, n).norm()).collect();
    let mut sorted = lengths.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = STANDS_OUT * sorted[sorted.len() / 2];
    Ok(lengths.iter().map(|l| if *l > limit { 0.0 } else { 1.0 }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuning_constants_of_one_dimension_are_the_published_ones() {
        // Maronna et al., table 2.2: 1.345 (Huber) and 4.685 (bisquare) for 95 %.
        assert!((Loss::Huber.tuning(1) - 1.345).abs() < 0.01, "{}", Loss::Huber.tuning(1));
        assert!((Loss::Tukey.tuning(1) - 4.685).abs() < 0.02, "{}", Loss::Tukey.tuning(1));
        assert!(Loss::Tukey.tuning(6) > Loss::Tukey.tuning(3));
    }
}
