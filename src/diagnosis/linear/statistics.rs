//! Distributions, detection limits and evidence.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};
use statrs::function::beta::ln_beta;

/// What is known of the size of the noise after a fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    /// Sum of squares of the whitened residual, corrected for rows that repeat each other.
    pub(crate) rss: f64,
    /// Sum of squares plus the penalty of the prior; gains of effects are taken from it.
    pub(crate) objective: f64,
    /// Its degrees of freedom, likewise.
    pub(crate) dof: f64,
    /// True if whitened rows have unit variance by statement.
    pub(crate) known: bool,
}

impl Noise {
    /// Variance of a whitened row.
    pub(crate) fn variance(&self) -> f64 {
        if self.known { 1.0 } else { self.rss / self.dof }
    }

    /// Variance after `p` parameters took `gain` away.
    pub(crate) fn variance_after(&self, gain: f64, p: f64) -> f64 {
        if self.known {
            return 1.0;
        }
        // An exact fit leaves rounding, never less than this part of what there was.
        ((self.objective - gain) / (self.dof - p).max(1.0)).max(1e-24 * self.objective)
    }

    /// False for a gain that chance exceeds in more than one of a hundred cases, without the work of a probability.
    pub(crate) fn may_be_significant(&self, gain: f64, p: usize) -> bool {
        let left = Self { known: false, ..*self }.variance_after(gain, p as f64);
        gain > NEVER * p as f64 * left
    }

    /// Probability of a gain at least this large by chance from `p` parameters.
    pub(crate) fn p_value(&self, gain: f64, p: usize) -> f64 {
        if p == 0 || !(gain > 0.0) {
            return 1.0;
        }
        let p = p as f64;
        let stated = if self.known { ChiSquared::new(p).map_or(1.0, |d| d.sf(gain)) } else { 0.0 };
        let rest = self.dof - p;
        if rest < 1.0 {
            return 1.0;
        }
        // Noise that is larger than stated explains everything by chance; a name must stand against what is really left.
        let left = Self { known: false, ..*self }.variance_after(gain, p);
        upper_f((gain / p) / left, p, rest).max(stated)
    }
}

/// An F below this is exceeded by chance more often than once in a hundred, for one to four directions: for four and many
/// remaining rows it is χ²₄ = 12.8, and the tails for fewer of either are longer.
const NEVER: f64 = 3.2;

/// Upper tail of Fisher's F; what is no number is no finding.
pub(crate) fn upper_f(f: f64, p: f64, rest: f64) -> f64 {
    if f.is_nan() {
        return 1.0;
    }
    if f.is_infinite() {
        return 0.0;
    }
    FisherSnedecor::new(p, rest).map_or(1.0, |d| d.sf(f)).clamp(0.0, 1.0)
}

/// The non-centrality `λ` at which the F test of `p` directions beside `rest` degrees of freedom, of level `alpha`, has power
/// 95 % (Currie's detection limit). The noise is estimated with the effect in the model, and its scatter costs
/// power: one direction at a level of 2e-4 must be 4 % larger where 100 degrees of freedom are left, and half as large again
/// where there are 10.
pub(crate) fn detection_limit(p: usize, alpha: f64, rest: f64) -> f64 {
    const POWER: f64 = 0.95;
    let (p, rest) = (p as f64, rest.max(1.0));
    let critical = upper_quantile(|f| upper_f(f, p, rest), alpha);
    let mut high = (((p * critical).sqrt() + 2.5).powi(2) + 10.0) * (1.0 + 10.0 / rest);
    while noncentral_upper(critical, p, rest, high) < POWER && high < 1e9 {
        high *= 2.0;
    }
    bisected(high, 60, 1e-3, |lambda| noncentral_upper(critical, p, rest, lambda) < POWER)
}

/// Where `below` turns false between 0 and `high`, in so many halvings or to this part of its value.
fn bisected(mut high: f64, rounds: usize, precision: f64, below: impl Fn(f64) -> bool) -> f64 {
    let mut low = 0.0;
    for _ in 0..rounds {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
        if high - low < precision * high {
            break;
        }
    }
    0.5 * (low + high)
}

/// The value that a variable exceeds with this probability; `tail` is its upper tail.
pub(crate) fn upper_quantile(tail: impl Fn(f64) -> f64, alpha: f64) -> f64 {
    let mut high = 1.0;
    while tail(high) > alpha && high < 1e9 {
        high *= 2.0;
    }
    bisected(high, 100, 1e-9, |x| tail(x) > alpha)
}

