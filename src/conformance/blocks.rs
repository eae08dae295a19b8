//! Random blocks with known structure, for the laws of an index.

use nalgebra::{DMatrix, Matrix6, Matrix6xX};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::observability::{Block, Spectrum};

/// How the blocks of a pool look, and with it which scans work on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Structure {
    /// Every row knows every parameter.
    Dense,
    /// Row `i` knows the seven parameters of leg `i`.
    SixLegs,
}

impl Structure {
    /// Number of parameters of six legs.
    pub(super) const OF_SIX_LEGS: usize = 42;

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Dense => "dense blocks",
            Self::SixLegs => "blocks of six legs",
        }
    }

    /// A block with this many parameters. Columns differ in size a hundredfold, as they do in mechanisms; rows of six
    /// legs are correlated, because a platform's coordinates are measured and not its legs.
    pub(super) fn block(self, parameters: usize, rng: &mut ChaCha8Rng) -> Block {
        let own = parameters / 6;
        let derivatives = Matrix6xX::from_fn(parameters, |row, column| {
            let size = 10_f64.powf((column * 7 % 5) as f64 / 2.0 - 1.0);
            let value: f64 = normal(rng) * size;
            if self == Self::Dense || column / own == row { value } else { 0.0 }
        });
        let noise = match self {
            Self::Dense => Matrix6::identity(),
            Self::SixLegs => {
                let mixed = Matrix6::from_fn(|_, _| 0.2 * normal(rng));
                Matrix6::identity() + mixed * mixed.transpose()
            }
        };
        Block { noise, derivatives }
    }
}

/// A spectrum over six decades with an orthogonal matrix of directions.
pub(super) fn spectrum(directions: usize, rng: &mut ChaCha8Rng) -> Spectrum {
    let mut values: Vec<f64> = (0..directions).map(|_| 10_f64.powf(rng.random_range(-3.0..3.0))).collect();
    values.sort_by(|a, b| b.total_cmp(a));
    Spectrum { values, directions: orthogonal(directions, rng), poses: directions.div_ceil(6) + 2 }
}

pub(super) fn orthogonal(n: usize, rng: &mut ChaCha8Rng) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |_, _| normal(rng)).qr().q()
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}
