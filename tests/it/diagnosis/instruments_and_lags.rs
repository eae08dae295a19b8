//! What is not wrong with the machine, what comes late, and what could not be measured: disturbances written here, on
//! machines and runs drawn blind.

use crate::common::asked::{asked, said};
use crate::common::hidden::effects::{At, Influence, Planted, measured};
use crate::common::hidden::hexapod::{Disturbance, Geometry, Pose, State};
use crate::common::hidden::limits::NOISE;
use crate::common::hidden::run::{Run, Weather, normal};
use crate::common::hidden::text::{Sheet, mechanism};
use nalgebra::Vector3;
use paracal::diagnosis::{Diagnosis, Verdict};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// The text of a measurement of a drawn machine with these influences.
fn measurement(seed: u64, make: impl Fn(&Run) -> Vec<Box<dyn Influence>>) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let run = Run::draw(120, Weather::Reference, &mut rng);
    let errors: [f64; 42] = std::array::from_fn(|_| 0.5e-3 * normal(&mut rng));
    let influences = make(&run);
    let all: Vec<&dyn Influence> = influences.iter().map(AsRef::as_ref).collect();
    let mut poses = measured(&Geometry::nominal().changed(&errors), &run, &all).unwrap();
    for pose in &mut poses {
        (0..6).for_each(|k| pose[k] += NOISE[usize::from(k >= 3)] * normal(&mut rng));
    }
    Sheet::of(run, poses).csv()
}

