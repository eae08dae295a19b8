//! Every measurement model keeps the laws, and one that breaks a law is named.

use crate::common::ranges::Ranges;
use paracal::conformance;
use paracal::measurement::{
    Contact, ContactReading, Frames, MeasurementModel, Plane, PlaneContact, PointReading, PoseMeasurement, PoseReading,
    RowKind, Rows, Sample, TargetMeasurement, TargetPoint,
};
use paracal::nalgebra::{DMatrix, Vector3, Vector6};
use paracal::pose::{Pose, PoseConvention, RotationOrder};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

const SIGMA: f64 = 1e-6;

fn poses() -> Vec<Pose> {
    let mut rng = ChaCha8Rng::seed_from_u64(91);
    let mut draw = |size: f64| rng.random_range(-size..size);
    let pose = |_| Pose::from_coordinates(&[draw(0.1), draw(0.1), 0.5 + draw(0.1), draw(0.2), draw(0.2), draw(0.2)]);
    (0..8).map(pose).collect()
}

fn samples() -> Vec<Sample> {
    vec![Sample::default(); poses().len()]
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn conventions() -> [PoseConvention; 2] {
    [PoseConvention::default(), PoseConvention { order: RotationOrder::Xyz, pivot: Vector3::new(0.2, -0.1, 0.7) }]
}

fn pose_readings(convention: &PoseConvention, measured: [bool; 6], sigma: [f64; 6]) -> PoseMeasurement {
    let mut rng = ChaCha8Rng::seed_from_u64(92);
    let reading = |pose: &Pose| {
        let mut values = convention.coordinates(pose);
        values.iter_mut().zip(sigma).for_each(|(v, s)| *v += s * normal(&mut rng));
        PoseReading { values, measured, sigma }
    };
    PoseMeasurement::new(*convention, poses().iter().map(reading).collect())
}

#[test]
fn poses_conform_whole_and_in_part() {
    let sigmas = [[SIGMA; 6], [1e-6, 2e-6, 3e-6, 1e-6, 4e-6, 9e-6]];
    for convention in conventions() {
        for sigma in sigmas {
            for left_out in [&[][..], &[0], &[2], &[3], &[4], &[5], &[3, 4, 5], &[0, 1, 2], &[0, 1, 3, 5]] {
                let measured = std::array::from_fn(|k| !left_out.contains(&k));
                let model = pose_readings(&convention, measured, sigma);
                conformance::measurement(&model, &samples(), &poses())
                    .unwrap_or_else(|v| panic!("without {left_out:?}: {v}"));
            }
        }
    }
}

#[test]
fn targets_conform_at_known_and_unknown_places() {
    let places = [[1.3, 0.0, 0.08], [-0.6, 1.1, 0.08], [-0.6, -1.1, 0.10], [0.1, 0.2, 0.9]];
    for known in 0..=places.len() {
        let mut rng = ChaCha8Rng::seed_from_u64(93);
        let target = |(k, t): (usize, &[f64; 3])| TargetPoint {
            name: format!("p{}", k + 1),
            platform: (k < known).then(|| Vector3::from(*t)),
        };
        let targets = places.iter().enumerate().map(target).collect();
        let reading = |(sample, pose): (usize, &Pose)| {
            let seen = |(k, t): (usize, &[f64; 3])| {
                let at = pose.place(&Vector3::from(*t));
                // The last target is not seen in the last sample, and one of its coordinates is missing in another.
                let missing = |axis: usize| k == 3 && (sample == 7 || sample == 4 && axis == 1);
                [0, 1, 2].map(|axis| (!missing(axis)).then(|| at[axis] + SIGMA * normal(&mut rng)))
            };
            places.iter().enumerate().map(seen).collect()
        };
        let readings: Vec<_> = poses().iter().enumerate().map(reading).collect();
        let model = TargetMeasurement::new(targets, readings, vec![[SIGMA, 2e-6, SIGMA]; 8]);
        conformance::measurement(&model, &samples(), &poses()).unwrap_or_else(|v| panic!("{known} known: {v}"));
    }
}

fn contacts(plane: Plane, known: bool) -> PlaneContact {
    let mut rng = ChaCha8Rng::seed_from_u64(94);
    let contact = Contact { plane, tip: Vector3::new(0.2, -0.3, -0.1), known };
    let reading = |(k, pose): (usize, &Pose)| ContactReading {
        height: (k != 3).then(|| plane.height(&pose.place(&contact.tip)) + SIGMA * normal(&mut rng)),
        sigma: SIGMA,
    };
    PlaneContact::new(contact, poses().iter().enumerate().map(reading).collect())
}

#[test]
fn contacts_conform_with_known_and_unknown_planes() {
    for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -2.0], [1.0, 0.0, 0.0], [0.3, -0.5, 0.4], [-0.1, 1.0, 0.0]] {
        let plane = Plane::new(&Vector3::from(normal), 0.3).unwrap();
        for known in [true, false] {
            conformance::measurement(&contacts(plane, known), &samples(), &poses())
                .unwrap_or_else(|v| panic!("{normal:?}, known {known}: {v}"));
        }
    }
    for size in [1e-320, 1.0, 1e308] {
        let plane = Plane::new(&Vector3::new(0.0, -size, 0.0), 0.0).unwrap();
        assert_eq!(*plane.normal, -Vector3::y());
    }
    assert_eq!(Plane::new(&Vector3::zeros(), 0.0), None);
    assert_eq!(Plane::new(&Vector3::new(f64::NAN, 0.0, 1.0), 0.0), None);
    assert_eq!(Plane::new(&Vector3::new(f64::INFINITY, 0.0, 1.0), 0.0), None);
}

