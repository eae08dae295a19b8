//! Numbers side by side, and symmetric 6 × 6 matrices of them.

use pulp::Simd;

pub(in super::super) use crate::solve::{LANES, Lanes};
pub(super) use crate::solve::{load, store, vectors};

/// Lower triangle of a symmetric 6 × 6 matrix: entry (i, j), `j ≤ i`, at [`at`]`(i, j)`.
pub(super) type Sym<V> = [V; 21];

/// Two vectors of lanes: each number that both are multiplied by is loaded once.
pub(super) type Two<S> = [<S as Simd>::f64s; 2];

/// Place of entry (i, j), `j ≤ i`, in a [`Sym`].
pub(super) const fn at(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

#[inline(always)]
pub(super) fn load_two<S: Simd>(row: &Lanes, vector: usize) -> Two<S> {
    let all = S::as_simd_f64s(row).0;
    [all[vector], all[vector + 1]]
}

/// One of the two vectors of every entry. Not `map`: a closure is compiled for the least machine and called.
#[inline(always)]
pub(super) fn half_of<S: Simd>(simd: S, both: &Sym<Two<S>>, half: usize) -> Sym<S::f64s> {
    let mut out = [simd.splat_f64s(0.0); 21];
    for (out, both) in out.iter_mut().zip(both) {
        *out = both[half];
    }
    out
}

/// Adds `factor` times one of the two vectors of every entry.
#[inline(always)]
pub(super) fn add_half<S: Simd>(simd: S, m: &mut Sym<S::f64s>, factor: S::f64s, both: &Sym<Two<S>>, half: usize) {
    for (m, both) in m.iter_mut().zip(both) {
        *m = simd.mul_add_e_f64s(factor, both[half], *m);
    }
}

/// Adds `weight y yᵀ`.
#[inline(always)]
pub(super) fn add_outer<S: Simd>(simd: S, m: &mut Sym<S::f64s>, weight: S::f64s, y: &[S::f64s; 6]) {
    for i in 0..6 {
        let scaled = simd.mul_f64s(weight, y[i]);
        for j in 0..=i {
            m[at(i, j)] = simd.mul_add_e_f64s(scaled, y[j], m[at(i, j)]);
        }
    }
}

/// Eliminates column `k` below its pivot; returns the inverse of the pivot.
#[inline(always)]
fn eliminate<S: Simd>(simd: S, m: &mut Sym<S::f64s>, k: usize) -> S::f64s {
    let inverse = simd.div_f64s(simd.splat_f64s(1.0), m[at(k, k)]);
    for i in k + 1..6 {
        let f = simd.mul_f64s(m[at(i, k)], inverse);
        for j in k + 1..=i {
            m[at(i, j)] = simd.negate_mul_add_e_f64s(f, m[at(j, k)], m[at(i, j)]);
        }
    }
    inverse
}

/// Replaces a matrix by its factors `L D Lᵀ` (unit lower triangle and pivots in one place). Without pivoting, so
/// that lanes stay together; the signs of the pivots are the inertia.
#[inline(always)]
pub(super) fn factor<S: Simd>(simd: S, m: &mut Sym<S::f64s>) {
    for k in 0..6 {
        let inverse = eliminate(simd, m, k);
        for i in k + 1..6 {
            m[at(i, k)] = simd.mul_f64s(m[at(i, k)], inverse);
        }
    }
}

/// Determinant of a matrix; the matrix is used up.
#[inline(always)]
pub(super) fn determinant_of<S: Simd>(simd: S, mut m: Sym<S::f64s>) -> S::f64s {
    let mut product = m[0];
    for k in 0..5 {
        eliminate(simd, &mut m, k);
        product = simd.mul_f64s(product, m[at(k + 1, k + 1)]);
    }
    product
}

/// `tr(C⁻¹ T)` for a factored `C`.
#[inline(always)]
pub(super) fn trace_of_quotient<S: Simd>(simd: S, c: &Sym<S::f64s>, t: &Sym<S::f64s>) -> S::f64s {
    // With the columns of L⁻¹ as wₖ it is Σ wₖ' T wₖ / dₖ, and row k of L⁻¹ ends at its diagonal.
    let zero = simd.splat_f64s(0.0);
    let one = simd.splat_f64s(1.0);
    let mut inverse = [zero; 21];
    for i in 0..6 {
        inverse[at(i, i)] = one;
        for j in (0..i).rev() {
            let mut sum = c[at(i, j)];
            for k in j + 1..i {
                sum = simd.mul_add_e_f64s(c[at(i, k)], inverse[at(k, j)], sum);
            }
            inverse[at(i, j)] = simd.neg_f64s(sum);
        }
    }
    let mut trace = zero;
    for k in 0..6 {
        let mut sum = zero;
        for i in 0..=k {
            let mut row = simd.mul_f64s(t[at(i, i)], inverse[at(k, i)]);
            for j in 0..i {
                let twice = simd.add_f64s(inverse[at(k, j)], inverse[at(k, j)]);
                row = simd.mul_add_e_f64s(t[at(i, j)], twice, row);
            }
            sum = simd.mul_add_e_f64s(row, inverse[at(k, i)], sum);
        }
        trace = simd.add_f64s(trace, simd.div_f64s(sum, c[at(k, k)]));
    }
    trace
}
