//! The five indices of the paper, eqs. (34)–(38).

use super::kernel::Extremes;
use super::{FastForm, ObservabilityIndex, Spectrum};

/// `O1 = (σ₁ ⋯ σ_L)^(1/L) / √n`, eq. (34): the volume of what is determined (D-optimality).
#[derive(Clone, Copy, Debug, Default)]
pub struct O1;

/// `O2 = σ_L / σ₁`, eq. (35): the inverse condition number.
#[derive(Clone, Copy, Debug, Default)]
pub struct O2;

/// `O3 = σ_L`, eq. (36): the worst direction (E-optimality).
#[derive(Clone, Copy, Debug, Default)]
pub struct O3;

/// `O4 = σ_L² / σ₁`, eq. (37): the noise amplification index.
#[derive(Clone, Copy, Debug, Default)]
pub struct O4;

/// `O5 = 1 / (1/σ₁ + ⋯ + 1/σ_L)`, eq. (38).
#[derive(Clone, Copy, Debug, Default)]
pub struct O5;

impl ObservabilityIndex for O1 {
    fn name(&self) -> &str {
        "o1"
    }

    fn value(&self, s: &Spectrum) -> f64 {
        // Through logarithms: the product of 42 small numbers underflows.
        let mean = s.values.iter().map(|v| v.ln()).sum::<f64>() / s.values.len() as f64;
        mean.exp() / (s.poses as f64).sqrt()
    }

    fn fast(&self) -> FastForm<'_> {
        FastForm::Determinant
    }
}

/// Smallest and largest singular value.
fn ends(s: &Spectrum) -> (f64, f64) {
    (s.values.last().copied().unwrap_or(0.0), s.values.first().copied().unwrap_or(0.0))
}

impl ObservabilityIndex for O2 {
    fn name(&self) -> &str {
        "o2"
    }

    fn value(&self, s: &Spectrum) -> f64 {
        let (smallest, largest) = ends(s);
        smallest / largest
    }

    fn fast(&self) -> FastForm<'_> {
        FastForm::Extremes(Extremes { smallest: 1, over_largest: true })
    }
}

impl ObservabilityIndex for O3 {
    fn name(&self) -> &str {
        "o3"
    }

    fn value(&self, s: &Spectrum) -> f64 {
        ends(s).0
    }

    fn fast(&self) -> FastForm<'_> {
        FastForm::Extremes(Extremes { smallest: 1, over_largest: false })
    }
}

impl ObservabilityIndex for O4 {
    fn name(&self) -> &str {
        "o4"
    }

    fn value(&self, s: &Spectrum) -> f64 {
        let (smallest, largest) = ends(s);
        smallest * smallest / largest
    }

    fn fast(&self) -> FastForm<'_> {
        FastForm::Extremes(Extremes { smallest: 2, over_largest: true })
    }
}

impl ObservabilityIndex for O5 {
    fn name(&self) -> &str {
        "o5"
    }

    fn value(&self, s: &Spectrum) -> f64 {
        1.0 / s.values.iter().map(|v| 1.0 / v).sum::<f64>()
    }

    fn fast(&self) -> FastForm<'_> {
        FastForm::HarmonicSum
    }
}
