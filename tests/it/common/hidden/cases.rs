//! Draws cases and keeps the truth about them.

use rand::rngs::ChaCha8Rng;
use rand::seq::index::sample;
use rand::{RngExt, SeedableRng};

use super::effects::{CATALOGUE, INSTRUMENTS, Influence, Known, Planted, Scan, measured, named};
use super::hexapod::{Geometry, Pose};
use super::limits::{Limits, NOISE};
use super::mistakes::Mistake;
use super::run::{Run, Weather, direction, normal};
use super::setting::Setting;
use super::stage::Reading;
use super::text::{self, Sheet};
use super::unlisted_effects::{NAMES, UnlistedEffect};

/// Rows of a run.
pub const ROWS: usize = 120;
/// Standard deviation of each of the 42 errors of the true machine, m.
const ERROR: f64 = 0.5e-3;
/// Causes that a warm-up confuses.
pub const WARM_UP_CAUSES: [&str; 5] =
    ["thermal.legs.uniform", "thermal.base", "thermal.platform", "drift.frame", "drift.leg"];

/// What is hidden. Sizes are multiples of the detection limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Nothing.
    Null,
    /// Nothing but a share of rows with gross errors of 8 to 60 σ.
    Outliers(f64),
    /// One effect of the catalogue.
    One(f64),
    /// One effect and five per cent of outliers.
    OneWithOutliers(f64),
    /// Two different effects.
    Two(f64),
    /// Three of them.
    Three(f64),
    /// Something wrong with the readings.
    Instrument(f64),
    /// One effect outside the catalogue.
    Outside(f64),
    /// One of five effects during a warm-up.
    WarmUp(f64),
    /// A file that is read wrongly.
    Misread,
    /// Noise that grows by a factor through the run, or with elevation.
    Noise(f64),
}

/// What was hidden, SI; legs from 1, rows from 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// The effect outside the catalogue, or the form of the mistake.
    pub detail: String,
    pub effects: Vec<String>,
    /// Of each effect; of an effect outside the catalogue its leg.
    pub legs: Vec<Option<usize>>,
    pub rows: Vec<Option<usize>>,
    pub parameters: Vec<Vec<f64>>,
    pub reading: Option<String>,
    /// Covariates that may be named for what is outside the catalogue, or for noise that varies.
    pub covariates: Vec<String>,
    /// Coordinates that may be named for what is outside the catalogue.
    pub coordinates: Vec<String>,
    /// Effects of the catalogue that are right for it as well.
    pub also: Vec<String>,
    pub outlier_rows: Vec<usize>,
}

/// Two files and the truth.
#[derive(Clone, Debug)]
pub struct Case {
    pub mechanism: String,
    pub data: String,
    pub truth: Truth,
}

/// Case `number` of a kind. Kinds with variants (effects, unlisted_effects, mistakes) take them in turn.
pub fn draw(kind: Kind, seed: u64, number: usize) -> Option<Case> {
    draw_in_run(kind, ROWS, seed, number)
}

