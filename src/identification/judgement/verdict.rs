//! May the result be used? What speaks against it, and what the user should know.

use crate::identification::estimators::identification::Identification;
use crate::measurement::{DataRow, Dataset};
use crate::mechanism::Mechanism;
use crate::units::{shortened, show_probability};

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
    let mut warnings = Vec::new();
    if found.misfit.degrees_of_freedom == 0 && !found.misfit.noise_known {
        reasons.push(
            "the readings do not outnumber the parameters and no noise is stated, so no uncertainty can be given; state \
             [noise] or measure more samples"
                .into(),
        );
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
