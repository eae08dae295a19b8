//! Passive coordinates: solved for, then eliminated.

use nalgebra::{DMatrix, DVector};

use super::evaluation::{Derivatives, Place, Wanted, derivatives};
use super::pattern::Pattern;
use super::{Closure, Outline};

const ITERATIONS: usize = 50;
const SMALL_STEP: f64 = 1e-10;

/// The passive coordinates that close the loops best at a place, by Gauss–Newton from those of the outline; `None` if
/// the iteration does not settle.
pub(super) fn solved<C: Closure>(
    closure: &C,
    outline: &Outline,
    pattern: &Pattern,
    place: &Place<'_>,
) -> Option<Vec<f64>> {
    let mut z = outline.passive.clone();
    for _ in 0..ITERATIONS {
        let here = Place { passive: &z, ..*place };
        let d = derivatives(closure, pattern, &[], outline.equations, &here, Wanted::Passive);
        if d.passive.iter().chain(d.residual.iter()).any(|v| !v.is_finite()) {
            return None;
        }
        let step = d.passive.svd(true, true).solve(&-d.residual, 1e-12).ok()?;
        z.iter_mut().zip(step.iter()).for_each(|(value, d)| *value += d);
        // The error after a Newton step is about its square.
        if step.amax() <= SMALL_STEP * z.iter().fold(1.0, |most: f64, v| most.max(v.abs())) {
            return Some(z);
        }
    }
    None
}

/// The rows that do not depend on the passive coordinates: the part of `g` and its derivatives orthogonal to the
/// columns of `∂g/∂z`.
///
/// The basis of that part turns from place to place. The sign of its first row is chosen so that the determinant of `J₁`
/// has that of `[∂g/∂q ∂g/∂z]`, up to a constant sign: it changes at singularities only.
pub(super) fn eliminated(mut d: Derivatives) -> Derivatives {
    let (m, p) = d.passive.shape();
    if p == 0 {
        return d;
    }
    let qr = std::mem::replace(&mut d.passive, DMatrix::zeros(m - p, 0)).qr();
    let sign: f64 = qr.r().diagonal().iter().map(|v| v.signum()).product();
    let rest = |matrix: &DMatrix<f64>| {
        let mut rotated = matrix.clone();
        qr.q_tr_mul(&mut rotated);
        let mut rest = rotated.rows(p, m - p).into_owned();
        rest.row_mut(0).scale_mut(sign);
        rest
    };
    let residual = rest(&DMatrix::from_column_slice(m, 1, d.residual.as_slice()));
    d.residual = DVector::from_column_slice(residual.as_slice());
    d.motion = rest(&d.motion);
    let reduced = rest(&d.columns);
    d.unreduced = Some(std::mem::replace(&mut d.columns, reduced));
    d
}
