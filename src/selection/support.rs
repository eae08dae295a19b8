//! The candidates that carry weight in an approximate design.

use nalgebra::{Cholesky, DMatrix};

use super::relaxation::Spread;
use crate::observability::{O1, Pool, PoseSet};

/// Weights below this part of the mean are dropped.
const DROPPED: f64 = 1e-5;
/// Candidates let in after each look at all of them.
const LET_IN: usize = 4;
/// Exchanges of weight between two looks.
const EXCHANGES: usize = 80;
/// Looks at all candidates.
const LOOKS: usize = 400;

/// Weights `w` of some candidates, and `M(w) = M₀ + m Σ wₖ JₖᵀJₖ` in stored coordinates.
pub(super) struct Support<'a> {
    pub(super) pool: &'a Pool,
    fixed: DMatrix<f64>,
    count: f64,
    members: Vec<usize>,
    weights: Vec<f64>,
    rows: Vec<DMatrix<f64>>,
}

/// Where the volume came to rest.
pub(super) struct Volume {
    pub(super) log_determinant: f64,
    pub(super) largest: f64,
    pub(super) mean: f64,
    pub(super) steps: usize,
}

impl<'a> Support<'a> {
    /// Equal weights on a set that determines everything. `None` if no set does.
    pub(super) fn new(pool: &'a Pool, fixed: &DMatrix<f64>, count: usize) -> Option<Self> {
        let directions = pool.directions();
        let stored = fixed * pool.inverse_basis();
        let mut set = PoseSet::new(pool, &O1, &[], &[]);
        let enough = (directions.div_ceil(6) * 2 + 4).min(pool.len());
        for _ in 0..enough {
            let best = set.best_addition()?;
            set.add(best.which);
        }
        while set.is_singular() {
            let best = set.best_addition()?;
            set.add(best.which);
        }
        let members = set.members().to_vec();
        let rows = members.iter().map(|k| pool.stored(*k)).collect();
        let weights = vec![1.0 / members.len() as f64; members.len()];
        Some(Self { pool, fixed: stored.transpose() * stored, count: count as f64, members, weights, rows })
    }

    /// Number `m` of poses that the weights stand for.
    pub(super) fn count(&self) -> f64 {
        self.count
    }

    /// `M₀`.
    pub(super) fn fixed(&self) -> &DMatrix<f64> {
        &self.fixed
    }

    pub(super) fn weights(&self) -> Vec<(usize, f64)> {
        self.members.iter().copied().zip(self.weights.iter().copied()).collect()
    }

    pub(super) fn set_weights(&mut self, weights: &[(usize, f64)]) {
        (self.members, self.weights) = weights.iter().copied().unzip();
        self.rows = self.members.iter().map(|k| self.pool.stored(*k)).collect();
    }

    /// `M(w)`.
    pub(super) fn information(&self) -> DMatrix<f64> {
        let n = self.pool.directions();
        let mut stack = DMatrix::zeros(6 * self.members.len(), n);
        for (k, (rows, w)) in self.rows.iter().zip(&self.weights).enumerate() {
            stack.view_mut((6 * k, 0), (6, n)).copy_from(&(rows * (self.count * w).sqrt()));
        }
        let mut m = self.fixed.clone();
        m.gemm(1.0, &stack.transpose(), &stack, 1.0);
        m
    }

    /// `dₖ = tr(Φ JₖᵀJₖ)` of all candidates.
    pub(super) fn directional(&self, phi: &DMatrix<f64>) -> Vec<f64> {
        self.pool.directional(phi)
    }

    /// Largest `d` and its mean over the weights.
    pub(super) fn spread(&self, d: &[f64]) -> Spread {
        let mean = self.members.iter().zip(&self.weights).map(|(k, w)| d[*k] * w).sum();
        Spread { largest: d.iter().copied().fold(0.0, f64::max), mean }
    }

    fn let_in(&mut self, candidate: usize, weight: f64) {
        if !self.members.contains(&candidate) {
            self.members.push(candidate);
            self.weights.push(weight);
            self.rows.push(self.pool.stored(candidate));
        }
    }

    fn drop_light(&mut self) {
        let limit = DROPPED / self.members.len() as f64;
        let kept: Vec<usize> = (0..self.members.len()).filter(|k| self.weights[*k] > limit).collect();
        self.members = kept.iter().map(|k| self.members[*k]).collect();
        self.rows = kept.iter().map(|k| self.rows[*k].clone()).collect();
        self.weights = kept.iter().map(|k| self.weights[*k]).collect();
        let sum: f64 = self.weights.iter().sum();
        self.weights.iter_mut().for_each(|w| *w /= sum);
    }

