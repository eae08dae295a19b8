//! Gross errors in single samples.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::kept_rows::KeptRows;
use crate::diagnosis::linear::model::{Fitting, Model};
use crate::diagnosis::linear::statistics::upper_quantile;
use crate::solve::SmallCholesky;

/// Probability of a sound sample to be called a gross error.
const LEVEL: f64 = 1e-6;
/// Rounds of fitting and judging.
const ROUNDS: usize = 12;

/// Length squared of the residual of each sample over what the noise would give, with the leverage of the sample taken
/// out, and its degrees of freedom. `left_out` samples are predicted from the others.
pub(crate) fn distances(model: &Model) -> Vec<Option<(f64, usize)>> {
    let distance = |(k, (first, n)): (usize, &(usize, usize))| {
        if *n == 0 {
            return None;
        }
        let length = |r: DVector<f64>, q_t: nalgebra::DMatrixView<'_, f64>, sign: f64| {
            let unit = |i, k| if i == k { 1.0 } else { 0.0 };
            let covariance = |i: usize, k: usize| unit(i, k) + sign * q_t.column(i).dot(&q_t.column(k));
            // A sample that alone decides a parameter fits by itself and cannot be judged.
            let factor = SmallCholesky::of(*n, covariance).filter(|f| f.diagonal().all(|d| d > 1e-3))?;
            Some((factor.form(&r), *n))
        };
        if model.kept.is_out(k) {
            let (r, q_t) = model.predicted(*first, *n);
            length(r, q_t.as_view(), 1.0)
        } else {
            length(model.residual.rows(*first, *n).into_owned(), model.leverage(*first, *n), -1.0)
        }
    };
    model.table().rows.iter().enumerate().map(distance).collect()
}

/// The χ² that a sample of so many rows exceeds with a probability.
#[derive(Debug)]
struct Quantiles {
    probability: f64,
    by_rows: BTreeMap<usize, f64>,
}

impl Quantiles {
    fn of(probability: f64) -> Self {
        Self { probability, by_rows: BTreeMap::new() }
    }

    fn at(&mut self, n: usize) -> f64 {
        let quantile =
            || ChiSquared::new(n as f64).map_or(f64::INFINITY, |d| upper_quantile(|x| d.sf(x), self.probability));
        *self.by_rows.entry(n).or_insert_with(quantile)
    }
}

/// Scale of the noise, as the median of the samples has it.
fn median_scale(distances: &[Option<(f64, usize)>], medians: &mut Quantiles) -> f64 {
    let mut ratios: Vec<f64> = distances.iter().flatten().map(|(d, n)| d / medians.at(*n)).collect();
    if ratios.is_empty() {
        return 1.0;
    }
    ratios.sort_by(f64::total_cmp);
    ratios[ratios.len() / 2].sqrt()
}

/// The one rule of the diagnosis for a gross error: a sample that is farther from the others than [`LEVEL`] allows beside
/// these names, found by fitting and judging in turn. Answers with the rows that are left and the scale of the noise.
pub(crate) fn outliers(
    start: Arc<KeptRows>,
    groups: &[EffectColumns],
    names: &[Hypothesis],
    fitting: &Fitting,
) -> Result<(Arc<KeptRows>, f64), DiagnoseError> {
    let mut kept = start;
    let mut scale = fitting.scale;
    let (mut medians, mut limits) = (Quantiles::of(0.5), Quantiles::of(LEVEL));
    for _ in 0..ROUNDS {
        let model = Model::fit(&kept, groups, names.to_vec(), &Fitting { scale, ..*fitting })?;
        let all = distances(&model);
        scale = if fitting.known { 1.0 } else { median_scale(&all, &mut medians) };
        let mut is_far = |found: &Option<(f64, usize)>| found.is_some_and(|(d, n)| d > limits.at(n) * scale * scale);
        let next: Vec<usize> = (0..all.len()).filter(|k| is_far(&all[*k])).collect();
        if next == kept.left_out {
            break;
        }
        kept = Arc::new(KeptRows::new(Arc::clone(&kept.table), next));
    }
    Ok((kept, scale))
}

/// Reason to try without leaving out: are these samples more than a tenth of all, or mostly neighbours?
pub(crate) fn suspicious(left_out: &[usize], samples: usize) -> bool {
    if left_out.len() * 10 > samples {
        return true;
    }
    // They are in order.
    let follows = |k: usize| k > 0 && left_out[k] == left_out[k - 1] + 1;
    let neighbours = (0..left_out.len()).filter(|k| follows(*k) || (*k + 1 < left_out.len() && follows(*k + 1)));
    left_out.len() > 2 && neighbours.count() * 10 > left_out.len() * 6
}
