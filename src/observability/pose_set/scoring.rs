//! Scores of candidates and members: by scans where an index has a fast form, else one by one.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::PoseSet;
use super::best::best_open;
use super::state::State;
use crate::observability::kernel::{self, LANES, Lanes};
use crate::observability::{FastForm, Spectrum};

/// Error of the quadrature behind O5, in parts of the change.
pub(super) const QUADRATURE: f64 = 1e-4;

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