    /// `w ← w d^γ`, and the candidate with the largest `d` is let in.
    pub(super) fn multiply(&mut self, d: &[f64], exponent: f64) {
        let best = (0..d.len()).max_by(|a, b| d[*a].total_cmp(&d[*b]));
        if let Some(best) = best {
            self.let_in(best, 1e-2 / self.members.len() as f64);
        }
        for (k, w) in self.members.iter().zip(&mut self.weights) {
            *w *= d[*k].max(0.0).powf(exponent);
        }
        self.drop_light();
    }

    /// Maximises `ln det M(w)` by exchanging weight between pairs of candidates with an exact line search (Böhning
    /// 1986), until the certificate is within `gap` of the index.
    pub(super) fn maximise_volume(&mut self, gap: f64) -> Volume {
        let l = self.pool.directions() as f64;
        let mut steps = 0;
        for look in 0.. {
            let m = self.information();
            let Some(factor) = Cholesky::new(m) else { break };
            let d = self.directional(&factor.inverse());
            let spread = self.spread(&d);
            if self.count * (spread.largest - spread.mean) < 2.0 * l * gap || look == LOOKS {
                let log_determinant = 2.0 * factor.l_dirty().diagonal().iter().map(|v| v.ln()).sum::<f64>();
                return Volume { log_determinant, largest: spread.largest, mean: spread.mean, steps };
            }
            let mut order: Vec<usize> = (0..d.len()).collect();
            order.select_nth_unstable_by(LET_IN.min(d.len() - 1), |a, b| d[*b].total_cmp(&d[*a]).then(a.cmp(b)));
            order.truncate(LET_IN);
            order.sort_unstable();
            for candidate in order {
                self.let_in(candidate, 0.0);
            }
            let inside = 0.1 * self.count * (spread.largest - spread.mean);
            steps += self.exchange(factor.inverse(), inside);
            self.drop_light();
        }
        Volume { log_determinant: f64::NAN, largest: f64::NAN, mean: f64::NAN, steps }
    }

    /// Exchanges within the support until its own certificate is below `gap`; returns their number.
    fn exchange(&mut self, mut inverse: DMatrix<f64>, gap: f64) -> usize {
        for step in 0..EXCHANGES {
            let d: Vec<f64> = self.rows.iter().map(|b| (b * &inverse).dot(b)).collect();
            let heaviest = |a: &usize, b: &usize| d[*a].total_cmp(&d[*b]);
            let Some(to) = (0..d.len()).max_by(heaviest) else { return step };
            let Some(from) = (0..d.len()).filter(|k| self.weights[*k] > 0.0).min_by(heaviest) else { return step };
            if to == from || self.count * (d[to] - d[from]) < gap {
                return step;
            }
            let t = self.best_shift(&inverse, from, to);
            self.weights[to] += t;
            self.weights[from] -= t;
            if self.weights[from] < 1e-15 {
                self.weights[from] = 0.0;
            }
            for (which, sign) in [(to, 1.0), (from, -1.0)] {
                let rows = &self.rows[which] * (self.count * t).sqrt();
                let across = &inverse * rows.transpose();
                let middle = DMatrix::identity(6, 6) + &rows * &across * sign;
                let Some(factor) = Cholesky::new(middle) else { return step + 1 };
                let solved = factor.solve(&across.transpose());
                inverse.gemm(-sign, &across, &solved, 1.0);
            }
        }
        EXCHANGES
    }

    /// The shift of weight that makes the determinant largest.
    fn best_shift(&self, inverse: &DMatrix<f64>, from: usize, to: usize) -> f64 {
        let n = self.pool.directions();
        let mut rows = DMatrix::zeros(12, n);
        rows.rows_mut(0, 6).copy_from(&self.rows[to]);
        rows.rows_mut(6, 6).copy_from(&self.rows[from]);
        let x = &rows * inverse * rows.transpose() * self.count;
        // det(I + t D X) = Π (1 + t μ) for the eigenvalues μ of Cᵀ D C, X = C Cᵀ.
        let most = self.weights[from];
        let Some(c) = Cholesky::new(&x + DMatrix::identity(12, 12) * (1e-14 * x.trace())) else { return 0.5 * most };
        let c = c.unpack();
        let mut signed = c.clone();
        signed.rows_mut(6, 6).neg_mut();
        let mu = (c.transpose() * signed).symmetric_eigenvalues();
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
