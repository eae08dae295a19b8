//! Charts of the errors of a model: by row, over workspace, legs and conditions, and against the noise.
//!
//! | file | question |
//! |---|---|
//! | `by_row` | which rows are wrong, and by how much? |
//! | `maps` | where in the workspace? |
//! | `strips` | which leg, and with what does it change? |
//! | `histograms` | are the residuals noise? |
//! | `drawing` | what does it look like? |
//! | `parameters` | which parameters are known, and which are correlated? |
//! | `evidence` | does the named cause follow the data? |
//! | `conditions` | what changed during the run? |
//! | `choice` | what do the chosen poses promise? |

mod by_row;
mod choice;
mod conditions;
mod drawing;
mod evidence;
mod histograms;
mod maps;
mod parameters;
mod scale;
mod standing;
mod strips;

pub(super) use by_row::by_row;
pub(super) use choice::{coverage, how_many, trace};
pub(super) use conditions::conditions;
pub(super) use drawing::{Displacements, drawing};
pub(super) use evidence::{added_variable, gain, sizes};
pub(super) use histograms::histograms;
pub(super) use maps::maps;
pub(super) use parameters::{correlation, deviations};
pub(super) use standing::Standing;
pub(super) use strips::{Layer, gross, strips};

use crate::identification::{Deviation, IdentifyError, ModelErrors};
use nalgebra::{Vector3, Vector6};

use crate::measurement::{DataRow, Dataset, Frames};
use crate::mechanism::Mechanism;

/// What rows that look like gross errors are called in legends.
const GROSS: &str = "looks like a gross error";

/// Data evaluated with one model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ModelResiduals {
    /// Name of the model in legends.
    pub name: String,
    /// Length of the error of each sample.
    pub errors: ModelErrors,
    /// The errors themselves.
    pub deviations: Vec<Deviation>,
}

impl ModelResiduals {
    /// The data through a mechanism, with the measurement's own parameters `own` as for
    /// [`deviations`](crate::identification::deviations).
    ///
    /// # Errors
    /// [`IdentifyError::Sample`] if a sample has no pose.
    pub fn new(
        name: impl Into<String>,
        mechanism: &dyn Mechanism,
        own: &[f64],
        data: &Dataset,
    ) -> Result<Self, IdentifyError> {
        let deviations = crate::identification::deviations(mechanism, own, data)?;
        Ok(Self { name: name.into(), errors: ModelErrors::of(&deviations), deviations })
    }

    /// The same with poses and motions in the base frame of a mechanism that stands in these frames.
    #[must_use]
    pub fn in_base(mut self, frames: &Frames) -> Self {
        let turn = frames.base.rotation.inverse();
        for d in &mut self.deviations {
            let [shift, turned] = [0, 3].map(|k| Vector3::new(d.motion[k], d.motion[k + 1], d.motion[k + 2]));
            let pose = frames.platform(&d.pose);
            // The origin of the platform moves with the target about which the motion is stated.
            let arm = frames.base.place(&pose.position) - d.pose.position;
            let (shift, turned) = (turn * (shift + turned.cross(&arm)), turn * turned);
            d.motion = Vector6::new(shift.x, shift.y, shift.z, turned.x, turned.y, turned.z);
            d.pose = pose;
        }
        self
    }

    /// Data row and deviation of each joint, SI.
    pub(super) fn in_joints(&self) -> Vec<(DataRow, &[f64])> {
        self.deviations.iter().map(|d| (d.row, d.joints.as_slice())).collect()
    }
}

/// The smallest of 1, 2, 5, 10, … times a power of ten that is not below a value.
fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0].iter().map(|k| k * power).find(|v| *v >= value * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_are_rounded_up_to_one_two_or_five() {
        for (value, expected) in [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (21.0, 50.0), (0.003, 0.005), (6e4, 1e5)] {
            let found = super::round_up(value);
            assert!((found / expected - 1.0).abs() < 1e-9, "{value}: {found}");
        }
    }
}
