//! The pinhole camera.

use super::View;

/// The scalar product.
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a + s (b − a)`.
pub(super) fn between(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + s * (b[i] - a[i]))
}

/// The distance of two points.
pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|i| a[i] - b[i]);
    dot(d, d).sqrt()
}

/// A camera that aims at the origin of a scene of radius one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    /// Unit vectors in the picture and, from the scene, to the camera.
    right: [f64; 3],
    up: [f64; 3],
    toward: [f64; 3],
    distance: f64,
}

impl Camera {
    pub(super) fn new(view: &View) -> Self {
        let usual = View::default();
        let or = |v: f64, usual: f64| if v.is_finite() { v } else { usual };
        let (sa, ca) = or(view.azimuth, usual.azimuth).sin_cos();
        let quarter = std::f64::consts::FRAC_PI_2;
        let (se, ce) = or(view.elevation, usual.elevation).clamp(-quarter, quarter).sin_cos();
        Self {
            right: [-sa, ca, 0.0],
            up: [-se * ca, -se * sa, ce],
            toward: [ce * ca, ce * sa, se],
            // Nearer than 1.5 radii the foreground is distorted too much to be recognised.
            distance: or(view.distance, usual.distance).clamp(1.5, 1e4),
        }
    }

    /// Where the camera is.
    pub(super) fn eye(&self) -> [f64; 3] {
        self.toward.map(|v| v * self.distance)
    }

    /// Place in the picture (x to the right, y downwards; lengths at the origin keep their size) and the depth, the
    /// distance from the camera along its axis.
    pub(super) fn project(&self, p: [f64; 3]) -> ([f64; 2], f64) {
        let depth = self.distance - dot(self.toward, p);
        let scale = self.distance / depth;
        ([dot(self.right, p) * scale, -dot(self.up, p) * scale], depth)
    }

    /// How much larger things at a depth appear than at the origin.
    pub(super) fn magnification(&self, depth: f64) -> f64 {
        self.distance / depth
    }
}
