//! Effects from outside the crate and those of the catalogue, held to the same laws.

// The example beside its `main`.
#[allow(dead_code, missing_docs, unreachable_pub)]
#[path = "../../../examples/own_effect.rs"]
mod example;

use std::sync::Arc;

use crate::common::asked::{Files, said};
use crate::common::hidden::cases::{Kind, draw_in_run};
use crate::common::hidden::effects::CATALOGUE;
use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::diagnosis::{Question, Verdict, diagnose, settle};
use paracal::effect::{
    ActsOn, AvailableData, Catalogue, Effect, EffectContext, EffectParameter, Environment, Perturbation, ScanPoint,
    Site,
};
use paracal::files::{Machine, ReadOptions};
use paracal::units::Dimension;

const TABLE5: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml");

fn table5() -> Machine {
    Machine::read(TABLE5).unwrap()
}

/// With the effect of the example and the condition that it names.
fn table5_with_motors() -> Machine {
    Machine::read_with(TABLE5, &example::reading()).unwrap()
}

/// Twenty rows of a reference run, with all that its columns can tell.
fn reference() -> Files {
    let case = draw_in_run(Kind::Null, 20, 1, 0).unwrap();
    Files::new(&case.mechanism, &case.data)
}

#[test]
fn an_effect_of_a_consumer_is_named_with_its_leg_and_its_value() {
    let machine = table5_with_motors();
    let found = example::run(&machine).unwrap();
    assert_eq!(found.verdict, Verdict::Named, "{}", said(&found));
    let [cause] = &found.causes[..] else { panic!("{}", said(&found)) };
    assert_eq!((cause.effect.as_str(), cause.leg), ("motor.heat", Some(2)), "{}", said(&found));
    let growth = &cause.parameters[0];
    let error = (growth.value - 1.5e-6).abs();
    assert!(error < 4.0 * growth.sigma.unwrap() && error < 0.15 * 1.5e-6, "{growth:?}");
    assert_eq!(found.effects[0].range.keys().collect::<Vec<_>>(), ["motor_current"]);

    // Written, read back, and commanded.
    let text = machine.extended_document(&found).unwrap().to_text();
    let again = Machine::from_text_with(&text, "e.toml".as_ref(), &example::reading()).unwrap();
    let (read, written) = (&again.effects()[0].range["motor_current"], &found.effects[0].range["motor_current"]);
    // A file has fifteen digits.
    assert!(read.iter().zip(written).all(|(r, w)| (r - w).abs() < 1e-13), "{read:?} for {written:?}");
    let (none, four) = (example::commanded(&again, 0.0).unwrap(), example::commanded(&again, 4.0).unwrap());
    for (leg, (none, four)) in none.iter().zip(&four).enumerate() {
        let expected = if leg == 2 { -4.0 * growth.value } else { 0.0 };
        assert!((four - none - expected).abs() < 1e-12, "leg {}: {none} {four}", leg + 1);
    }
    let refused = Machine::from_text(&text, "e.toml".as_ref()).unwrap_err().to_string();
    for part in ["e.toml: effect 1 'motor.heat'", "'motor.heat' is not an effect", "thermal.legs.uniform", "step.leg"] {
        assert!(refused.contains(part), "'{part}' is not in: {refused}");
    }
    // The machine without its effects knows them still.
    assert!(again.without_effects().unwrap().catalogue().get("motor.heat").is_some());
}

