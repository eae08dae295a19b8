//! A set of poses: its index, the best pose to add, the best to remove.

use nalgebra::{Cholesky, DMatrix};
use rayon::prelude::*;

use super::kernel::{self, LANES, Lanes};
use super::pool::Stored;
use super::{FastForm, Goal, ObservabilityIndex, Pool, Spectrum};

/// Rank-six updates of an inverse until it is computed afresh; its error is then about 1e-10.
const REFRESH: usize = 64;
/// A removal whose smallest pivot is below this makes the updated inverse inaccurate.
const SMALL_PIVOT: f64 = 1e-6;
/// Ridge of a set that does not determine everything, in parts of the mean eigenvalue.
const RIDGE: f64 = 1e-6;
/// Ratio of pivots from which on a set determines nothing.
const SINGULAR: f64 = 1e-14;
/// Scores closer than this are a tie; the candidate with the smaller index wins.
const TIE: f64 = 1e-12;
/// Error of the quadrature behind O5, in parts of the change.
const QUADRATURE: f64 = 1e-4;

/// Members of a pool, together with rows that belong to every set: poses measured before, and a prior.
pub struct PoseSet<'a> {
    pool: &'a Pool,
    index: &'a dyn ObservabilityIndex,
    /// Rows (m × L') along the visible directions.
    fixed: DMatrix<f64>,
    fixed_poses: usize,
    members: Vec<usize>,
    /// 1 for candidates that may be added.
    open: Vec<Lanes>,
    scores: Vec<Lanes>,
    log_volume: f64,
    state: State,
}

/// What is known of the present members.
enum State {
    Stale,
    Determinant { information: DMatrix<f64>, inverse: DMatrix<f64>, ridged: bool, updates: usize },
    Trace { inverse: DMatrix<f64>, middle: DMatrix<f64> },
    Spectral { spectrum: Spectrum, lambda: Vec<f64>, rotation: DMatrix<f64> },
}

/// The best candidate or member by score; larger scores are better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Best {
    /// Candidate, or position among the members.
    pub which: usize,
    /// Its score: comparable only within one scan.
    pub score: f64,
}

impl<'a> PoseSet<'a> {
    /// A set of members. `given` are rows (6 each) of poses that are part of it beside the candidates.
    pub fn new(pool: &'a Pool, index: &'a dyn ObservabilityIndex, given: &[DMatrix<f64>], members: &[usize]) -> Self {
        let directions = pool.directions();
        let prior = if index.prior() { directions } else { 0 };
        let mut fixed = DMatrix::zeros(6 * given.len() + prior, directions);
        for (k, rows) in given.iter().enumerate() {
            fixed.view_mut((6 * k, 0), (6, directions)).copy_from(rows);
        }
        fixed.view_mut((6 * given.len(), 0), (prior, directions)).fill_with_identity();
        let mut open = vec![[1.0; LANES]; pool.len().div_ceil(LANES)];
        for k in pool.len()..LANES * open.len() {
            open[k / LANES][k % LANES] = 0.0;
        }
        let scores = vec![[0.0; LANES]; open.len()];
        let mut set = Self {
            pool,
            index,
            fixed,
            fixed_poses: given.len(),
            members: Vec::with_capacity(members.len() + 1),
            open,
            scores,
            log_volume: pool.log_volume(),
            state: State::Stale,
        };
        for k in members {
            set.close(*k);
            set.members.push(*k);
        }
        set
    }

    /// The members, in the order in which they came.
    pub fn members(&self) -> &[usize] {
        &self.members
    }

    /// Number of poses, given ones included.
    pub fn poses(&self) -> usize {
        self.members.len() + self.fixed_poses
    }

    /// Keeps a candidate from being added.
    pub fn close(&mut self, candidate: usize) {
        self.open[candidate / LANES][candidate % LANES] = 0.0;
    }

    /// Allows a candidate to be added again.
    pub fn reopen(&mut self, candidate: usize) {
        self.open[candidate / LANES][candidate % LANES] = 1.0;
    }

    fn is_open(&self, candidate: usize) -> bool {
        self.open[candidate / LANES][candidate % LANES] != 0.0
    }

