//! A kind of condition from outside the crate: one entry, which readers, campaigns, effects and `settle` take.

use crate::common::asked::said;
use crate::common::path;
use paracal::conditions::{ConditionKind, Conditions, Variation, of_leg};
use paracal::diagnosis::{Question, Verdict, diagnose, settle};
use paracal::effect::{AvailableData, Effect, EffectContext, EffectParameter, Perturbation, Scan, ScanPoint, Site};
use paracal::files::{FileError, Machine, Measurement, ReadOptions, read_conditions, read_measurement};
use paracal::measurement::{DataRow, Dataset, PoseMeasurement, Sample};
use paracal::pose::Pose;
use paracal::units::Dimension;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const FORCE: &str = "force_leg";

/// A leg that gives way under its own force.
#[derive(Clone, Copy, Debug)]
struct SoftLeg;

impl Effect for SoftLeg {
    fn name(&self) -> &str {
        "soft.leg"
    }
    fn cause(&self) -> &str {
        "one leg gives way under its force"
    }
    fn remedy(&self) -> &str {
        "stiffen that leg"
    }
    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        (0..context.joints()).map(|leg| of_leg(FORCE, leg)).filter(|name| !available.has(name)).collect()
    }
    fn parameters(&self, _: &EffectContext<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("compliance", Dimension::Compliance, 1e-7)]
    }
    fn scan(&self, _: &EffectContext<'_>, _: &AvailableData) -> Scan {
        Scan::Legs
    }
    fn covariates(&self, at: &ScanPoint) -> Vec<String> {
        at.leg.map(|leg| of_leg(FORCE, leg)).into_iter().collect()
    }
    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        let Some(leg) = at.leg else { return };
        if let Some(force) = site.conditions.get(&of_leg(FORCE, leg)) {
            out.joints[leg] += theta[0] * force;
        }
    }
}

fn machine() -> Machine {
    let force = ConditionKind::new(FORCE, Dimension::Force, "force").each_leg().varied(Variation::Evenly([0.0, 200.0]));
    let humidity = ConditionKind::new("humidity", Dimension::None, "humidity").varied(Variation::Steps(vec![0.3, 0.6]));
    let reading = ReadOptions::default().with_effect(SoftLeg).with_condition(force).with_condition(humidity);
    Machine::read_with(path("mechanisms/table5.toml"), &reading).unwrap()
}

/// A measurement at home with one further column.
fn measured(machine: &Machine, column: &str) -> Result<Measurement, FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let legs: String = (1..=6).map(|leg| format!("leg{leg}_mm,")).collect();
    let text =
        format!("{legs}x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,{column}\n800,800,800,800,800,800,0,0,475.7,0,0,0,40\n");
    std::fs::write(&path, text).unwrap();
    read_measurement(&path, machine)
}

#[test]
fn its_column_is_read_with_its_unit() {
    let machine = machine();
    let read = measured(&machine, "force_leg3_N").unwrap();
    assert_eq!(read.data.sample(0).conditions.get("force_leg3"), Some(40.0));
    for (column, parts) in [
        ("force_leg3", ["the name must end in a unit (N)", "'force_leg3_N'"]),
        ("force_leg3_lbf", ["the name must end in a unit (N)", "'force_leg3_N'"]),
        ("force_leg3_mm", ["'mm' is not a unit for it", "N"]),
    ] {
        let said = measured(&machine, column).unwrap_err().to_string();
        for part in parts {
            assert!(said.contains(part), "{column}: '{part}' is not in: {said}");
        }
    }
    // Without the entry it is a number like any other.
    let plain = Machine::read(path("mechanisms/table5.toml")).unwrap();
    let read = measured(&plain, "force_leg3").unwrap();
    assert_eq!(read.data.sample(0).conditions.get("force_leg3"), Some(40.0));
}

