//! The concave criteria behind the indices that have a bound, their tangents, and what a tangent proves.

use nalgebra::{Cholesky, DMatrix};

use super::support::Support;
use crate::observability::{FastForm, ObservabilityIndex};
use crate::solve::svd;

/// Room for the rounding of the certificate itself.
pub(super) const ROUNDING: f64 = 1e-9;

/// What a bound is taken of.
pub(super) enum Criterion<'a> {
    Determinant,
    Harmonic,
    Trace(&'a DMatrix<f64>),
    Smallest,
}

/// A matrix `Φ` in stored coordinates, and what the index is at `M(x)`.
pub(super) struct Tangent {
    pub(super) phi: DMatrix<f64>,
    /// `ln det M`, `tr M^-½`, `tr G M⁻¹` or unused.
    pub(super) now: f64,
}

impl<'a> Criterion<'a> {
    pub(super) fn of(index: &'a dyn ObservabilityIndex) -> Option<Self> {
        Some(match index.fast() {
            FastForm::Determinant => Self::Determinant,
            FastForm::HarmonicSum => Self::Harmonic,
            FastForm::Trace(gain) => Self::Trace(gain),
            FastForm::Extremes(e) if !e.over_largest && e.smallest == 1 => Self::Smallest,
            _ => return None,
        })
    }

    pub(super) fn tangent(&self, support: &Support<'_>, power: f64) -> Option<Tangent> {
        let (m, basis) = (support.information(), &support.pool.basis());
        let factor = Cholesky::new(m.clone())?;
        match self {
            Criterion::Determinant => Some(Tangent { phi: factor.inverse(), now: factor.ln_determinant() }),
            Criterion::Trace(gain) => {
                let onto = support.pool.inverse_basis() * factor.inverse();
                let phi = onto.transpose() * *gain * &onto;
                let now = (&phi * &m).trace();
                Some(Tangent { phi, now })
            }
            Criterion::Harmonic | Criterion::Smallest => {
                // M = Wᵀ M_w W = (Lᵀ W)ᵀ (Lᵀ W): singular values of a factor keep the small ones.
                let svd = svd(factor.l().transpose() * *basis, false, true);
                let onto = *basis * svd.v_t?.transpose();
                let smallest = svd.singular_values.min();
                let weights = match self {
                    Criterion::Harmonic => svd.singular_values.map(|s| s.powi(-3)),
                    _ => {
                        let relative = svd.singular_values.map(|s| (s / smallest).powf(-2.0 * (power + 1.0)));
                        let sum = relative.sum();
                        relative / sum
                    }
                };
                let mut weighted = onto.clone();
                for (mut column, w) in weighted.column_iter_mut().zip(weights.iter()) {
                    column.scale_mut(*w);
                }
                let now = svd.singular_values.iter().map(|s| 1.0 / s).sum();
                Some(Tangent { phi: weighted * onto.transpose(), now })
            }
        }
    }

    /// The bound that a tangent proves, from sums of `d`.
    pub(super) fn bound(&self, tangent: &Tangent, support: &Support<'_>, d: &Spread, free_scale: bool) -> f64 {
        match self {
            // Volumes have a bound of their own, see `Task`.
            Criterion::Determinant => f64::INFINITY,
            // Here d belongs to M^-3/2, twice the gradient.
            Criterion::Harmonic if free_scale => d.top.sqrt() / tangent.now.powf(1.5) * (1.0 + ROUNDING),
            Criterion::Harmonic => {
                let least = tangent.now - 0.5 * (d.top - d.within);
                if least > 0.0 { (1.0 + ROUNDING) / least } else { f64::INFINITY }
            }
            Criterion::Trace(_) if free_scale => tangent.now / d.top.sqrt() * (1.0 - ROUNDING),
            Criterion::Trace(_) => (tangent.now - (d.top - d.within)).max(0.0).sqrt() * (1.0 - ROUNDING),
            Criterion::Smallest => ((&tangent.phi * support.fixed()).trace() + d.top).sqrt() * (1.0 + ROUNDING),
        }
    }

    pub(super) fn tighter(&self, a: f64, b: f64) -> bool {
        if matches!(self, Criterion::Trace(_)) { a > b } else { a < b }
    }
}

/// The sum of the `m` largest `d`, and `Σ x d`.
pub(super) struct Spread {
    pub(super) top: f64,
    pub(super) within: f64,
}

impl Spread {
    /// For the `d` of all candidates and the shares `x` of some, `Σ x = m`.
    pub(super) fn of(d: &[f64], shares: &[(usize, f64)], m: usize) -> Self {
        let within = shares.iter().map(|(k, x)| d[*k] * x).sum();
        let mut sorted = d.to_vec();
        if m < sorted.len() {
            sorted.select_nth_unstable_by(m - 1, |a, b| b.total_cmp(a));
        }
        Self { top: sorted[..m].iter().sum(), within }
    }
}
