//! May the result be used? What speaks against it, and what the user should know.

use crate::identification::estimators::identification::Identification;
use crate::identification::judgement::drawing::{DrawingTest, widened_in_words};
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::judgement::held_out::HeldOut;
use crate::identification::judgement::model_errors::ErrorSummary;
use crate::identification::problem::prior::PriorPolicy;
use crate::measurement::{DataRow, Dataset};
use crate::mechanism::Mechanism;
use crate::observability::PredictedError;
use crate::units::{shortened, show_angle, show_length, show_probability};

/// May the result be used?
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CalibrationVerdict {
    /// True if nothing speaks against it.
    pub trusted: bool,
    /// Reasons not to trust the result, one sentence each.
    pub reasons: Vec<String>,
    /// Warnings that do not prevent the use of the result.
    pub warnings: Vec<String>,
}

impl CalibrationVerdict {
    /// Adds a reason not to trust the result.
    pub(crate) fn distrust(&mut self, reason: String) {
        self.trusted = false;
        self.reasons.push(reason);
    }
}

/// A misfit this unlikely is not chance.
const MISFIT: f64 = 1e-6;
/// Part of the samples that may be gross errors.
const MOST_GROSS: f64 = 0.3;
/// A sample with less weight than this has none.
const NO_WEIGHT: f64 = 1e-2;
/// Without a stated noise: errors of rows that were not fitted, over what those of the fitted ones lead one to expect.
const FAR: f64 = 3.0;
/// Errors above this part of the size of a mechanism, and angles above this, rad, bend what a covariance takes for straight.
const BENT: f64 = 0.05;
/// A tolerance that has to be this many times as wide is none.
const WIDEST: f64 = 300.0;
/// Errors up to this, m and rad, are those of arithmetic.
const ROUNDING: f64 = 1e-9;

/// What the identification itself says.
pub(crate) fn judge(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    found: &Identification,
    converged: bool,
) -> CalibrationVerdict {
    let mut reasons = Vec::new();
    if !converged {
        reasons.push("the iteration did not converge".into());
    }
    let unknowns = found.parameters.len();
    if found.rank < unknowns {
        let missing = unknowns - found.rank;
        reasons.push(format!(
            "the poses leave {missing} of {unknowns} parameter directions undetermined and there is no prior; \
             measure other poses or state a [tolerance]"
        ));
    }
    if let Some(p) = found.misfit.p_value().filter(|p| *p < MISFIT) {
        let scale = found.misfit.scale().unwrap_or(f64::NAN);
        reasons.push(format!(
            "the residuals are {scale:.3} times the stated noise, which cannot be due to chance (p {}); \
             the model misses something, the file is misread, or the noise is understated",
            show_probability(p)
        ));
    }
    let ignored = found.weights.iter().filter(|w| **w < NO_WEIGHT).count().max(found.outliers.len());
    if ignored as f64 > MOST_GROSS * data.len() as f64 {
        reasons.push(format!(
            "{ignored} of {} samples got no weight; so many are not gross errors, but something that the model misses",
            data.len()
        ));
    }
    let mut warnings = Vec::new();
    if let Some(p) = found.misfit.p_value().filter(|p| *p > 1.0 - MISFIT) {
        let scale = found.misfit.scale().unwrap_or(f64::NAN);
        warnings.push(format!(
            "the residuals are only {scale:.3} times the stated noise, which is too good to be chance (p of less {}): rows that \
             are copies, commanded values in the place of measured ones, or a noise that is overstated",
            show_probability(1.0 - p)
        ));
    }
    if found.misfit.widening().is_none() {
        reasons.push(format!(
            "no noise is stated, and the readings outnumber the parameters by {}, which is too few to tell it, so no uncertainty \
             can be given; state [noise] or measure more samples",
            found.misfit.degrees_of_freedom
        ));
    } else if found.misfit.degrees_of_freedom == 0 {
        warnings.push(
            "the readings do not outnumber the parameters, so the fit cannot be checked against the noise".into(),
        );
    }
    let outside: Vec<String> =
        data.iter().filter(|s| !mechanism.within_strokes(&s.joints)).map(|s| s.row.to_string()).collect();
    if !outside.is_empty() {
        warnings.push(format!("joints outside their stroke in data row {}", shortened(&outside)));
    }
    if !found.outliers.is_empty() {
        let rows: Vec<String> = found.outliers.iter().map(DataRow::to_string).collect();
        warnings.push(format!("gross errors in data row {}; they were given little or no weight", shortened(&rows)));
    }
    CalibrationVerdict { trusted: reasons.is_empty(), reasons, warnings }
}

