//! Scores of candidates and members: by scans where an index has a fast form, else one by one.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::PoseSet;
use super::best::best_open;
use super::state::State;
use crate::observability::kernel::{self, LANES, Lanes};
use crate::observability::{Extremes, FastForm, Spectrum};

/// Error of the quadrature behind O5, in parts of the change.
pub(super) const QUADRATURE: f64 = 1e-4;
/// Power with which eigenvalues beside an extreme one count in its stand-in: the larger, the fewer of them do.
const SMOOTHED: f64 = 3.0;

impl PoseSet<'_> {
    /// Scores of all candidates of a layout, larger is better.
    pub(super) fn scan<L: kernel::Layout>(&self, layout: &L, sign: f64, open: &[Lanes], out: &mut [Lanes]) {
        match (&self.state, self.index.fast()) {
            (State::Determinant { inverse, .. }, _) => kernel::determinant(layout, inverse, sign, open, out),
            (State::Trace { inverse, middle }, _) => {
                kernel::trace(layout, inverse, middle, sign, open, out);
                if sign < 0.0 {
                    negate(out);
                }
            }
            (State::Spectral { lambda, rotation, .. }, FastForm::Extremes(index)) => {
                kernel::extremes(layout, lambda, rotation.as_slice(), sign, index, open, out);
            }
            (State::Spectral { lambda, rotation, .. }, _) => {
                kernel::harmonic(layout, lambda, rotation.as_slice(), sign, open, out);
                negate(out);
            }
            (State::Stale, _) => {}
        }
    }

    /// What each candidate would do for the set, the larger the better, for ranking many of them; 0 for members. It is
    /// the score of a scan, within the error of the quadrature for O5. For indices of extreme singular values, whose
    /// scans tell only the best candidates apart, it is the derivative of their logarithm along `JᵀJ`, in which the
    /// neighbours of the extreme eigenvalues count too.
    pub(crate) fn gains(&mut self) -> Vec<f64> {
        self.refresh();
        if let (State::Spectral { spectrum, rotation, .. }, FastForm::Extremes(index)) =
            (&self.state, self.index.fast())
        {
            let squares: Vec<f64> = spectrum.values.iter().map(|s| s * s).collect();
            return self.pool.directional(&smoothed(&squares, rotation, index));
        }
        let mut scores = std::mem::take(&mut self.scores);
        self.scan_additions(&mut scores);
        self.scores = scores;
        self.scores.iter().flatten().copied().take(self.pool.len()).collect()
    }

    /// Replaces the scores of O5 within the error of the quadrature by exact ones.
    pub(super) fn sharpen(&mut self) {
        if !matches!(self.index.fast(), FastForm::HarmonicSum) {
            return;
        }
        let Some(best) = best_open(&self.scores, &self.open) else { return };
        let limit = best.score * (1.0 - QUADRATURE);
        let close: Vec<usize> = (0..self.pool.len()).filter(|k| self.is_open(*k) && self.score(*k) >= limit).collect();
        let exact: Vec<f64> =
            close.iter().map(|k| -self.spectrum_with(*k).values.iter().map(|v| 1.0 / v).sum::<f64>()).collect();
        // From here on scores are minus the sums themselves: their differences would drown in that of a singular set.
        self.scores.iter_mut().flatten().for_each(|score| *score = f64::NEG_INFINITY);
        for (k, score) in close.into_iter().zip(exact) {
            self.scores[k / LANES][k % LANES] = score;
        }
    }

    /// Spectrum with a candidate more.
    fn spectrum_with(&self, candidate: usize) -> Spectrum {
        let State::Spectral { spectrum, .. } = &self.state else { return self.spectrum() };
        let n = spectrum.values.len();
        let mut rows = DMatrix::zeros(n + 6, n);
        for (k, s) in spectrum.values.iter().enumerate() {
            rows[(k, k)] = *s;
        }
        // In the basis of the right singular vectors, so that the rows before are a diagonal matrix.
        rows.rows_mut(n, 6).copy_from(&(self.pool.rows(candidate) * &spectrum.directions));
        let with = self.index.needs_directions();
        let mut found = Spectrum::of(&rows, self.poses() + 1, with);
        if with {
            found.directions = &spectrum.directions * found.directions;
        }
        found
    }

    pub(super) fn slow_additions(&self, scores: &mut [Lanes]) {
        scores.par_iter_mut().enumerate().for_each(|(batch, lanes)| {
            for (lane, score) in lanes.iter_mut().enumerate() {
                let k = batch * LANES + lane;
                if k < self.pool.len() && self.is_open(k) {
                    *score = self.index.goal().score(self.index.value(&self.spectrum_with(k)));
                }
            }
        });
    }

    /// Value of the index without a member, larger is better.
    pub(super) fn exact_without(&self, position: usize) -> f64 {
        let rows = self.stacked(|k| self.pool.rows(k), &self.fixed, Some(position));
        let value = self.index.value(&Spectrum::of(&rows, self.poses() - 1, self.index.needs_directions()));
        self.index.goal().score(value)
    }
}

fn negate(scores: &mut [Lanes]) {
    scores.iter_mut().flatten().for_each(|v| *v = -*v);
}

/// Derivative of `ln σ_L^p/σ₁^q` with respect to `JᵀJ`, in the coordinates of `rotation`, with smoothed extremes.
/// `squares` are the eigenvalues, descending.
fn smoothed(squares: &[f64], rotation: &DMatrix<f64>, index: Extremes) -> DMatrix<f64> {
    let (largest, smallest) = (squares[0], squares[squares.len() - 1].max(squares[0] * f64::EPSILON));
    let low: Vec<f64> = squares.iter().map(|s| (s.max(smallest) / smallest).powf(-SMOOTHED)).collect();
    let high: Vec<f64> = squares.iter().map(|s| (s / largest).powf(SMOOTHED)).collect();
    let (low_sum, high_sum): (f64, f64) = (low.iter().sum(), high.iter().sum());
    let divided = if index.over_largest { 0.5 / (high_sum * largest) } else { 0.0 };
    let gained = 0.5 * f64::from(index.smallest) / (low_sum * smallest);
    let mut weighted = rotation.clone();
    for (k, mut column) in weighted.column_iter_mut().enumerate() {
        column.scale_mut(gained * low[k] - divided * high[k]);
    }
    weighted * rotation.transpose()
}
