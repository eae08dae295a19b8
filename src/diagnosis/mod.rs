//! From residuals to causes: what the model gets wrong, and why.
//! Even the best-fit kinematic parameters leave a residual. [`diagnose`] always gives one of five answers:
//!
//! | verdict | meaning |
//! |---|---|
//! | clean | the residuals are noise |
//! | named | causes of the [catalogue](crate::effect::catalogue()) explain it |
//! | tied | they do, but the data do not exclude other names |
//! | unknown | an error depends on a covariate, or is at a leg, and no name explains it |
//! | misread | the file was read wrongly: a sign, a unit, an order |
//! The steps, with their files:
//!
//! 1. **Preflight** (`preflight`, `misreadings`): would the file fit much better if it were read otherwise?
//! 2. **Baseline** (`hypotheses`, `design_matrix`): the parameters are identified with a prior of two tolerances, which
//! keeps the two weak
//!    directions of each leg finite, and the columns of everything are computed once.
//! 3. **Outliers** (`outliers`): samples that fit nothing, judged again after every step.
//! 4. **Search** (`search`): all columns are projected off those of the parameters (`model`). Names are *detected*
//!    by a test at a family-wise level with all places of a scan counted, and *chosen* by their marginal likelihood
//!    with priors of physical size, heavy-tailed by a mixture of widths. One is added, all are tried in each other's
//!    places, and so on; then parameters and values are identified together and the columns computed anew.
//! 5. **Ties**: every other name within a factor of 20 in evidence is reported.
//! 6. **Remainder** (`remainder`): tests without a named cause. If one finds something, the answer is *unknown*, and if
//!    one covariate at one leg explains more than all names together the names are withdrawn.
//! 7. **Gain** (`gain`): errors on rows that were not fitted, with the causes and without.
//!
//! Frames, targets and leg offsets are absorbed by the parameters; no effect is named for them. What parameters absorb
//! is not harmless: a shifting pivot looks right within the measured range and is wrong outside.

mod answer;
mod error;
mod linear;
mod planning;
mod preflight;
mod search;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use answer::result::{
    AddedVariable, Cause, CauseParameter, Diagnosis, Gain, JointResiduals, Misread, NoiseVaries, NotFound, NotTestable,
    Rival, Unknown, Verdict,
};
pub use error::DiagnoseError;
pub use planning::design::{detection_limits, planned};

pub use planning::settle::{MeasurementPlan, Separation, TOLD_APART, settle};

use crate::effect::{Effect, Environment};
use crate::identification::{ErrorSummary, Prior, register};
use crate::measurement::Dataset;
use crate::mechanism::Mechanism;
use crate::pose::PoseConvention;
use crate::units::shortened;
use linear::hypotheses::Hypotheses;
use search::iteration::Search;

/// Tolerances by which parameters may differ from the drawing.
const TOLERANCES: f64 = 2.0;

/// Samples that can be searched in minutes, with a few gigabytes.
const MOST_SAMPLES: usize = 10_000;

/// Input of a diagnosis.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The mechanism without effects.
    pub mechanism: &'a dyn Mechanism,
    /// The samples.
    pub data: &'a Dataset,
    /// Surroundings of the mechanism.
    pub environment: Environment,
    /// How the data write poses.
    pub convention: PoseConvention,
    /// The effects that are looked for.
    pub catalogue: Vec<Arc<dyn Effect>>,
    /// True if the stated noise is taken as known; otherwise only its ratio of position to rotation is.
    pub noise_known: bool,
    /// Seed of the folds.
    pub seed: u64,
}

