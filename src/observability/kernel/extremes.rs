//! The largest and the smallest singular value after adding or removing a pose.
//!
//! In the eigenbasis of `M = Q diag(λ) Qᵀ` a candidate has `Y = U Q`, and one matrix
//! `P ± Σ yᵢ yᵢᵀ/(λᵢ - b)` tells how many eigenvalues of `M ± JᵀJ` lie below `b`: a bisection on that count gives any
//! eigenvalue exactly, each lane with its own `b`. Few candidates need it. With a lower bound of the largest
//! eigenvalue (power steps in the span of the leading eigenvectors) a value better than the best so far asks for a
//! smallest eigenvalue above some `b`, and one count shows that nearly all candidates have none.

use pulp::Simd;

use super::lanes::{LANES, Lanes, Sym, at, factor, load, store, vectors};
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

/// Leading eigenvectors in which the largest eigenvalue is bounded.
const LEADING: usize = 6;
const POWER_STEPS: usize = 4;
/// Relative width at which an interval of eigenvalues counts as a number.
const NARROW: f64 = 1e-13;
/// How far above its lower bound the largest eigenvalue is first sought.
const FIRST_WIDTH: f64 = 0.1;
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

/// The lanes of a vector.
#[inline(always)]
fn spread<S: Simd>(value: S::f64s) -> Lanes {
    let mut out = [0.0; LANES];
    store::<S>(&mut out, 0, value);
    out
}

/// One vector of candidates, each lane on its own.
struct Lane<'a, S: Simd> {
    simd: S,
    p: Sym<S::f64s>,
    y: &'a [S::f64s],
    /// Eigenvalues of `M`, descending.
    lambda: &'a [f64],
    sign: f64,
}