#[test]
fn measurements_that_settle_a_tie_with_it_vary_what_it_names() {
    // The current rises through the run, as does whatever else drifts.
    let rising = |row: usize, _: &mut _| 0.5 + 4.0 * row as f64 / (example::ROWS - 1) as f64;
    let unlisted = ReadOptions::default().with_effect(example::MotorHeat);
    let expected = [
        (example::reading(), "12 poses alternating between motor current 0.5 and 4.5"),
        // Of a column without an entry the ends of the run are known.
        (unlisted, "12 poses alternating between motor_current 0.500 and 4.50"),
    ];
    for (reading, expected) in expected {
        let machine = Machine::read_with(TABLE5, &reading).unwrap();
        let data = example::measured_with(&machine, rising).unwrap();
        let question = Question::of(&machine, &data);
        let found = diagnose(&question).unwrap();
        assert_eq!(found.verdict, Verdict::Tied, "{}", said(&found));
        let plans = settle(&question, &found).unwrap();
        let what: Vec<&str> = plans.iter().map(|plan| plan.what.as_str()).collect();
        let plan = plans.iter().find(|plan| plan.what == expected).unwrap_or_else(|| panic!("{what:#?}"));
        let present = plans.last().unwrap();
        assert!(plan.settles() && !present.settles(), "{:#?}", plan.separations);
        let currents: Vec<_> = plan.samples.iter().map(|s| s.conditions.get(example::CURRENT).unwrap()).collect();
        assert_eq!((currents.len(), currents[0], currents[1]), (12, 0.5, 4.5));
    }
}

#[test]
fn a_catalogue_is_a_value() {
    let standard = Catalogue::standard();
    let with = standard.clone().with(example::MotorHeat);
    assert_eq!((standard.len() + 1, standard.get("motor.heat").is_none()), (with.len(), true));
    assert_eq!(with.clone().with(example::MotorHeat).len(), with.len(), "one effect of a name");
    let alone: Catalogue = with.iter().filter(|e| e.name() == "motor.heat").cloned().collect();
    let machine = table5();
    let data = example::measured(&machine).unwrap();
    let found = diagnose(&Question { catalogue: alone, ..Question::of(&machine, &data) }).unwrap();
    assert_eq!((found.causes.len(), found.causes[0].effect.as_str()), (1, "motor.heat"), "{}", said(&found));
    assert!(found.not_found.is_empty() && found.not_testable.is_empty(), "nothing else was looked for");
}

#[test]
fn without_it_the_same_data_are_unknown_over_the_current() {
    let machine = table5();
    let data = example::measured(&machine).unwrap();
    let found = diagnose(&Question::of(&machine, &data)).unwrap();
    let unknown = found.unknown.as_ref().unwrap_or_else(|| panic!("{}", said(&found)));
    assert_eq!((unknown.covariate.as_deref(), unknown.leg), (Some("motor_current"), Some(2)), "{}", said(&found));
    assert!(found.causes.is_empty(), "{}", said(&found));
}

#[test]
fn an_effect_of_a_consumer_conforms() {
    let machine = table5();
    let data = example::measured(&machine).unwrap().subset(&[0, 20, 40, 60]);
    let effect: Arc<dyn Effect> = Arc::new(example::MotorHeat);
    conformance::effect(&effect, machine.plain(), &Environment::default(), &data).unwrap();
}

#[test]
fn the_catalogue_conforms() {
    let files = reference();
    let (mechanism, environment) = (files.machine.plain(), files.machine.environment());
    let data = &files.measurement.data;
    let mut tested: Vec<String> = Vec::new();
    for effect in &Catalogue::standard() {
        match conformance::effect(effect, mechanism, environment, data) {
            Ok(()) => tested.push(effect.name().into()),
            Err(violation) if violation.law == "what an effect needs is there" => {
                let context = EffectContext::new(mechanism, environment);
                let missing = effect.missing(&context, &AvailableData::of(data));
                assert!(!missing.is_empty(), "{}: {violation}", effect.name());
            }
            Err(violation) => panic!("{}: {violation}", effect.name()),
        }
    }
    let mut expected: Vec<&str> = CATALOGUE.iter().map(|known| known.name).collect();
    expected.extend(["joint.screw_coupling", "thermal.frame"]);
    expected.extend(["instrument.scale", "instrument.rotation_gain", "instrument.skew"]);
    expected.sort_unstable();
    tested.sort_unstable();
    assert_eq!(tested, expected);
}

/// An effect that breaks a law.
#[derive(Clone, Copy, Debug)]
enum Broken {
    /// It grows with the square of its parameter.
    Square,
    /// It moves a joint, and says that it moves readings.
    Liar,
    /// It says nothing of a remedy.
    Silent,
    /// Two parameters have one name.
    Doubled,
    /// It changes its mind with the pose so fast that columns mean nothing.
    Wild,
}

