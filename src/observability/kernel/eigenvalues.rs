//! Eigenvalues of `M ± JᵀJ`, one candidate in each lane, by bisection on the inertia.
//!
//! With `M = Q diag(λ) Qᵀ` and `Y = U Q` the number of eigenvalues below `b` is that of the `λᵢ` below `b`, less (adding)
//! or plus (removing) the number of negative pivots of `P ± Σ yᵢ yᵢᵀ/(λᵢ - b)`.

use pulp::Simd;

use super::lanes::{LANES, Lanes, Sym, add_outer, at, factor, store};

/// Leading eigenvectors in which the largest eigenvalue is bounded.
const LEADING: usize = 6;
const POWER_STEPS: usize = 4;
/// Relative width at which an interval of eigenvalues counts as a number.
const NARROW: f64 = 1e-13;
/// How far above its lower bound the largest eigenvalue is first sought.
const FIRST_WIDTH: f64 = 0.1;

/// The lanes of a vector.
#[inline(always)]
pub(super) fn spread<S: Simd>(value: S::f64s) -> Lanes {
    let mut out = [0.0; LANES];
    store::<S>(&mut out, 0, value);
    out
}

/// One vector of candidates, each lane on its own.
pub(super) struct Lane<'a, S: Simd> {
    pub(super) simd: S,
    pub(super) p: Sym<S::f64s>,
    pub(super) y: &'a [S::f64s],
    /// Eigenvalues of `M`, descending.
    pub(super) lambda: &'a [f64],
    pub(super) sign: f64,
}

impl<S: Simd> Lane<'_, S> {
    /// Number of eigenvalues of `M ± JᵀJ` below `b`.
    #[inline(always)]
    pub(super) fn below(&self, b: S::f64s) -> S::f64s {
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
            add_outer(simd, &mut m, weight, y);
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
    pub(super) fn smallest(&self) -> S::f64s {
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
    pub(super) fn largest_at_most(&self, bound: S::f64s) -> S::f64s {
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
    pub(super) fn narrower(&self, low: S::f64s, high: S::f64s) -> (S::f64s, S::f64s) {
        let simd = self.simd;
        let middle = simd.mul_f64s(simd.splat_f64s(0.5), simd.add_f64s(low, high));
        let inside = self.all_below(middle);
        (simd.select_f64s(inside, low, middle), simd.select_f64s(inside, middle, high))
    }

    /// Largest eigenvalue, which lies in an interval.
    #[inline(always)]
    pub(super) fn between(&self, low: S::f64s, high: S::f64s) -> S::f64s {
        let below = self.simd.splat_f64s(1.0 - 1e-12);
        self.bisect(self.simd.mul_f64s(low, below), high, self.lambda.len() as f64)
    }

    /// A lower bound of the largest eigenvalue: the Rayleigh quotient after power steps in the span of the leading
    /// eigenvectors.
    #[inline(always)]
    pub(super) fn largest_at_least(&self) -> S::f64s {
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
