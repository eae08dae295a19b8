//! `Σ 1/σᵢ` after adding or removing a pose, by quadrature.
//!
//! `tr (M ± JᵀJ)^-½ - tr M^-½ = 1/π ∫ [h(e²ˣ) - h(0)] e⁻ˣ dx` with `h(t) = ln det(I ± J (M + tI)⁻¹ Jᵀ)`. The integrand
//! is analytic in a strip of half-width π/2, so that the trapezoid rule with step 0.8 errs by about
//! `2 exp(-π²/0.8)`, 1e-5 of the change; beyond the nodes it behaves as `eˣ` (left) and as `-h(0) e⁻ˣ` (right), two
//! geometric sums.

use pulp::Simd;

use super::lanes::{LANES, Lanes, add_outer, determinant_of, store, vectors};
use super::{Layout, Scan, run};

const STEP: f64 = 0.8;
/// How far the nodes reach beyond the logarithms of the largest and the smallest singular value.
const ABOVE: f64 = 2.5;
const BELOW: f64 = 4.0;
/// Removing a pose may make the smallest singular value much smaller.
const BELOW_REMOVAL: f64 = 8.0;

struct Harmonic<'a> {
    rotation: &'a [f64],
    sign: f64,
    /// `1/λᵢ`, then `1/(λᵢ + t)` for each node.
    weights: Vec<Vec<f64>>,
    /// Factor of `h(t) - h(0)` of each node, and of `-h(0)` beyond the last.
    factors: Vec<f64>,
    tail: f64,
}

impl<L: Layout> Scan<L> for Harmonic<'_> {
    type Memory<S: Simd> = Vec<S::f64s>;

    fn start<S: Simd>(&self, _: S, layout: &L) -> Vec<S::f64s> {
        Vec::with_capacity(6 * layout.parameters())
    }

    #[inline(always)]
    fn batch<S: Simd>(
        &self,
        simd: S,
        layout: &L,
        batch: &[Lanes],
        open: &Lanes,
        out: &mut Lanes,
        y: &mut Vec<S::f64s>,
    ) {
        *out = [0.0; LANES];
        let sign = simd.splat_f64s(self.sign);
        let width = LANES / vectors::<S>();
        for vector in 0..vectors::<S>() {
            let lanes = width * vector..width * (vector + 1);
            layout.rotate(simd, batch, vector, self.rotation, y);
            let p = layout.noise(simd, batch, vector);
            let mut first = [0.0; LANES];
            for (node, weights) in self.weights.iter().enumerate() {
                let mut m = p;
                for (weight, y) in weights.iter().zip(y.as_chunks::<6>().0) {
                    let weight = simd.mul_f64s(sign, simd.splat_f64s(*weight));
                    add_outer(simd, &mut m, weight, y);
                }
                let mut h = [0.0; LANES];
                store::<S>(&mut h, 0, determinant_of(simd, m));
                for (lane, (h, first)) in h.iter().zip(&mut first).enumerate().take(width) {
                    // Layouts keep det P = 1. A removal that leaves a singular set has no finite value.
                    let h = if *h > 0.0 { h.ln() } else { f64::NEG_INFINITY };
                    let sum = &mut out[lanes.start + lane];
                    if node == 0 {
                        *first = h;
                        *sum = -self.tail * h;
                    } else {
                        *sum += self.factors[node - 1] * (h - *first);
                    }
                }
            }
            for k in lanes {
                out[k] *= open[k];
            }
        }
    }
}

/// Change of `Σ 1/σᵢ` when each candidate is added (`sign = 1`) or removed (`sign = -1`); 0 where `open` is.
pub(in super::super) fn harmonic<L: Layout>(
    layout: &L,
    lambda: &[f64],
    rotation: &[f64],
    sign: f64,
    open: &[Lanes],
    out: &mut [Lanes],
) {
    let (largest, smallest) = (lambda[0], lambda[lambda.len() - 1].max(lambda[0] * 1e-30));
    let start = 0.5 * smallest.ln() - if sign > 0.0 { BELOW } else { BELOW_REMOVAL };
    let nodes = ((0.5 * largest.ln() + ABOVE - start) / STEP).ceil() as usize + 1;
    let shrink = (-STEP).exp();
    let geometric = shrink / (1.0 - shrink);
    let at = |k: usize| start + STEP * k as f64;
    let factor = |k: usize| {
        let beyond = if k == 0 { 1.0 + geometric } else { 1.0 };
        STEP / std::f64::consts::PI * (-at(k)).exp() * beyond
    };
    let shifts = std::iter::once(0.0).chain((0..nodes).map(|k| (2.0 * at(k)).exp()));
    let weights = shifts.map(|t| lambda.iter().map(|l| 1.0 / (l.max(smallest) + t)).collect()).collect();
    let tail = STEP / std::f64::consts::PI * (-at(nodes - 1)).exp() * geometric;
    let scan = Harmonic { rotation, sign, weights, factors: (0..nodes).map(factor).collect(), tail };
    run(layout, &scan, open, out);
}
