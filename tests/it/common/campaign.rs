//! A campaign with the bundled mechanism, and how well it predicts what was not fitted.

use super::{machine, paper_noise, true_mechanism, workspace};
use paracal::identification::{CalibrationProblem, Identifier, LevenbergMarquardt, PriorPolicy, Task};
use paracal::measurement::{DataRow, Dataset, Sample};
use paracal::mechanism::{Mechanism, Workspace};
use paracal::nalgebra::{DMatrix, DVector};
use paracal::pose::Pose;
use paracal::simulation::{SimulatedSample, simulate};
use paracal::solve::LeastSquaresProblem;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// A nominal mechanism, the true one, and what it does at commanded poses.
pub struct Campaign {
    pub nominal: Box<dyn Mechanism>,
    pub truth: Box<dyn Mechanism>,
    pub space: Workspace,
    pub samples: Vec<Sample>,
    pub run: Vec<SimulatedSample>,
}

/// Random poses of ±100 mm and ±10° for the mechanism of Table 5 with the errors of Table 6.
pub fn campaign(poses: usize) -> Campaign {
    let nominal = machine("table5").mechanism;
    let truth = true_mechanism(nominal.as_ref());
    campaign_of(nominal, truth, poses)
}

/// The same for any true mechanism near the nominal one.
pub fn campaign_of(nominal: Box<dyn Mechanism>, truth: Box<dyn Mechanism>, poses: usize) -> Campaign {
    let space = workspace(nominal.as_ref(), 100.0, 10.0);
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let wanted: Vec<Pose> = (0..poses).map(|_| space.random(&mut rng)).collect();
    let run = simulate(nominal.as_ref(), truth.as_ref(), &wanted, &space.convention, &paper_noise(), &mut rng).unwrap();
    let sample = |(row, s): (usize, &SimulatedSample)| Sample {
        row: DataRow(row),
        joints: s.joints.clone(),
        ..Sample::default()
    };
    let samples = run.iter().enumerate().map(sample).collect();
    Campaign { nominal, truth, space, samples, run }
}

/// Mean square of whitened residuals of rows that were not fitted over their variance, the noise's and the
/// model's: 1 + diag(J Cov Jᵀ). All parameters take part, those of the measurement too.
pub fn held_out_over_predicted(c: &Campaign, data: &Dataset, fitted: usize) -> f64 {
    let task = |data| Task { prior: PriorPolicy::Auto, ..Task::new(c.nominal.as_ref(), data) };
    let (fit, rest): (Vec<usize>, Vec<usize>) = (0..data.len()).partition(|k| *k < fitted);
    let (fit, rest) = (data.subset(&fit), data.subset(&rest));
    let found = LevenbergMarquardt::default().identify(&task(&fit)).unwrap();
    let x = DVector::from_iterator(found.parameters.len(), found.parameters.iter().map(|p| p.value));
    let mut problem = CalibrationProblem::new(&task(&rest)).unwrap();
    let (m, n) = problem.shape();
    let (mut r, mut j) = (DVector::zeros(m), DMatrix::zeros(m, n));
    problem.linearize(&x, &mut r, &mut j).unwrap();
    let spread = &j * &found.covariance * j.transpose();
    (0..m).map(|k| r[k] * r[k] / (1.0 + spread[(k, k)])).sum::<f64>() / m as f64
}
