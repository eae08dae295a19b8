//! Poses at random.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::{Choice, Numbered, PoseSelector, Problem, SelectionError};

/// Draws poses without repetition: what people do who do not choose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Random;

impl PoseSelector for Random {
    fn name(&self) -> &str {
        "random"
    }

    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        self.select_numbered(problem).map(|found| found.choice)
    }

    fn select_numbered(&self, problem: &Problem<'_>) -> Result<Numbered, SelectionError> {
        let mut rng = ChaCha8Rng::seed_from_u64(problem.seed);
        let members = problem.draw(&mut rng)?;
        let value = problem.set(&members).value();
        Ok(problem.choice_of(&members, vec![value]))
    }
}
