//! Laws of an [`Identifier`].

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::{Violation, violation};
use crate::conditions::Conditions;
use crate::identification::{Identification, Identifier, IdentifyError, PriorPolicy, Task, evaluate};
use crate::measurement::{Dataset, Noise};
use crate::mechanism::{Mechanism, Workspace, consistent};
use crate::pose::Pose;
use crate::simulation::{as_dataset, draw_parameters, monte_carlo, simulate};

/// Trials of the comparison of the covariance with Monte Carlo.
const TRIALS: u64 = 100;
const EXACT: f64 = 1e-9;

/// Checks an identifier with a mechanism and a workspace in which `samples` random poses determine it.
///
/// * exact data give a model that predicts other poses exactly, and the parameters if the data decide them;
/// * the order of the samples does not matter;
/// * the errors of the estimates over a hundred draws of the noise are as large as the covariance says;
/// * no samples, or too few without a prior, give an error.
///
/// # Errors
/// The first [`Violation`].
pub fn identifier(
    identifier: &dyn Identifier,
    mechanism: &dyn Mechanism,
    workspace: &Workspace,
    noise: &Noise,
    samples: usize,
) -> Result<(), Violation> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let bench = Bench {
        identifier,
        mechanism,
        workspace,
        noise: *noise,
        poses: reachable(mechanism, workspace, &mut rng, samples)?,
    };
    // A thousand times the noise: small enough that every mechanism converges.
    let sd = 1e3 * noise.position;
    let truth = mechanism
        .with_values(&draw_parameters(mechanism, Some(sd), &mut rng), mechanism.home())
        .map_err(|e| violation("the mechanism takes values near its own", e.to_string()))?;
    bench.exact(truth.as_ref())?;
    bench.order(truth.as_ref())?;
    bench.covariance(truth.as_ref())?;
    bench.refusals(truth.as_ref())
}

/// Poses of the workspace that the mechanism can take, with the coordinates that it does not control where they belong.
fn reachable(m: &dyn Mechanism, w: &Workspace, rng: &mut ChaCha8Rng, count: usize) -> Result<Vec<Pose>, Violation> {
    let mut poses = Vec::with_capacity(count);
    for _ in 0..100 * count {
        poses.extend(consistent(m, m.values(), &w.random(rng), &Conditions::unknown()).map(|(pose, _)| pose));
        if poses.len() == count {
            return Ok(poses);
        }
    }
    Err(violation("the workspace can be reached", format!("only {} of {} poses", poses.len(), 100 * count)))
}

struct Bench<'a> {
    identifier: &'a dyn Identifier,
    mechanism: &'a dyn Mechanism,
    workspace: &'a Workspace,
    noise: Noise,
    poses: Vec<Pose>,
}