/// The same in a run of another length.
pub fn draw_in_run(kind: Kind, rows: usize, seed: u64, number: usize) -> Option<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream((stream(kind) << 32) | number as u64);
    let weather = if matches!(kind, Kind::WarmUp(_)) { Weather::WarmUp } else { Weather::Reference };
    let run = Run::draw(rows, weather, &mut rng);
    let errors: [f64; 42] = std::array::from_fn(|_| ERROR * normal(&mut rng));
    let machine = Geometry::nominal().changed(&errors);

    let mut truth = Truth::default();
    let mut planted: Vec<Planted> = Vec::new();
    let mut unlisted_effects: Vec<UnlistedEffect> = Vec::new();
    match kind {
        Kind::One(size) | Kind::OneWithOutliers(size) => {
            planted.push(plant(&CATALOGUE[number % CATALOGUE.len()], size, &Limits::of(&run)?, &run, &mut rng)?);
        }
        Kind::Two(size) | Kind::Three(size) => {
            let limits = Limits::of(&run)?;
            let count = if matches!(kind, Kind::Two(_)) { 2 } else { 3 };
            for which in sample(&mut rng, CATALOGUE.len(), count) {
                planted.push(plant(&CATALOGUE[which], size, &limits, &run, &mut rng)?);
            }
        }
        Kind::Instrument(size) => {
            planted.push(plant(&INSTRUMENTS[number % INSTRUMENTS.len()], size, &Limits::of(&run)?, &run, &mut rng)?);
        }
        Kind::WarmUp(size) => {
            let known = named(WARM_UP_CAUSES[number % WARM_UP_CAUSES.len()])?;
            planted.push(plant(&known, size, &Limits::of(&run)?, &run, &mut rng)?);
        }
        Kind::Outside(size) => {
            let mut stranger = UnlistedEffect::draw(number % NAMES.len(), &run, &mut rng);
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            stranger.amplitude =
                sign * size * Limits::at_limit_of_strangers() / Limits::of(&run)?.prominence(&stranger)?;
            unlisted_effects.push(stranger);
        }
        Kind::Null | Kind::Outliers(_) | Kind::Misread | Kind::Noise(_) => {}
    }
    let influences: Vec<&dyn Influence> = planted
        .iter()
        .map(|p| p as &dyn Influence)
        .chain(unlisted_effects.iter().map(|s| s as &dyn Influence))
        .collect();
    let mut poses = measured(&machine, &run, &influences)?;

    let loudness = loudness(kind, &run, &mut truth, &mut rng);
    for (q, loud) in poses.iter_mut().zip(&loudness) {
        (0..6).for_each(|k| q[k] += loud * NOISE[usize::from(k >= 3)] * normal(&mut rng));
    }
    if let Kind::Outliers(_) | Kind::OneWithOutliers(_) = kind {
        let share = if let Kind::Outliers(share) = kind { share } else { 0.05 };
        let mut hit = sample(&mut rng, rows, (share * rows as f64).round() as usize).into_vec();
        hit.sort_unstable();
        for k in &hit {
            let size = rng.random_range(8.0..60.0);
            let gross = direction(6, &mut rng);
            (0..6).for_each(|j| poses[*k][j] += size * NOISE[usize::from(j >= 3)] * gross[j]);
        }
        truth.outlier_rows = hit;
    }
    for p in &planted {
        truth.effects.push(p.name.to_owned());
        truth.legs.push(p.leg.map(|leg| leg + 1));
        truth.rows.push(p.row);
        truth.parameters.push(p.theta.clone());
    }
    for s in &unlisted_effects {
        truth.detail = s.name.to_owned();
        truth.legs.push(s.leg.map(|leg| leg + 1));
        truth.covariates = s.covariates.clone();
        truth.coordinates = s.coordinates.clone();
        truth.also = s.names.clone();
    }
    let mut sheet = Sheet::of(run, poses);
    if kind == Kind::Misread {
        let mistake = Mistake::of(number);
        truth.detail = mistake.make(&mut sheet, &mut rng);
        truth.reading = Some(mistake.reading.to_owned());
    }
    Some(Case { mechanism: text::mechanism(), data: sheet.csv(), truth })
}

/// Case `number` of a kind in a setting.
pub fn draw_in(setting: &Setting, kind: Kind, seed: u64, number: usize) -> Option<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream((stream(kind) << 32) | number as u64);
    let run = setting.run(&mut rng);
    let errors: [f64; 42] = std::array::from_fn(|_| run.stage.design.error * normal(&mut rng));
    let machine = run.stage.design.geometry.changed(&errors);
    let recorded: Vec<&Known> = CATALOGUE.iter().filter(|known| setting.records(known)).collect();
    let (names, size): (Vec<&Known>, f64) = match kind {
        Kind::One(size) | Kind::OneWithOutliers(size) => (vec![recorded[number % recorded.len()]], size),
        Kind::Instrument(size) => {
            // Positions alone do not show how angles are read.
            let blind = setting.reading == Reading::Positions;
            let shown = |known: &&Known| !(blind && known.name == "instrument.rotation_gain");
            let all: Vec<&Known> = INSTRUMENTS.iter().filter(shown).collect();
            (vec![all[number % all.len()]], size)
        }
        Kind::Two(size) => (sample(&mut rng, recorded.len(), 2).into_iter().map(|k| recorded[k]).collect(), size),
        Kind::Three(size) => (sample(&mut rng, recorded.len(), 3).into_iter().map(|k| recorded[k]).collect(), size),
        _ => (Vec::new(), 0.0),
    };
    let limits = if names.is_empty() { None } else { Some(Limits::of(&run)?) };
    let size = size * setting.loudness();
    let plants = names.iter().filter_map(|known| Some(plant(known, size, limits.as_ref()?, &run, &mut rng)));
    let planted = plants.collect::<Option<Vec<Planted>>>()?;
    let influences: Vec<&dyn Influence> = planted.iter().map(|p| p as &dyn Influence).collect();
    let poses = measured(&machine, &run, &influences)?;
    let mut seen: Vec<Vec<f64>> = poses.iter().map(|q| run.stage.seen(&Pose::of(*q))).collect();
    let sigma = run.stage.noise();
    setting.add_noise(&sigma, &mut seen, &mut rng);
    let mut truth = Truth::default();
    if let Kind::OneWithOutliers(_) = kind {
        truth.outlier_rows = gross(&mut seen, &sigma, &mut rng);
    }
    for p in &planted {
        truth.effects.push(p.name.to_owned());
        truth.legs.push(p.leg.map(|leg| leg + 1));
        truth.rows.push(p.row);
        truth.parameters.push(p.theta.clone());
    }
    Some(Case { mechanism: setting.mechanism(&run), data: setting.csv(&run, &seen, &mut rng), truth })
}

