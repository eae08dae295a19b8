//! From a machine and its data to a question for the diagnosis.

use super::machine::Machine;
use crate::diagnosis::Question;
use crate::effect::{Extended, catalogue};
use crate::measurement::Dataset;
use crate::mechanism::Mechanism;

impl Machine {
    /// The mechanism without the effects of its file.
    pub fn plain(&self) -> &dyn Mechanism {
        let whole = self.mechanism.as_ref();
        (whole as &dyn std::any::Any).downcast_ref::<Extended>().map_or(whole, Extended::inner)
    }
}

impl<'a> Question<'a> {
    /// What does this machine get wrong in these data? All effects of the catalogue are looked for, those in the file of the
    /// machine too, and of the stated noise only the ratio is used.
    pub fn of(machine: &'a Machine, data: &'a Dataset) -> Self {
        Self {
            mechanism: machine.plain(),
            data,
            surroundings: (**machine.surroundings()).clone(),
            convention: machine.convention,
            catalogue: catalogue(),
            noise_known: false,
            seed: 0,
        }
    }
}