/// Says what the model gets wrong.
///
/// # Errors
/// [`DiagnoseError`] if there is no answer at all.
pub fn diagnose(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let Question { mechanism, data, convention, .. } = *question;
    if data.len() > MOST_SAMPLES {
        return Err(DiagnoseError::TooManySamples { samples: data.len(), most: MOST_SAMPLES });
    }
    let convention = &convention;
    let prior = Prior::wide(mechanism, TOLERANCES);
    if let Some(misread) = preflight::compare::preflight(mechanism, data, convention, &prior) {
        return Ok(misread_file(data, misread));
    }
    let (data, gaps) = complete_rows(data);
    let registration = register(mechanism, &data)?;
    let data = data.with_frames(registration.frames);
    let environment = Arc::new(question.environment.with_references_of(&data));
    let (mut subject, missing) = Hypotheses::new(mechanism, &data, environment, prior, &question.catalogue);
    let known = question.noise_known && data.noise.known;
    if subject.is_pose_space() && !data.noise.known {
        // Nothing says how the noise of the six coordinates compares, and each is fitted by itself.
        let first = Search { subject: &subject, known }.explore_with_care()?;
        subject.spreads = first.spreads(&subject)?;
    }
    let mut state = Search { subject: &subject, known }.explore_with_care()?;
    if let Some(ratio) = state.ratio(&subject)?.filter(|_| !known && subject.spreads.is_empty()) {
        subject.kind_spreads = Some(ratio);
        state = Search { subject: &subject, known }.explore_with_care()?;
    }
    let mut noise = None;
    if let Some((varies, spreads)) = state.noise_varies(&subject)? {
        // Rows count by the noise that they have.
        noise = Some(varies);
        subject.sample_spreads = spreads;
        state = Search { subject: &subject, known }.explore_with_care()?;
    }
    let mut found = answer::findings::findings(question, &subject, &state, missing, &registration, noise)?;
    found.warnings.extend(gaps);
    Ok(found)
}

/// Part of the rows that must have a covariate for rows without it to be left out, rather than the covariate.
const MOST: f64 = 0.8;

/// The samples that have every covariate that most have, and what to say of the others. A covariate with gaps would else
/// be none, and its effects would go to their relatives.
fn complete_rows(data: &Dataset) -> (Dataset, Vec<String>) {
    let n = data.len();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in data.iter().flat_map(|s| s.conditions.covariates.keys()) {
        *counts.entry(name).or_default() += 1;
    }
    let nearly: Vec<&str> =
        counts.iter().filter(|(_, c)| **c < n && **c as f64 >= MOST * n as f64).map(|(name, _)| *name).collect();
    let whole = |k: &usize| nearly.iter().all(|name| data.sample(*k).conditions.get(name).is_some());
    let (kept, gaps): (Vec<usize>, Vec<usize>) = (0..n).partition(whole);
    if gaps.is_empty() || (kept.len() as f64) < MOST * n as f64 {
        let warning = format!("{} have empty cells; effects that depend on them are not tested", nearly.join(", "));
        return (data.clone(), if nearly.is_empty() { Vec::new() } else { vec![warning] });
    }
    let rows: Vec<String> = gaps.iter().map(|k| data.sample(*k).row.to_string()).collect();
    let warning = format!("data rows {} are left out: {} has empty cells there", shortened(&rows), nearly.join(", "));
    (data.subset(&kept), vec![warning])
}

fn misread_file(data: &Dataset, misread: Misread) -> Diagnosis {
    Diagnosis {
        verdict: Verdict::Misread,
        causes: Vec::new(),
        unknown: None,
        misread: Some(misread),
        outlier_rows: Vec::new(),
        residuals: Vec::new(),
        noise_varies: None,
        correlation: None,
        gain: Gain::default(),
        not_found: Vec::new(),
        not_testable: Vec::new(),
        before: ErrorSummary::default(),
        after: ErrorSummary::default(),
        noise_scale: f64::NAN,
        samples: data.len(),
        joints: Vec::new(),
        values: Vec::new(),
        own: Vec::new(),
        effects: Vec::new(),
        environment: Environment::default(),
        frames: data.frames,
        warnings: Vec::new(),
    }
}
