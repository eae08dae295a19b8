//! A set of poses: its index, the best pose to add, the best to remove.

mod best;
mod scoring;
mod state;

use nalgebra::DMatrix;

use super::kernel::{LANES, Lanes};
use super::pool::Stored;
use super::{FastForm, Goal, ObservabilityIndex, Pool, Spectrum, stacked};
use best::{best_of, best_open};
use scoring::QUADRATURE;
use state::{SINGULAR, State};

pub use best::Best;

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

impl<'a> PoseSet<'a> {
    /// A set of members. `given` are rows (6 each) of poses that are part of it beside the candidates.
    pub fn new(pool: &'a Pool, index: &'a dyn ObservabilityIndex, given: &[DMatrix<f64>], members: &[usize]) -> Self {
        let mut open = vec![[1.0; LANES]; pool.len().div_ceil(LANES)];
        for k in pool.len()..LANES * open.len() {
            open[k / LANES][k % LANES] = 0.0;
        }
        let scores = vec![[0.0; LANES]; open.len()];
        let mut set = Self {
            pool,
            index,
            fixed: stacked(given, pool.directions(), index.prior()),
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
            (State::Determinant { log_determinant, ridged: false, .. }, _) if self.index.goal() == Goal::Largest => {
                let directions = self.pool.directions();
                let mean = (0.5 * log_determinant + self.log_volume) / directions as f64;
                let values = vec![mean.exp(); directions];
                self.index.value(&Spectrum { values, directions: DMatrix::zeros(0, 0), poses: self.poses() })
            }
            (State::Spectral { spectrum, .. }, _) => self.index.value(spectrum),
            _ => self.value(),
        }
    }

    /// True if `a` is a better value of the index than `b`.
    pub fn better(&self, a: f64, b: f64) -> bool {
        self.index.goal().better(a, b)
    }

    /// The open candidate whose addition makes the index best; `None` if none is open.
    pub fn best_addition(&mut self) -> Option<Best> {
        self.refresh();
        let mut scores = std::mem::take(&mut self.scores);
        self.scan_additions(&mut scores);
        self.scores = scores;
        self.sharpen();
        best_open(&self.scores, &self.open)
    }

    fn scan_additions(&self, scores: &mut [Lanes]) {
        match (&self.pool.layout, self.exact_scores_only()) {
            (_, true) => self.slow_additions(scores),
            (Stored::Legs(legs), _) => self.scan(legs, 1.0, &self.open, scores),
            (Stored::Dense(dense), _) => self.scan(dense, 1.0, &self.open, scores),
        }
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
        &self.fixed * &self.pool.coordinates.inverse
    }
}