fn diagnosed(seed: u64, influence: &(impl Influence + 'static + Clone)) -> Diagnosis {
    asked(&mechanism(), &measurement(seed, |_| vec![Box::new(influence.clone())]))
}

/// Names and their rivals.
fn mentioned(found: &Diagnosis) -> Vec<&str> {
    let rivals = found.causes.iter().flat_map(|c| c.tied_with.iter().map(|r| r.effect.as_str()));
    found.causes.iter().map(|c| c.effect.as_str()).chain(rivals).collect()
}

fn value(found: &Diagnosis, effect: &str, parameter: &str) -> Option<f64> {
    let cause = found.causes.iter().find(|c| c.effect == effect)?;
    cause.parameters.iter().find(|p| p.name == parameter).map(|p| p.value)
}

/// A reading that is changed where it is read.
#[derive(Clone, Copy)]
enum Misreads {
    /// The frame moves along z and turns about x with the temperature of the base, per kelvin.
    Frame { z: f64, rx: f64 },
    /// Positions by factors.
    Scale([f64; 3]),
    /// Angles by factors.
    Gain([f64; 3]),
    /// x leans towards y.
    Skew(f64),
}

impl Influence for Misreads {
    fn disturb(&self, _: &At<'_>, _: &State, _: &mut Disturbance) {}

    fn carry(&self, at: &At<'_>, pose: Pose) -> Pose {
        let mut q = pose.coordinates();
        match *self {
            Self::Frame { z, rx } => {
                let warm = at.run.rows[at.k].temp_base - at.run.mean_of_base;
                return pose.carried(Vector3::new(0.0, 0.0, z * warm), Vector3::new(rx * warm, 0.0, 0.0));
            }
            Self::Scale(k) => (0..3).for_each(|i| q[i] *= 1.0 + k[i]),
            Self::Gain(k) => (0..3).for_each(|i| q[3 + i] *= 1.0 + k[i]),
            Self::Skew(s) => q[0] += s * q[1],
        }
        Pose::of(q)
    }
}

#[test]
fn a_frame_that_follows_a_temperature_is_named_or_tied_with_growth() {
    for seed in 0..6 {
        let found = diagnosed(seed, &Misreads::Frame { z: 6e-6, rx: 0.0 });
        assert!(mentioned(&found).contains(&"thermal.frame"), "{seed}: {}", said(&found));
        let found = diagnosed(seed + 50, &Misreads::Frame { z: 0.0, rx: 4e-6 });
        assert_eq!(found.causes[0].effect, "thermal.frame", "{seed}: {}", said(&found));
        assert_eq!(found.causes[0].of.as_deref(), Some("temp_base"));
        let turn = value(&found, "thermal.frame", "rx").unwrap();
        assert!((turn / 4e-6 - 1.0).abs() < 0.1, "{turn}");
    }
}

#[test]
fn an_axis_that_is_read_wrongly_is_named_with_its_factor() {
    for seed in 0..4 {
        let sign = if seed % 2 == 0 { 1.0 } else { -1.0 };
        let axis = (seed % 3) as usize;
        let mut factors = [0.0; 3];
        factors[axis] = sign * 2.5e-3;
        let found = diagnosed(100 + seed, &Misreads::Gain(factors));
        let name = ["rx", "ry", "rz"][axis];
        let gain = value(&found, "instrument.rotation_gain", name).unwrap_or_else(|| panic!("{}", said(&found)));
        assert!((gain / factors[axis] - 1.0).abs() < 0.3, "{gain}: {}", said(&found));
        factors[axis] = sign * 1.5e-3;
        let found = diagnosed(200 + seed, &Misreads::Scale(factors));
        let name = ["x", "y", "z"][axis];
        let scale = value(&found, "instrument.scale", name).unwrap_or_else(|| panic!("{}", said(&found)));
        assert!((scale / factors[axis] - 1.0).abs() < 0.3, "{scale}: {}", said(&found));
        let found = diagnosed(300 + seed, &Misreads::Skew(sign * 1.5e-3));
        assert!(mentioned(&found).contains(&"instrument.skew"), "{}", said(&found));
    }
}

#[test]
fn a_common_scale_of_readings_and_one_of_joints_are_tied() {
    for seed in 0..3 {
        let found = diagnosed(400 + seed, &Misreads::Scale([8e-4; 3]));
        for name in ["instrument.scale", "scale.common"] {
            assert!(mentioned(&found).contains(&name), "{name}: {}", said(&found));
        }
        let common = Planted { name: "scale.common", leg: None, row: None, theta: vec![-8e-4] };
        let found = diagnosed(450 + seed, &common);
        for name in ["instrument.scale", "scale.common"] {
            assert!(mentioned(&found).contains(&name), "{name}: {}", said(&found));
        }
    }
}

/// Legs that follow their mean temperature late.
struct Late {
    expansion: f64,
    course: Vec<f64>,
}

impl Late {
    /// `lag dy/dt = x - y` from equilibrium, in small steps along the straight lines between the rows.
    fn of(run: &Run, expansion: f64, lag: f64) -> Self {
        const STEPS: usize = 2000;
        let x: Vec<f64> = run.rows.iter().map(|row| row.temp_legs.iter().sum::<f64>() / 6.0).collect();
        let mean = run.mean_of_legs.iter().sum::<f64>() / 6.0;
        let mut y = x[0];
        let mut course = vec![y - mean];
        for k in 1..x.len() {
            let dt = (run.rows[k].time - run.rows[k - 1].time) / STEPS as f64;
            for i in 0..STEPS {
                let at = (i as f64 + 0.5) / STEPS as f64;
                y += dt / lag * (x[k - 1] + (x[k] - x[k - 1]) * at - y);
            }
            course.push(y - mean);
        }
        Self { expansion, course }
    }
}

impl Influence for Late {
    fn disturb(&self, at: &At<'_>, _: &State, out: &mut Disturbance) {
        let row = &at.run.rows[at.k];
        (0..6).for_each(|i| out.leg[i] += self.expansion * row.commanded[i] * self.course[at.k]);
    }
}

#[test]
fn legs_that_follow_late_are_named_with_their_time_constant() {
    for (seed, lag) in [(500, 1800.0), (501, 3000.0), (502, 1200.0), (503, 7000.0)] {
        let data = measurement(seed, |run| vec![Box::new(Late::of(run, 8e-6, lag))]);
        let found = asked(&mechanism(), &data);
        assert!(matches!(found.verdict, Verdict::Named | Verdict::Tied), "{}", said(&found));
        let causes: Vec<_> = found.causes.iter().map(|c| (&c.effect, c.lag, c.size_over_limit)).collect();
        assert_eq!(causes.len(), 1, "{lag}: {causes:?} {}", said(&found));
        let cause = &found.causes[0];
        assert_eq!(cause.effect, "thermal.legs.uniform", "{}", said(&found));
        let ratio = cause.lag.unwrap_or_else(|| panic!("{}", said(&found))) / lag;
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
        let expansion = cause.parameters[0].value;
        assert!((expansion / 8e-6 - 1.0).abs() < 0.06, "{expansion}");
        assert!(cause.plausible);
    }
}

#[test]
fn legs_that_follow_at_once_have_no_lag() {
    for seed in 0..3 {
        let legs = Planted { name: "thermal.legs.individual", leg: None, row: None, theta: vec![6e-6] };
        let found = diagnosed(600 + seed, &legs);
        assert_eq!(found.causes[0].effect, "thermal.legs.individual", "{}", said(&found));
        assert_eq!(found.causes[0].lag, None);
    }
}

/// The text without the cells of a column that `gap` says, or without the whole column.
fn without(csv: &str, column: &str, gap: impl Fn(usize) -> bool) -> String {
    let at = csv.lines().next().unwrap().split(',').position(|name| name == column).unwrap();
    let cut = |(k, line): (usize, &str)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if k > 0 && gap(k - 1) {
            cells[at] = "";
        }
        cells.join(",") + "\n"
    };
    csv.lines().enumerate().map(cut).collect()
}

#[test]
fn gaps_in_two_columns_leave_their_effects_in_the_question() {
    let legs = Planted { name: "thermal.legs.uniform", leg: None, row: None, theta: vec![6e-6] };
    for seed in 0..3 {
        let data = measurement(700 + seed, |_| vec![Box::new(legs.clone())]);
        let data = without(&data, "temp_leg2_degC", |k| k % 9 == 4);
        let data = without(&data, "elevation_deg", |k| k % 8 == 1);
        let found = asked(&mechanism(), &data);
        assert!(mentioned(&found).contains(&"thermal.legs.uniform"), "{}", said(&found));
        assert!(!found.causes.iter().any(|c| c.effect == "thermal.base"), "{}", said(&found));
        assert!(found.warnings.iter().any(|w| w.contains("left out")), "{:?}", found.warnings);
    }
}

/// The text without a column.
fn cut(csv: &str, column: &str) -> String {
    let at = csv.lines().next().unwrap().split(',').position(|name| name == column).unwrap();
    let kept = |line: &str| {
        let cells = line.split(',').enumerate().filter(|(k, _)| *k != at).map(|(_, cell)| cell);
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    csv.lines().map(kept).collect()
}

#[test]
fn a_cause_whose_sensor_is_missing_is_not_excluded() {
    for seed in 0..4 {
        let payload = Planted { name: "compliance.payload", leg: None, row: None, theta: vec![3e-8] };
        let data = cut(&measurement(800 + seed, |_| vec![Box::new(payload.clone())]), "payload_kg");
        let found = asked(&mechanism(), &data);
        for cause in &found.causes {
            assert!(cause.not_excluded.iter().any(|n| n == "compliance.payload"), "{}", said(&found));
            assert!(cause.tentative);
        }
    }
    // What nothing imitates is not put in doubt.
    let backlash =
        Planted { name: "backlash", leg: None, row: None, theta: vec![2e-5, -1e-5, 2e-5, 1e-5, -2e-5, 3e-5] };
    let data = cut(&measurement(900, |_| vec![Box::new(backlash.clone())]), "temp_platform_degC");
    let found = asked(&mechanism(), &data);
    assert_eq!((found.causes[0].effect.as_str(), found.causes[0].tentative), ("backlash", false), "{}", said(&found));
    assert!(found.causes[0].not_excluded.is_empty());
}