impl<S: Simd> Lane<'_, S> {
    /// Number of eigenvalues of `M ± JᵀJ` below `b`.
    #[inline(always)]
    fn below(&self, b: S::f64s) -> S::f64s {
        let simd = self.simd;
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let sign = simd.splat_f64s(self.sign);
        let tiny = simd.splat_f64s(f64::MIN_POSITIVE);
        let mut m = self.p;
        let mut count = zero;
        for (lambda, y) in self.lambda.iter().zip(self.y.as_chunks::<6>().0) {
            let distance = simd.sub_f64s(simd.splat_f64s(*lambda), b);
            let negative = simd.less_than_f64s(distance, zero);
            count = simd.add_f64s(count, simd.select_f64s(negative, one, zero));
            let distance = simd.select_f64s(simd.equal_f64s(distance, zero), tiny, distance);
            let weight = simd.div_f64s(sign, distance);
            for i in 0..6 {
                let scaled = simd.mul_f64s(weight, y[i]);
                for j in 0..=i {
                    m[at(i, j)] = simd.mul_add_e_f64s(scaled, y[j], m[at(i, j)]);
                }
            }
        }
        factor(simd, &mut m);
        // Adding: #(λ < b) - #neg; removing: #(λ < b) + #neg.
        let part = simd.splat_f64s(-self.sign);
        for k in 0..6 {
            let negative = simd.less_than_f64s(m[at(k, k)], zero);
            count = simd.add_f64s(count, simd.select_f64s(negative, part, zero));
        }
        count
    }

    /// The point of `[low, high]` where the count passes `wanted - ½`, bisected in the logarithm.
    #[inline(always)]
    fn bisect(&self, mut low: S::f64s, mut high: S::f64s, wanted: f64) -> S::f64s {
        let simd = self.simd;
        let wanted = simd.splat_f64s(wanted - 0.5);
        let widest = spread::<S>(simd.div_f64s(high, low)).into_iter().fold(1.0, f64::max).ln();
        let halvings = (widest / NARROW).log2().ceil().max(0.0) as usize;
        for _ in 0..halvings {
            let middle = simd.sqrt_f64s(simd.mul_f64s(low, high));
            let beyond = simd.less_than_f64s(wanted, self.below(middle));
            high = simd.select_f64s(beyond, middle, high);
            low = simd.select_f64s(beyond, low, middle);
        }
        simd.sqrt_f64s(simd.mul_f64s(low, high))
    }

    /// Smallest eigenvalue of `M ± JᵀJ`.
    #[inline(always)]
    fn smallest(&self) -> S::f64s {
        // Adding six rows moves no eigenvalue past the sixth above it; removing leaves it below the old one.
        let n = self.lambda.len();
        let floor = self.lambda[0] * 1e-36;
        let last = self.lambda[n - 1].max(floor);
        let (low, high) =
            if self.sign > 0.0 { (last, self.lambda[n.saturating_sub(7)].max(last)) } else { (floor, last) };
        let (low, high) = (self.simd.splat_f64s(low * (1.0 - 1e-12)), self.simd.splat_f64s(high * (1.0 + 1e-12)));
        self.bisect(low, high, 1.0)
    }

    /// A number above the largest eigenvalue, which is at least `bound`.
    #[inline(always)]
    fn largest_at_most(&self, bound: S::f64s) -> S::f64s {
        let simd = self.simd;
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let mut step = simd.mul_f64s(bound, simd.splat_f64s(FIRST_WIDTH));
        let mut high = simd.add_f64s(bound, step);
        for _ in 0..60 {
            let outside = simd.select_f64s(self.all_below(high), zero, one);
            if spread::<S>(outside).iter().all(|v| *v == 0.0) {
                break;
            }
            high = simd.mul_add_e_f64s(outside, step, high);
            step = simd.add_f64s(step, step);
        }
        high
    }

    /// Whether all eigenvalues lie below `b`.
    #[inline(always)]
    fn all_below(&self, b: S::f64s) -> S::m64s {
        let all = self.simd.splat_f64s(self.lambda.len() as f64 - 0.5);
        self.simd.less_than_f64s(all, self.below(b))
    }

    /// Half of an interval around the largest eigenvalue.
    #[inline(always)]
    fn narrower(&self, low: S::f64s, high: S::f64s) -> (S::f64s, S::f64s) {
        let simd = self.simd;
        let middle = simd.mul_f64s(simd.splat_f64s(0.5), simd.add_f64s(low, high));
        let inside = self.all_below(middle);
        (simd.select_f64s(inside, low, middle), simd.select_f64s(inside, middle, high))
    }

    /// Largest eigenvalue, which lies in an interval.
    #[inline(always)]
    fn between(&self, low: S::f64s, high: S::f64s) -> S::f64s {
        let below = self.simd.splat_f64s(1.0 - 1e-12);
        self.bisect(self.simd.mul_f64s(low, below), high, self.lambda.len() as f64)
    }

    /// A lower bound of the largest eigenvalue: the Rayleigh quotient after power steps in the span of the leading
    /// eigenvectors.
    #[inline(always)]
    fn largest_at_least(&self) -> S::f64s {
        let simd = self.simd;
        let leading = LEADING.min(self.lambda.len());
        let zero = simd.splat_f64s(0.0);
        let sign = simd.splat_f64s(self.sign);
        let mut p = self.p;
        factor(simd, &mut p);
        let (y, _) = self.y.as_chunks::<6>();
        // z = P^-½ y: forward substitution with L, then the roots of the pivots.
        let mut z = [[zero; 6]; LEADING];
        for (z, y) in z.iter_mut().zip(y).take(leading) {
            for i in 0..6 {
                let mut v = y[i];
                for j in 0..i {
                    v = simd.negate_mul_add_e_f64s(p[at(i, j)], z[j], v);
                }
                z[i] = v;
            }
            for i in 0..6 {
                z[i] = simd.div_f64s(z[i], simd.sqrt_f64s(p[at(i, i)]));
            }
        }
        let mut x = [simd.splat_f64s(1.0); LEADING];
        let mut quotient = zero;
        for _ in 0..POWER_STEPS {
            let mut w = [zero; 6];
            for k in 0..leading {
                for i in 0..6 {
                    w[i] = simd.mul_add_e_f64s(z[k][i], x[k], w[i]);
                }
            }
            let (mut above, mut square) = (zero, zero);
            let mut next = [zero; LEADING];
            for k in 0..leading {
                let mut v = zero;
                for i in 0..6 {
                    v = simd.mul_add_e_f64s(z[k][i], w[i], v);
                }
                let v = simd.mul_add_e_f64s(sign, v, simd.mul_f64s(simd.splat_f64s(self.lambda[k]), x[k]));
                above = simd.mul_add_e_f64s(x[k], v, above);
                square = simd.mul_add_e_f64s(x[k], x[k], square);
                next[k] = v;
            }
            quotient = simd.max_f64s(quotient, simd.div_f64s(above, square));
            let scale = simd.div_f64s(simd.splat_f64s(1.0), simd.sqrt_f64s(square));
            for (x, next) in x.iter_mut().zip(next) {
                *x = simd.mul_f64s(next, scale);
            }
        }
        quotient
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