impl Effect for Broken {
    fn name(&self) -> &str {
        "broken"
    }

    fn cause(&self) -> &str {
        "it is broken"
    }

    fn remedy(&self) -> &str {
        if matches!(self, Self::Silent) { " " } else { "mend it" }
    }

    fn acts_on(&self) -> ActsOn {
        if matches!(self, Self::Liar) { ActsOn::Measurement } else { ActsOn::Mechanism }
    }

    fn missing(&self, _: &EffectContext<'_>, _: &AvailableData) -> Vec<String> {
        Vec::new()
    }

    fn parameters(&self, _: &EffectContext<'_>) -> Vec<EffectParameter> {
        let count = if matches!(self, Self::Doubled) { 2 } else { 1 };
        vec![EffectParameter::new("growth", Dimension::Length, 1e-5); count]
    }

    fn covariates(&self, _: &ScanPoint) -> Vec<String> {
        Vec::new()
    }

    fn perturb(&self, theta: &[f64], _: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        out.joints[0] += match self {
            Self::Square => theta[0] * theta[0],
            Self::Wild => theta[0] * (1e5 * site.pose.position.z).sin(),
            _ => theta[0],
        };
    }
}

#[test]
fn what_breaks_a_law_is_caught_and_told() {
    let files = reference();
    let law = |effect: Broken| {
        let effect: Arc<dyn Effect> = Arc::new(effect);
        let machine = &files.machine;
        conformance::effect(&effect, machine.plain(), machine.environment(), &files.measurement.data)
            .expect_err("it is broken")
            .to_string()
    };
    for (effect, parts) in [
        (Broken::Square, ["an effect is linear in its parameters", "sum of its parameters"]),
        (Broken::Liar, ["an effect acts on what it says", "Measurement"]),
        (Broken::Silent, ["an effect says what it is", "its remedy is empty"]),
        (Broken::Doubled, ["an effect says what it is", "two parameters are called growth"]),
        (Broken::Wild, ["columns agree with forward kinematics", "columns say"]),
    ] {
        let said = law(effect);
        for part in parts {
            assert!(said.contains(part), "{effect:?}: '{part}' is not in: {said}");
        }
    }
}

#[test]
fn an_effect_of_the_catalogue_does_nothing_where_nothing_is_known() {
    let files = reference();
    let machine = &files.machine;
    let (mechanism, joints) = (machine.plain(), &files.measurement.data.sample(3).joints);
    let context = EffectContext::new(mechanism, machine.environment());
    let nothing = Conditions::unknown();
    let pose = mechanism.forward(mechanism.values(), joints, &nothing, &mechanism.home()).unwrap();
    let mut block = paracal::mechanism::MotionBlock::sized_for(mechanism);
    mechanism.motion_block(mechanism.values(), joints, &pose, &nothing, &mut block).unwrap();
    for effect in &Catalogue::standard() {
        let depends = !effect.covariates(&ScanPoint::leg(0)).is_empty();
        let lengths = effect.covariates(&ScanPoint::leg(0)).iter().all(|c| c.starts_with("length_leg"));
        if !depends || lengths {
            continue;
        }
        let site = Site {
            context: &context,
            values: mechanism.values(),
            joints,
            pose: &pose,
            conditions: &nothing,
            joint_motion: &block.joints,
        };
        let mut out = Perturbation::sized(mechanism.values().len(), joints.len());
        let theta: Vec<f64> = effect.parameters(&context).iter().map(|p| p.scale).collect();
        let at = ScanPoint { row: Some(1), covariate: Some("temp_base".into()), ..ScanPoint::leg(0) };
        effect.perturb(&theta, &at, &site, &mut out);
        let all = out.parameters.iter().chain(&out.joints).chain(out.pose.iter());
        assert!(all.into_iter().all(|v| *v == 0.0), "{}: {out:?}", effect.name());
    }
}
