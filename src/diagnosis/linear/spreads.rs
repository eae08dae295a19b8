//! How much more than stated each row scatters: the weights of the reweighted fit.

use crate::measurement::RowKind;

/// The σ of the rows over the stated one. The default is noise as stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Spreads {
    /// For each joint that of the rows that it moves; in pose space, where each coordinate has its own.
    pub(crate) joints: Vec<f64>,
    /// That of position rows and of rotation rows, where their ratio is not the stated one.
    pub(crate) kinds: Option<[f64; 2]>,
    /// That of each sample, where the noise was found to vary.
    pub(crate) samples: Vec<f64>,
}

impl Spreads {
    pub(crate) fn are_as_stated(&self) -> bool {
        self.joints.is_empty() && self.kinds.is_none() && self.samples.is_empty()
    }

    /// Spread of one row of a sample; `joint` is asked only where joints differ.
    pub(crate) fn of_row(&self, sample: usize, joint: impl FnOnce() -> usize, kind: RowKind) -> f64 {
        let of_sample = self.samples.get(sample).copied().unwrap_or(1.0);
        let of_joint = if self.joints.is_empty() { 1.0 } else { self.joints[joint()] };
        let of_kind = self.kinds.map_or(1.0, |k| k[usize::from(kind == RowKind::Rotation)]);
        of_sample * of_joint * of_kind
    }
}
