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

use nalgebra::{Cholesky, DMatrix};

use super::support::Support;
use crate::observability::{FastForm, ObservabilityIndex, Pool};
use crate::solve::svd;

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
/// Room for the rounding of the certificate itself.
const ROUNDING: f64 = 1e-9;

/// The bound of `index` over all sets of `count` candidates beside the `fixed` rows (m × L') of `fixed_poses` poses and
/// of a prior. `None` for indices without a concave criterion: O2, O4, and a consumer's own.
pub fn relax(
    pool: &Pool,
    index: &dyn ObservabilityIndex,
    fixed: &DMatrix<f64>,
    fixed_poses: usize,
    count: usize,
) -> Option<Relaxation> {
    let criterion = match index.fast() {
        FastForm::Determinant => Criterion::Determinant,
        FastForm::HarmonicSum => Criterion::Harmonic,
        FastForm::Trace(gain) => Criterion::Trace(gain),
        FastForm::Extremes(e) if !e.over_largest && e.smallest == 1 => Criterion::Smallest,
        _ => return None,
    };
    let mut support = Support::new(pool, fixed, count)?;
    let free_scale = fixed.nrows() == 0;
    let volume = support.maximise_volume(GAP);
    let (best, iterations) = match criterion {
        Criterion::Determinant => {
            let l = pool.directions() as f64;
            let determinant = if free_scale {
                volume.log_determinant + l * (volume.top / l).ln()
            } else {
                volume.log_determinant + volume.top - volume.within
            };
            let raw = determinant + 2.0 * pool.log_volume();
            ((raw / (2.0 * l)).exp() / ((count + fixed_poses) as f64).sqrt() * (1.0 + ROUNDING), volume.steps)
        }
        _ => approach(&mut support, &criterion, free_scale, volume.steps),
    };
    best.is_finite().then(|| Relaxation { shares: support.shares(), bound: best, iterations })
}

enum Criterion<'a> {
    Determinant,
    Harmonic,
    Trace(&'a DMatrix<f64>),
    Smallest,
}

/// A matrix `Φ` in stored coordinates, and what the index is at `M(x)`.
struct Tangent {
    phi: DMatrix<f64>,
    /// `tr M^-½`, `tr G M⁻¹` or unused.
    now: f64,
}

impl Criterion<'_> {
    fn tangent(&self, support: &Support<'_>, power: f64) -> Option<Tangent> {
        let (m, basis) = (support.information(), &support.pool.basis());
        let factor = Cholesky::new(m.clone())?;
        match self {
            Criterion::Determinant => Some(Tangent { phi: factor.inverse(), now: 0.0 }),
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
    fn bound(&self, tangent: &Tangent, support: &Support<'_>, d: &Spread, free_scale: bool) -> f64 {
        match self {
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

    fn tighter(&self, a: f64, b: f64) -> bool {
        if matches!(self, Criterion::Trace(_)) { a > b } else { a < b }
    }
}

/// The sum of the `m` largest `d`, and `Σ x d`.
pub(super) struct Spread {
    pub(super) top: f64,
    pub(super) within: f64,
}

/// Multiplicative steps `x ← x d^γ` (Silvey, Titterington and Torsney 1978), with the best candidate let in at each.
fn approach(support: &mut Support<'_>, criterion: &Criterion<'_>, free_scale: bool, before: usize) -> (f64, usize) {
    let worst = if matches!(criterion, Criterion::Trace(_)) { 0.0 } else { f64::INFINITY };
    let mut best = (worst, support.shares());
    let mut steps = before;
    let mut power: f64 = match criterion {
        Criterion::Trace(_) => 1.0,
        Criterion::Harmonic => 0.5,
        _ => 1.0,
    };
    let mut since = 0;
    for _ in 0..STEPS {
        let Some(tangent) = criterion.tangent(support, power) else { break };
        let d = support.directional(&tangent.phi);
        let spread = support.spread(&d);
        let bound = criterion.bound(&tangent, support, &spread, free_scale);
        since += 1;
        if criterion.tighter(bound, best.0) {
            if (bound / best.0 - 1.0).abs() > 1e-5 || best.0 == 0.0 {
                since = 0;
            }
            best = (bound, support.shares());
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
    (best.0, steps)
}
