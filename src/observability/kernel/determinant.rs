//! `det(I ± J A Jᵀ)`.

use nalgebra::DMatrix;
use pulp::Simd;

use super::lanes::{Lanes, add_half, determinant_of, load, store, vectors};
use super::{Layout, Scan, run};

struct Determinant {
    packed: Vec<f64>,
    sign: f64,
}

impl<L: Layout> Scan<L> for Determinant {
    type Memory<S: Simd> = ();

    fn start<S: Simd>(&self, _: S, _: &L) {}

    #[inline(always)]
    fn batch<S: Simd>(&self, simd: S, layout: &L, batch: &[Lanes], open: &Lanes, out: &mut Lanes, _: &mut ()) {
        let sign = simd.splat_f64s(self.sign);
        for pair in 0..vectors::<S>() / 2 {
            let s = layout.quadratic(simd, batch, 2 * pair, &self.packed);
            for half in 0..2 {
                let vector = 2 * pair + half;
                let mut sum = layout.noise(simd, batch, vector);
                add_half(simd, &mut sum, sign, &s, half);
                // Layouts keep det P = 1.
                store::<S>(out, vector, simd.mul_f64s(determinant_of(simd, sum), load::<S>(open, vector)));
            }
        }
    }
}

/// `det(I ± J A Jᵀ)` of every candidate, 0 where `open` is.
pub(in super::super) fn determinant<L: Layout>(
    layout: &L,
    a: &DMatrix<f64>,
    sign: f64,
    open: &[Lanes],
    out: &mut [Lanes],
) {
    run(layout, &Determinant { packed: layout.pack(a), sign }, open, out);
}
