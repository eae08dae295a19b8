//! A mechanism that wraps one with effects and hands on what is around it.

use std::sync::Arc;

use crate::common;
use crate::common::effects::{hexapod, read, state};
use crate::common::wrapped::Wrapped;
use paracal::conditions::Conditions;
use paracal::diagnosis::Question;
use paracal::effect::{effects_of, without_effects};
use paracal::files::Machine;
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, PriorPolicy, calibrate, evaluate};
use paracal::measurement::{DataRow, Dataset, Frames, Noise, PoseMeasurement, Sample};
use paracal::pose::{Pose, PoseConvention};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

const SCALE: f64 = 8e-4;

fn machine_with(scale: f64) -> Machine {
    let entry = format!("\n[[effect]]\nname = \"scale.common\"\nparameters = {{ scale = {scale:e} }}\n");
    read(&hexapod("", &entry))
}

fn renamed(mut machine: Machine) -> Machine {
    let plain = machine.plain();
    let copy = plain.with_values(plain.values(), plain.home()).unwrap();
    let inner = std::mem::replace(&mut machine.mechanism, copy);
    machine.mechanism = Box::new(Wrapped::around(inner));
    machine
}

/// Exact readings of the machine with its effect.
fn measured() -> Dataset {
    let machine = machine_with(SCALE);
    let (truth, plain) = (machine.mechanism.as_ref(), machine.plain());
    let workspace = common::workspace(plain, 60.0, 4.0);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut sample = |row| {
        let pose = workspace.random(&mut rng);
        let joints = plain.inverse(plain.values(), &pose, &Conditions::unknown()).unwrap();
        let conditions = state(&joints);
        let went = truth.forward(truth.values(), &joints, &conditions, &pose).unwrap();
        (Sample { id: None, row: DataRow(row), joints, conditions }, went)
    };
    let (samples, went): (Vec<Sample>, Vec<Pose>) = (0..30).map(&mut sample).unzip();
    let noise = Noise::stated(1e-6, 1e-6);
    let model = PoseMeasurement::full(PoseConvention::default(), &went, noise.position, noise.rotation);
    Dataset::new(samples, Arc::new(model), noise)
}

#[test]
fn a_wrapper_keeps_the_effects_of_what_it_wraps() {
    let data = measured();
    let machine = renamed(machine_with(SCALE));
    let mechanism = machine.mechanism.as_ref();
    let (all, plain) = (mechanism.parameters().len(), machine.plain().parameters().len());
    assert_eq!((mechanism.name(), effects_of(mechanism).len(), all - plain), ("renamed", 1, 1));
    assert_eq!(machine.effects()[0].values, [SCALE]);
    assert!(effects_of(without_effects(mechanism)).is_empty());
    // The readings hold it, so that it must act.
    let errors = evaluate(mechanism, &[], &data).unwrap().rms();
    assert!(errors.position.unwrap() < 1e-12, "{errors:?}");
    // What is looked for in data is looked for beside the mechanism without it.
    assert_eq!(Question::of(&machine, &data).mechanism.parameters().len(), plain);
}

#[test]
fn what_is_calibrated_through_a_wrapper_is_written_with_its_effects() {
    let data = measured();
    let machine = renamed(machine_with(0.0));
    let options = CalibrationOptions { prior: PriorPolicy::None, ..CalibrationOptions::default() };
    let identifier = LevenbergMarquardt::default();
    let result = calibrate(machine.mechanism.as_ref(), &data, None, &identifier, &options).unwrap();
    assert_eq!(result.mechanism.name(), "renamed");
    let [found] = effects_of(result.mechanism.as_ref()) else { panic!("the effect is lost") };
    assert!((found.values[0] - SCALE).abs() < 1e-9, "{:?}", found.values);
    let document = machine.document_of(result.mechanism.as_ref(), None, &Frames::default()).unwrap();
    let again = read(&document.to_text());
    assert_eq!(again.effects().len(), 1);
    let errors = evaluate(again.mechanism.as_ref(), &[], &data).unwrap().rms();
    assert!(errors.position.unwrap() < 1e-9, "{errors:?}");
}
