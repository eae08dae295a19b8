//! The candidates that have a share in an approximate design.

use nalgebra::{Cholesky, DMatrix};

use super::criterion::Spread;
use crate::observability::{O1, Pool, PoseSet, update_inverse};
use crate::solve::symmetric_eigen;

/// Shares below this are dropped.
const DROPPED: f64 = 1e-6;
/// Candidates let in after each look at all of them.
const LET_IN: usize = 4;
/// Exchanges between two looks.
const EXCHANGES: usize = 80;
/// Looks at all candidates.
const LOOKS: usize = 600;

/// Shares `0 < xₖ ≤ 1` of some candidates, `Σ x = m`, and `M(x) = M₀ + Σ xₖ JₖᵀJₖ` in stored coordinates.
pub(super) struct Support<'a> {
    pub(super) pool: &'a Pool,
    fixed: DMatrix<f64>,
    count: usize,
    members: Vec<usize>,
    shares: Vec<f64>,
    rows: Vec<DMatrix<f64>>,
}

/// Where the volume came to rest.
pub(super) struct Volume {
    pub(super) log_determinant: f64,
    pub(super) top: f64,
    pub(super) within: f64,
    pub(super) steps: usize,
}

impl<'a> Support<'a> {
    /// Equal shares of a set that determines everything. `None` if no set does, or if there are fewer candidates than
    /// poses.
    pub(super) fn new(pool: &'a Pool, fixed: &DMatrix<f64>, count: usize) -> Option<Self> {
        if pool.len() < count || count == 0 {
            return None;
        }
        let directions = pool.directions();
        let mut set = PoseSet::new(pool, &O1, &[], &[]);
        let enough = (directions.div_ceil(6) * 2 + 4).max(count + count / 4).min(pool.len());
        while set.members().len() < enough || set.is_singular() {
            let best = set.best_addition()?;
            set.add(best.which);
        }
        let share = count as f64 / set.members().len() as f64;
        let shares: Vec<(usize, f64)> = set.members().iter().map(|k| (*k, share)).collect();
        Some(Self::with_shares(pool, fixed, count, &shares))
    }

    /// Shares that were found before.
    pub(super) fn with_shares(pool: &'a Pool, fixed: &DMatrix<f64>, count: usize, shares: &[(usize, f64)]) -> Self {
        let stored = fixed * pool.inverse_basis();
        let fixed = stored.transpose() * stored;
        let mut support = Self { pool, fixed, count, members: Vec::new(), shares: Vec::new(), rows: Vec::new() };
        support.set_shares(shares);
        support
    }

    /// `M₀`.
    pub(super) fn fixed(&self) -> &DMatrix<f64> {
        &self.fixed
    }

    pub(super) fn shares(&self) -> Vec<(usize, f64)> {
        self.members.iter().copied().zip(self.shares.iter().copied()).collect()
    }

    pub(super) fn set_shares(&mut self, shares: &[(usize, f64)]) {
        (self.members, self.shares) = shares.iter().copied().unzip();
        self.rows = self.members.iter().map(|k| self.pool.stored(*k)).collect();
    }

    /// `M(x)`.
    pub(super) fn information(&self) -> DMatrix<f64> {
        let n = self.pool.directions();
        let mut stack = DMatrix::zeros(6 * self.members.len(), n);
        for (k, (rows, x)) in self.rows.iter().zip(&self.shares).enumerate() {
            stack.rows_mut(6 * k, 6).copy_from(&(rows * x.sqrt()));
        }
        let mut m = self.fixed.clone();
        m.gemm(1.0, &stack.transpose(), &stack, 1.0);
        m
    }

    /// `dₖ = tr(Φ JₖᵀJₖ)` of all candidates.
    pub(super) fn directional(&self, phi: &DMatrix<f64>) -> Vec<f64> {
        self.pool.directional(phi)
    }

    /// The sums that make the certificate.
    pub(super) fn spread(&self, d: &[f64]) -> Spread {
        Spread::of(d, &self.shares(), self.count)
    }

