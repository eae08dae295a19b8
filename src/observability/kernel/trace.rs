//! How much `tr(G M⁻¹)` changes.

use nalgebra::DMatrix;
use pulp::Simd;

use super::lanes::{Lanes, factor, half_of, load, store, trace_of_quotient, vectors};
use super::{Layout, Scan, run};

struct Trace {
    inverse: Vec<f64>,
    middle: Vec<f64>,
    sign: f64,
}

impl<L: Layout> Scan<L> for Trace {
    type Memory<S: Simd> = ();

    fn start<S: Simd>(&self, _: S, _: &L) {}

    #[inline(always)]
    fn batch<S: Simd>(&self, simd: S, layout: &L, batch: &[Lanes], open: &Lanes, out: &mut Lanes, _: &mut ()) {
        let sign = simd.splat_f64s(self.sign);
        for pair in 0..vectors::<S>() / 2 {
            let s = layout.quadratic(simd, batch, 2 * pair, &self.inverse);
            let t = layout.quadratic(simd, batch, 2 * pair, &self.middle);
            for half in 0..2 {
                let vector = 2 * pair + half;
                let mut c = layout.noise(simd, batch, vector);
                for (c, s) in c.iter_mut().zip(&s) {
                    *c = simd.mul_add_e_f64s(sign, s[half], *c);
                }
                factor(simd, &mut c);
                let change = trace_of_quotient(simd, &c, &half_of(simd, &t, half));
                store::<S>(out, vector, simd.mul_f64s(change, load::<S>(open, vector)));
            }
        }
    }
}

/// By how much `tr(G M⁻¹)` falls when a candidate is added (`sign = 1`), or rises when it is removed (`sign = -1`),
/// for `inverse` = `M⁻¹` and `middle` = `M⁻¹ G M⁻¹`; 0 where `open` is.
pub(in super::super) fn trace<L: Layout>(
    layout: &L,
    inverse: &DMatrix<f64>,
    middle: &DMatrix<f64>,
    sign: f64,
    open: &[Lanes],
    out: &mut [Lanes],
) {
    run(layout, &Trace { inverse: layout.pack(inverse), middle: layout.pack(middle), sign }, open, out);
}
