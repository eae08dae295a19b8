//! A kind of measurement from outside the crate: ranges from fixed stations to points of the platform, as a
//! multilateration system reports them, with an offset of the range meter that is identified.

use std::sync::Arc;

use crate::common::ranges::{OFFSET, Ranges, SIGMA};
use crate::common::{machine, paper_noise, true_mechanism, workspace};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::{DataRow, Dataset, Noise, Sample};
use paracal::pose::Pose;
use paracal::simulation::simulate;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

#[test]
fn ranges_calibrate_the_mechanism_and_their_own_offset() {
    let m = machine("table5");
    let nominal = m.mechanism.as_ref();
    let truth = true_mechanism(nominal);
    let space = workspace(nominal, 100.0, 10.0);
    let mut rng = ChaCha8Rng::seed_from_u64(61);
    let poses: Vec<Pose> = (0..40).map(|_| space.random(&mut rng)).collect();
    let run = simulate(nominal, truth.as_ref(), &poses, &space.convention, &paper_noise(), &mut rng).unwrap();
    let mut model = Ranges::new();
    model.measure(run.iter().map(|sample| sample.truth), || StandardNormal.sample(&mut rng));
    let samples = run.iter().enumerate().map(|(row, s)| Sample {
        row: DataRow(row),
        joints: s.joints.clone(),
        ..Sample::default()
    });
    let data = Dataset::new(samples.collect(), Arc::new(model), Noise::stated(SIGMA, SIGMA));
    let options = CalibrationOptions::default();
    let result = calibrate(nominal, &data, Some(&space), &LevenbergMarquardt::default(), &options).unwrap();
    assert!(result.verdict.trusted, "{:?}", result.verdict);
    let found = result.parameters.last().unwrap();
    let (error, sigma) = ((found.value - OFFSET).abs(), found.sigma.unwrap());
    assert!(found.spec.name == "offset" && error < 4.0 * sigma && sigma < 2e-6, "{error:.2e} {sigma:.2e}");
    for (p, t) in result.parameters.iter().zip(truth.values()) {
        assert!((p.value - t).abs() < 4.5 * p.sigma.unwrap(), "{}: {} {t}", p.spec.name, p.value);
    }
}