/// Upper tail of the non-central F as a mixture of tails of beta distributions with Poisson weights. These tails follow from
/// one another, `I_x(a + 1, b) = I_x(a, b) - xᵃ (1 - x)ᵇ / (a B(a, b))`.
fn noncentral_upper(f: f64, p: f64, rest: f64, lambda: f64) -> f64 {
    let x = p * f / (p * f + rest);
    let (a, b) = (0.5 * p, 0.5 * rest);
    let mut tail = upper_f(f, p, rest);
    let mut term = (a * x.ln() + b * (-x).ln_1p() - ln_beta(a, b) - a.ln()).exp();
    let mut weight = (-0.5 * lambda).exp();
    let mut sum = 0.0;
    let mut weights = 0.0;
    for j in (0..2000).map(f64::from) {
        sum += weight * tail;
        weights += weight;
        if weights > 1.0 - 1e-10 {
            break;
        }
        tail = (tail + term).min(1.0);
        term *= x * (a + b + j) / (a + j + 1.0);
        weight *= 0.5 * lambda / (j + 1.0);
    }
    sum
}

/// `ln Σ exp(xᵢ) - ln n`: the logarithm of a mean.
pub(crate) fn log_mean(values: &[f64]) -> f64 {
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return largest;
    }
    largest + (values.iter().map(|v| (v - largest).exp()).sum::<f64>() / values.len() as f64).ln()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn the_power_of_the_noncentral_test_agrees_with_published_values() {
        // R: pchisq(3.841459, 1, ncp = 12.99474, lower = FALSE) = 0.95; pchisq(12.59159, 6, ncp = 20.86, lower = FALSE) = 0.95
        let many = 1e7;
        assert!((detection_limit(1, 0.05, many) - 12.9947).abs() < 0.03);
        assert!((detection_limit(6, 0.05, many) - 20.86).abs() < 0.1);
        // SciPy: brentq over ncf.sf(f.isf(2e-4, p, rest), p, rest, λ) - 0.95
        assert!((detection_limit(1, 2e-4, 12.0) - 57.6).abs() < 0.1);
        assert!((detection_limit(6, 2e-4, 80.0) - 47.27).abs() < 0.1);
    }

    /// Against draws of the two sums of squares, which share nothing with the formula.
    #[test]
    fn the_power_with_an_estimated_noise_is_that_of_draws() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for (p, rest, alpha) in [(1, 12, 1e-3), (4, 25, 1e-2), (6, 80, 2e-4)] {
            let lambda = detection_limit(p, alpha, rest as f64);
            let critical = FisherSnedecor::new(p as f64, rest as f64).unwrap().inverse_cdf(1.0 - alpha);
            let draws = 40_000;
            let found = (0..draws).filter(|_| {
                let mut square = |count: usize, shift: f64| -> f64 {
                    let z = |k: usize, rng: &mut ChaCha8Rng| -> f64 {
                        let z: f64 = StandardNormal.sample(rng);
                        z + if k == 0 { shift } else { 0.0 }
                    };
                    (0..count).map(|k| z(k, &mut rng).powi(2)).sum()
                };
                (square(p, lambda.sqrt()) / p as f64) / (square(rest, 0.0) / rest as f64) > critical
            });
            let rate = found.count() as f64 / f64::from(draws);
            assert!((rate - 0.95).abs() < 0.005, "{p} {rest}: {rate}");
        }
    }

    #[test]
    fn what_may_not_be_significant_is_not() {
        for (dof, known) in [(5.0, false), (40.0, false), (1e4, false), (40.0, true)] {
            let noise = Noise { rss: 1.1 * dof, objective: 1.2 * dof, dof, known };
            for p in 1..=4 {
                for gain in (0..400).map(|k| 0.1 * f64::from(k)).filter(|g| *g < noise.objective) {
                    assert!(noise.may_be_significant(gain, p) || noise.p_value(gain, p) > 0.01, "{dof} {p} {gain}");
                }
            }
        }
    }

    #[test]
    fn the_log_mean_neither_overflows_nor_forgets() {
        assert!((log_mean(&[1000.0, 1000.0]) - 1000.0).abs() < 1e-12);
        assert!((log_mean(&[0.0, f64::NEG_INFINITY]) + 2.0_f64.ln()).abs() < 1e-12);
    }
}
