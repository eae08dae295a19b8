//! How much `tr(G M⁻¹)` changes, and derivatives `tr(Φ JᵀJ)`.

use nalgebra::DMatrix;
use pulp::Simd;

use super::lanes::{Lanes, add_half, factor, half_of, load, store, trace_of_quotient, vectors};
use super::{Layout, Scan, run};

/// `tr[(P ± S(A))⁻¹ S(B)]`, or `tr[P⁻¹ S(B)]` without `A`.
struct Trace {
    /// `A` and its sign.
    a: Option<(Vec<f64>, f64)>,
    b: Vec<f64>,
}

impl<L: Layout> Scan<L> for Trace {
    type Memory<S: Simd> = ();

    fn start<S: Simd>(&self, _: S, _: &L) {}

    #[inline(always)]
    fn batch<S: Simd>(&self, simd: S, layout: &L, batch: &[Lanes], open: &Lanes, out: &mut Lanes, _: &mut ()) {
        for pair in 0..vectors::<S>() / 2 {
            let t = layout.quadratic(simd, batch, 2 * pair, &self.b);
            let mut c = [layout.noise(simd, batch, 2 * pair), layout.noise(simd, batch, 2 * pair + 1)];
            if let Some((a, sign)) = &self.a {
                let s = layout.quadratic(simd, batch, 2 * pair, a);
                add_half(simd, &mut c[0], simd.splat_f64s(*sign), &s, 0);
                add_half(simd, &mut c[1], simd.splat_f64s(*sign), &s, 1);
            }
            for (half, c) in c.iter_mut().enumerate() {
                let vector = 2 * pair + half;
                factor(simd, c);
                let value = trace_of_quotient(simd, c, &half_of(simd, &t, half));
                store::<S>(out, vector, simd.mul_f64s(value, load::<S>(open, vector)));
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
    run(layout, &Trace { a: Some((layout.pack(inverse), sign)), b: layout.pack(middle) }, open, out);
}

/// `tr(Φ JᵀJ)` of every candidate, 0 where `open` is.
pub(in super::super) fn gradient<L: Layout>(layout: &L, phi: &DMatrix<f64>, open: &[Lanes], out: &mut [Lanes]) {
    run(layout, &Trace { a: None, b: layout.pack(phi) }, open, out);
}