/// Five per cent of the rows, moved by 8 to 60 σ.
fn gross(seen: &mut [Vec<f64>], sigma: &[f64], rng: &mut ChaCha8Rng) -> Vec<usize> {
    let n = seen.len();
    let mut hit = sample(rng, n, (0.05 * n as f64).round() as usize).into_vec();
    hit.sort_unstable();
    for k in &hit {
        let size = rng.random_range(8.0..60.0);
        let along = direction(sigma.len(), rng);
        seen[*k].iter_mut().zip(sigma).zip(along).for_each(|((v, s), d)| *v += size * s * d);
    }
    hit
}

/// Random numbers of different kinds have nothing to do with each other.
fn stream(kind: Kind) -> u64 {
    let (number, size) = match kind {
        Kind::Null => (1, 0.0),
        Kind::Outliers(share) => (2, share),
        Kind::One(size) => (3, size),
        Kind::OneWithOutliers(size) => (4, size),
        Kind::Two(size) => (5, size),
        Kind::Outside(size) => (6, size),
        Kind::WarmUp(size) => (7, size),
        Kind::Misread => (8, 0.0),
        Kind::Noise(factor) => (9, factor),
        Kind::Three(size) => (10, size),
        Kind::Instrument(size) => (11, size),
    };
    100_000 * number + (1000.0 * size) as u64
}

/// An effect at a random place, in a random direction of its parameters, of a size in detection limits.
fn plant(known: &Known, size: f64, limits: &Limits<'_>, run: &Run, rng: &mut ChaCha8Rng) -> Option<Planted> {
    let leg = matches!(known.scan, Scan::Leg | Scan::LegAndRow).then(|| rng.random_range(0..6));
    // A step in the first or last tenth is hardly more than a few odd rows.
    let edge = run.len() / 10;
    let row = matches!(known.scan, Scan::Row | Scan::LegAndRow).then(|| rng.random_range(edge..run.len() - edge));
    let along = direction(known.scale.len(), rng);
    let theta: Vec<f64> = along.iter().zip(known.scale).map(|(d, s)| d * s).collect();
    let prominence = {
        let d = nalgebra::DVector::from_vec(along);
        (limits.information(known, leg, row)? * &d).dot(&d).sqrt()
    };
    let by = size * limits.at_limit(known) / prominence;
    Some(Planted { name: known.name, leg, row, theta: theta.iter().map(|t| t * by).collect() })
}

/// Factor of the noise, row by row.
fn loudness(kind: Kind, run: &Run, truth: &mut Truth, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let Kind::Noise(factor) = kind else { return vec![1.0; run.len()] };
    let in_time = rng.random_bool(0.5);
    truth.covariates = vec![if in_time { "time" } else { "elevation" }.to_owned()];
    let elevations: Vec<f64> = run.rows.iter().map(|row| row.elevation).collect();
    let (low, high) = elevations.iter().fold((f64::MAX, f64::MIN), |(l, h), e| (l.min(*e), h.max(*e)));
    let position = |k: usize| if in_time { run.elapsed(k) } else { (elevations[k] - low) / (high - low) };
    (0..run.len()).map(|k| factor.powf(position(k) - 0.5)).collect()
}