#[test]
fn planned_campaigns_vary_it() {
    let machine = machine();
    let states = machine.reference_conditions(60);
    for name in (0..6).map(|leg| of_leg(FORCE, leg)) {
        let values: Vec<f64> = states.iter().map(|s| s.get(&name).unwrap()).collect();
        let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
        assert!((0.0..20.0).contains(&least) && (180.0..200.0).contains(&most), "{name}: {least} to {most}");
    }
    let differs = |s: &Conditions| (s.get("force_leg1").unwrap() - s.get("force_leg2").unwrap()).abs() > 1.0;
    assert!(states.iter().filter(|s| differs(s)).count() > 50, "the legs go together");
    assert!(states.iter().all(|s| [0.3, 0.6].contains(&s.get("humidity").unwrap())));
    let words = machine.reference_conditions_in_words();
    assert!(words.ends_with("payload 0, 50 or 100 kg, force 0 to 200 N, humidity 0.3 or 0.6"), "{words}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.csv");
    std::fs::write(&path, "force_leg1_N,humidity\n12.5,0.4\n").unwrap();
    let planned = read_conditions(&path, &machine).unwrap();
    assert_eq!((planned.states[0].get("force_leg1"), planned.states[0].get("humidity")), (Some(12.5), Some(0.4)));
}

/// A run in which leg 3 gives way under a force that rises as time passes.
fn run(machine: &Machine) -> Dataset {
    const ROWS: usize = 80;
    let (plain, noise) = (machine.plain(), machine.noise.unwrap());
    let workspace = machine.workspace.unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let poses: Vec<Pose> = (0..ROWS).map(|_| workspace.random(&mut rng)).collect();
    let at = Conditions::unknown();
    let joints: Vec<Vec<f64>> = poses.iter().map(|p| plain.inverse(plain.values(), p, &at).unwrap()).collect();
    let force = |row: usize| 200.0 * row as f64 / (ROWS - 1) as f64;
    let state = |row: usize| {
        let mut state = Conditions::unknown();
        state.covariates.extend((0..6).map(|leg| (of_leg(FORCE, leg), force(row) * (1.0 - 0.1 * leg as f64))));
        state
    };
    let mut states: Vec<Conditions> = (0..ROWS).map(state).collect();
    Conditions::put_in_run(&mut states, joints.clone(), None);
    let mut reading = |row: usize| {
        let mut moved = joints[row].clone();
        moved[2] += 1e-7 * states[row].get("force_leg3").unwrap();
        let pose = plain.forward(plain.values(), &moved, &at, &poses[row]).unwrap();
        let mut draw = |sigma: f64| Normal::new(0.0, sigma).unwrap().sample(&mut rng);
        let error = [noise.position, noise.position, noise.position, noise.rotation, noise.rotation, noise.rotation];
        pose.moved(&error.map(&mut draw).into())
    };
    let readings: Vec<Pose> = (0..ROWS).map(&mut reading).collect();
    let samples = joints.iter().zip(&states).enumerate();
    let sample = |(row, (joints, conditions)): (usize, (&Vec<f64>, &Conditions))| Sample {
        id: None,
        row: DataRow(row),
        joints: joints.clone(),
        conditions: conditions.clone(),
    };
    let model = PoseMeasurement::full(machine.convention, &readings, noise.position, noise.rotation);
    Dataset::new(samples.map(sample).collect(), std::sync::Arc::new(model), noise)
}

#[test]
fn an_effect_names_it_and_settling_a_tie_varies_it() {
    let machine = machine();
    let data = run(&machine);
    let question = Question::of(&machine, &data);
    let found = diagnose(&question).unwrap();
    assert_eq!(found.verdict, Verdict::Tied, "{}", said(&found));
    let names = found.causes.iter().flat_map(|c| c.tied_with.iter().map(|r| &r.effect).chain([&c.effect]));
    assert!(names.collect::<Vec<_>>().contains(&&"soft.leg".to_owned()), "{}", said(&found));
    let plans = settle(&question, &found).unwrap();
    let what: Vec<&str> = plans.iter().map(|plan| plan.what.as_str()).collect();
    for expected in [
        "12 poses alternating between force 0 N and 200 N",
        "12 poses alternating between force 0 N and 200 N at leg 3 only",
    ] {
        let plan = plans.iter().find(|plan| plan.what == expected).unwrap_or_else(|| panic!("{what:#?}"));
        assert!(plan.settles(), "{expected}: {:#?}", plan.separations);
    }
    assert!(!plans.last().unwrap().settles(), "{:#?}", plans.last().unwrap().separations);
}
