//! How precise a reading is.

/// 1σ of what is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Of one coordinate of a position, m.
    pub position: f64,
    /// Of one angle, rad.
    pub rotation: f64,
    /// Of one joint reading, in its unit; 0 if commands are exact.
    pub joint: f64,
    /// False if only the ratio is meant and the size is estimated from the residuals.
    pub known: bool,
}

impl Noise {
    /// Noise of unknown size: position and rotation as they would be for a measurement whose points are as far
    /// apart as those of the platform, 1 : 1/(mean radius).
    pub fn unknown(characteristic_length: f64) -> Self {
        Self { position: 1e-6, rotation: 1e-6 / characteristic_length, joint: 0.0, known: false }
    }

    /// Stated noise.
    pub fn stated(position: f64, rotation: f64) -> Self {
        Self { position, rotation, joint: 0.0, known: true }
    }
}
