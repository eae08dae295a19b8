//! The rigid motion that best carries one set of points onto another.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::Pose;

/// The motion `T` that minimises `Σₖ |T fromₖ - toₖ|²` (Kabsch 1976, by SVD, reflections excluded).
///
/// `None` for fewer than three points, for points on one line (the turn about it is then free), or for numbers
/// that are not finite.
pub fn fit_rigid_motion(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> Option<Pose> {
    let n = from.len();
    if n < 3 || to.len() != n {
        return None;
    }
    let centre = |p: &[Vector3<f64>]| p.iter().sum::<Vector3<f64>>() / n as f64;
    let (from_centre, to_centre) = (centre(from), centre(to));
    let mut spread = Matrix3::zeros();
    for (p, q) in from.iter().zip(to) {
        spread += (q - to_centre) * (p - from_centre).transpose();
    }
    let rotation = kabsch(&spread)?;
    Some(Pose { position: to_centre - rotation * from_centre, rotation })
}

/// The rotation that maximises `tr(Rᵀ S)`; `None` where `S` has rank below two.
pub fn kabsch(spread: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    if spread.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let svd = spread.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut sigma: Vec<f64> = svd.singular_values.iter().copied().collect();
    sigma.sort_by(f64::total_cmp);
    if !(sigma[1] > 1e-9 * sigma[2]) {
        return None;
    }
    // A reflection is turned into a rotation along the direction that matters least.
    let sign = (u * v_t).determinant().signum();
    let least = svd.singular_values.imin();
    let mut flip = Matrix3::identity();
    flip[(least, least)] = sign;
    Some(Rotation3::from_matrix_unchecked(u * flip * v_t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_is_recovered_from_points_in_a_plane() {
        let truth = Pose::from_coordinates(&[5.0, -3.0, 2.0, 2.0, -1.0, 0.7]);
        let from = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.2], [0.3, -0.9]].map(|[x, y]| Vector3::new(x, y, 0.0));
        let to = from.map(|p| truth.place(&p));
        let found = fit_rigid_motion(&from, &to).unwrap();
        assert!(truth.motion_to(&found).amax() < 1e-14);
    }

    #[test]
    fn points_on_a_line_fix_no_motion() {
        let line = [1.0, 2.0, 3.0].map(|x| Vector3::new(x, 0.0, 0.0));
        assert!(fit_rigid_motion(&line, &line).is_none());
        assert!(fit_rigid_motion(&line[..2], &line[..2]).is_none());
    }
}