impl Bench<'_> {
    fn data(&self, truth: &dyn Mechanism, poses: &[Pose], noisy: bool, seed: u64) -> Result<Dataset, Violation> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let none = Noise { position: 0.0, rotation: 0.0, joint: 0.0, known: true };
        let noise = if noisy { self.noise } else { none };
        let convention = &self.workspace.convention;
        let samples = simulate(self.mechanism, truth, poses, convention, &noise, &mut rng)
            .map_err(|(k, e)| violation("the workspace can be reached", format!("pose {k}: {e}")))?;
        Ok(as_dataset(&samples, convention, &self.noise))
    }

    fn identify(&self, law: &'static str, data: &Dataset) -> Result<Identification, Violation> {
        let task = Task { prior: PriorPolicy::None, ..Task::new(self.mechanism, data) };
        self.identifier.identify(&task).map_err(|e| violation(law, e.to_string()))
    }

    fn exact(&self, truth: &dyn Mechanism) -> Result<(), Violation> {
        const LAW: &str = "exact data give an exact model";
        let found = self.identify(LAW, &self.data(truth, &self.poses, false, 0)?)?;
        let model = self.mechanism.with_values(&found.mechanism_values(), self.mechanism.home());
        let model = model.map_err(|e| violation(LAW, e.to_string()))?;
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let others = reachable(self.mechanism, self.workspace, &mut rng, 50)?;
        let errors = evaluate(model.as_ref(), &[], &self.data(truth, &others, false, 0)?)
            .map_err(|e| violation(LAW, e.to_string()))?
            .max();
        let worst = errors.position.unwrap_or(0.0).max(errors.rotation.unwrap_or(0.0));
        if !(worst <= EXACT) {
            return Err(violation(LAW, format!("other poses are missed by {worst:.3e} (m, rad)")));
        }
        if found.mechanism_values().len() != truth.values().len() {
            return Err(violation(
                LAW,
                format!("{} of {} parameters", found.mechanism_values().len(), truth.values().len()),
            ));
        }
        for (p, truth) in found.parameters.iter().zip(truth.values()) {
            let limit = EXACT + p.sigma.unwrap_or(f64::INFINITY);
            if !((p.value - truth).abs() <= limit) {
                return Err(violation(LAW, format!("{} is {:.12}, true {truth:.12}", p.spec.name, p.value)));
            }
        }
        Ok(())
    }

    fn order(&self, truth: &dyn Mechanism) -> Result<(), Violation> {
        const LAW: &str = "the order of the samples does not matter";
        let data = self.data(truth, &self.poses, true, 4)?;
        let backwards: Vec<usize> = (0..data.len()).rev().collect();
        let (a, b) = (self.identify(LAW, &data)?, self.identify(LAW, &data.subset(&backwards))?);
        for (p, q) in a.parameters.iter().zip(&b.parameters) {
            let limit = EXACT + 1e-3 * p.sigma.unwrap_or(f64::INFINITY);
            if !((p.value - q.value).abs() <= limit) {
                return Err(violation(LAW, format!("{}: {:.12} and {:.12}", p.spec.name, p.value, q.value)));
            }
        }
        Ok(())
    }

    fn covariance(&self, truth: &dyn Mechanism) -> Result<(), Violation> {
        const LAW: &str = "errors are as large as the covariance says";
        let trial = |k: u64, _: &mut ChaCha8Rng| -> Result<f64, Violation> {
            let found = self.identify(LAW, &self.data(truth, &self.poses, true, 100 + k)?)?;
            let scaled =
                found.parameters.iter().zip(truth.values()).filter_map(|(p, t)| Some((p.value - t) / p.sigma?));
            let squares: Vec<f64> = scaled.map(|z: f64| z * z).collect();
            if squares.is_empty() {
                return Err(violation(LAW, "no parameter has a sigma"));
            }
            Ok(squares.iter().sum::<f64>() / squares.len() as f64)
        };
        let means: Result<Vec<f64>, Violation> = monte_carlo(TRIALS, 5, trial).into_iter().collect();
        let means = means?;
        let ratio = (means.iter().sum::<f64>() / means.len() as f64).sqrt();
        // Parameters of one draw are correlated, so that a draw counts as few numbers: 15 % is three of their σ.
        if !((0.85..1.15).contains(&ratio)) {
            return Err(violation(LAW, format!("they are {ratio:.3} times as large over {TRIALS} draws")));
        }
        Ok(())
    }

    fn refusals(&self, truth: &dyn Mechanism) -> Result<(), Violation> {
        const LAW: &str = "too few samples are refused";
        let data = self.data(truth, &self.poses, false, 0)?;
        for (count, name) in [(0, "no sample"), (1, "one sample")] {
            let few = data.subset(&(0..count).collect::<Vec<_>>());
            let task = Task { prior: PriorPolicy::None, ..Task::new(self.mechanism, &few) };
            match self.identifier.identify(&task) {
                Err(IdentifyError::TooFewRows { .. } | IdentifyError::Empty) => {}
                Err(_) if few.row_count() >= self.mechanism.parameters().len() => {}
                Err(other) => return Err(violation(LAW, format!("{name} gives another error: {other}"))),
                Ok(_) if few.row_count() >= self.mechanism.parameters().len() => {}
                Ok(_) => return Err(violation(LAW, format!("{name} gives a result"))),
            }
        }
        Ok(())
    }
}
