//! Poses at random.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::{Choice, PoseSelector, Problem, SelectionError};

/// Draws poses without repetition: what people do who do not choose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Random;

impl PoseSelector for Random {
    fn name(&self) -> &str {
        "random"
    }

    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        let mut rng = ChaCha8Rng::seed_from_u64(problem.seed);
        let members = problem.draw(&mut rng)?;
        let value = problem.set(&members).value();
        Ok(Choice { poses: problem.poses(&members), iterations: 0, trace: vec![value] })
    }
}
