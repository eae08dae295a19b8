//! From a machine and its data to a question for the diagnosis, and from its answer to an extended machine.

use crate::diagnosis::{Cause, Diagnosis, Question};
use crate::effect::ActiveEffect;
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::measurement::{Dataset, Frames};

impl Machine {
    /// The machine of the same file without its effects.
    ///
    /// # Errors
    /// [`FileError`] as for any file.
    pub fn without_effects(self) -> Result<Self, FileError> {
        if self.document.effects.is_empty() {
            return Ok(self);
        }
        let mut document = self.document.clone();
        document.effects.clear();
        self.with_document(document)
    }

    /// The file of the extended model that a diagnosis of this machine found, in the frames of the drawing.
    ///
    /// # Errors
    /// [`FileError`] if there is no mechanism of the values that were found.
    pub fn extended_document(&self, found: &Diagnosis) -> Result<MechanismDocument, FileError> {
        let plain = self.plain();
        let calibrated = plain
            .with_values(&found.values, plain.home())
            .map_err(|cause| FileError::Geometry { path: self.path.clone(), cause })?;
        let sigma = |effect: &ActiveEffect| -> Vec<f64> {
            let is_it = |c: &&Cause| {
                c.effect == effect.effect.name()
                    && c.leg == effect.at.leg
                    && c.row == effect.at.row
                    && c.of == effect.at.covariate
            };
            let cause = found.causes.iter().find(is_it);
            let of = |c: &Cause| c.parameters.iter().map(|p| p.sigma.unwrap_or(f64::NAN)).collect();
            cause.map(of).unwrap_or_default()
        };
        let sigmas: Vec<Vec<f64>> = found.effects.iter().map(sigma).collect();
        self.document_with_effects(
            calibrated.as_ref(),
            self.workspace.as_ref(),
            &Frames::default(),
            &found.effects,
            &sigmas,
            &found.environment,
        )
    }
}

impl<'a> Question<'a> {
    /// What does this machine get wrong in these data? All effects of its catalogue are looked for, and of the stated noise
    /// only the ratio is used. Data of a machine whose file has effects are read with the machine
    /// [`without_effects`](Machine::without_effects), so that these are looked for anew.
    pub fn of(machine: &'a Machine, data: &'a Dataset) -> Self {
        Self {
            mechanism: machine.plain(),
            data,
            environment: (**machine.environment()).clone(),
            convention: machine.convention,
            catalogue: machine.catalogue().clone(),
            noise_known: false,
            seed: 0,
        }
    }
}
