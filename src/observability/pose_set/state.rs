//! State of a set for its current members, and its updates.

use nalgebra::{Cholesky, DMatrix};

use super::PoseSet;
use crate::observability::{FastForm, Spectrum};

/// Rank-six updates of an inverse until it is computed afresh; its error is then about 1e-10.
const REFRESH: usize = 64;
/// A removal whose smallest pivot is below this makes the updated inverse inaccurate.
const SMALL_PIVOT: f64 = 1e-6;
/// Ridge of a set that does not determine everything, in parts of the mean eigenvalue.
const RIDGE: f64 = 1e-6;
/// Singular values below this part of the largest count as zero.
const NOTHING: f64 = 1e-13;
/// Stands in for them, in parts of the smallest that is not zero.
const FLOOR: f64 = 1e-2;
/// Tenfold larger ridges that are tried.
const RIDGES: usize = 40;
/// Ratio of pivots from which on a set determines nothing.
pub(super) const SINGULAR: f64 = 1e-14;

/// State of a set for its current members.
pub(super) enum State {
    Stale,
    /// `log_determinant` is that of `M` in stored coordinates.
    Determinant {
        inverse: DMatrix<f64>,
        log_determinant: f64,
        ridged: bool,
        updates: usize,
    },
    Trace {
        inverse: DMatrix<f64>,
        middle: DMatrix<f64>,
    },
    Spectral {
        spectrum: Spectrum,
        lambda: Vec<f64>,
        rotation: DMatrix<f64>,
    },
}

/// What is added to all eigenvalues of a set that does not determine everything: little beside those that it has, and
/// enough to keep differences between candidates above the rounding of `1/σ`.
fn floor(values: &[f64]) -> f64 {
    let largest = values.first().copied().unwrap_or(0.0);
    let seen = |s: &f64| *s > NOTHING * largest;
    match values.iter().rev().find(|s| seen(s)) {
        Some(smallest) if !values.last().is_some_and(seen) => (FLOOR * smallest).powi(2),
        // A set without rows.
        None => f64::MIN_POSITIVE.sqrt(),
        Some(_) => 0.0,
    }
}

impl PoseSet<'_> {
    /// Brings the state up to date.
    pub(super) fn refresh(&mut self) {
        if let State::Determinant { updates, ridged, .. } = &self.state
            && (*updates >= REFRESH || *ridged)
        {
            self.state = State::Stale;
        }
        if !matches!(self.state, State::Stale) {
            return;
        }
        self.state = match self.index.fast() {
            FastForm::Determinant => {
                let (inverse, log_determinant, ridged) = self.inverse_information();
                State::Determinant { inverse, log_determinant, ridged, updates: 0 }
            }
            FastForm::Trace(gain) => {
                let (inverse, ..) = self.inverse_information();
                let onto = &self.pool.coordinates.inverse * &inverse;
                let middle = onto.transpose() * gain * onto;
                State::Trace { inverse, middle }
            }
            FastForm::Extremes(_) | FastForm::HarmonicSum | FastForm::None => {
                let spectrum = Spectrum::of(&self.rows(), self.poses(), true);
                let floor = floor(&spectrum.values);
                let lambda: Vec<f64> = spectrum.values.iter().map(|s| s * s + floor).collect();
                let rotation = &self.pool.coordinates.basis * &spectrum.directions;
                State::Spectral { spectrum, lambda, rotation }
            }
        };
    }

    /// The inverse of `M` in stored coordinates, `ln det M`, and whether a ridge was needed.
    fn inverse_information(&self) -> (DMatrix<f64>, f64, bool) {
        let rows = self.stacked(|k| self.pool.stored(k), &self.fixed_stored(), None);
        let mut m = rows.transpose() * &rows;
        let n = m.nrows();
        let regular = |m: &DMatrix<f64>| {
            let factor = Cholesky::new(m.clone())?;
            let pivots = factor.l_dirty().diagonal();
            (pivots.min() > SINGULAR.sqrt() * pivots.max()).then(|| (factor.inverse(), factor.ln_determinant()))
        };
        if let Some((inverse, volume)) = regular(&m) {
            return (inverse, volume, false);
        }
        let mut ridge = (RIDGE * m.trace() / n as f64).max(f64::MIN_POSITIVE.sqrt());
        for _ in 0..RIDGES {
            for k in 0..n {
                m[(k, k)] += ridge;
            }
            if let Some((inverse, volume)) = regular(&m) {
                return (inverse, volume, true);
            }
            ridge *= 10.0;
        }
        // Rows so large that their squares overflow: nothing can be ranked.
        (DMatrix::identity(n, n), 0.0, true)
    }

    /// Carries the state over to one candidate more or less, where that is cheaper than computing it afresh.
    pub(super) fn update(&mut self, candidate: usize, sign: f64) {
        let State::Determinant { inverse, log_determinant, ridged: false, updates } = &mut self.state else {
            self.state = State::Stale;
            return;
        };
        match self.pool.update(inverse, candidate, sign, SMALL_PIVOT) {
            Some(change) => {
                *log_determinant += change;
                *updates += 1;
            }
            None => self.state = State::Stale,
        }
    }
}
