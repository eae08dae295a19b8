//! What campaigns differ in beside what is hidden in them, and the text of their files.

use std::fmt::Write;

use rand::seq::index::sample;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StudentT};

use super::effects::{CENTRE_OF_MASS, Known, MASS, PAYLOAD_CENTRE, PITCH};
use super::run::{Run, Weather, normal};
use super::stage::{Make, Reading, Stage};

/// How the noise of a campaign is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    AsStated,
    Double,
    Half,
    /// Student's t with three degrees of freedom, of the stated variance.
    HeavyTails,
    /// Each row remembers 0.6 of the one before.
    Correlated,
    /// Written to one standard deviation.
    Rounded,
}

/// What was written down beside the readings, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    Reference,
    OneNight,
    /// Elevation goes up and down in sweeps.
    Sweeps,
    /// Of all temperatures only the mean of the legs.
    OneSensor,
    /// A tenth of the cells of two columns is empty.
    Gaps,
    /// Further columns that no catalogue knows.
    UnusualNames,
    /// Ten columns of random numbers.
    Nonsense,
}

/// One campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    pub rows: usize,
    pub make: Make,
    pub noise: Noise,
    pub tracker: bool,
    pub reading: Reading,
    pub recorded: Recorded,
}

pub const REFERENCE: Setting = Setting {
    rows: 120,
    make: Make::Reference,
    noise: Noise::AsStated,
    tracker: false,
    reading: Reading::Poses,
    recorded: Recorded::Reference,
};

const MAKES: [Make; 5] = [Make::Reference, Make::Desk, Make::ThreeThree, Make::Camera, Make::Wide];
const NOISES: [Noise; 6] =
    [Noise::AsStated, Noise::Double, Noise::Half, Noise::HeavyTails, Noise::Correlated, Noise::Rounded];
const READINGS: [Reading; 3] = [Reading::Poses, Reading::Targets, Reading::Positions];
const RECORDED: [Recorded; 7] = [
    Recorded::Reference,
    Recorded::OneNight,
    Recorded::Sweeps,
    Recorded::OneSensor,
    Recorded::Gaps,
    Recorded::UnusualNames,
    Recorded::Nonsense,
];

impl Setting {
    /// Every setting that differs from the reference in one respect, with the reference itself first.
    pub fn each() -> Vec<Self> {
        let mut all = vec![REFERENCE];
        all.extend([30, 60, 240].map(|rows| Self { rows, ..REFERENCE }));
        all.extend(MAKES[1..].iter().map(|make| Self { make: *make, ..REFERENCE }));
        all.extend(NOISES[1..].iter().map(|noise| Self { noise: *noise, ..REFERENCE }));
        all.push(Self { tracker: true, ..REFERENCE });
        all.extend(READINGS[1..].iter().map(|reading| Self { reading: *reading, ..REFERENCE }));
        all.extend(RECORDED[1..].iter().map(|recorded| Self { recorded: *recorded, ..REFERENCE }));
        all
    }

    /// One that differs in any respects.
    pub fn draw<R: Rng + ?Sized>(rng: &mut R) -> Self {
        let mut pick = |n: usize| rng.random_range(0..n);
        Self {
            rows: [30, 60, 120, 240][pick(4)],
            make: MAKES[pick(5)],
            noise: NOISES[pick(6)],
            tracker: pick(2) == 1,
            reading: READINGS[pick(3)],
            recorded: RECORDED[pick(7)],
        }
    }

    /// What is not as in the reference, in words.
    pub fn name(&self) -> String {
        let mut parts = Vec::new();
        if self.rows != REFERENCE.rows {
            parts.push(format!("{} rows", self.rows));
        }
        if self.make != REFERENCE.make {
            parts.push(format!("{:?}", self.make));
        }
        if self.noise != REFERENCE.noise {
            parts.push(format!("noise {:?}", self.noise));
        }
        if self.tracker {
            parts.push("tracker".into());
        }
        if self.reading != REFERENCE.reading {
            parts.push(format!("{:?}", self.reading));
        }
        if self.recorded != REFERENCE.recorded {
            parts.push(format!("{:?}", self.recorded));
        }
        if parts.is_empty() { "reference".into() } else { parts.join(", ") }
    }

