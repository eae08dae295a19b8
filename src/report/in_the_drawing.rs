//! Deviations of the parameters from the file that are those of the machine, and not of the place of tracker and target.

use nalgebra::{DMatrix, DVector};

use crate::identification::{Calibration, Estimate};
use crate::mechanism::{Body, rigid_directions};
use crate::solve::minimum_norms;

/// The parameters in the frame of the mechanism file, then those of the measurement. Where the frames of the data were
/// found, the rigid motions of base and platform that are left are taken out of the points: they are a matter of where
/// frames lie.
pub(in crate::report) fn in_the_drawing(c: &Calibration) -> Vec<Estimate> {
    let found = &c.identification;
    let n = found.mechanism_parameters;
    let mut all = found.parameters.clone();
    if !c.registration.applied {
        return all;
    }
    let Some(rigid) = rigid_motions(c, &all[..n]) else { return all };
    let keep = DMatrix::identity(n, n) - &rigid * minimum_norms(&rigid, &DMatrix::identity(n, n));
    let deviation = &keep * DVector::from_iterator(n, all[..n].iter().map(|p| p.value - p.start));
    let covariance = &keep * found.mechanism_covariance() * keep.transpose();
    for (k, p) in all[..n].iter_mut().enumerate() {
        p.value = p.start + deviation[k];
        p.sigma = p.sigma.map(|_| covariance[(k, k)].max(0.0).sqrt());
    }
    all
}

/// Columns of small rigid motions of the points of each body, as the drawing has them.
fn rigid_motions(c: &Calibration, parameters: &[Estimate]) -> Option<DMatrix<f64>> {
    let start: Vec<f64> = parameters.iter().map(|p| p.start).collect();
    let drawn = c.mechanism.with_values(&start, c.mechanism.home()).ok()?;
    let scale = vec![1.0; start.len()];
    let of_body = |body| rigid_directions(drawn.as_ref(), body, &scale);
    Some(DMatrix::from_columns(&[Body::Base, Body::Platform].map(of_body).concat()))
}
