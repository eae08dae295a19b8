//! An effect from outside the crate: a leg that grows with the current of its motor.
//!
//! A motor that holds a load is warm, and so is the screw on it. No entry of the catalogue knows of currents; this one reads a
//! column `motor_current` and stands in a diagnosis beside all others. Without it the finding would be "unknown".
//!
//! Run with `cargo run --release --example own_effect`.

use std::error::Error;
use std::sync::Arc;

use paracal::conditions::Conditions;
use paracal::diagnosis::{Diagnosis, Question, diagnose};
use paracal::effect::{ActiveEffect, Effect, EffectParameter, Extended};
use paracal::effect::{AvailableData, EffectContext, Environment, Perturbation, Scan, ScanPoint, Site};
use paracal::files::Machine;
use paracal::measurement::{Dataset, Sample};
use paracal::simulation::{Command, as_dataset, draw_parameters, simulate_run};
use paracal::units::Dimension;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

const CURRENT: &str = "motor_current";

#[derive(Clone, Copy, Debug)]
/// The effect of this example.
pub struct MotorHeat;

impl Effect for MotorHeat {
    fn name(&self) -> &str {
        "motor.heat"
    }
    fn cause(&self) -> &str {
        "one leg grows with the current of its motor"
    }
    fn remedy(&self) -> &str {
        "switch the motor off at standstill, or correct the commanded length by the current"
    }
    fn missing(&self, _: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        if available.has(CURRENT) { Vec::new() } else { vec![CURRENT.into()] }
    }
    fn parameters(&self, _: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("growth_per_ampere", Dimension::Length, 2e-6)]
    }
    fn scan(&self, _: &EffectContext<'_>, _: &AvailableData) -> Scan {
        Scan::Legs
    }
    fn covariates(&self, _: &ScanPoint) -> Vec<String> {
        vec![CURRENT.into()]
    }
    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let (Some(leg), Some(current)) = (at.leg, site.conditions.get(CURRENT)) {
            out.joints[leg] += theta[0] * current;
        }
    }
}

/// A machine with wrong anchors whose leg 3 grows by 1.5 µm per ampere, measured at 80 poses.
pub fn measured(machine: &Machine) -> Result<Dataset, Box<dyn Error>> {
    let (nominal, workspace) = (machine.plain(), machine.workspace.ok_or("the file states a workspace")?);
    let (noise, mut rng) = (machine.noise.ok_or("the file states the noise")?, ChaCha8Rng::seed_from_u64(3));
    let mut command = |_| {
        let mut state = Conditions::unknown();
        state.covariates.insert(CURRENT.into(), rng.random_range(0.5..4.5));
        Command { pose: workspace.random(&mut rng), state }
    };
    let run: Vec<Command> = (0..80).map(&mut command).collect();
    let inner = nominal.with_values(&draw_parameters(nominal, None, &mut rng), nominal.home())?;
    let heat = ActiveEffect {
        effect: Arc::new(MotorHeat),
        at: ScanPoint::leg(2),
        values: vec![1.5e-6],
        range: Default::default(),
    };
    let truth = Extended::new(inner, Arc::new(Environment::default()), vec![heat]);
    let samples = simulate_run(nominal, &truth, &run, None, &machine.convention, &noise, &mut rng)
        .map_err(|(row, cause)| format!("row {row}: {cause}"))?;
    let readings = as_dataset(&samples, &machine.convention, &noise);
    let mut states: Vec<Conditions> = run.into_iter().map(|command| command.state).collect();
    Conditions::put_in_run(&mut states, samples.iter().map(|s| s.joints.clone()).collect(), None);
    let with_state = |(sample, conditions): (&Sample, Conditions)| Sample { conditions, ..sample.clone() };
    Ok(Dataset::new(readings.iter().zip(states).map(with_state).collect(), Arc::clone(readings.model()), noise))
}

/// What the catalogue and the new effect find in the data.
pub fn run(machine: &Machine) -> Result<Diagnosis, Box<dyn Error>> {
    let data = measured(machine)?;
    let mut question = Question::of(machine, &data);
    question.catalogue.push(Arc::new(MotorHeat));
    Ok(diagnose(&question)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Machine::read(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"))?;
    print!("{}", paracal::report::text::diagnosis(&run(&machine)?, machine.mechanism.name()));
    Ok(())
}
