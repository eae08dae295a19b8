//! How good a set of poses can be at most.
//!
//! A set takes each candidate once or not at all. Let it be taken in part, with a share `0 ≤ xₖ ≤ 1`, `Σ x = m`, and
//! let `M(x) = M₀ + Σ xₖ JₖᵀJₖ`: an approximate design for `m` poses beside fixed rows `M₀`. A criterion `φ(M)` that is
//! concave lies below its tangent, so that for **every** `x` and every set `S` of `m` candidates
//!
//! ```text
//! φ(M₀ + Σ_S JₖᵀJₖ)  ≤  φ(M(x)) + (sum of the m largest dₖ) - Σ xₖ dₖ,      dₖ = tr(∇φ JₖᵀJₖ)
//! ```
//!
//! which is the equivalence theorem read as a certificate (Kiefer and Wolfowitz 1960; Pukelsheim, *Optimal Design of
//! Experiments*, 1993; for shares of at most one Wynn 1982). Without fixed rows the scale of `M(x)` is free, and the
//! best one gives a sharper form. The shares only make the bound tight; any shares make it true.
//!
//! | index | `φ` | `∇φ` |
//! |---|---|---|
//! | O1 | `ln det M` | `M⁻¹` |
//! | O5 | `-tr M^-½` | `½ M^-³ᐟ²` |
//! | pose error | `-tr(G M⁻¹)` | `M⁻¹ G M⁻¹` |
//! | O3 | `λ_min(M) ≤ tr(Z M)` for every `Z ⪰ 0`, `tr Z = 1` | `Z ∝ M^-(p+1)` with growing `p` |
//!
//! Of a long list few candidates ever get a share. The shares are then found over a part of it, the certificate is
//! taken over all of it, and the candidates with the largest `dₖ` join the part, until the certificate over all is that
//! over the part (column generation).

use nalgebra::DMatrix;

use super::criterion::{Criterion, ROUNDING, Spread, Tangent};
use super::screening::{WHOLE, strongest};
use super::support::Support;
use crate::observability::{ObservabilityIndex, Pool};

/// Shares of candidates, and what they prove.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Relaxation {
    /// Candidates with the part of each that is taken, at most one; they sum to the number of poses.
    pub shares: Vec<(usize, f64)>,
    /// No set of as many of these candidates, each taken once, has a better value of the index.
    pub bound: f64,
    /// Steps that led there.
    pub iterations: usize,
}

/// The bound is certified to this part of the index.
const GAP: f64 = 2e-6;
/// Steps of the multiplicative algorithm.
const STEPS: usize = 800;
/// Largest power with which O3 is approached.
const LARGEST_POWER: f64 = 150.0;

/// Candidates of the first part of a long list, and how many of the others join it after each look at all of them.
const PART: usize = 2500;
const JOINING: usize = 500;
/// Looks at all candidates, of which few are needed.
const PARTS: usize = 25;
/// The certificates over a part and over all candidates count as the same.
const SAME: f64 = 1e-9;

/// The bound of `index` over all sets of `count` candidates beside the `fixed` rows (m × L') of `fixed_poses` poses and
/// of a prior. `None` for indices without a concave criterion: O2, O4, and a consumer's own.
pub fn relax(
    pool: &Pool,
    index: &dyn ObservabilityIndex,
    fixed: &DMatrix<f64>,
    fixed_poses: usize,
    count: usize,
) -> Option<Relaxation> {
    relax_with(pool, None, index, fixed, fixed_poses, count)
}

/// The same over a pool and further candidates in its coordinates, which are numbered behind those of the pool.
pub(super) fn relax_with(
    pool: &Pool,
    further: Option<&Pool>,
    index: &dyn ObservabilityIndex,
    fixed: &DMatrix<f64>,
    fixed_poses: usize,
    count: usize,
) -> Option<Relaxation> {
    let criterion = Criterion::of(index)?;
    let task = Task { criterion, fixed, poses: count + fixed_poses };
    let own = pool.len();
    let all = own + further.map_or(0, Pool::len);
    let part_of = |members: &[usize]| match further {
        Some(further) => pool.joined(further, members),
        None => pool.only(members),
    };
    if all <= WHOLE.max(2 * count) {
        let joined = further.map(|_| part_of(&(0..all).collect::<Vec<_>>()));
        let mut support = Support::new(joined.as_ref().unwrap_or(pool), fixed, count)?;
        let found = task.solve(&mut support, 0)?;
        return Some(Relaxation { shares: support.shares(), bound: found.bound, iterations: found.steps });
    }
    let size = PART.max(2 * count);
    let mut part: Vec<usize> = (0..own).step_by(own.div_ceil(size)).chain(own..all).collect();
    let mut best: Option<Relaxation> = None;
    let mut before: Option<(Found, Vec<(usize, f64)>)> = None;
    for _ in 0..PARTS {
        let stored = part_of(&part);
        let mut support = match &before {
            Some((_, shares)) => Support::with_shares(&stored, fixed, count, &within(&part, shares)),
            None => Support::new(&stored, fixed, count)?,
        };
        let found = task.solve(&mut support, before.as_ref().map_or(0, |(found, _)| found.steps))?;
        let tangent = task.criterion.tangent(&support, found.power)?;
        let mut d = pool.directional(&tangent.phi);
        d.extend(further.iter().flat_map(|f| f.directional(&tangent.phi)));
        let shares: Vec<(usize, f64)> = support.shares().into_iter().map(|(k, x)| (part[k], x)).collect();
        let bound = task.bound(&tangent, &support, &Spread::of(&d, &shares, count));
        if best.as_ref().is_none_or(|b| task.criterion.tighter(bound, b.bound)) {
            best = Some(Relaxation { shares: shares.clone(), bound, iterations: found.steps });
        }
        if (bound - found.bound).abs() <= SAME * bound.abs() {
            break;
        }
        part = match &before {
            // The first part was taken blindly.
            None => strongest(&d, size, shares.iter().map(|(k, _)| *k)),
            Some(_) => strongest(&d, JOINING.max(2 * count), part),
        };
        before = Some((found, shares));
    }
    best.filter(|b| b.bound.is_finite())
}

