//! Samples and their readings.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::{DataRow, Frames, MeasurementModel, Noise, RowKind, Rows, SamplePosition};
use crate::conditions::Conditions;
use crate::pose::Pose;

/// One measured sample, without its reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Label from the file.
    pub id: Option<String>,
    /// Where it is in the file.
    pub row: DataRow,
    /// Commanded (or read) joint coordinates, SI.
    pub joints: Vec<f64>,
    /// Operating state.
    pub conditions: Conditions,
}

/// Samples, their readings and their noise.
///
/// A subset shares the readings with the whole; the operating states were filled in for the whole file, so
/// that the previous joints of a sample do not change when its neighbour is left out.
#[derive(Clone, Debug)]
pub struct Dataset {
    samples: Arc<[Sample]>,
    model: Arc<dyn MeasurementModel>,
    kept: Vec<usize>,
    /// By which the σ that the model gives to positions and to angles are multiplied.
    scales: [f64; 2],
    /// 1σ of the readings; the model's covariances are made of it, or of the file's own columns.
    pub noise: Noise,
    /// Where the tracker and the target are.
    pub frames: Frames,
}

impl Dataset {
    /// All samples of a measurement.
    ///
    /// # Panics
    /// If the model has another number of samples, which is a mistake of the caller.
    #[allow(clippy::panic)]
    pub fn new(samples: Vec<Sample>, model: Arc<dyn MeasurementModel>, noise: Noise) -> Self {
        assert_eq!(samples.len(), model.samples(), "one reading for each sample");
        Self {
            kept: (0..samples.len()).collect(),
            samples: samples.into(),
            model,
            scales: [1.0; 2],
            noise,
            frames: Frames::default(),
        }
    }

    /// The same readings under other conditions.
    pub(crate) fn with_conditions(&self, change: impl Fn(&Conditions) -> Conditions) -> Self {
        let sample = |s: &Sample| Sample { conditions: change(&s.conditions), ..s.clone() };
        Self { samples: self.samples.iter().map(sample).collect(), ..self.clone() }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// The `k`-th sample that is kept.
    pub fn sample(&self, k: usize) -> &Sample {
        &self.samples[self.kept[k]]
    }

    /// The data row of a kept sample.
    pub fn row(&self, position: SamplePosition) -> DataRow {
        self.sample(position.0).row
    }

    /// The kept samples in order.
    pub fn iter(&self) -> impl Iterator<Item = &Sample> {
        self.kept.iter().map(|&k| &self.samples[k])
    }

    /// Residual and derivatives of the `k`-th kept sample at a pose of the platform, with the own parameters of the model;
    /// `out` as for [`MeasurementModel::evaluate`].
    pub fn evaluate(&self, k: usize, pose: &Pose, own: &[f64], out: &mut Rows) {
        let index = self.kept[k];
        self.model.evaluate(index, &self.samples[index], pose, &self.frames, own, out);
    }

    /// Covariance of the `k`-th kept reading, SI.
    pub fn covariance(&self, k: usize) -> DMatrix<f64> {
        let mut covariance = self.model.covariance(self.kept[k], &self.frames);
        if self.scales != [1.0; 2] {
            let scales: Vec<f64> =
                self.rows(k).iter().map(|kind| self.scales[usize::from(*kind == RowKind::Rotation)]).collect();
            for (row, a) in scales.iter().enumerate() {
                for (column, b) in scales.iter().enumerate() {
                    covariance[(row, column)] *= a * b;
                }
            }
        }
        covariance
    }

    /// The same readings with `[position, rotation]` times the σ of positions and of angles.
    #[must_use]
    pub(crate) fn with_noise_of_kinds(&self, [position, rotation]: [f64; 2]) -> Self {
        let noise =
            Noise { position: self.noise.position * position, rotation: self.noise.rotation * rotation, ..self.noise };
        Self { scales: [self.scales[0] * position, self.scales[1] * rotation], noise, ..self.clone() }
    }

    /// The model, and the index in it of the `k`-th kept sample.
    pub fn reading(&self, k: usize) -> (&dyn MeasurementModel, usize) {
        (self.model.as_ref(), self.kept[k])
    }

    /// The measurement model.
    pub fn model(&self) -> &Arc<dyn MeasurementModel> {
        &self.model
    }

    /// The row of each quantity of a complete reading in the `k`-th kept sample ([`MeasurementModel::row_of_each`]).
    pub fn row_of_each(&self, k: usize) -> Vec<Option<usize>> {
        self.model.row_of_each(self.kept[k])
    }

    /// True if no reading says where anything is, and some say how high.
    pub fn heights_only(&self) -> bool {
        let places = |k: usize| {
            let (model, index) = self.reading(k);
            model.rigid_pose(index).is_some() || model.point(index).is_some() || !model.points(index).is_empty()
        };
        self.row_count() > 0 && !(0..self.len()).any(places)
    }

    /// Kinds of the rows of the `k`-th kept sample.
    pub fn rows(&self, k: usize) -> Vec<RowKind> {
        self.model.rows(self.kept[k])
    }

    /// Number of rows of all kept samples.
    pub fn row_count(&self) -> usize {
        (0..self.len()).map(|k| self.rows(k).len()).sum()
    }

    /// The samples at these positions among the kept ones.
    pub fn subset(&self, positions: &[usize]) -> Self {
        Self { kept: positions.iter().map(|&k| self.kept[k]).collect(), ..self.clone() }
    }

    /// These data with another model of their readings.
    ///
    /// # Panics
    /// If the model has another number of samples, which is a mistake of the caller.
    #[allow(clippy::panic)]
    pub fn with_model(&self, model: Arc<dyn MeasurementModel>) -> Self {
        assert_eq!(self.samples.len(), model.samples(), "one reading for each sample");
        Self { model, ..self.clone() }
    }

    /// These data with other frames.
    pub fn with_frames(&self, frames: Frames) -> Self {
        Self { frames, ..self.clone() }
    }
}
