//! The inverse `A = M⁻¹` after a pose of six legs has come or gone.
//!
//! `(M ± Uᵀ P⁻¹ U)⁻¹ = A ∓ V C⁻¹ Vᵀ` with `V = A Uᵀ` and `C = P ± U V` (Sherman, Morrison and Woodbury), where a column
//! of `V` takes seven columns of `A`: a sixth of the arithmetic of six full rows.

use nalgebra::{Cholesky, DMatrix, Matrix6};
use pulp::{Arch, Simd, WithSimd};

use super::legs::{PER_LEG, SLOTS};

/// A pose of six legs: the seven numbers of each, and `P` with determinant one.
pub(in super::super) struct LegBlock {
    pub(in super::super) u: [[f64; PER_LEG]; 6],
    pub(in super::super) p: Matrix6<f64>,
}

type Columns = [[f64; SLOTS]; 6];

/// A pivot of `C` is the difference of numbers as large as the diagonal of `P`; below this part of it too few digits
/// are left.
const CANCELLED: f64 = 1e-8;

/// Turns `M⁻¹` into `(M ± JᵀJ)⁻¹` and returns the logarithm of the ratio of the determinants of `M`. `None`, and nothing
/// done, if a pivot of `C` is not above `smallest_pivot` times that of `P`, or has cancelled: the result would be
/// inaccurate.
pub(in super::super) fn update_legs(
    inverse: &mut DMatrix<f64>,
    block: &LegBlock,
    sign: f64,
    smallest_pivot: f64,
) -> Option<f64> {
    if inverse.shape() != (SLOTS, SLOTS) {
        return None;
    }
    let arch = Arch::new();
    let across = arch.dispatch(Across { inverse: inverse.as_slice(), u: &block.u });
    let middle = Matrix6::from_fn(|i, j| {
        let (i, j) = (i.max(j), i.min(j));
        let along = &across[j][PER_LEG * i..PER_LEG * (i + 1)];
        block.p[(i, j)] + sign * block.u[i].iter().zip(along).map(|(u, v)| u * v).sum::<f64>()
    });
    let before = Cholesky::new(block.p)?.unpack();
    let after = Cholesky::new(middle)?.unpack();
    let accurate = |k: usize| {
        let pivot = after[(k, k)].powi(2);
        pivot > smallest_pivot * before[(k, k)].powi(2) && pivot > CANCELLED * block.p[(k, k)]
    };
    if !(0..6).all(accurate) {
        return None;
    }
    arch.dispatch(RankSix { inverse: inverse.as_mut_slice(), across, factor: &after, sign });
    Some(2.0 * (0..6).map(|k| after[(k, k)].ln()).sum::<f64>())
}

/// `V = A Uᵀ`.
struct Across<'a> {
    inverse: &'a [f64],
    u: &'a [[f64; PER_LEG]; 6],
}

impl WithSimd for Across<'_> {
    type Output = Columns;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Columns {
        let mut across = [[0.0; SLOTS]; 6];
        let (columns, _) = self.inverse.as_chunks::<SLOTS>();
        for ((across, u), columns) in across.iter_mut().zip(self.u).zip(columns.chunks_exact(PER_LEG)) {
            for (factor, column) in u.iter().zip(columns) {
                add_multiple(simd, across, *factor, column);
            }
        }
        across
    }
}

/// `a ← a + f b`.
#[inline(always)]
fn add_multiple<S: Simd>(simd: S, a: &mut [f64; SLOTS], f: f64, b: &[f64; SLOTS]) {
    let (a, a_rest) = S::as_mut_simd_f64s(a);
    let (b, b_rest) = S::as_simd_f64s(b);
    let factor = simd.splat_f64s(f);
    for (a, b) in a.iter_mut().zip(b) {
        *a = simd.mul_add_e_f64s(factor, *b, *a);
    }
    for (a, b) in a_rest.iter_mut().zip(b_rest) {
        *a += f * b;
    }
}

/// `A ∓ V C⁻¹ Vᵀ` for the factor `L` of `C = L Lᵀ`.
struct RankSix<'a> {
    inverse: &'a mut [f64],
    across: Columns,
    factor: &'a Matrix6<f64>,
    sign: f64,
}

impl WithSimd for RankSix<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut w = self.across;
        for i in 0..6 {
            let (before, rest) = w.split_at_mut(i);
            for (j, before) in before.iter().enumerate() {
                add_multiple(simd, &mut rest[0], -self.factor[(i, j)], before);
            }
            let pivot = 1.0 / self.factor[(i, i)];
            for value in &mut rest[0] {
                *value *= pivot;
            }
        }
        let (columns, _) = self.inverse.as_chunks_mut::<SLOTS>();
        for (c, column) in columns.iter_mut().enumerate() {
            let (column, rest) = S::as_mut_simd_f64s(column);
            for (v, value) in column.iter_mut().enumerate() {
                let mut sum = *value;
                for own in &w {
                    let own_vectors = S::as_simd_f64s(own).0;
                    sum = simd.mul_add_e_f64s(simd.splat_f64s(-self.sign * own[c]), own_vectors[v], sum);
                }
                *value = sum;
            }
            let first = SLOTS - rest.len();
            for (r, value) in rest.iter_mut().enumerate() {
                for own in &w {
                    *value -= self.sign * own[c] * own[first + r];
                }
            }
        }
    }
}
