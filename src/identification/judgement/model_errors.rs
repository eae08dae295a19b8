//! Errors of a model on measured data; nothing is fitted.

use crate::identification::error::IdentifyError;
use crate::identification::judgement::deviations::Deviation;
use crate::identification::judgement::samples::{each_sample, each_sample_at};
use crate::measurement::{DataRow, Dataset, RowKind, Rows};
use crate::mechanism::Mechanism;
use crate::pose::Pose;

/// Error of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SampleError {
    /// The sample.
    pub row: DataRow,
    /// Length of the position error, m (RMS over the targets if there are several); `None` if no position was
    /// measured.
    pub position: Option<f64>,
    /// Length of the vector of angle errors, rad; `None` if no angle was measured.
    pub rotation: Option<f64>,
}

impl SampleError {
    /// From the rows of a reading, predicted minus measured or the other way round.
    fn of(row: DataRow, readings: &[(RowKind, f64)]) -> Self {
        let sum = |kind: RowKind| {
            let squares: Vec<f64> = readings.iter().filter(|(k, _)| *k == kind).map(|(_, r)| r * r).collect();
            (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / (squares.len() / 3).max(1) as f64).sqrt())
        };
        Self { row, position: sum(RowKind::Position), rotation: sum(RowKind::Rotation) }
    }
}

/// One number for position and one for rotation, over samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ErrorSummary {
    /// Over lengths of position errors, m.
    pub position: Option<f64>,
    /// Over lengths of angle errors, rad.
    pub rotation: Option<f64>,
}

/// Errors of all samples.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ModelErrors {
    /// By sample, in the order of the data.
    pub samples: Vec<SampleError>,
}

impl ModelErrors {
    /// The lengths of deviations.
    pub fn of(deviations: &[Deviation]) -> Self {
        Self { samples: deviations.iter().map(|d| SampleError::of(d.row, &d.readings)).collect() }
    }

    fn over(&self, f: impl Fn(&[f64]) -> f64) -> ErrorSummary {
        let collect = |get: fn(&SampleError) -> Option<f64>| {
            let values: Vec<f64> = self.samples.iter().filter_map(get).collect();
            (!values.is_empty()).then(|| f(&values))
        };
        ErrorSummary { position: collect(|s| s.position), rotation: collect(|s| s.rotation) }
    }

    /// Root of the mean square.
    pub fn rms(&self) -> ErrorSummary {
        self.over(|v| (v.iter().map(|e| e * e).sum::<f64>() / v.len() as f64).sqrt())
    }

    /// Mean.
    pub fn mean(&self) -> ErrorSummary {
        self.over(|v| v.iter().sum::<f64>() / v.len() as f64)
    }

    /// Largest.
    pub fn max(&self) -> ErrorSummary {
        self.over(|v| v.iter().copied().fold(0.0, f64::max))
    }
}

/// Compares what a mechanism predicts for each sample with what was measured.
///
/// `own` are the values of the measurement's own parameters; if there are too few, they are found from the
/// predicted poses.
///
/// # Errors
/// [`IdentifyError::Sample`] if a sample has no pose.
pub fn evaluate(mechanism: &dyn Mechanism, own: &[f64], data: &Dataset) -> Result<ModelErrors, IdentifyError> {
    let samples = each_sample(mechanism, own, data, |k, _, rows| sample_error(data, k, rows))?;
    Ok(ModelErrors { samples })
}

/// As [`evaluate`], where the model puts the samples at these poses.
pub(crate) fn errors_at(poses: &[Pose], own: &[f64], data: &Dataset) -> ModelErrors {
    ModelErrors { samples: each_sample_at(poses, own, data, |k, _, rows| sample_error(data, k, rows)) }
}

fn sample_error(data: &Dataset, k: usize, rows: &Rows) -> SampleError {
    let readings: Vec<(RowKind, f64)> = data.rows(k).into_iter().zip(rows.residual.iter().copied()).collect();
    SampleError::of(data.sample(k).row, &readings)
}