    /// The rows of all members and all fixed rows, along the visible directions.
    pub fn rows(&self) -> DMatrix<f64> {
        self.stacked(|k| self.pool.rows(k), &self.fixed, None)
    }

    fn stacked(
        &self,
        rows_of: impl Fn(usize) -> DMatrix<f64>,
        fixed: &DMatrix<f64>,
        without: Option<usize>,
    ) -> DMatrix<f64> {
        let kept: Vec<usize> =
            (0..self.members.len()).filter(|p| Some(*p) != without).map(|p| self.members[p]).collect();
        let mut rows = DMatrix::zeros(6 * kept.len() + fixed.nrows(), fixed.ncols());
        for (slot, k) in kept.iter().enumerate() {
            rows.view_mut((6 * slot, 0), (6, fixed.ncols())).copy_from(&rows_of(*k));
        }
        rows.rows_mut(6 * kept.len(), fixed.nrows()).copy_from(fixed);
        rows
    }

    /// Spectrum of the stacked rows, through their QR and singular value decompositions.
    pub fn spectrum(&self) -> Spectrum {
        Spectrum::of(&self.rows(), self.poses(), self.index.needs_directions())
    }

    /// The index of the set.
    pub fn value(&self) -> f64 {
        self.index.value(&self.spectrum())
    }

    /// The index of the set through the factors that the scans work with: a hundredth of the cost of
    /// [`value`](Self::value) for O1, with an error of about 1e-9.
    pub fn quick_value(&mut self) -> f64 {
        self.refresh();
        match (&self.state, self.index.fast()) {
            // With a ridge the factors are those of another set.
            (State::Determinant { information, ridged: false, .. }, _) if self.index.goal() == Goal::Largest => {
                let Some(factor) = Cholesky::new(information.clone()) else { return self.value() };
                let stored: f64 = factor.l_dirty().diagonal().iter().map(|v| v.ln()).sum();
                let mean = (stored + self.log_volume) / information.nrows() as f64;
                let values = vec![mean.exp(); information.nrows()];
                self.index.value(&Spectrum { values, directions: DMatrix::zeros(0, 0), poses: self.poses() })
            }
            (State::Spectral { spectrum, .. }, _) => self.index.value(spectrum),
            _ => self.value(),
        }
    }

    /// True if `a` is a better value of the index than `b`.
    pub fn better(&self, a: f64, b: f64) -> bool {
        super::better(self.index.goal(), a, b)
    }

    /// The open candidate whose addition makes the index best; `None` if none is open.
    pub fn best_addition(&mut self) -> Option<Best> {
        self.refresh();
        let mut scores = std::mem::take(&mut self.scores);
        match (&self.pool.layout, self.exact_scores_only()) {
            (_, true) => self.slow_additions(&mut scores),
            (Stored::Legs(legs), _) => self.scan(legs, 1.0, &self.open, &mut scores),
            (Stored::Dense(dense), _) => self.scan(dense, 1.0, &self.open, &mut scores),
        }
        self.scores = scores;
        self.sharpen();
        best_open(&self.scores, &self.open)
    }

    /// Score of a candidate in the last scan of additions.
    pub fn score(&self, candidate: usize) -> f64 {
        self.scores[candidate / LANES][candidate % LANES]
    }

    /// The member (by position) whose removal leaves the index best; `None` if there is none.
    pub fn best_removal(&mut self) -> Option<Best> {
        if self.members.is_empty() {
            return None;
        }
        self.refresh();
        let n = self.members.len();
        let mut scores = vec![[0.0; LANES]; n.div_ceil(LANES)];
        let all = vec![[1.0; LANES]; scores.len()];
        let tight = 6 * (n - 1) + self.fixed.nrows() < self.pool.directions() + 12;
        if self.exact_scores_only() || (tight && !matches!(self.state, State::Determinant { .. })) {
            return best_of((0..n).map(|p| self.exact_without(p)));
        }
        match self.pool.gather(&self.members) {
            Stored::Legs(legs) => self.scan(&legs, -1.0, &all, &mut scores),
            Stored::Dense(dense) => self.scan(&dense, -1.0, &all, &mut scores),
        }
        let mut flat: Vec<f64> = scores.into_iter().flatten().take(n).collect();
        if matches!(self.index.fast(), FastForm::HarmonicSum)
            && let Some(best) = best_of(flat.iter().copied())
        {
            // Scores are minus the change: those within the error of the quadrature are computed exactly.
            let margin = QUADRATURE * best.score.abs();
            let close: Vec<usize> = (0..n).filter(|p| flat[*p] >= best.score - margin).collect();
            if close.len() > 1 {
                flat = vec![f64::NEG_INFINITY; n];
                close.into_iter().for_each(|p| flat[p] = self.exact_without(p));
            }
        }
        best_of(flat)
    }

