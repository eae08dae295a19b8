//! An effect from outside the crate: a leg that grows with the current of its motor.
//!
//! A motor that holds a load is warm, and so is the screw on it. No standard effect knows of currents; this one reads a
//! column `motor_current`. From the catalogue that the mechanism file is read with it goes all the way: it is diagnosed,
//! written to the extended file, read back from there, and commanded. Without it the finding would be "unknown".
//!
//! Run with `cargo run --release --example own_effect`.

use std::error::Error;
use std::sync::Arc;

use paracal::conditions::{ConditionKind, Conditions, Variation};
use paracal::diagnosis::{Diagnosis, Question, diagnose};
use paracal::effect::{ActiveEffect, Compensator, Effect, EffectParameter, Extended};
use paracal::effect::{AvailableData, EffectContext, Environment, Perturbation, Scan, ScanPoint, Site};
use paracal::files::{Machine, ReadOptions};
use paracal::measurement::{Dataset, Sample};
use paracal::simulation::{Command, as_dataset, draw_parameters, simulate_run};
use paracal::units::Dimension;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// The column of the current, A.
pub const CURRENT: &str = "motor_current";
/// Rows of the run.
pub const ROWS: usize = 80;

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

/// What the mechanism file is read with: the standard effects and conditions, the effect of this example, and the condition
/// that it names. The entry of the condition says how further measurements may vary it; without one the column would be
/// read all the same.
pub fn reading() -> ReadOptions {
    let current = ConditionKind::new(CURRENT, Dimension::None, "motor current");
    let current = current.varied(Variation::Evenly([0.5, 4.5]));
    ReadOptions::default().with_effect(MotorHeat).with_condition(current)
}

/// A machine with wrong anchors whose leg 3 grows by 1.5 µm per ampere, measured at 80 poses with currents between 0.5 and
/// 4.5 A.
pub fn measured(machine: &Machine) -> Result<Dataset, Box<dyn Error>> {
    measured_with(machine, |_, rng| rng.random_range(0.5..4.5))
}

/// The same with the current of each row.
pub fn measured_with(
    machine: &Machine,
    current: impl Fn(usize, &mut ChaCha8Rng) -> f64,
) -> Result<Dataset, Box<dyn Error>> {
    let (nominal, workspace) = (machine.plain(), machine.workspace.ok_or("the file states a workspace")?);
    let (noise, mut rng) = (machine.noise.ok_or("the file states the noise")?, ChaCha8Rng::seed_from_u64(3));
    let mut command = |row| {
        let mut state = Conditions::unknown();
        state.covariates.insert(CURRENT.into(), current(row, &mut rng));
        Command { pose: workspace.random(&mut rng), state }
    };
    let run: Vec<Command> = (0..ROWS).map(&mut command).collect();
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

/// What the effects of the machine's catalogue explain in the data.
pub fn run(machine: &Machine) -> Result<Diagnosis, Box<dyn Error>> {
    Ok(diagnose(&Question::of(machine, &measured(machine)?))?)
}

/// The lengths to command for home with this current in the motors.
pub fn commanded(machine: &Machine, current: f64) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut state = Conditions::unknown();
    state.covariates.insert(CURRENT.into(), current);
    let effects = machine.effects();
    let mut compensator = Compensator::new(machine.plain(), machine.environment(), &effects, false)?;
    Ok(compensator.command(&machine.mechanism.home(), &state)?.joints)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml");
    let machine = Machine::read_with(path, &reading())?;
    let found = run(&machine)?;
    print!("{}", paracal::report::text::diagnosis(&found, machine.mechanism.name()));

    let extended = machine.extended_document(&found)?.to_text();
    println!("\nThe extended file ends with\n{}", &extended[extended.find("[[effect]]").unwrap_or(0)..]);
    let extended = Machine::from_text_with(&extended, "extended.toml".as_ref(), &reading())?;
    let (cold, warm) = (commanded(&extended, 0.0)?, commanded(&extended, 4.0)?);
    println!("At 4 A leg 3 is commanded {:.2} um shorter than at none.", 1e6 * (cold[2] - warm[2]));
    Ok(())
}