/// Shares with the places of their candidates in a part, which has all of them in order.
fn within(part: &[usize], shares: &[(usize, f64)]) -> Vec<(usize, f64)> {
    shares.iter().filter_map(|(k, x)| Some((part.binary_search(k).ok()?, *x))).collect()
}

/// What is relaxed, over whatever candidates.
struct Task<'a> {
    criterion: Criterion<'a>,
    fixed: &'a DMatrix<f64>,
    /// Poses in all.
    poses: usize,
}

/// Where the shares of a support came to rest, and the certificate over its candidates.
struct Found {
    bound: f64,
    /// Power of the tangent that gave it.
    power: f64,
    steps: usize,
}

impl Task<'_> {
    fn free_scale(&self) -> bool {
        self.fixed.nrows() == 0
    }

    /// Improves the shares of a support until the certificate over its candidates is tight, after so many steps before.
    /// Every criterion starts from the volume: from the shares of another it is slow.
    fn solve(&self, support: &mut Support<'_>, before: usize) -> Option<Found> {
        let volume = support.maximise_volume(GAP);
        let steps = before + volume.steps;
        let found = if matches!(self.criterion, Criterion::Determinant) {
            let spread = Spread { top: volume.top, within: volume.within };
            Found { bound: self.volume_bound(support, volume.log_determinant, &spread), power: 1.0, steps }
        } else {
            self.approach(support, steps)
        };
        found.bound.is_finite().then_some(found)
    }

    /// The bound that a tangent proves, from sums of `d`.
    fn bound(&self, tangent: &Tangent, support: &Support<'_>, d: &Spread) -> f64 {
        match self.criterion {
            Criterion::Determinant => self.volume_bound(support, tangent.now, d),
            _ => self.criterion.bound(tangent, support, d, self.free_scale()),
        }
    }

    fn volume_bound(&self, support: &Support<'_>, log_determinant: f64, d: &Spread) -> f64 {
        let l = support.pool.directions() as f64;
        let determinant =
            if self.free_scale() { log_determinant + l * (d.top / l).ln() } else { log_determinant + d.top - d.within };
        let raw = determinant + 2.0 * support.pool.log_volume();
        (raw / (2.0 * l)).exp() / (self.poses as f64).sqrt() * (1.0 + ROUNDING)
    }

    /// Multiplicative steps `x ← x d^γ` (Silvey, Titterington and Torsney 1978), with the best candidate let in at each.
    fn approach(&self, support: &mut Support<'_>, before: usize) -> Found {
        let criterion = &self.criterion;
        let worst = if matches!(criterion, Criterion::Trace(_)) { 0.0 } else { f64::INFINITY };
        let mut best = (worst, support.shares(), 1.0);
        let mut steps = before;
        let mut power: f64 = if matches!(criterion, Criterion::Harmonic) { 0.5 } else { 1.0 };
        let mut since = 0;
        for _ in 0..STEPS {
            let Some(tangent) = criterion.tangent(support, power) else { break };
            let d = support.directional(&tangent.phi);
            let spread = support.spread(&d);
            let bound = criterion.bound(&tangent, support, &spread, self.free_scale());
            since += 1;
            if criterion.tighter(bound, best.0) {
                if (bound / best.0 - 1.0).abs() > 1e-5 || best.0 == 0.0 {
                    since = 0;
                }
                best = (bound, support.shares(), power);
            }
            steps += 1;
            let gap = spread.top / spread.within - 1.0;
            if matches!(criterion, Criterion::Smallest) {
                if since > 40 && power >= LARGEST_POWER {
                    break;
                }
                power = (power * 1.03).min(LARGEST_POWER);
            } else if gap < 1e-5 || since > 150 {
                break;
            }
            support.multiply(&d, 1.0 / (power + 1.0));
        }
        support.set_shares(&best.1);
        Found { bound: best.0, power: best.2, steps }
    }
}
