//! From measured data to parameters, their covariance, and how far to trust them.
//!
//! The error model of one sample is `dq = J_b dC` (eq. 23); stacked over the samples (eq. 27) and whitened it
//! is a least-squares problem in the `L` parameters of the mechanism and the own parameters of the
//! measurement. It is iterated, because the model is linear only for small errors; the residual of each
//! iteration comes from full forward kinematics.
//!
//! | identifier | rows weighted by | use |
//! |---|---|---|
//! | [`LevenbergMarquardt`] | noise; tolerance as prior where the data do not determine the parameters | the default |
//! | [`LeastSquares`] | noise, or mm and rad as they are | the paper's iteration (section 4.1), for reproduction |
//! | [`Robust`] | noise, and less for samples that do not fit | data with gross errors |
//!
//! [`Identifier`] is the trait; [`calibrate`] is the whole job around it:
//!
//! 1. [`register`]: real data are in the tracker's frame; find the frames from any orientation,
//! 2. choose the prior ([`PriorPolicy`]),
//! 3. identify, and transform the result back into the tracker's frame,
//! 4. judge: rank and [`weak_directions`], plausibility after the rigid motions are taken out
//!    ([`plausibility`]), misfit ([`GoodnessOfFit`]), errors on rows that were not fitted ([`HeldOut`]), predicted
//!    errors over the workspace.
//!
//! Eighteen of the 42 directions are pure convention: six for the place of the tracker, six for that of the target, six
//! leg offsets. They are identified like any other, reported, and not judged.

mod calibrate;
mod calibration;
mod carried;
mod error;
mod estimators;
mod judgement;
mod problem;
mod registration;
mod task;

pub use calibrate::calibrate;
pub use calibration::{Calibration, CalibrationOptions};
pub use carried::carried_workspace;
pub use error::IdentifyError;
pub use estimators::fit::Fit;
pub use estimators::identification::{Estimate, Identification};
pub use estimators::identifiers::{Identifier, LeastSquares, LevenbergMarquardt};
pub use estimators::registry::{IDENTIFIERS, identifier};
pub use estimators::robust::{Loss, Robust};
pub use judgement::deviations::{Deviation, deviations};
pub use judgement::drawing::DrawingTest;
pub use judgement::goodness_of_fit::GoodnessOfFit;
pub use judgement::held_out::{HeldOut, Holdout};
pub use judgement::model_errors::{ErrorSummary, ModelErrors, SampleError, evaluate};
pub use judgement::plausibility::{Implausible, Plausibility, plausibility};
pub use judgement::prediction::{pose_covariance, predicted_errors};
pub use judgement::verdict::CalibrationVerdict;
pub use judgement::weak_directions::{WeakDirection, weak_directions};
pub use problem::belief::{Belief, Conventions, GROUPS};
pub use problem::calibration_problem::CalibrationProblem;
pub(crate) use problem::closure_fit::{ClosureFit, ClosureRow, Look};
pub use problem::prior::{Prior, PriorPolicy};
pub use problem::spectrum::DataSpectrum;
#[cfg(feature = "cli")]
pub(crate) use problem::start::poses_from_home;
pub use registration::{Registration, register};
pub(crate) use registration::{SeenPose, frames_between};
pub use task::{Task, Weights};
