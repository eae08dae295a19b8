//! One run of measurements: what is commanded and what the environment does, row by row.
//!
//! The reference run is kind: poses, elevation and load are in random order, the air swings through one and a half
//! days, each leg wanders on its own, platform and base follow late. The warm-up is unkind: time and every temperature
//! rise together, so that what depends on one of them can be told from the others in part or not at all.

use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::hexapod::Pose;
use super::stage::Stage;

/// Standard gravity of the file format, m/s².
const G: f64 = 9.81;
/// Duration, s.
const DURATION: f64 = 8.0 * 3600.0;
/// Wander of a temperature: its standard deviation, K, and the rows over which it forgets.
const WANDER: (f64, f64) = (0.8, 8.0);

/// What is known of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub time: f64,
    pub commanded: [f64; 6],
    /// Commands of the row before; of the first row, those of home.
    pub before: [f64; 6],
    pub temp_legs: [f64; 6],
    pub temp_platform: f64,
    pub temp_base: f64,
    pub elevation: f64,
    pub azimuth: f64,
    pub payload: f64,
}

impl Row {
    /// Unit vector of gravity in the base frame.
    pub fn down(&self) -> Vector3<f64> {
        Vector3::new(self.elevation.cos(), 0.0, -self.elevation.sin())
    }

    pub fn gravity(&self) -> Vector3<f64> {
        self.down() * G
    }
}

/// A run, and the means from which its temperatures count.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    pub rows: Vec<Row>,
    pub mean_of_legs: [f64; 6],
    pub mean_of_platform: f64,
    pub mean_of_base: f64,
    pub stage: Stage,
}

/// How conditions go through a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weather {
    Reference,
    WarmUp,
    /// One night: the air cools, legs follow at once and bodies late.
    Night,
}

impl Run {
    /// A run of `n` rows in ±10 mm and ±0.5° about home.
    pub fn draw<R: Rng + ?Sized>(n: usize, weather: Weather, rng: &mut R) -> Self {
        Self::draw_on(Stage::reference(), n, weather, rng)
    }

    /// A run of `n` rows about the home of another machine.
    pub fn draw_on<R: Rng + ?Sized>(stage: Stage, n: usize, weather: Weather, rng: &mut R) -> Self {
        let design = &stage.design;
        let home = design.home.coordinates();
        let temperatures = match weather {
            Weather::Reference => diurnal(n, rng),
            Weather::WarmUp => warm_up(n, rng),
            Weather::Night => night(n, rng),
        };
        let mut before = design.lengths;
        let mut rows = Vec::with_capacity(n);
        for (k, temperature) in temperatures.iter().enumerate() {
            let half = |j: usize| design.half[usize::from(j >= 3)];
            let q = std::array::from_fn(|j| home[j] + half(j) * rng.random_range(-1.0..1.0));
            let commanded = design.geometry.lengths(&Pose::of(q));
            rows.push(Row {
                time: DURATION * share(k, n),
                commanded,
                before,
                temp_legs: std::array::from_fn(|i| temperature[i]),
                temp_platform: temperature[6],
                temp_base: temperature[7],
                elevation: rng.random_range(20_f64..90.0).to_radians(),
                azimuth: rng.random_range(0.0..TAU),
                payload: [0.0, 50.0, 100.0][rng.random_range(0..3)],
            });
            before = commanded;
        }
        Self { stage, ..Self::of(rows) }
    }

