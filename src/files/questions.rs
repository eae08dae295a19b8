//! From a machine and its data to a question for the diagnosis, and from answers to calibrated and extended machines.

use crate::diagnosis::{Cause, Diagnosis, Question};
use crate::effect::{ActiveEffect, effects_of};
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::sections::EffectEntry;
use crate::files::table::measurement_file::Measurement;
use crate::identification::{Calibration, ErrorSummary, carried_workspace, evaluate};
use crate::measurement::{Dataset, Frames};
use crate::mechanism::mount;

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

    /// The file of the calibrated model, with what was identified of the measurement: places of targets, the plane, effects.
    ///
    /// # Errors
    /// [`FileError::Value`] for a mechanism of another kind.
    pub fn calibrated_document(
        &self,
        result: &Calibration,
        measurement: &Measurement,
    ) -> Result<MechanismDocument, FileError> {
        let found = &result.identification;
        let frames = &result.registration.frames;
        let mut document = self.document_of(result.mechanism.as_ref(), result.workspace.as_ref(), frames)?;
        measurement.put_identified(self, &found.parameters[found.mechanism_parameters..], &mut document);
        if !self.effects().is_empty() {
            document.effects = refitted(self, result, measurement);
        }
        Ok(document)
    }

    /// What a written file makes of the data that it was fitted to: the errors of its model, read as anyone reads it. They are
    /// to be those of the fit.
    ///
    /// # Errors
    /// Why the file cannot be read, or what its model does not reach.
    pub fn errors_as_written(
        &self,
        document: &MechanismDocument,
        measurement: &Measurement,
    ) -> Result<ErrorSummary, String> {
        let mut written = self.with_document(document.clone()).map_err(|e| e.to_string())?;
        let again = measurement.of(&written).map_err(|e| e.to_string())?;
        written.refer_to(again.data.iter().map(|s| &s.conditions), "the data");
        let errors = evaluate(written.mechanism.as_ref(), &[], &again.data).map_err(|e| e.to_string())?;
        Ok(errors.rms())
    }

    /// The file of the extended model that a diagnosis of this machine found, in the frames of the measurement.
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
        let (frames, workspace) = (&found.frames, self.workspace.as_ref());
        let seen = match frames.is_identity() {
            true => calibrated,
            false => mount(calibrated, &frames.base, &frames.target),
        };
        self.document_with_effects(
            seen.as_ref(),
            workspace.map(|w| carried_workspace(w, frames)).as_ref(),
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

/// The effects of the file with the identified values, their 1σ, and the range of the data.
fn refitted(machine: &Machine, result: &Calibration, measurement: &Measurement) -> Vec<EffectEntry> {
    let on_measurement = machine.instrument_with(&result.identification.own_values());
    let mut effects: Vec<ActiveEffect> =
        effects_of(result.mechanism.as_ref()).iter().cloned().chain(on_measurement).collect();
    effects.iter_mut().for_each(|e| e.range = e.range_over(&measurement.data, machine.condition_kinds()));
    let sigmas: Vec<Vec<f64>> = effects
        .iter()
        .map(|effect| {
            let mine = format!("{}.", effect.label());
            let own = result.parameters.iter().filter(|p| p.spec.name.starts_with(&mine));
            own.map(|p| p.sigma.unwrap_or(f64::NAN)).collect()
        })
        .collect();
    machine.effect_entries(&effects, &sigmas, machine.environment())
}