    /// A run in this setting.
    pub fn run<R: Rng + ?Sized>(&self, rng: &mut R) -> Run {
        let design = self.make.design();
        let size = design.targets[0].norm();
        let frames = self.tracker.then(|| Stage::tracker(0.3 * size, rng));
        // Targets and points are known in the platform frame.
        let frames = frames.map(|[base, target]| match self.reading {
            Reading::Poses => [base, target],
            _ => [base, super::hexapod::Pose { t: nalgebra::Vector3::zeros(), r: nalgebra::Matrix3::identity() }],
        });
        let stage = Stage { design, reading: self.reading, frames };
        let weather = if self.recorded == Recorded::OneNight { Weather::Night } else { Weather::Reference };
        let mut run = Run::draw_on(stage, self.rows, weather, rng);
        if self.recorded == Recorded::Sweeps {
            let n = run.len();
            for (k, row) in run.rows.iter_mut().enumerate() {
                let part = 4.0 * k as f64 / n as f64;
                let up = if (part as usize).is_multiple_of(2) { part.fract() } else { 1.0 - part.fract() };
                row.elevation = (20.0 + 70.0 * up).to_radians();
            }
        }
        run
    }

    /// How much larger than the stated noise an effect must be to stand out as it would there.
    pub fn loudness(&self) -> f64 {
        match self.noise {
            Noise::Double => 2.0,
            Noise::Half => 0.5,
            // A slow effect stands out of fewer independent rows.
            Noise::Correlated => (1.6_f64 / 0.4).sqrt(),
            _ => 1.0,
        }
    }

    /// True if what an effect depends on was written down.
    pub fn records(&self, known: &Known) -> bool {
        let of_sensors =
            ["thermal.legs.individual", "thermal.leg.single", "thermal.platform", "thermal.base"].contains(&known.name);
        !(self.recorded == Recorded::OneSensor && of_sensors)
    }

    /// Noise of every number of a campaign, added to what is seen.
    pub fn add_noise<R: Rng + ?Sized>(&self, sigma: &[f64], seen: &mut [Vec<f64>], rng: &mut R) {
        let tails = StudentT::new(3.0).ok();
        let mut memory = vec![0.0; sigma.len()];
        for row in seen.iter_mut() {
            for ((value, sigma), memory) in row.iter_mut().zip(sigma).zip(&mut memory) {
                let z = match self.noise {
                    Noise::HeavyTails => tails.map_or(f64::NAN, |t| t.sample(rng)) / 3_f64.sqrt(),
                    Noise::Correlated => {
                        // From the stationary distribution on.
                        let fresh: f64 = normal(rng);
                        *memory = if *memory == 0.0 { fresh } else { 0.6 * *memory + 0.8 * fresh };
                        *memory
                    }
                    _ => normal(rng),
                };
                let loud = if self.noise == Noise::Correlated { 1.0 } else { self.loudness() };
                *value += loud * sigma * z;
                if self.noise == Noise::Rounded {
                    *value = (*value / sigma).round() * sigma;
                }
            }
        }
    }