fn ranges(wrong_sign: bool) -> Ranges {
    let mut rng = ChaCha8Rng::seed_from_u64(95);
    let mut model = Ranges::new();
    model.wrong_sign = wrong_sign;
    model.measure(poses().into_iter(), || normal(&mut rng));
    model
}

#[test]
fn a_model_from_outside_conforms() {
    conformance::measurement(&ranges(false), &samples(), &poses()).unwrap();
}

#[test]
fn a_wrong_sign_is_caught_and_named() {
    let found = conformance::measurement(&ranges(true), &samples(), &poses()).unwrap_err();
    assert_eq!(found.law, "motion agrees with differences");
    assert!(found.detail.starts_with("sample 0, δω x, row 1: analytic"), "{found}");
    assert!(found.detail.contains(", numeric "), "{found}");
}

/// Full poses with one mistake.
#[derive(Debug)]
struct Broken {
    inner: PlaneContact,
    mistake: Mistake,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mistake {
    OwnSign,
    NoVariance,
    TooManyValues,
    NotFinite,
    BlindToNaN,
    Panics,
    StatesAnotherPose,
    StatesAnotherPoint,
    IgnoresTheTracker,
}

impl MeasurementModel for Broken {
    fn describe(&self) -> String {
        self.inner.describe()
    }
    fn samples(&self) -> usize {
        self.inner.samples()
    }
    fn rows(&self, sample: usize) -> Vec<RowKind> {
        self.inner.rows(sample)
    }
    fn nuisance_parameters(&self) -> &[paracal::mechanism::ParameterSpec] {
        self.inner.nuisance_parameters()
    }
    fn start(&self, poses: &[Option<Pose>], frames: &Frames) -> Vec<f64> {
        let mut start = self.inner.start(poses, frames);
        match self.mistake {
            Mistake::TooManyValues => start.push(0.0),
            Mistake::NotFinite => start[1] = f64::NAN,
            _ => {}
        }
        start
    }
    fn evaluate(&self, index: usize, sample: &Sample, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows) {
        assert!(self.mistake != Mistake::Panics || pose.is_finite(), "not a pose");
        self.inner.evaluate(index, sample, pose, frames, own, out);
        match self.mistake {
            Mistake::OwnSign => out.own.column_mut(2).neg_mut(),
            Mistake::BlindToNaN if !pose.is_finite() => out.residual.fill(0.0),
            Mistake::IgnoresTheTracker if !frames.is_identity() => {
                let motion = out.motion.clone();
                self.inner.evaluate(index, sample, pose, &Frames::default(), own, out);
                out.motion = motion;
            }
            _ => {}
        }
    }
    fn covariance(&self, sample: usize, frames: &Frames) -> DMatrix<f64> {
        self.inner.covariance(sample, frames) * if self.mistake == Mistake::NoVariance { 0.0 } else { 1.0 }
    }
    fn rigid_pose(&self, sample: usize) -> Option<Pose> {
        (self.mistake == Mistake::StatesAnotherPose).then(|| poses()[sample].moved(&Vector6::repeat(0.01)))
    }
    fn point(&self, sample: usize) -> Option<PointReading> {
        let position = poses()[sample].position + Vector3::repeat(0.01);
        (self.mistake == Mistake::StatesAnotherPoint).then(|| PointReading { position, place: Vector3::zeros() })
    }
}

#[test]
fn every_mistake_is_named() {
    let plane = Plane::new(&Vector3::new(0.3, -0.5, 0.4), 0.3).unwrap();
    let cases = [
        (Mistake::OwnSign, "own agrees with differences", "sample 0, plane_distance, row 1: analytic 1.0"),
        (
            Mistake::NoVariance,
            "covariances are symmetric and positive definite",
            "sample 0: the variance of row 1 is 0",
        ),
        (Mistake::TooManyValues, "own parameters start at finite values", "3 parameters, 4 values"),
        (Mistake::NotFinite, "own parameters start at finite values", "plane_tilt2 starts at NaN"),
        (
            Mistake::BlindToNaN,
            "a pose that is not a number gives neither a finite residual nor a panic",
            "sample 0, row 1: 0",
        ),
        (Mistake::Panics, "a pose that is not a number gives neither a finite residual nor a panic", "sample 0: panic"),
        (Mistake::StatesAnotherPoint, "three rows vanish where a reading states a point", "sample 0: "),
        (
            Mistake::IgnoresTheTracker,
            "motion agrees with differences",
            "sample 0 with the tracker elsewhere, δt x, row 1: analytic",
        ),
    ];
    for (mistake, law, detail) in cases {
        let model = Broken { inner: contacts(plane, false), mistake };
        let found = conformance::measurement(&model, &samples(), &poses()).unwrap_err();
        assert!(found.law == law && found.detail.starts_with(detail), "{mistake:?}: {found}");
    }
    // With a known plane nothing takes a wrong pose in.
    let model = Broken { inner: contacts(plane, true), mistake: Mistake::StatesAnotherPose };
    let found = conformance::measurement(&model, &samples(), &poses()).unwrap_err();
    assert_eq!(found.law, "the rows vanish at the pose that a reading states");
    assert!(found.detail.starts_with("sample 0, row 1: "), "{found}");
    let found = conformance::measurement(&contacts(plane, true), &samples(), &poses()[1..]).unwrap_err();
    assert_eq!(found.detail, "8 samples, 7 poses");
    let found = conformance::measurement(&contacts(plane, true), &samples()[1..], &poses()).unwrap_err();
    assert_eq!(found.detail, "the model has 8 samples, 7 are given");
}
