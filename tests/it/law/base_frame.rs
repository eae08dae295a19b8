//! A model of tracker data, brought back to the frame of its drawing: the same machine, seen from elsewhere.

use paracal::files::{Machine, read_measurement};
use paracal::measurement::Sample;
use paracal::mechanism::{ForwardQuery, Mechanism, characteristic_length};
use paracal::pose::Pose;
use paracal::simulation::monte_carlo;

use super::combination::{Combination, Frame, Reading};
use super::{calibrated, read_beside};

/// Where a mechanism goes in the samples.
fn poses(mechanism: &dyn Mechanism, samples: &[Sample]) -> Vec<Pose> {
    let queries: Vec<ForwardQuery<'_>> =
        samples.iter().map(|s| ForwardQuery::new(&s.joints, &s.conditions, mechanism.home())).collect();
    mechanism.forward_batch(mechanism.values(), &queries).into_iter().map(Result::unwrap).collect()
}

/// What two frames agree on of the way from one pose to another: how far the platform turns, and how far it goes along the
/// axis of the turn.
fn turn_and_advance(from: &Pose, to: &Pose) -> [f64; 2] {
    let way = from.inverse().compose(to);
    let turn = way.rotation.scaled_axis();
    [turn.norm(), turn.dot(&way.position)]
}

/// What is wrong with the model of tracker data when it is brought back; `None` if there is no such model.
fn verdict(seed: u64) -> Option<String> {
    let combination = Combination::draw(seed);
    if combination.frame == Frame::Base || combination.reading != Reading::Poses {
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.csv");
    let text = combination.write(&path).ok()?;
    let drawing = Machine::from_text(&text, "m.toml".as_ref()).unwrap();
    let found = calibrated(&text, &path).ok().filter(|found| found.result.verdict.trusted)?;
    let seen = read_beside(&found.text, &path).unwrap();
    let samples: Vec<Sample> = read_measurement(&path, &seen).unwrap().data.iter().cloned().collect();
    let brought = read_beside(&found.text, &path).unwrap().in_base_frame().unwrap();
    let again =
        Machine::from_text(&brought.document().to_text(), "base.toml".as_ref()).unwrap().in_base_frame().unwrap();
    let size = characteristic_length(drawing.plain());
    let home = drawing.plain().home();
    let moved = home.inverse().compose(&brought.plain().home());
    let far = moved.position.norm() / size + moved.rotation.angle();
    let (before, after) = (poses(seen.mechanism.as_ref(), &samples), poses(brought.mechanism.as_ref(), &samples));
    let mut worst: f64 = 0.0;
    for k in 1..samples.len() {
        let (a, b) = (turn_and_advance(&before[0], &before[k]), turn_and_advance(&after[0], &after[k]));
        worst = worst.max((a[0] - b[0]).abs()).max((a[1] - b[1]).abs() / size);
    }
    let twice = poses(again.mechanism.as_ref(), &samples);
    let same = after.iter().zip(&twice).all(|(a, b)| (a.position - b.position).norm() <= 1e-12 * size);
    let problem = format!("{combination}: ways differ by {worst:.1e}, home by {far:.1e}, twice {same}");
    // Only tolerances hold a machine to its drawing, and wrong readings carry it away from there.
    let held = drawing.plain().parameters().iter().all(|p| p.tolerance.is_some()) && drawing.instrument().is_empty();
    Some(if worst > 1e-9 || (held && far > 0.5) || !same { problem } else { String::new() })
}

#[test]
fn a_model_of_tracker_data_is_the_same_machine_in_the_frame_of_its_drawing() {
    let told: Vec<String> = monte_carlo(600, 1, |seed, _| verdict(10_000 + seed)).into_iter().flatten().collect();
    let wrong: Vec<&String> = told.iter().filter(|problem| !problem.is_empty()).collect();
    assert!(told.len() >= 40, "{} were calibrated", told.len());
    assert!(wrong.is_empty(), "{} of {}:\n{wrong:#?}", wrong.len(), told.len());
}
