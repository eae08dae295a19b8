//! The largest and the smallest singular value after adding or removing a pose.
//!
//! In the eigenbasis of `M = Q diag(λ) Qᵀ` a candidate has `Y = U Q`, and one matrix
//! `P ± Σ yᵢ yᵢᵀ/(λᵢ - b)` tells how many eigenvalues of `M ± JᵀJ` lie below `b`: a bisection on that count gives any
//! eigenvalue exactly, each lane with its own `b`. Few candidates need it. With a lower bound of the largest
//! eigenvalue (power steps in the span of the leading eigenvectors) a value better than the best so far asks for a
//! smallest eigenvalue above some `b`, and one count shows that nearly all candidates have none.

use pulp::Simd;

use super::eigenvalues::{Lane, spread};
use super::lanes::{LANES, Lanes, load, vectors};
use super::{Layout, Scan, run};

/// An index that is `σ_L^p / σ₁^q`, with `p` 1 or 2 and `q` 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extremes {
    /// Power `p` of the smallest singular value: 1 or 2.
    pub smallest: u8,
    /// True if it is divided by the largest singular value.
    pub over_largest: bool,
}

impl Extremes {
    /// The index for the smallest and the largest eigenvalue of `JᵀJ`.
    pub(in super::super) fn value(self, smallest: f64, largest: f64) -> f64 {
        let s = smallest.max(0.0).sqrt();
        let power = if self.smallest == 2 { s * s } else { s };
        if self.over_largest { power / largest.sqrt() } else { power }
    }

    /// The smallest eigenvalue that a `value` needs if the largest is `largest`.
    fn needed(self, value: f64, largest: f64) -> f64 {
        let power = if self.over_largest { value * largest.sqrt() } else { value };
        if self.smallest == 2 { power } else { power * power }
    }
}

/// Halvings of that interval before the smallest eigenvalue is computed.
const NARROWINGS: usize = 8;
/// Candidates that fall short by less than this are still evaluated.
const CLOSE: f64 = 1e-6;

pub(super) struct ExtremesScan<'a> {
    lambda: &'a [f64],
    rotation: &'a [f64],
    sign: f64,
    index: Extremes,
}

/// What is kept between batches.
pub(super) struct Work<S: Simd> {
    y: Vec<S::f64s>,
    best: f64,
}

impl<L: Layout> Scan<L> for ExtremesScan<'_> {
    type Memory<S: Simd> = Work<S>;

    fn start<S: Simd>(&self, _: S, layout: &L) -> Work<S> {
        Work { y: Vec::with_capacity(6 * layout.parameters()), best: 0.0 }
    }

    #[inline(always)]
    fn batch<S: Simd>(&self, simd: S, layout: &L, batch: &[Lanes], open: &Lanes, out: &mut Lanes, work: &mut Work<S>) {
        *out = [0.0; LANES];
        let width = LANES / vectors::<S>();
        for vector in 0..vectors::<S>() {
            let lanes = width * vector..width * (vector + 1);
            if open[lanes.clone()].iter().all(|o| *o == 0.0) {
                continue;
            }
            layout.rotate(simd, batch, vector, self.rotation, &mut work.y);
            let p = layout.noise(simd, batch, vector);
            let lane = Lane { simd, p, y: &work.y, lambda: self.lambda, sign: self.sign };
            let mut open_here = [0.0; LANES];
            open_here[..width].copy_from_slice(&open[lanes.clone()]);
            let Some((low, high)) = self.survivors(&lane, &open_here, work.best) else { continue };
            let smallest = spread::<S>(lane.smallest());
            let largest = if self.index.over_largest { spread::<S>(lane.between(low, high)) } else { [0.0; LANES] };
            for k in lanes.clone() {
                out[k] = open[k] * self.index.value(smallest[k - lanes.start], largest[k - lanes.start]);
                work.best = work.best.max(out[k]);
            }
        }
    }
}

// Nothing here may hide in a closure: a closure is compiled for the least machine and called.
impl ExtremesScan<'_> {
    /// Bounds of the largest eigenvalue of each lane, or `None` once it is sure that no open lane beats `best`: the
    /// bounds are narrowed until either that shows or they are tight.
    #[inline(always)]
    fn survivors<S: Simd>(&self, lane: &Lane<'_, S>, open: &Lanes, best: f64) -> Option<(S::f64s, S::f64s)> {
        let simd = lane.simd;
        let best = best * (1.0 - CLOSE);
        if !self.index.over_largest {
            let zero = simd.splat_f64s(0.0);
            return if self.hopeless(lane, open, best, zero) { None } else { Some((zero, zero)) };
        }
        let mut low = lane.largest_at_least();
        if self.hopeless(lane, open, best, low) {
            return None;
        }
        let mut high = lane.largest_at_most(low);
        for _ in 0..NARROWINGS {
            (low, high) = lane.narrower(low, high);
            if self.hopeless(lane, open, best, low) {
                return None;
            }
        }
        Some((low, high))
    }

    /// True if no open lane whose largest eigenvalue is at least `largest` has an index above `best`.
    #[inline(always)]
    fn hopeless<S: Simd>(&self, lane: &Lane<'_, S>, open: &Lanes, best: f64, largest: S::f64s) -> bool {
        let mut needed = spread::<S>(largest);
        for l in &mut needed {
            *l = self.index.needed(best, *l);
        }
        let below = spread::<S>(lane.below(load::<S>(&needed, 0)));
        open.iter().zip(&below).all(|(open, below)| *open == 0.0 || *below > 0.5)
    }
}

/// Values of the index after adding (`sign = 1`) or removing (`sign = -1`) each candidate, exact for all that come
/// within 1e-6 of the best and 0 for others and where `open` is. `lambda` are the eigenvalues of `M`, descending, and
/// `rotation` (column-major) their eigenvectors in the coordinates of the layout.
pub(in super::super) fn extremes<L: Layout>(
    layout: &L,
    lambda: &[f64],
    rotation: &[f64],
    sign: f64,
    index: Extremes,
    open: &[Lanes],
    out: &mut [Lanes],
) {
    run(layout, &ExtremesScan { lambda, rotation, sign, index }, open, out);
}