    /// Adds a candidate.
    pub fn add(&mut self, candidate: usize) {
        self.update(candidate, 1.0);
        self.members.push(candidate);
        self.close(candidate);
    }

    /// Removes the member at a position, and opens it again.
    pub fn remove(&mut self, position: usize) -> usize {
        let candidate = self.members.remove(position);
        self.update(candidate, -1.0);
        self.reopen(candidate);
        candidate
    }

    /// Replaces a member by the best candidate, if that is better (Cook and Nachtsheim 1980); tells whether it was.
    pub fn exchange(&mut self, position: usize) -> bool {
        let old = self.remove(position);
        let found = self.best_addition();
        let better = |best: &Best| best.which != old && best.score > self.score(old) + 1e-10 * best.score.abs();
        let new = found.filter(better).map_or(old, |best| best.which);
        self.add(new);
        // Keep the place, so that a pass visits each member once.
        if let Some(last) = self.members.pop() {
            self.members.insert(position, last);
        }
        new != old
    }

    /// True if this set determines nothing without a ridge.
    pub fn is_singular(&self) -> bool {
        let values = Spectrum::of(&self.stacked(|k| self.pool.stored(k), &self.fixed_stored(), None), 0, false).values;
        let (first, last) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
        !(last * last > SINGULAR * first * first)
    }

    fn exact_scores_only(&self) -> bool {
        matches!(self.index.fast(), FastForm::None)
    }

    fn fixed_stored(&self) -> DMatrix<f64> {
        &self.fixed * &self.pool.inverse
    }

