//! Questions to measurements that are only planned: poses and conditions, but no readings.

use std::sync::Arc;

use crate::diagnosis::answer::limits::limit;
use crate::diagnosis::answer::result::{NotFound, NotTestable};
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::{Hypotheses, Point};
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::kept_rows::KeptRows;
use crate::diagnosis::linear::model::{Fitting, Model};
use crate::diagnosis::linear::spreads::Spreads;
use crate::diagnosis::question::{Question, TOLERANCES};
use crate::identification::{Conventions, IdentifyError, Prior};
use crate::measurement::{DataRow, Dataset, Noise, PoseMeasurement, PoseReading, Sample};
use crate::mechanism::Mechanism;
use crate::pose::{Pose, PoseConvention};

/// The samples as poses of which these coordinates are measured, just where the mechanism says, with this noise.
///
/// # Errors
/// [`IdentifyError::Sample`] if a sample has no pose.
pub fn planned(
    mechanism: &dyn Mechanism,
    samples: Vec<Sample>,
    convention: PoseConvention,
    noise: Noise,
    measured: [bool; 6],
) -> Result<Dataset, IdentifyError> {
    let pose = |(k, s): (usize, &Sample)| {
        mechanism
            .forward(mechanism.values(), &s.joints, &s.conditions, &mechanism.home())
            .map_err(|cause| IdentifyError::Sample { row: DataRow(k), label: String::new(), cause })
    };
    let poses: Vec<Pose> = samples.iter().enumerate().map(pose).collect::<Result<_, _>>()?;
    let (p, r) = (noise.position, noise.rotation);
    let sigma = [p, p, p, r, r, r];
    let reading = |pose: &Pose| PoseReading { values: convention.coordinates(pose), measured, sigma };
    let model = PoseMeasurement::new(convention, poses.iter().map(reading).collect());
    Ok(Dataset::new(samples, Arc::new(model), noise))
}

/// Detection limits of planned samples, effect by effect, with the noise as stated, and what the effects that cannot be
/// tested need. `question.data` are the planned samples.
///
/// # Errors
/// [`DiagnoseError`] if the samples decide too little.
pub fn detection_limits(question: &Question<'_>) -> Result<(Vec<NotFound>, Vec<NotTestable>), DiagnoseError> {
    let prior = Prior::wide(question.mechanism, TOLERANCES, Conventions::FRAMES);
    let environment = Arc::new(question.environment.with_references_of(question.data));
    let (subject, mut missing) =
        Hypotheses::new(question.mechanism, question.data, environment, prior, &question.catalogue, &[]);
    let table = table_of(&subject)?;
    let model = model_of(&subject, &table, Vec::new())?;
    let mut limits = Vec::new();
    for (k, group) in subject.groups.iter().enumerate() {
        match limit(&model, &subject.groups, k, subject.groups.len()) {
            Some(found) => limits.push(found),
            None => missing.push(group.unchanging()),
        }
    }
    Ok((limits, missing))
}

/// All rows at the values of the mechanism, without effects.
pub(crate) fn table_of(subject: &Hypotheses<'_>) -> Result<Arc<KeptRows>, DiagnoseError> {
    let point = Point { values: subject.mechanism.values().to_vec(), effects: Vec::new(), scale: 1.0 };
    let table = subject.table(&point, &Spreads::default())?;
    Ok(Arc::new(KeptRows::new(Arc::new(table), Vec::new())))
}

/// The parameters and these effects, with the noise as stated.
pub(crate) fn model_of(
    subject: &Hypotheses<'_>,
    rows: &Arc<KeptRows>,
    effects: Vec<Hypothesis>,
) -> Result<Model, DiagnoseError> {
    let fitting = Fitting { scale: 1.0, inflation: 1.0, known: true };
    Model::fit(rows, &subject.groups, effects, &fitting)
}