    /// A run of these rows.
    pub fn of(rows: Vec<Row>) -> Self {
        let n = rows.len();
        let mean = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / n as f64;
        let mean_of_legs = std::array::from_fn(|i| mean(&|row| row.temp_legs[i]));
        let (mean_of_platform, mean_of_base) = (mean(&|row| row.temp_platform), mean(&|row| row.temp_base));
        Self { rows, mean_of_legs, mean_of_platform, mean_of_base, stage: Stage::reference() }
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// 0 at the first row, 1 at the last, by time.
    pub fn elapsed(&self, k: usize) -> f64 {
        let of = |row: Option<&Row>| row.map_or(0.0, |row| row.time);
        let (first, last) = (of(self.rows.first()), of(self.rows.last()));
        (self.rows[k].time - first) / (last - first)
    }
}

fn share(k: usize, n: usize) -> f64 {
    k as f64 / (n.max(2) - 1) as f64
}

/// Six legs, platform, base.
type Temperatures = Vec<[f64; 8]>;

/// ±3 K of air in one and a half cycles; legs at once, platform and base late and damped.
fn diurnal<R: Rng + ?Sized>(n: usize, rng: &mut R) -> Temperatures {
    let (level, phase) = (20.0 + 0.5 * normal(rng), rng.random_range(0.0..TAU));
    // Lag of a body in radians of the cycle's speed: 1 is a delay of an eighth of a cycle.
    let lags = [rng.random_range(0.4..2.0), rng.random_range(0.8..2.5)];
    let wander: Vec<Vec<f64>> = (0..8).map(|_| wandering(n, WANDER.0, WANDER.1, rng)).collect();
    let air =
        |k: usize, lag: f64| 3.0 / (1.0 + lag * lag).sqrt() * (1.5 * TAU * share(k, n) + phase - lag.atan()).sin();
    let lag_of = |body: usize| if body < 6 { 0.0 } else { lags[body - 6] };
    (0..n).map(|k| std::array::from_fn(|body| level + air(k, lag_of(body)) + wander[body][k])).collect()
}

/// 4 K upwards in the run, bodies differing by hundredths of a kelvin only.
fn warm_up<R: Rng + ?Sized>(n: usize, rng: &mut R) -> Temperatures {
    let level = 18.0 + 0.5 * normal(rng);
    let wander: Vec<Vec<f64>> = (0..8).map(|_| wandering(n, 0.03, WANDER.1, rng)).collect();
    (0..n).map(|k| std::array::from_fn(|body| level + 4.0 * share(k, n) + wander[body][k])).collect()
}

/// 6 K down, fast at first; legs at once, platform and base with lags of their own, and each body with a little wander.
fn night<R: Rng + ?Sized>(n: usize, rng: &mut R) -> Temperatures {
    let level = 15.0 + 2.0 * normal(rng);
    let rates = [2.5, rng.random_range(0.9..1.6), rng.random_range(0.4..0.8)];
    let wander: Vec<Vec<f64>> = (0..8).map(|_| wandering(n, 0.3, WANDER.1, rng)).collect();
    let cooled = |k: usize, rate: f64| -6.0 * (1.0 - (-rate * share(k, n)).exp());
    let rate_of = |body: usize| if body < 6 { rates[0] } else { rates[body - 5] };
    (0..n).map(|k| std::array::from_fn(|body| level + cooled(k, rate_of(body)) + wander[body][k])).collect()
}

/// A stationary walk that forgets over some rows.
fn wandering<R: Rng + ?Sized>(n: usize, sd: f64, rows: f64, rng: &mut R) -> Vec<f64> {
    let keep = (-1.0 / rows).exp();
    let mut value = sd * normal(rng);
    let mut next = || {
        let now = value;
        value = keep * value + (1.0 - keep * keep).sqrt() * sd * normal(rng);
        now
    };
    (0..n).map(|_| next()).collect()
}

pub fn normal<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    StandardNormal.sample(rng)
}

/// A random direction.
pub fn direction<R: Rng + ?Sized>(p: usize, rng: &mut R) -> Vec<f64> {
    let raw: Vec<f64> = (0..p).map(|_| normal(rng)).collect();
    let norm = raw.iter().map(|v| v * v).sum::<f64>().sqrt();
    raw.iter().map(|v| v / norm).collect()
}

/// A random angle.
pub fn angle<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    rng.random_range(-PI..PI)
}
