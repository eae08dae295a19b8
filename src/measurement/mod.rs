//! Measurements: samples, their noise, and how a reading depends on the pose.
//!
//! A [`Dataset`] is a list of [`Sample`]s (joints and operating state) and one [`MeasurementModel`] that
//! knows the readings. A reading contributes `k` rows: six for a full pose, fewer where coordinates were not
//! measured, `3N` for `N` target points. For each sample the model states
//!
//! * the residual `r = ŷ(q) - y`, predicted minus measured,
//! * its derivative along a small motion of the platform, `H = ∂r/∂(δt, δω)` (k × 6), so that the
//!   identification block is `H J_b` (k × L),
//! * its derivative along the model's own parameters (k × p), such as target points whose place on the
//!   platform is not known,
//! * the covariance of the reading (k × k).
//!
//! | model | reading | own parameters |
//! |---|---|---|
//! | [`PoseMeasurement`] | six coordinates of the pose, or some of them | – |
//! | [`TargetMeasurement`] | positions of points on the platform | the points that are not known |
//! | [`PlaneContact`] | heights of a point of the platform over a plane, 0 at a touch | the plane, if it is not known |
//!
//! Another kind of reading is another implementation; `conformance::measurement` checks it (feature
//! `conformance`).
//!
//! **Frames.** A tracker reports in its own frame, and a target has a frame of its own: a full pose is
//! measured as `B T(q) A` with `B` the base in the tracker's frame and `A` the target on the platform
//! ([`Frames`]). Both are identities until a registration finds them
//! ([`crate::identification::register`]).

mod dataset;
mod frames;
mod noise;
mod plane_contact;
mod pose_measurement;
mod row;
mod targets;
mod unknown_frames;

use std::fmt::Debug;

use nalgebra::{DMatrix, DVector, Vector3};

pub use dataset::{Dataset, Sample};
pub use frames::Frames;
pub use noise::Noise;
pub use plane_contact::{Contact, ContactReading, Plane, PlaneContact};
pub use pose_measurement::{PoseMeasurement, PoseReading};
pub use row::{DataRow, SamplePosition};
pub use targets::{TargetMeasurement, TargetPoint};
pub(crate) use unknown_frames::{Free, UnknownFrames};

use crate::mechanism::ParameterSpec;
use crate::pose::Pose;

/// Kind of quantity that a row measures, so that position and rotation can be reported separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKind {
    /// A length, m.
    Position,
    /// An angle, rad.
    Rotation,
}

/// How readings depend on the pose of the platform.
///
/// Samples are counted in the order in which they were measured; a [`Dataset`] may hold a part of them.
pub trait MeasurementModel: Debug + Send + Sync {
    /// Short description of the measurement.
    fn describe(&self) -> String;

    /// Number of samples.
    fn samples(&self) -> usize;

    /// Kind of each row of a sample; its length is the number `k` of rows.
    fn rows(&self, sample: usize) -> Vec<RowKind>;

    /// The row of each quantity of a complete reading (six coordinates of a pose, three of each target), `None` for one that
    /// was not measured.
    fn row_of_each(&self, sample: usize) -> Vec<Option<usize>> {
        (0..self.rows(sample).len()).map(Some).collect()
    }

    /// Parameters of the measurement that are identified together with those of the mechanism.
    fn nuisance_parameters(&self) -> &[ParameterSpec] {
        &[]
    }

    /// Heading of the table of these parameters.
    fn nuisance_heading(&self) -> &'static str {
        "Identified measurement parameters"
    }

    /// Start values of the own parameters, from the poses that the mechanism predicts for the samples in use;
    /// `None` stands for a sample that is left out. Their nominal values if nothing better is known.
    fn start(&self, _poses: &[Option<Pose>], _frames: &Frames) -> Vec<f64> {
        self.nuisance_parameters().iter().map(|p| p.nominal).collect()
    }

    /// Residual and derivatives of the reading `index` at a pose of the platform; `sample` was measured by it.
    ///
    /// `out` has been sized for the rows of the sample and is zero; entries that are not zero are set.
    fn evaluate(&self, index: usize, sample: &Sample, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows);

    /// Covariance of the reading (k × k), SI.
    fn covariance(&self, sample: usize, frames: &Frames) -> DMatrix<f64>;

    /// The measured pose of a frame that is fixed to the platform, in the tracker's frame, if the reading
    /// determines one. Registration starts from it.
    fn rigid_pose(&self, sample: usize) -> Option<Pose>;

    /// The six coordinates of the measured pose as they stand in the file, m and rad, if all were measured.
    fn coordinates(&self, _sample: usize) -> Option<[f64; 6]> {
        None
    }

    /// Knowledge about the place of the target on the platform.
    fn target_frame(&self) -> TargetFrame {
        TargetFrame::Convention
    }

    /// Small motion `(δt, δω)` of the platform at a pose, in base axes, that does to a prediction of it what each own parameter
    /// does (6 × own), where these say where the target sits or the tracker stands; `None` if they do not.
    fn platform_motion(&self, _own: &[f64], _pose: &Pose, _frames: &Frames) -> Option<DMatrix<f64>> {
        None
    }

    /// The measured positions of the points at known places on the platform, where several were measured at once; none by
    /// default.
    fn points(&self, _sample: usize) -> Vec<PointReading> {
        Vec::new()
    }

    /// The measured position of one point that is fixed to the platform, in the tracker's frame.
    fn point(&self, sample: usize) -> Option<PointReading>;
}

/// Knowledge about the place of the target on the platform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetFrame {
    /// Nothing: it is a matter of convention ([`Frames::target`]), and the calibrated platform frame is the
    /// target's.
    Convention,
    /// The readings are tied to the platform frame by known points.
    Known,
    /// The points have unknown places, which are identified; they take the place of a target frame.
    Identified,
}

/// Numbers what was measured.
fn numbered(measured: impl IntoIterator<Item = bool>) -> Vec<Option<usize>> {
    let mut next = 0..;
    measured.into_iter().map(|measured| if measured { next.next() } else { None }).collect()
}

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointReading {
    /// Where it was seen, tracker's frame, m.
    pub position: Vector3<f64>,
    /// Its place in the target's frame, m.
    pub place: Vector3<f64>,
}

/// Residual and derivatives of one sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// `ŷ - y` (k), m and rad.
    pub residual: DVector<f64>,
    /// `∂ŷ/∂(δt, δω)` (k × 6).
    pub motion: DMatrix<f64>,
    /// `∂ŷ/∂` own parameters (k × p).
    pub own: DMatrix<f64>,
}

impl Rows {
    /// Zeros for `k` rows and `p` own parameters.
    pub fn sized(k: usize, p: usize) -> Self {
        Self { residual: DVector::zeros(k), motion: DMatrix::zeros(k, 6), own: DMatrix::zeros(k, p) }
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.residual.fill(0.0);
        self.motion.fill(0.0);
        self.own.fill(0.0);
    }
}