/// What the agreement with the drawing says.
pub(crate) fn judge_drawing(
    verdict: &mut CalibrationVerdict,
    drawing: Option<&DrawingTest>,
    factors: [f64; 4],
    policy: PriorPolicy,
) {
    let widened = widened_in_words(&factors);
    if !widened.is_empty() {
        let advice = "the tolerances were taken as that much wider; correct [tolerance] or the drawing";
        verdict.warnings.push(format!("{}; {advice}", widened.join(", ")));
    }
    if factors.iter().any(|f| *f > WIDEST) {
        verdict.distrust(format!(
            "{}: so far from its drawing no machine is built; check the drawing (signs, units, order of the legs) and the columns",
            widened.join(", ")
        ));
    }
    if let Some(p) = drawing.and_then(DrawingTest::p_value).filter(|p| *p < MISFIT) {
        let remedy = match policy {
            PriorPolicy::Tolerance => "--prior auto lets the data say how much wider they are",
            _ => {
                "wider tolerances do not explain it: check the drawing (signs, units, order of the legs) and the columns"
            }
        };
        verdict.distrust(format!(
            "the machine is farther from its drawing than [tolerance] allows (p {}); {remedy}",
            show_probability(p)
        ));
    }
}

/// What the number of directions says of which the data say anything at all, of those that move the pose.
pub(crate) fn judge_poses(verdict: &mut CalibrationVerdict, rank: usize, visible: usize) {
    if 2 * rank < visible {
        verdict.distrust(format!(
            "the data see {rank} of the {visible} directions that matter, and nothing checks the rest of the drawing; measure \
             more and other poses"
        ));
    }
}

/// What the predicted error says: of what was `measured`, positions or rotations, something must have been learned that the
/// drawing does not say, and it must be so small a part of a mechanism of this `size` that a covariance has a meaning.
pub(crate) fn judge_prediction(
    verdict: &mut CalibrationVerdict,
    predicted: &PredictedError,
    drawing: Option<&PredictedError>,
    measured: &ErrorSummary,
    size: f64,
) {
    let shown = |e: &PredictedError| format!("{} and {}", show_length(e.position_rms), show_angle(e.rotation_rms));
    let (position, rotation) = (measured.position.is_some(), measured.rotation.is_some());
    if position && predicted.position_rms > BENT * size || rotation && predicted.rotation_rms > BENT {
        verdict.distrust(format!(
            "the predicted error, {}, is so large that it means nothing for a mechanism of this size; check the drawing (signs, \
             units, order of the legs) and the columns, and measure more and other poses",
            shown(predicted)
        ));
    }
    let Some(drawing) = drawing else { return };
    // A platform that cannot turn is not expected to, by either.
    let no_better = |predicted: f64, drawn: f64| drawn > 0.0 && predicted >= drawn;
    if position && no_better(predicted.position_rms, drawing.position_rms)
        || rotation && no_better(predicted.rotation_rms, drawing.rotation_rms)
    {
        verdict.distrust(format!(
            "the data tell little that the drawing does not: the predicted error is {}, that of the drawing with its \
             tolerances {}; measure more and other poses",
            shown(predicted),
            shown(drawing)
        ));
    }
}

/// What the commands say: where nothing was commanded, what moved is no noise.
pub(crate) fn judge_commands(verdict: &mut CalibrationVerdict, data: &Dataset) {
    let still = data.len() > 1 && data.iter().all(|s| s.joints == data.sample(0).joints);
    if still && !data.noise.known {
        verdict.distrust(
            "the joints are the same in all data rows, and no noise is stated: nothing tells the noise from what moved the \
             platform; check the columns of the joints, or state [noise]"
                .into(),
        );
    }
}

/// What the errors on samples that were not fitted say, against those on the `fitted` ones with so many `rows`.
pub(crate) fn judge_held_out(
    verdict: &mut CalibrationVerdict,
    held_out: &HeldOut,
    fitted: &ErrorSummary,
    misfit: &GoodnessOfFit,
    rows: usize,
) {
    let shown = |e: &ErrorSummary| {
        let both = [e.position.map(show_length), e.rotation.map(show_angle)];
        both.into_iter().flatten().collect::<Vec<_>>().join(" and ")
    };
    if let Some(p) = held_out.p_value.filter(|p| *p < MISFIT) {
        verdict.distrust(format!(
            "the errors on the rows that were held out, {}, are larger than noise and model allow (p {}); something changed \
             between the two files, or the model misses something",
            shown(&held_out.rms),
            show_probability(p)
        ));
    }
    if misfit.noise_known {
        return;
    }
    // Least squares leaves the part `free / rows` of the square of the noise, and rows that are not fitted get its inverse.
    let (rows, free) = (rows as f64, misfit.degrees_of_freedom as f64);
    let far = |held: Option<f64>, fitted: Option<f64>| {
        held.zip(fitted).is_some_and(|(held, fitted)| held > ROUNDING && held * free > FAR * fitted * rows)
    };
    if far(held_out.rms.position, fitted.position) || far(held_out.rms.rotation, fitted.rotation) {
        verdict.distrust(format!(
            "the errors on rows that were not fitted, {}, are far larger than on those that were, {}: the parameters follow \
             the noise; measure more poses, or state [noise] and a [tolerance]",
            shown(&held_out.rms),
            shown(fitted)
        ));
    }
}
