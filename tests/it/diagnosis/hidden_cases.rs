//! The generator of blind cases, held to what others published: poses, detection limits, and its own laws.

use crate::common::hidden;

use crate::common::hidden::cases::{Kind, draw};
use crate::common::hidden::effects::{CATALOGUE, Scan, measured};
use crate::common::hidden::hexapod::{Geometry, Pose};
use crate::common::hidden::limits::{Limits, noncentrality};
use crate::common::hidden::mistakes::FORMS;
use crate::common::hidden::run::{Run, Weather};
use paracal::files::{Machine, read_measurement};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

fn numbers(file: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(format!("{}/examples/data/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

#[test]
fn its_forward_kinematics_meets_the_reference_poses() {
    let errors: Vec<f64> = numbers("hardpoint-errors.csv").iter().flat_map(|row| row[1..].to_vec()).collect();
    let machine = Geometry::nominal().changed(&std::array::from_fn(|k| 1e-3 * errors[k]));
    let home = machine.home().unwrap();
    for row in numbers("hardpoint-exact.csv") {
        let lengths = std::array::from_fn(|i| 1e-3 * row[i]);
        // The corners are far from home: half way first.
        let half = machine.reach(&lengths.map(|l: f64| 0.5 * (l + 0.8)), home, |_| Default::default()).unwrap();
        let pose = machine.reach(&lengths, half, |_| Default::default()).unwrap().coordinates();
        for k in 0..6 {
            let found = if k < 3 { 1e3 * pose[k] } else { pose[k].to_degrees() };
            assert!((found - row[6 + k]).abs() < 1e-9, "{found} {}", row[6 + k]);
        }
    }
}

/// First parameter alone, 120 poses in ±10 mm and ±0.5°: ppm/K, ppm, µm/mm², µm, nm/N, mm.
const PUBLISHED: [(&str, f64, f64); 19] = [
    ("thermal.legs.uniform", 0.171, 1e-6),
    ("thermal.legs.individual", 0.166, 1e-6),
    ("thermal.leg.single", 0.521, 1e-6),
    ("thermal.platform", 3.6, 1e-6),
    ("thermal.base", 0.421, 1e-6),
    ("scale.common", 49.9, 1e-6),
    ("scale.per_leg", 198.0, 1e-6),
    ("length.quadratic", 0.0098, 1.0),
    ("cyclic.pitch", 1.6, 1e-6),
    ("backlash", 2.33, 1e-6),
    ("compliance.gravity", 0.581, 1e-9),
    ("compliance.payload", 2.37, 1e-9),
    ("sag.frame", 1.51, 1e-6),
    ("sag.platform", 4.32, 1e-6),
    ("joint.pivot_shift", 2.35, 1e-3),
    ("drift.frame", 2.04, 1e-6),
    ("drift.leg", 3.3, 1e-6),
    ("step.frame", 1.36, 1e-6),
    ("step.leg", 2.23, 1e-6),
];

#[test]
fn its_detection_limits_are_the_published_ones() {
    let mut means = [0.0; 19];
    let draws = 20;
    for seed in 0..draws {
        let run = Run::draw(120, Weather::Reference, &mut ChaCha8Rng::seed_from_u64(seed));
        let limits = Limits::of(&run).unwrap();
        for (mean, known) in means.iter_mut().zip(&CATALOGUE) {
            let leg = matches!(known.scan, Scan::Leg | Scan::LegAndRow).then_some(0);
            let row = matches!(known.scan, Scan::Row | Scan::LegAndRow).then_some(60);
            let s = limits.information(known, leg, row).unwrap();
            *mean += known.scale[0] * limits.at_limit(known) / s[(0, 0)].sqrt() / draws as f64;
        }
    }
    for ((name, limit, unit), (mean, known)) in PUBLISHED.iter().zip(means.iter().zip(&CATALOGUE)) {
        assert_eq!(*name, known.name);
        let ratio = mean / (limit * unit);
        println!("{name:<26} {:>9.4}  published {limit:>7}  ratio {ratio:.3}", mean / unit);
        assert!((0.88..1.12).contains(&ratio), "{name}: {mean} against {limit}");
    }
}

#[test]
fn a_limit_has_the_power_that_defines_it() {
    // Non-central χ² against its own simulation: normal variables, one of them shifted.
    let (p, level) = (3, 0.01);
    let lambda = noncentrality(p, level);
    let critical = 11.344_866_730_144_37; // χ² with 3 degrees of freedom exceeds it once in a hundred
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let n = 40_000;
    let seen = (0..n).filter(|_| {
        let mut z: Vec<f64> = (0..p).map(|_| hidden::run::normal(&mut rng)).collect();
        z[0] += lambda.sqrt();
        z.iter().map(|z| z * z).sum::<f64>() > critical
    });
    let power = seen.count() as f64 / f64::from(n);
    assert!((power - 0.95).abs() < 0.005, "{power}");
}

#[test]
fn effects_of_size_zero_are_none_and_gravity_is_carried() {
    let run = Run::draw(12, Weather::Reference, &mut ChaCha8Rng::seed_from_u64(2));
    let nominal = Geometry::nominal();
    for (q, row) in measured(&nominal, &run, &[]).unwrap().iter().zip(&run.rows) {
        // Commands come from nominal inverse kinematics, which an undisturbed nominal machine meets.
        let back = nominal.lengths(&Pose::of(*q));
        assert!((0..6).all(|i| (back[i] - row.commanded[i]).abs() < 1e-14));
        // The vertical parts of the axial forces carry the weight.
        let state = nominal.state(Pose::of(*q));
        let forces = hidden::effects::axial_forces(&state, 500.0, 0.15, row.gravity());
        let carried: f64 = (0..6).map(|i| forces[i] * state.along[i].z).sum();
        assert!((carried + 500.0 * 9.81 * row.elevation.sin()).abs() < 1e-9, "{carried}");
    }
}

#[test]
fn a_case_is_always_the_same_and_the_program_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let kinds =
        [Kind::Null, Kind::Outliers(0.05), Kind::Two(3.0), Kind::Outside(3.0), Kind::WarmUp(3.0), Kind::Noise(2.0)];
    for kind in kinds {
        let case = draw(kind, 5, 3).unwrap();
        assert_eq!(case.data, draw(kind, 5, 3).unwrap().data);
        assert_ne!(case.data, draw(kind, 5, 4).unwrap().data);
        let (machine, data) = (folder.path().join("mechanism.toml"), folder.path().join("data.csv"));
        std::fs::write(&machine, &case.mechanism).unwrap();
        std::fs::write(&data, &case.data).unwrap();
        let machine = Machine::read(&machine).unwrap();
        assert_eq!(read_measurement(&data, &machine).unwrap().data.len(), 120);
    }
    for (number, form) in FORMS.iter().enumerate() {
        let case = draw(Kind::Misread, 5, number).unwrap();
        assert_eq!(case.truth.reading.as_deref(), Some(form.0));
    }
}