    /// Brings the state up to date.
    fn refresh(&mut self) {
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
                let (information, inverse, ridged) = self.information();
                State::Determinant { information, inverse, ridged, updates: 0 }
            }
            FastForm::Trace(gain) => {
                let (_, inverse, _) = self.information();
                let onto = &self.pool.inverse * &inverse;
                let middle = onto.transpose() * gain * onto;
                State::Trace { inverse, middle }
            }
            FastForm::Extremes(_) | FastForm::HarmonicSum | FastForm::None => {
                let spectrum = Spectrum::of(&self.rows(), self.poses(), true);
                let largest = spectrum.values.first().copied().unwrap_or(0.0);
                let floor = (1e-15 * largest).powi(2);
                let lambda: Vec<f64> = spectrum.values.iter().map(|s| s * s + floor).collect();
                let rotation = &self.pool.basis * &spectrum.directions;
                State::Spectral { spectrum, lambda, rotation }
            }
        };
    }

    /// `M` in stored coordinates, its inverse, and whether a ridge was needed.
    fn information(&self) -> (DMatrix<f64>, DMatrix<f64>, bool) {
        let rows = self.stacked(|k| self.pool.stored(k), &self.fixed_stored(), None);
        let mut m = rows.transpose() * &rows;
        let n = m.nrows();
        let regular = |m: &DMatrix<f64>| {
            let factor = Cholesky::new(m.clone())?;
            let pivots = factor.l_dirty().diagonal();
            (pivots.min() > SINGULAR.sqrt() * pivots.max()).then(|| factor.inverse())
        };
        if let Some(inverse) = regular(&m) {
            return (m, inverse, false);
        }
        let mut ridge = (RIDGE * m.trace() / n as f64).max(f64::MIN_POSITIVE.sqrt());
        loop {
            for k in 0..n {
                m[(k, k)] += ridge;
            }
            match regular(&m) {
                Some(inverse) => return (m, inverse, true),
                // A ridge as large as the mean eigenvalue always is enough.
                None => ridge *= 10.0,
            }
        }
    }

    /// Scores of all candidates of a layout, larger is better.
    fn scan<L: kernel::Layout>(&self, layout: &L, sign: f64, open: &[Lanes], out: &mut [Lanes]) {
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
    fn sharpen(&mut self) {
        if !matches!(self.index.fast(), FastForm::HarmonicSum) {
            return;
        }
        let State::Spectral { spectrum, .. } = &self.state else { return };
        let now: f64 = spectrum.values.iter().map(|v| 1.0 / v).sum();
        let Some(best) = best_open(&self.scores, &self.open) else { return };
        let limit = best.score * (1.0 - QUADRATURE);
        let close: Vec<usize> = (0..self.pool.len()).filter(|k| self.is_open(*k) && self.score(*k) >= limit).collect();
        for k in close {
            let exact = now - self.spectrum_with(k).values.iter().map(|v| 1.0 / v).sum::<f64>();
            self.scores[k / LANES][k % LANES] = exact;
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

    fn slow_additions(&self, scores: &mut [Lanes]) {
        let sign = if self.index.goal() == Goal::Largest { 1.0 } else { -1.0 };
        scores.par_iter_mut().enumerate().for_each(|(batch, lanes)| {
            for (lane, score) in lanes.iter_mut().enumerate() {
                let k = batch * LANES + lane;
                if k < self.pool.len() && self.is_open(k) {
                    *score = sign * self.index.value(&self.spectrum_with(k));
                }
            }
        });
    }

    /// Value of the index without a member, larger is better.
    fn exact_without(&self, position: usize) -> f64 {
        let rows = self.stacked(|k| self.pool.rows(k), &self.fixed, Some(position));
        let value = self.index.value(&Spectrum::of(&rows, self.poses() - 1, self.index.needs_directions()));
        if self.index.goal() == Goal::Largest { value } else { -value }
    }

    /// Carries the state over to one candidate more or less, where that is cheaper than computing it afresh.
    fn update(&mut self, candidate: usize, sign: f64) {
        let State::Determinant { information, inverse, ridged: false, updates } = &mut self.state else {
            self.state = State::Stale;
            return;
        };
        let rows = self.pool.stored(candidate);
        information.gemm(sign, &rows.transpose(), &rows, 1.0);
        let across = &*inverse * rows.transpose();
        let middle = DMatrix::identity(6, 6) + &rows * &across * sign;
        let factor = Cholesky::new(middle).filter(|c| c.l_dirty().diagonal().min() > SMALL_PIVOT.sqrt());
        match factor {
            Some(factor) => {
                let solved = factor.solve(&across.transpose());
                inverse.gemm(-sign, &across, &solved, 1.0);
                *updates += 1;
            }
            None => self.state = State::Stale,
        }
    }
}

fn negate(scores: &mut [Lanes]) {
    scores.iter_mut().flatten().for_each(|v| *v = -*v);
}

/// The largest score; of ties the smallest index.
fn best_of(scores: impl IntoIterator<Item = f64>) -> Option<Best> {
    scores.into_iter().enumerate().fold(None, better_of)
}

/// The same among open candidates, batch by batch: most hold nothing above the best of those before.
fn best_open(scores: &[Lanes], open: &[Lanes]) -> Option<Best> {
    let mut best: Option<Best> = None;
    for (batch, (scores, open)) in scores.iter().zip(open).enumerate() {
        if best.is_none_or(|best| scores.iter().fold(false, |any, score| any | (*score > best.score))) {
            let lanes = (0..LANES).filter(|lane| open[*lane] != 0.0);
            best = lanes.map(|lane| (batch * LANES + lane, scores[lane])).fold(best, better_of);
        }
    }
    best
}

fn better_of(best: Option<Best>, (which, score): (usize, f64)) -> Option<Best> {
    let slack = |b: Best| if b.score.is_finite() { TIE * b.score.abs() } else { 0.0 };
    let better = best.is_none_or(|b| score > b.score + slack(b)) && !score.is_nan();
    if better { Some(Best { which, score }) } else { best }
}
