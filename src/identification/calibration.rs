//! A calibrated mechanism, and what is asked of a calibration.

use nalgebra::DMatrix;

use crate::identification::estimators::identification::{Estimate, Identification};
use crate::identification::judgement::drawing::DrawingTest;
use crate::identification::judgement::held_out::{HeldOut, Holdout};
use crate::identification::judgement::model_errors::ErrorSummary;
use crate::identification::judgement::plausibility::Plausibility;
use crate::identification::judgement::verdict::CalibrationVerdict;
use crate::identification::judgement::weak_directions::WeakDirection;
use crate::identification::problem::prior::PriorPolicy;
use crate::identification::registration::Registration;
use crate::identification::task::Weights;
use crate::mechanism::{Mechanism, Workspace};
use crate::observability::PredictedError;
use crate::pose::PoseConvention;
use crate::units::show_length;

/// Options of a calibration.
#[derive(Clone, Debug)]
pub struct CalibrationOptions {
    /// Where priors come from.
    pub prior: PriorPolicy,
    /// How to weight the rows.
    pub weights: Weights,
    /// Which rows are held out to measure the errors.
    pub holdout: Holdout,
    /// Seed of the folds and of the poses at which errors are predicted.
    pub seed: u64,
    /// Whose pivot is meant by the position of a pose, where there is no workspace that says so.
    pub convention: PoseConvention,
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self {
            prior: PriorPolicy::Auto,
            weights: Weights::Noise,
            holdout: Holdout::Folds(5),
            seed: 0,
            convention: PoseConvention::default(),
        }
    }
}

/// Errors of a written file are those of the fit to this part, and to this length and angle, m and rad.
const AS_WRITTEN: (f64, f64) = (1e-6, 1e-9);

impl Calibration {
    /// Compares the errors that the fit left with those of the file that it is written to; where they differ, the file is not
    /// what was found, and the result is not to be trusted.
    pub fn compare_with_written(&mut self, written: Result<ErrorSummary, String>) {
        let same = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= AS_WRITTEN.0 * a + AS_WRITTEN.1,
            (a, b) => a.is_none() && b.is_none(),
        };
        let problem = match written {
            Ok(errors) if same(errors.position, self.after.position) && same(errors.rotation, self.after.rotation) => {
                return;
            }
            Ok(errors) => match errors.position {
                Some(position) => format!("its errors on these data are {}", show_length(position)),
                None => "its errors on these data are others".into(),
            },
            Err(cause) => cause,
        };
        if self.verdict.trusted {
            self.verdict.distrust(format!("the file does not say what was identified: {problem}"));
        }
    }
}

/// A calibrated mechanism and how far to trust it.
#[derive(Debug)]
#[non_exhaustive]
pub struct Calibration {
    /// What was measured, as the model of the readings describes it.
    pub measurement: String,
    /// Heading of the parameters of the measurement in tables.
    pub nuisance_heading: &'static str,
    /// Name of the identifier.
    pub identifier: String,
    /// The calibrated mechanism, in the frames of the measurement; it has the name of the one that was given.
    pub mechanism: Box<dyn Mechanism>,
    /// Its parameters, then those of the measurement, in the frames of the measurement; those of a mechanism that is
    /// mounted in them ([`Mechanism::mounted`]) in the frames of its drawing.
    pub parameters: Vec<Estimate>,
    /// Covariance of the mechanism's parameters, in the same frames.
    pub covariance: DMatrix<f64>,
    /// Result of the identifier, in the frames of the nominal mechanism.
    pub identification: Identification,
    /// True if the iteration converged.
    pub converged: bool,
    /// Where the tracker and the target were found before the identification.
    pub registration: Registration,
    /// The workspace in the frames of the measurement.
    pub workspace: Option<Workspace>,
    /// RMS errors of the mechanism as it was given, once the frames of the data are found; nothing if it does not reach all
    /// samples.
    pub before: ErrorSummary,
    /// Samples that the mechanism as it was given does not reach.
    pub not_reached: usize,
    /// RMS errors of the calibrated mechanism on the rows that were fitted.
    pub after: ErrorSummary,
    /// RMS errors on rows that were not fitted.
    pub held_out: Option<HeldOut>,
    /// Predicted error over the workspace, or over the measured poses without one.
    pub predicted: Option<PredictedError>,
    /// The same of the drawing with its tolerances, conventions apart.
    pub of_drawing: Option<PredictedError>,
    /// Whether the machine is as near its drawing as the tolerances say, if they were the prior.
    pub drawing: Option<DrawingTest>,
    /// How much wider than stated the tolerances were taken, by group ([`GROUPS`](crate::identification::GROUPS)).
    pub tolerance_factors: [f64; 4],
    /// Directions that the data do not decide.
    pub weak: Vec<WeakDirection>,
    /// Rigid motions, leg offsets, and what is left against the tolerances.
    pub plausibility: Plausibility,
    /// May it be used?
    pub verdict: CalibrationVerdict,
}
