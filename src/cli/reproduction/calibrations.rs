//! Calibrations with chosen poses, draw by draw.

use rand::rngs::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::sets::Place;
use super::{ReproduceError, ReproductionContext, paper};
use crate::identification::{LeastSquares, LevenbergMarquardt, PriorPolicy, Weights};
use crate::measurement::Noise;
use crate::mechanism::Mechanism;
use crate::pose::Pose;
use crate::simulation::{Estimator, Trial, TrialError, TrialResult, draw_parameters, monte_carlo, stream};

/// Which least squares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fit {
    /// The paper's: Gauss–Newton on mm and rad as they are.
    Paper,
    /// Rows over their noise.
    Weighted,
    /// The same, with the tolerance as prior where the data do not decide.
    WithPrior,
}

/// Whose errors the mechanism has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Truth {
    /// Those of Table 6.
    Table6,
    /// Normal ones, new in each draw.
    Drawn,
    /// Normal ones, new in each draw, under the noise of draw number so-and-so.
    UnderOneNoise(u64),
}

/// A calibration to repeat.
#[derive(Clone)]
pub(super) struct Study<'a> {
    pub(super) place: &'a Place,
    /// What the poses are, for the key.
    pub(super) set: String,
    pub(super) poses: Vec<Pose>,
    pub(super) targets: &'a [Pose],
    /// What the targets are, for the key.
    pub(super) at: String,
    pub(super) noise: Noise,
    pub(super) truth: Truth,
    pub(super) fit: Fit,
    pub(super) draws: u64,
    /// Studies with the same seed share errors and noise, draw by draw.
    pub(super) seed: u64,
}

/// What a draw gave, in the units of the paper: mm and degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Draw {
    /// Eq. (44).
    pub(super) integrated: f64,
    /// Position maximum and mean, attitude maximum and mean, as in Table 8.
    pub(super) table_8: [f64; 4],
    /// Root mean square error of the parameters, mm.
    pub(super) parameters: f64,
}

/// All draws of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Draws {
    /// By number; `None` if the identification failed.
    pub(super) draws: Vec<Option<Draw>>,
}

impl Draws {
    /// A number of each draw that succeeded.
    pub(super) fn each(&self, get: impl Fn(&Draw) -> f64) -> Vec<f64> {
        self.draws.iter().flatten().map(get).collect()
    }

    pub(super) fn integrated(&self) -> Vec<f64> {
        self.each(|d| d.integrated)
    }

    /// The integrated errors by the number of the draw.
    pub(super) fn by_number(&self) -> Vec<Option<f64>> {
        self.draws.iter().map(|d| d.map(|d| d.integrated)).collect()
    }

    pub(super) fn failed(&self) -> usize {
        self.draws.iter().filter(|d| d.is_none()).count()
    }
}

/// Repeats calibrations, each study once, in parallel.
pub(super) fn calibrate(
    context: &ReproductionContext<'_>,
    what: &str,
    studies: &[Study<'_>],
) -> Result<Vec<Draws>, ReproduceError> {
    let key = |s: &Study<'_>| {
        let Study { place, set, at, noise, truth, fit, draws, seed, .. } = s;
        let (p, r) = (noise.position, noise.rotation);
        format!("{}: {set}; {fit:?}, {truth:?}, noise {p:e} {r:e}, {draws} at {at}, {seed}", place.name)
    };
    context.units(&format!("calibrations for {what}"), studies, key, |s| s.run())
}

impl Study<'_> {
    /// All draws.
    pub(super) fn run(&self) -> Result<Draws, ReproduceError> {
        let results = monte_carlo(self.draws, self.seed, |_, rng| self.draw(rng));
        let failed = results.iter().filter(|r| r.is_err()).count() as u64;
        if 2 * failed > self.draws {
            let cause = results.iter().filter_map(|r| r.as_ref().err()).next_back().map(ToString::to_string);
            let what = format!("{} ({:?})", self.set, self.fit);
            return Err(ReproduceError::Failed { what, failed, draws: self.draws, cause: cause.unwrap_or_default() });
        }
        Ok(Draws { draws: results.into_iter().map(Result::ok).collect() })
    }

    fn draw(&self, rng: &mut ChaCha8Rng) -> Result<Draw, ReproduceError> {
        let nominal = self.place.nominal();
        let drawn = |rng: &mut ChaCha8Rng| {
            nominal.with_values(&draw_parameters(nominal, Some(paper::ERROR_SD), rng), nominal.home())
        };
        let truth = match self.truth {
            Truth::Table6 => paper::with_table_6(nominal)?,
            Truth::Drawn | Truth::UnderOneNoise(_) => drawn(rng)?,
        };
        let result = match self.truth {
            // The noise comes after the errors in a stream of its own, the same for all of them.
            Truth::UnderOneNoise(number) => self.run_once(truth.as_ref(), &mut stream(!self.seed, number)),
            _ => self.run_once(truth.as_ref(), rng),
        };
        let TrialResult { values, errors } = result?;
        let squares: f64 = values.iter().zip(truth.values()).map(|(v, t)| (v - t).powi(2)).sum();
        let (p, r) = (&errors.positions, &errors.rotations);
        let largest = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        Ok(Draw {
            integrated: errors.integrated(),
            table_8: [1e3 * largest(p), 1e3 * mean(p), largest(r).to_degrees(), mean(r).to_degrees()],
            parameters: 1e3 * (squares / values.len() as f64).sqrt(),
        })
    }

    /// One calibration of a mechanism.
    pub(super) fn run_once(&self, truth: &dyn Mechanism, rng: &mut ChaCha8Rng) -> Result<TrialResult, TrialError> {
        let (paper, weighted) = (LeastSquares::default(), LevenbergMarquardt::default());
        let estimator = match self.fit {
            Fit::Paper => {
                Estimator { identifier: &paper, weights: Weights::MillimetresAndRadians, prior: PriorPolicy::None }
            }
            Fit::Weighted => Estimator { identifier: &weighted, weights: Weights::Noise, prior: PriorPolicy::None },
            Fit::WithPrior => Estimator { identifier: &weighted, weights: Weights::Noise, prior: PriorPolicy::Auto },
        };
        let trial = Trial {
            nominal: self.place.nominal(),
            poses: &self.poses,
            targets: self.targets,
            convention: self.place.space.convention,
            noise: self.noise,
            estimator,
        };
        trial.run(truth, rng)
    }
}
