//! What the user gains: full nonlinear calibrations of a mechanism with errors, from data of chosen poses, judged at
//! other poses by what the platform then does.

use crate::common::{machine, paper_noise, true_mechanism, workspace};
use paracal::conditions::Conditions;
use paracal::identification::{Identifier, LeastSquares, LevenbergMarquardt, PriorPolicy, Task, Weights};
use paracal::mechanism::Mechanism;
use paracal::observability::{O1, Scaling};
use paracal::pose::{Pose, PoseConvention};
use paracal::rand::SeedableRng;
use paracal::rand::rngs::ChaCha8Rng;
use paracal::selection::{
    Campaign, Exchange, Forecaster, Objective, PoseSelector, Random, SelectionTask, Sources, TabuDetmax, select,
};
use paracal::simulation::{as_dataset, monte_carlo, simulate};

const DRAWS: u64 = 60;
const TARGETS: usize = 150;

fn poses(
    mechanism: &dyn Mechanism,
    aim: Objective<'_>,
    paper: bool,
    selector: &dyn PoseSelector,
    n: usize,
    seed: u64,
) -> Vec<Pose> {
    let box_ = workspace(mechanism, 100.0, 10.0);
    let noise = paper_noise();
    let whitened = Campaign::new(mechanism, &box_, Some(&noise), Scaling::Whitened).unwrap();
    let forecaster = Forecaster::new(whitened.clone(), &[]).unwrap();
    let campaign = if paper { Campaign::new(mechanism, &box_, None, Scaling::Paper).unwrap() } else { whitened };
    let plan =
        SelectionTask { campaign: &campaign, forecaster: Some(&forecaster), aim, given: &[], seed, watch: &|_| {} };
    let sources = Sources { random: 2000, corners_and_grid: selector.wants_corners(), seed, ..Sources::default() };
    select(&plan, selector, &sources, n).unwrap().poses
}

/// Integrated error (eq. 44) after calibration, mm and degrees, mean over draws of the noise.
fn integrated(nominal: &dyn Mechanism, poses: &[Pose], weights: Weights) -> f64 {
    let truth = true_mechanism(nominal);
    let (noise, convention, at) = (paper_noise(), PoseConvention::default(), Conditions::unknown());
    let mut rng = ChaCha8Rng::seed_from_u64(99);
    let box_ = workspace(nominal, 100.0, 10.0);
    let targets: Vec<Pose> = (0..TARGETS).map(|_| box_.random(&mut rng)).collect();
    let errors = monte_carlo(DRAWS, 5, |_, rng| {
        let samples = simulate(nominal, truth.as_ref(), poses, &convention, &noise, rng).unwrap();
        let data = as_dataset(&samples, &convention, &noise);
        let task = Task { weights, prior: PriorPolicy::None, ..Task::new(nominal, &data) };
        let identifier: Box<dyn Identifier> = match weights {
            Weights::Noise => Box::new(LevenbergMarquardt::default()),
            Weights::MillimetresAndRadians => Box::new(LeastSquares { builtin: false }),
        };
        let found = identifier.identify(&task).unwrap();
        let c = found.mechanism_values();
        let square = |target: &Pose| {
            let joints = nominal.inverse(&c, target, &at).unwrap();
            let reached = truth.forward(truth.values(), &joints, &at, target).unwrap();
            let (q, wanted) = (reached.coordinates(), target.coordinates());
            let part = |from: usize| (from..from + 3).map(|k| (q[k] - wanted[k]).powi(2)).sum::<f64>().sqrt();
            (1e3 * part(0) + part(3).to_degrees()).powi(2)
        };
        (targets.iter().map(square).sum::<f64>() / TARGETS as f64).sqrt()
    });
    errors.iter().sum::<f64>() / DRAWS as f64
}

#[test]
fn twenty_poses_are_worth_a_hundred() {
    let machine = machine("table5");
    let nominal = machine.mechanism.as_ref();
    let aim = Objective::Index(&O1);
    let paper =
        integrated(nominal, &poses(nominal, aim, true, &TabuDetmax::default(), 20, 0), Weights::MillimetresAndRadians);
    // The reproduction of the paper has 0.00151 with a spread of a few percent over lists of candidates.
    assert!((paper / 0.00151 - 1.0).abs() < 0.15, "the paper's procedure: {paper}");
    let ours = integrated(nominal, &poses(nominal, aim, false, &Exchange::default(), 20, 0), Weights::Noise);
    assert!(ours <= 0.65 * paper, "{ours} and {paper}");
    let hundred: Vec<f64> = (0..3)
        .map(|seed| integrated(nominal, &poses(nominal, aim, true, &Random, 100, seed), Weights::MillimetresAndRadians))
        .collect();
    let hundred = hundred.iter().sum::<f64>() / 3.0;
    assert!(ours / hundred < 1.15, "twenty of ours {ours}, a hundred random ones with the paper's estimator {hundred}");
}

#[test]
fn the_predicted_error_is_best_in_its_own_measure() {
    let machine = machine("table5");
    let mechanism = machine.mechanism.as_ref();
    for (mm, degrees) in [(100.0, 10.0), (10.0, 0.5)] {
        let box_ = workspace(mechanism, mm, degrees);
        let campaign = Campaign::new(mechanism, &box_, Some(&paper_noise()), Scaling::Whitened).unwrap();
        let forecaster = Forecaster::new(campaign.clone(), &[]).unwrap();
        let sources = Sources { random: 500, corners_and_grid: true, ..Sources::default() };
        let run = |aim: Objective<'_>| {
            let plan = SelectionTask {
                campaign: &campaign,
                forecaster: Some(&forecaster),
                aim,
                given: &[],
                seed: 0,
                watch: &|_| {},
            };
            select(&plan, &Exchange::default(), &sources, 20).unwrap()
        };
        let (error, volume) = (run(Objective::PoseError(&forecaster)), run(Objective::Index(&O1)));
        let measured = |poses: &[Pose]| {
            let all = nalgebra::DMatrix::identity(42, 42);
            let spectrum = forecaster.spectrum(poses);
            let f = forecaster.forecast(poses);
            let scale = |k: usize| (spectrum.values[k].powi(2) + if f.prior { 1.0 } else { 0.0 }).sqrt();
            let values = (0..42).map(scale).collect();
            let index = forecaster.index(&all, false);
            paracal::observability::ObservabilityIndex::value(
                &index,
                &paracal::observability::Spectrum { values, ..spectrum },
            )
        };
        let (ours, others) = (measured(&error.poses), measured(&volume.poses));
        assert!((ours / error.value - 1.0).abs() < 1e-6, "±{mm} mm: {ours} is reported as {}", error.value);
        assert!(ours <= others * (1.0 + 1e-9), "±{mm} mm: pose-error {ours}, O1 {others}");
        assert!(error.efficiency.unwrap() <= 1.0 && error.efficiency.unwrap() > 0.9, "{:?}", error.efficiency);
    }
}