    /// Candidates outside with the largest `d`, in order of their number.
    fn outside(&self, d: &[f64], how_many: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..d.len()).filter(|k| !self.members.contains(k)).collect();
        if how_many < order.len() {
            order.select_nth_unstable_by(how_many, |a, b| d[*b].total_cmp(&d[*a]).then(a.cmp(b)));
            order.truncate(how_many);
        }
        order.sort_unstable();
        order
    }

    fn let_in(&mut self, candidate: usize, share: f64) {
        self.members.push(candidate);
        self.shares.push(share);
        self.rows.push(self.pool.stored(candidate));
    }

    /// Drops what is negligible and brings the sum back to `m` with no share above one.
    fn tidy(&mut self) {
        let kept: Vec<usize> = (0..self.members.len()).filter(|k| self.shares[*k] > DROPPED).collect();
        self.members = kept.iter().map(|k| self.members[*k]).collect();
        self.rows = kept.iter().map(|k| self.rows[*k].clone()).collect();
        self.shares = kept.iter().map(|k| self.shares[*k]).collect();
        let count = self.count as f64;
        // Scaling up can push further shares over one; each round fixes at least one of them.
        for _ in 0..=self.shares.len() {
            let full = self.shares.iter().filter(|x| **x >= 1.0).count() as f64;
            let rest: f64 = self.shares.iter().filter(|x| **x < 1.0).sum();
            if rest <= 0.0 {
                break;
            }
            let factor = (count - full) / rest;
            self.shares.iter_mut().for_each(|x| *x = if *x >= 1.0 { 1.0 } else { *x * factor });
            if self.shares.iter().all(|x| *x <= 1.0) {
                break;
            }
        }
    }

    /// `x ← x d^γ`, and the best candidate outside is let in.
    pub(super) fn multiply(&mut self, d: &[f64], exponent: f64) {
        let smallest = self.members.iter().map(|k| d[*k]).fold(f64::INFINITY, f64::min);
        for candidate in self.outside(d, 1) {
            if d[candidate] > smallest {
                self.let_in(candidate, 1e-2);
            }
        }
        let mean = self.spread(d).within / self.count as f64;
        for (k, x) in self.members.iter().zip(&mut self.shares) {
            *x *= (d[*k].max(0.0) / mean).powf(exponent);
        }
        self.tidy();
    }

    /// Maximises `ln det M(x)` by exchanging shares between pairs of candidates with an exact line search (Böhning
    /// 1986), until the certificate is within `gap` of the index.
    pub(super) fn maximise_volume(&mut self, gap: f64) -> Volume {
        let l = self.pool.directions() as f64;
        let mut steps = 0;
        for look in 0.. {
            let m = self.information();
            let Some(factor) = Cholesky::new(m) else { break };
            let d = self.directional(&factor.inverse());
            let Spread { top, within } = self.spread(&d);
            if top - within < 2.0 * l * gap || look == LOOKS {
                return Volume { log_determinant: factor.ln_determinant(), top, within, steps };
            }
            for candidate in self.outside(&d, LET_IN) {
                self.let_in(candidate, 0.0);
            }
            steps += self.exchange(factor.inverse(), 0.1 * (top - within) / self.count as f64);
            self.tidy();
        }
        Volume { log_determinant: f64::NAN, top: f64::NAN, within: f64::NAN, steps }
    }

    /// Exchanges within the support until no pair differs by more than `gap`; returns their number.
    fn exchange(&mut self, mut inverse: DMatrix<f64>, gap: f64) -> usize {
        for step in 0..EXCHANGES {
            let d: Vec<f64> = self.rows.iter().map(|b| (b * &inverse).dot(b)).collect();
            let heavier = |a: &usize, b: &usize| d[*a].total_cmp(&d[*b]);
            let Some(to) = (0..d.len()).filter(|k| self.shares[*k] < 1.0).max_by(heavier) else { return step };
            let Some(from) = (0..d.len()).filter(|k| self.shares[*k] > 0.0).min_by(heavier) else { return step };
            if to == from || d[to] - d[from] < gap {
                return step;
            }
            let most = self.shares[from].min(1.0 - self.shares[to]);
            let t = self.best_shift(&inverse, from, to, most);
            self.shares[to] = if t == 1.0 - self.shares[to] { 1.0 } else { self.shares[to] + t };
            self.shares[from] = if t == self.shares[from] { 0.0 } else { self.shares[from] - t };
            for (which, sign) in [(to, 1.0), (from, -1.0)] {
                let rows = &self.rows[which] * t.sqrt();
                if update_inverse(&mut inverse, &rows, sign, 0.0).is_none() {
                    return step + 1;
                }
            }
        }
        EXCHANGES
    }

    /// The shift of shares, at most `most`, that makes the determinant largest.
    fn best_shift(&self, inverse: &DMatrix<f64>, from: usize, to: usize, most: f64) -> f64 {
        let mut rows = DMatrix::zeros(12, self.pool.directions());
        rows.rows_mut(0, 6).copy_from(&self.rows[to]);
        rows.rows_mut(6, 6).copy_from(&self.rows[from]);
        let x = &rows * inverse * rows.transpose();
        // det(I + t D X) = Π (1 + t μ) for the eigenvalues μ of Cᵀ D C, X = C Cᵀ, D = diag(I, -I).
        let Some(c) = Cholesky::new(&x + DMatrix::identity(12, 12) * (1e-14 * x.trace())) else { return 0.5 * most };
        let c = c.unpack();
        let mut signed = c.clone();
        signed.rows_mut(6, 6).neg_mut();
        let mu = symmetric_eigen(c.transpose() * signed).eigenvalues;
        let slope = |t: f64| mu.iter().map(|m| m / (1.0 + t * m)).sum::<f64>();
        let safe = mu.iter().filter(|m| **m < 0.0).map(|m| -0.999 / m).fold(most, f64::min);
        if safe == most && slope(most) >= 0.0 {
            return most;
        }
        let (mut low, mut high) = (0.0, safe);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if slope(middle) > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}
