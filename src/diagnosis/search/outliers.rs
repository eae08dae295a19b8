//! Gross errors in single samples.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::ChiSquared;

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::DesignMatrix;
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::model::{Fitting, Hypothesis, Model};
use crate::diagnosis::linear::statistics::upper_quantile;

/// Probability of a sound sample to be called a gross error.
const LEVEL: f64 = 1e-6;
/// Rounds of fitting and judging.
const ROUNDS: usize = 12;

/// Length squared of the residual of each sample over what the noise would give, with the leverage of the sample taken
/// out, and its degrees of freedom. `left_out` samples are predicted from the others.
pub(crate) fn distances(
    full: &DesignMatrix,
    model: &Model<'_>,
    groups: &[EffectColumns],
    left_out: &[usize],
) -> Vec<Option<(f64, usize)>> {
    let distance = |k: usize| {
        let (first, n) = full.rows[k];
        if n == 0 {
            return None;
        }
        let (r, q, sign) = if left_out.contains(&k) {
            let (r, q) = model.predicted(full, groups, first, n);
            (r, q, 1.0)
        } else {
            (model.residual.rows(first, n).into_owned(), model.leverage_rows(first, n), -1.0)
        };
        let covariance = DMatrix::identity(n, n) + &q * q.transpose() * sign;
        // A sample that alone decides a parameter fits by itself and cannot be judged.
        let factor = Cholesky::new(covariance).filter(|f| f.l_dirty().diagonal().min() > 1e-3)?;
        let whole: DVector<f64> = factor.solve(&r);
        Some((r.dot(&whole), n))
    };
    (0..full.samples()).map(distance).collect()
}

/// Scale of the noise, as the median of the samples has it.
fn median_scale(distances: &[Option<(f64, usize)>]) -> f64 {
    let mut ratios: Vec<f64> = distances
        .iter()
        .flatten()
        .filter_map(|(d, n)| Some(d / upper_quantile(&ChiSquared::new(*n as f64).ok()?, 0.5)))
        .collect();
    if ratios.is_empty() {
        return 1.0;
    }
    ratios.sort_by(f64::total_cmp);
    ratios[ratios.len() / 2].sqrt()
}

/// The samples that do not fit beside these names, found by fitting and judging in turn, and the scale of the noise.
pub(crate) fn outliers(
    full: &DesignMatrix,
    groups: &[EffectColumns],
    names: &[Hypothesis],
    fitting: &Fitting,
    start: &[usize],
) -> Result<(Vec<usize>, f64), DiagnoseError> {
    let mut left_out = start.to_vec();
    let mut scale = fitting.scale;
    let mut limits: Vec<(usize, f64)> = Vec::new();
    for _ in 0..ROUNDS {
        let table = full.without(&left_out);
        let rows = full.count(&left_out);
        let model = Model::fit(&table, groups, names.to_vec(), &Fitting { rows, scale, ..*fitting })?;
        let all = distances(full, &model, groups, &left_out);
        scale = if fitting.known { 1.0 } else { median_scale(&all) };
        let mut limit = |n: usize| match limits.iter().find(|(m, _)| *m == n) {
            Some((_, limit)) => *limit,
            None => {
                let limit = ChiSquared::new(n as f64).map_or(f64::INFINITY, |d| upper_quantile(&d, LEVEL));
                limits.push((n, limit));
                limit
            }
        };
        let mut next = Vec::new();
        for (k, found) in all.iter().enumerate() {
            if let Some((d, n)) = found
                && *d > limit(*n) * scale * scale
            {
                next.push(k);
            }
        }
        if next == left_out {
            break;
        }
        left_out = next;
    }
    Ok((left_out, scale))
}

/// Reason to try without leaving out: are these samples more than a tenth of all, or mostly neighbours?
pub(crate) fn suspicious(left_out: &[usize], samples: usize) -> bool {
    if left_out.len() * 10 > samples {
        return true;
    }
    let neighbours = left_out
        .iter()
        .filter(|k| left_out.contains(&(**k + 1)) || k.checked_sub(1).is_some_and(|p| left_out.contains(&p)));
    left_out.len() > 2 && neighbours.count() * 10 > left_out.len() * 6
}
