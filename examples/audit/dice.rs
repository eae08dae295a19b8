//! Random draws of the generator: each trial has its own, whatever thread it runs on.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The draws of one trial.
pub(crate) struct Dice(ChaCha8Rng);

impl Dice {
    /// The draws of trial `number` of a situation; those of another trial, situation or seed have nothing to do with
    /// them.
    pub(crate) fn of(seed: u64, situation: &str, number: usize) -> Self {
        let mut mixed = 0xcbf2_9ce4_8422_2325_u64 ^ seed;
        for byte in situation.bytes().chain(number.to_le_bytes()) {
            mixed = (mixed ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        Self(ChaCha8Rng::seed_from_u64(mixed))
    }

    pub(crate) fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.random::<f64>()
    }

    pub(crate) fn log_uniform(&mut self, from: f64, to: f64) -> f64 {
        self.uniform(from.ln(), to.ln()).exp()
    }

    /// A whole number from `from` to `to`, both included.
    pub(crate) fn count(&mut self, from: usize, to: usize) -> usize {
        self.0.random_range(from..=to)
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// −1 or 1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Standard normal, by Box and Muller.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.0.random::<f64>()).ln()).sqrt();
        radius * (TAU * self.0.random::<f64>()).cos()
    }

    /// Student's t with so many degrees of freedom, scaled to variance one.
    pub(crate) fn student(&mut self, freedom: usize) -> f64 {
        let square = (0..freedom).map(|_| self.normal().powi(2)).sum::<f64>() / freedom as f64;
        let nu = freedom as f64;
        self.normal() / square.sqrt() * ((nu - 2.0) / nu).sqrt()
    }

    /// Three numbers in ±`half`.
    pub(crate) fn in_cube(&mut self, half: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.uniform(-half, half))
    }

    /// The index of one of these weights, with a probability that is proportional to it.
    pub(crate) fn pick(&mut self, weights: &[f64]) -> usize {
        let mut left = self.uniform(0.0, weights.iter().sum());
        for (k, weight) in weights.iter().enumerate() {
            left -= weight;
            if left < 0.0 {
                return k;
            }
        }
        weights.len() - 1
    }

    /// `count` different numbers below `below`.
    pub(crate) fn some_of(&mut self, below: usize, count: usize) -> Vec<usize> {
        let mut all: Vec<usize> = (0..below).collect();
        for k in 0..count.min(below) {
            let other = self.count(k, below - 1);
            all.swap(k, other);
        }
        all.truncate(count);
        all
    }
}
