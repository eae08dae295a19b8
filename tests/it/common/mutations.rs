//! How many mutated inputs are tried, and which.

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// Mutated inputs of each group of readers where `PARACAL_MUTATIONS` names no other number.
const CASES: u32 = 20_000;

fn number<T: std::str::FromStr>(variable: &str, otherwise: T) -> T {
    match std::env::var(variable) {
        Ok(text) => text.parse().ok().expect(variable),
        Err(_) => otherwise,
    }
}

/// A test that has one of `parts` equal parts of the inputs of its group. The inputs follow from `PARACAL_SEED` (0).
pub fn mutations(parts: u32) -> ProptestConfig {
    ProptestConfig {
        cases: (number("PARACAL_MUTATIONS", CASES) / parts).max(1),
        rng_seed: RngSeed::Fixed(number("PARACAL_SEED", 0)),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}