    /// The measurement file.
    pub fn csv<R: Rng + ?Sized>(&self, run: &Run, seen: &[Vec<f64>], rng: &mut R) -> String {
        let mut head: Vec<String> = vec!["time_s".into()];
        head.extend((1..=6).map(|i| format!("leg{i}_mm")));
        match self.reading {
            Reading::Poses => head.extend(["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"].map(str::to_owned)),
            Reading::Targets => {
                head.extend((1..=4).flat_map(|p| ["x", "y", "z"].map(|axis| format!("p{p}{axis}_mm"))));
            }
            Reading::Positions => head.extend(["x_mm", "y_mm", "z_mm"].map(str::to_owned)),
        }
        let one = self.recorded == Recorded::OneSensor;
        match one {
            true => head.push("temp_legs_degC".into()),
            false => {
                head.extend((1..=6).map(|i| format!("temp_leg{i}_degC")));
                head.extend(["temp_platform_degC", "temp_base_degC"].map(str::to_owned));
            }
        }
        head.extend(["elevation_deg", "azimuth_deg", "payload_kg"].map(str::to_owned));
        let more: Vec<String> = match self.recorded {
            Recorded::UnusualNames => {
                ["Humidity_%", "wind speed", "T_hall_degC", "operator_id"].map(str::to_owned).to_vec()
            }
            Recorded::Nonsense => (0..10).map(|k| format!("channel{k}")).collect(),
            _ => Vec::new(),
        };
        head.extend(more.iter().cloned());
        let gaps: Vec<Vec<usize>> = match self.recorded {
            Recorded::Gaps => (0..2).map(|_| sample(rng, run.len(), run.len() / 10).into_vec()).collect(),
            _ => Vec::new(),
        };
        let mut text = head.join(",") + "\n";
        for (k, (row, seen)) in run.rows.iter().zip(seen).enumerate() {
            let mut cells: Vec<String> = vec![format!("{:.3}", row.time)];
            cells.extend(row.commanded.iter().map(|l| format!("{:.9}", 1e3 * l)));
            let angles = self.reading == Reading::Poses;
            let shown =
                |(j, v): (usize, &f64)| format!("{:.9}", if angles && j >= 3 { v.to_degrees() } else { 1e3 * v });
            cells.extend(seen.iter().enumerate().map(shown));
            let gap = |which: usize| gaps.get(which).is_some_and(|rows| rows.contains(&k));
            let cell = |v: f64, gap: bool| if gap { String::new() } else { format!("{v:.6}") };
            match one {
                true => cells.push(cell(row.temp_legs.iter().sum::<f64>() / 6.0, false)),
                false => {
                    cells.extend(row.temp_legs.iter().map(|v| cell(*v, false)));
                    cells.extend([cell(row.temp_platform, gap(0)), cell(row.temp_base, gap(1))]);
                }
            }
            cells.extend([row.elevation.to_degrees(), row.azimuth.to_degrees(), row.payload].map(|v| cell(v, false)));
            cells.extend(more.iter().map(|_| cell(normal(rng), false)));
            text += &(cells.join(",") + "\n");
        }
        text
    }

    /// The mechanism file.
    pub fn mechanism(&self, run: &Run) -> String {
        let design = &run.stage.design;
        let mut text =
            "name = \"campaign\"\ntype = \"six-hardpoint\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\n".to_owned();
        let list = |v: &nalgebra::Vector3<f64>| format!("[{:.9}, {:.9}, {:.9}]", 1e3 * v.x, 1e3 * v.y, 1e3 * v.z);
        for i in 0..6 {
            let (a, b) = (&design.geometry.platform[i], &design.geometry.base[i]);
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "[[leg]]\nplatform = {}\nbase = {}\nlength = {:.9}\n",
                list(a),
                list(b),
                1e3 * design.lengths[i]
            );
        }
        let [shift, turn] = design.half;
        let _ = write!(
            text,
            "\n[home]\nposition = {}\nrotation = [0.0, 0.0, 0.0]\n[workspace]\nposition = [{p}, {p}, {p}]\nrotation = [{r}, {r}, {r}]\n\
             [tolerance]\nanchor = {tolerance}\nlength = {tolerance}\n[noise]\nposition = {}\nrotation = {}\n\
             [platform]\nmass_kg = {MASS:.1}\ncentre_of_mass = [0.0, 0.0, {:.1}]\npayload_centre = [0.0, 0.0, {:.1}]\n\
             [actuator]\nscrew_pitch = {:.1}\n",
            list(&design.home.t),
            1e3 * design.noise[0],
            design.noise[1].to_degrees(),
            1e3 * CENTRE_OF_MASS,
            1e3 * PAYLOAD_CENTRE,
            1e3 * PITCH,
            p = 1e3 * shift,
            r = turn.to_degrees(),
            tolerance = 1e3 * design.error,
        );
        if self.reading == Reading::Targets {
            for (k, place) in design.targets.iter().enumerate() {
                let _ = write!(text, "\n[[target]]\nname = \"p{}\"\nplatform = {}\n", k + 1, list(place));
            }
        }
        text
    }
}
