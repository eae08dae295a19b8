//! How well the data alone know each direction of the parameters.
//!
//! The whitened Jacobian of the data, with each column multiplied by the tolerance of its parameter and the
//! measurement's own parameters projected out, has one singular value for each direction of the parameters:
//! the tolerance along it over the σ that the data alone give. Ten means that the data know the direction to a
//! tenth of the tolerance ([`DECIDED`]); one that they know no more than the workshop.

use nalgebra::{DMatrix, DVector};

use crate::mechanism::Mechanism;
use crate::observability::{DECIDED, Spectrum};
use crate::solve::{exceeds, gram};

/// Singular values and directions of the data alone.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DataSpectrum {
    /// Singular values in descending order, one for each parameter of the mechanism.
    pub values: Vec<f64>,
    /// Directions as columns, in parameters divided by their tolerance.
    pub directions: DMatrix<f64>,
    /// Tolerance of each parameter, SI; 1e-3 stands in where none is stated.
    pub scale: Vec<f64>,
    /// True if every parameter has a tolerance.
    pub scaled_by_tolerance: bool,
}

/// Rows that see a direction by less than this part of the strongest do not see it.
pub(crate) const UNSEEN: f64 = 1e-9;
/// Above this part of all columns together a direction is seen without looking more closely.
const CLEARLY_SEEN: f64 = 1e-6;

/// The whitened rows of the data, or others with the same products of columns, in parameters over their tolerance.
#[derive(Clone, Debug)]
pub(crate) struct ScaledRows {
    part: DMatrix<f64>,
    /// Products of its columns.
    gram: DMatrix<f64>,
    scale: Vec<f64>,
    by_tolerance: bool,
}

impl ScaledRows {
    /// Of a whitened Jacobian of finite numbers whose first columns belong to the mechanism and whose others are
    /// projected out.
    pub(crate) fn of(mechanism: &dyn Mechanism, jacobian: &DMatrix<f64>) -> Self {
        let specs = mechanism.parameters();
        let n = specs.len();
        let scale: Vec<f64> = specs.iter().map(|s| s.tolerance.unwrap_or(1e-3)).collect();
        let mut part = jacobian.columns(0, n).into_owned();
        let own = jacobian.ncols() - n;
        if own > 0 {
            let mut columns = jacobian.columns(n, own).into_owned();
            columns.column_iter_mut().for_each(|mut c| c.unscale_mut(c.amax().max(f64::MIN_POSITIVE)));
            let q = columns.qr().q();
            part -= &q * (q.transpose() * &part);
        }
        for (k, s) in scale.iter().enumerate() {
            part.column_mut(k).scale_mut(*s);
        }
        Self { gram: gram(&part), part, by_tolerance: specs.iter().all(|s| s.tolerance.is_some()), scale }
    }

    /// All singular values, for the noise as stated.
    pub(crate) fn spectrum(&self) -> DataSpectrum {
        let Spectrum { values, directions, .. } = Spectrum::of(&self.part, 0, true);
        DataSpectrum { values, directions, scaled_by_tolerance: self.by_tolerance, scale: self.scale.clone() }
    }

    /// True if the data decide every direction, for σ of the readings times `noise_scale`.
    pub(crate) fn decided(&self, noise_scale: f64) -> bool {
        let limit = DECIDED * noise_scale;
        exceeds(&self.gram, limit) || self.spectrum().smallest() >= limit
    }

    /// Number of parameters of the mechanism.
    pub(crate) fn parameters(&self) -> usize {
        self.scale.len()
    }

    /// True if the rows say nothing of these directions (columns, in parameters over their tolerance).
    pub(crate) fn miss(&self, directions: &DMatrix<f64>) -> bool {
        (&self.part * directions).norm() < CLEARLY_SEEN * self.part.norm()
    }

    /// How many directions the rows see at all.
    pub(crate) fn rank(&self) -> usize {
        self.scale.len() - self.unseen().map_or(0, |(_, directions)| directions.ncols())
    }

    /// Tolerances and the directions (columns, in parameters over them) of which the rows say nothing; `None` if there are
    /// none.
    pub(crate) fn unseen(&self) -> Option<(&[f64], DMatrix<f64>)> {
        if exceeds(&self.gram, CLEARLY_SEEN * self.gram.trace().sqrt()) {
            return None;
        }
        self.spectrum().unseen().map(|directions| (self.scale.as_slice(), directions))
    }

    /// True if there is nothing to tell of weak directions.
    pub(crate) fn without_weakness(&self, noise_scale: f64) -> bool {
        if self.by_tolerance { self.decided(noise_scale) } else { self.unseen().is_none() }
    }
}

impl DataSpectrum {
    /// For σ of the readings times `noise_scale`.
    #[must_use]
    pub fn for_noise(mut self, noise_scale: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v /= noise_scale);
        self
    }

    /// Directions (columns, in parameters over their scale) of which the rows say nothing; `None` if there are
    /// none.
    pub fn unseen(&self) -> Option<DMatrix<f64>> {
        let largest = self.values.iter().copied().fold(0.0, f64::max);
        let columns: Vec<DVector<f64>> = (0..self.values.len())
            .filter(|k| self.values[*k] < UNSEEN * largest)
            .map(|k| self.directions.column(k).into_owned())
            .collect();
        (!columns.is_empty()).then(|| DMatrix::from_columns(&columns))
    }

    /// The smallest singular value.
    pub fn smallest(&self) -> f64 {
        self.values.iter().copied().fold(f64::INFINITY, f64::min)
    }
}
