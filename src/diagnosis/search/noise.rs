//! Noise that is not the same in all rows, and rows that repeat each other.

use crate::diagnosis::answer::result::NoiseVaries;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::statistics::upper_f;
use crate::diagnosis::search::covariates::Covariate;
use crate::measurement::RowKind;

/// Level at which the ratio of position to rotation is not the stated one.
const RATIO: f64 = 1e-4;
/// Level of the tests of all covariates together.
const LEVEL: f64 = 5e-4;

/// Does the size of the residual depend on a covariate, and which σ has each sample then, relative to the middle of the
/// range? Regression of `ln(d²)` on each, with `d²` the length squared of a sample over what the noise would give.
pub(crate) fn noise_varies(
    distances: &[Option<(f64, usize)>],
    covariates: &[Covariate],
    kept: &[usize],
) -> Option<(NoiseVaries, Vec<f64>)> {
    let mut best: Option<(f64, NoiseVaries, Vec<f64>)> = None;
    let tested: Vec<&Covariate> = covariates.iter().filter(|c| c.own.is_none()).collect();
    for covariate in &tested {
        let x = covariate.scaled();
        let points: Vec<(f64, f64)> = kept
            .iter()
            .filter_map(|k| {
                distances[*k].filter(|(d, n)| *d > 0.0 && *n > 1).map(|(d, n)| (x[*k], (d / n as f64).ln()))
            })
            .collect();
        let n = points.len() as f64;
        if n < 12.0 {
            continue;
        }
        let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
        let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
        for (x, y) in &points {
            sxx += (x - mx).powi(2);
            sxy += (x - mx) * (y - my);
            syy += (y - my).powi(2);
        }
        if !(sxx > 0.0) {
            continue;
        }
        let slope = sxy / sxx;
        let rest = (syy - slope * sxy).max(f64::MIN_POSITIVE) / (n - 2.0);
        let p_value = upper_f(slope * slope * sxx / rest, 1.0, n - 2.0) * tested.len() as f64;
        if p_value < LEVEL && best.as_ref().is_none_or(|(p, ..)| p_value < *p) {
            // ln σ² changes by 2 slopes over the range.
            let spreads = x.iter().map(|x| (0.5 * slope * x).exp()).collect();
            best = Some((
                p_value,
                NoiseVaries { covariate: covariate.name.clone(), ratio: slope.exp(), p_value },
                spreads,
            ));
        }
    }
    best.map(|(_, found, spreads)| (found, spreads))
}

/// σ of position rows and of rotation rows in units of the stated ones, where their ratio differs from one by more than
/// chance. A wrong ratio looks like one leg that scatters.
pub(crate) fn ratio(model: &Model) -> Option<[f64; 2]> {
    let table = model.table();
    let mut sums = [(0.0, 0.0); 2];
    for (first, n) in model.kept.rows() {
        let q_t = model.leverage(first, n);
        for i in 0..n {
            let sum = &mut sums[usize::from(table.kinds[first + i] == RowKind::Rotation)];
            sum.0 += model.residual[first + i].powi(2);
            sum.1 += 1.0 - q_t.column(i).norm_squared();
        }
    }
    let [(p, np), (r, nr)] = sums;
    if np < 10.0 || nr < 10.0 || !(p > 0.0 && r > 0.0) {
        return None;
    }
    let (vp, vr) = (p / np, r / nr);
    let chance = if vp > vr { upper_f(vp / vr, np, nr) } else { upper_f(vr / vp, nr, np) };
    (2.0 * chance < RATIO).then(|| [vp.sqrt(), vr.sqrt()])
}

/// Correlation of the residual of each sample with that of the sample before, and whether it is more than chance.
pub(crate) fn correlation(model: &Model) -> Option<f64> {
    let table = model.table();
    let (mut product, mut square, mut count) = (0.0, 0.0, 0.0);
    let kept = |k: usize| !model.kept.is_out(k);
    for k in 1..table.samples() {
        let ((a, n), (b, m)) = (table.rows[k - 1], table.rows[k]);
        if n == m && n > 0 && kept(k) && kept(k - 1) {
            let (before, now) = (model.residual.rows(a, n), model.residual.rows(b, m));
            product += before.dot(&now);
            square += 0.5 * (before.norm_squared() + now.norm_squared());
            count += n as f64;
        }
    }
    // Four σ, and rows enough that this means something.
    let rho = if square > 0.0 { product / square } else { 0.0 };
    (count > 30.0 && rho * f64::sqrt(count) > 4.0).then_some(rho.min(0.95))
}
