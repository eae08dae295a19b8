//! Combinations of everything that a mechanism file and its data may differ in.

use std::fmt;
use std::path::Path;

use paracal::conditions::Conditions;
use paracal::effect::EffectContext;
use paracal::files::{CsvTable, JointsAndPose, Machine, labelled_joints, number};
use paracal::measurement::{Frames, Noise, TargetPoint};
use paracal::mechanism::characteristic_length;
use paracal::nalgebra::{Rotation3, Vector3};
use paracal::pose::Pose;
use paracal::rand::RngExt;
use paracal::rand::rngs::ChaCha8Rng;
use paracal::simulation::{Command, Instrument, SimulatedSample, draw_parameters, simulate_run, stream};

use crate::common;

const KINDS: [&str; 6] =
    ["table5", "rubin-camera-hexapod", "nategh-agheli", "rotary-stewart", "linear-delta", "tripod-3rps"];
/// One of so many machines has redundant cables, whose forward kinematics take a hundred times as long.
const RARE: usize = 100;
/// Of the numbers of a mechanism file, which stay: it is of metres, kilometres, or half the size of a stadium.
const SIZES: [&str; 3] = ["mm", "in", "m"];
const LENGTHS: [(&str, f64); 4] = [("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("in", 0.0254)];
const ANGLES: [(&str, f64); 4] =
    [("rad", 1.0), ("mrad", 1e-3), ("deg", std::f64::consts::PI / 180.0), ("arcsec", std::f64::consts::PI / 648_000.0)];

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    Poses,
    Positions,
    KnownTargets,
    UnknownTargets,
    Heights,
    HeightsOverUnknownPlane,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Frame {
    Base,
    Tracker,
    TrackerAndTarget,
}

/// What is combined; the numbers follow from the seed.
#[derive(Clone, Debug)]
pub struct Combination {
    seed: u64,
    kind: &'static str,
    pub reading: Reading,
    pub frame: Frame,
    effects: usize,
    pivot: bool,
    order: &'static str,
    /// Of the lengths of the mechanism file: numbers stay, so that the machine has another size.
    unit: &'static str,
    data: ((&'static str, f64), (&'static str, f64)),
    rows: usize,
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

fn one<T: Copy>(of: &[T], rng: &mut ChaCha8Rng) -> T {
    of[rng.random_range(0..of.len())]
}

impl Combination {
    pub fn draw(seed: u64) -> Self {
        let rng = &mut stream(seed, 0);
        let kind = if rng.random_range(0..RARE) == 0 { "planar-cables" } else { one(&KINDS, rng) };
        use Reading::{Heights, HeightsOverUnknownPlane, KnownTargets, Poses, Positions, UnknownTargets};
        let reading =
            one(&[Poses, Poses, Positions, KnownTargets, UnknownTargets, Heights, HeightsOverUnknownPlane], rng);
        let frame = match reading {
            Heights | HeightsOverUnknownPlane => Frame::Base,
            Poses => one(&[Frame::Base, Frame::Tracker, Frame::TrackerAndTarget], rng),
            _ => one(&[Frame::Base, Frame::Tracker], rng),
        };
        let controls_all = !["linear-delta", "tripod-3rps", "planar-cables"].contains(&kind);
        Self {
            seed,
            kind,
            reading,
            frame,
            effects: one(&[0, 0, 1, 1, 2], rng),
            // Files of machines that control some of the angles only take neither.
            pivot: controls_all && rng.random(),
            order: if controls_all { one(&["zyx", "xyz"], rng) } else { "zyx" },
            unit: one(&SIZES, rng),
            data: (one(&LENGTHS, rng), one(&ANGLES, rng)),
            rows: rng.random_range(12..30),
        }
    }

    fn has_targets(&self) -> bool {
        matches!(self.reading, Reading::KnownTargets | Reading::UnknownTargets)
    }

    /// Writes the data, and gives the text of the mechanism file.
    pub fn write(&self, data: &Path) -> Result<String, String> {
        let rng = &mut stream(self.seed, 1);
        let mut machine = self.machine(rng)?;
        let commands = self.commands(&machine, rng);
        machine.refer_to(commands.iter().map(|c| &c.state), "the data");
        let run = self.run(&machine, &commands, rng)?;
        let mut table = joints(&machine, &run);
        table.append(&self.readings(&machine, &run, rng));
        table.append(&conditions(&commands));
        std::fs::write(data, table.to_text()).unwrap();
        let mut document = machine.document().clone();
        if self.reading == Reading::UnknownTargets {
            document.targets.iter_mut().for_each(|t| t.platform = None);
        }
        Ok(document.to_text())
    }

    /// The machine of the file, with the effects that the calibration identifies again.
    fn machine(&self, rng: &mut ChaCha8Rng) -> Result<Machine, String> {
        let file = common::text(&format!("mechanisms/{}.toml", self.kind));
        let unit = format!("length_unit = \"{}\"", self.unit);
        let mut text =
            file.replacen("length_unit = \"mm\"", &unit, 1).replacen("\nrotation_order", "\n# rotation_order", 1);
        // In the unit of the file.
        let drawing = common::machine(self.kind);
        let size = drawing.length_unit.from_si(characteristic_length(drawing.mechanism.as_ref()));
        let mut place = |part: f64| format!("{:?}", in_cube(part * size, rng));
        if self.pivot {
            text = format!("pivot = {}\n{}", place(0.3), text.replacen("\npivot", "\n# pivot", 1));
        }
        if self.has_targets() {
            for k in 1..=4 {
                text += &format!("\n[[target]]\nname = \"smr{k}\"\nplatform = {}\n", place(1.0));
            }
        }
        match self.reading {
            Reading::Heights => text += &format!("\n[plane]\nnormal = [0.1, -0.05, 1.0]\ntip = {}\n", place(0.3)),
            Reading::HeightsOverUnknownPlane => text += &format!("\n[plane]\nidentify = true\ntip = {}\n", place(0.3)),
            _ => {}
        }
        if self.kind == "table5" {
            text += common::effects::STATED;
        }
        let read = |text: &str| Machine::from_text(text, "m.toml".as_ref()).map_err(|e| e.to_string());
        let plain = read(&format!("rotation_order = \"{}\"\n{text}", self.order))?;
        let mut document = plain.document().clone();
        let mut possible = common::effects::entries(&plain);
        possible.retain(|e| e.leg.is_none_or(|leg| leg <= plain.plain().joints().len()));
        document.effects = (0..self.effects).map(|_| possible[rng.random_range(0..possible.len())].clone()).collect();
        document.effects.dedup_by_key(|e| e.label());
        plain.with_document(document).map_err(|e| e.to_string())
    }

    /// Poses about home in changing conditions.
    fn commands(&self, machine: &Machine, rng: &mut ChaCha8Rng) -> Vec<Command> {
        let workspace = machine.workspace.unwrap();
        let command = |row: usize, rng: &mut ChaCha8Rng| {
            let mut state = Conditions::unknown();
            for name in temperatures(machine) {
                state.covariates.insert(name, 20.0 + rng.random_range(-4.0..4.0));
            }
            let elevation: f64 = rng.random_range(0.3..1.4);
            state.covariates.insert("elevation".into(), elevation);
            state.gravity = Some(Vector3::new(elevation.cos(), 0.0, -elevation.sin()));
            state.covariates.insert("payload".into(), rng.random_range(0.0..100.0));
            state.covariates.insert("time".into(), 60.0 * row as f64);
            let u: [f64; 6] = std::array::from_fn(|_| rng.random_range(-0.5..0.5));
            Command { pose: workspace.pose(&u), state }
        };
        (0..self.rows).map(|row| command(row, rng)).collect()
    }

    /// Where a machine as far from its drawing as its tolerances allow goes.
    fn run(
        &self,
        machine: &Machine,
        commands: &[Command],
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<SimulatedSample>, String> {
        let drawing = machine.mechanism.as_ref();
        let truth = drawing.with_values(&draw_parameters(drawing, None, rng), drawing.home());
        let truth = truth.map_err(|e| e.to_string())?;
        let context = EffectContext::new(machine.plain(), machine.environment());
        let instrument = Instrument { context: &context, effects: machine.instrument() };
        let noise = Noise { joint: machine.noise.map_or(0.0, |n| n.joint), ..Noise::stated(0.0, 0.0) };
        let (plain, convention) = (machine.plain(), &machine.convention);
        simulate_run(plain, truth.as_ref(), commands, Some(&instrument), convention, &noise, rng)
            .map_err(|(row, cause)| format!("row {row}: {cause}"))
    }

    /// What an instrument reads of them, in the units of the data.
    fn readings(&self, machine: &Machine, run: &[SimulatedSample], rng: &mut ChaCha8Rng) -> CsvTable {
        let size = characteristic_length(machine.plain());
        let frames = self.frames(size, rng);
        let noise = machine.noise.unwrap_or(Noise::stated(1e-5 * size, 1e-5));
        let mut read = |s: &SimulatedSample| -> Vec<f64> {
            let seen = frames.measured(&s.seen);
            let exact: Vec<f64> = match self.reading {
                Reading::Poses => machine.convention.coordinates(&seen).to_vec(),
                Reading::Positions => machine.convention.coordinates(&seen)[..3].to_vec(),
                Reading::KnownTargets | Reading::UnknownTargets => {
                    machine.targets.iter().flat_map(|t| <[f64; 3]>::from(seen.place(&t.platform.unwrap()))).collect()
                }
                Reading::Heights | Reading::HeightsOverUnknownPlane => {
                    vec![
                        machine.contact.plane.normal.dot(&seen.place(&machine.contact.tip))
                            - machine.contact.plane.distance,
                    ]
                }
            };
            let sigma =
                |k: usize| if self.reading == Reading::Poses && k >= 3 { noise.rotation } else { noise.position };
            exact.into_iter().enumerate().map(|(k, v)| v + sigma(k) * rng.random_range(-1.7..1.7)).collect()
        };
        let (length, angle) = (self.data.0, self.data.1);
        let rows = run.iter().map(|s| {
            let in_unit = |(k, v): (usize, f64)| match self.reading == Reading::Poses && k >= 3 {
                true => number(v / angle.1),
                false => number(v / length.1),
            };
            read(s).into_iter().enumerate().map(in_unit).collect()
        });
        let rows: Vec<Vec<String>> = rows.collect();
        let lengths = |names: &[&str]| names.iter().map(|n| format!("{n}_{}", length.0)).collect::<Vec<_>>();
        let header = match self.reading {
            Reading::Poses => {
                [lengths(&["x", "y", "z"]), ["rx", "ry", "rz"].map(|n| format!("{n}_{}", angle.0)).into()].concat()
            }
            Reading::Positions => lengths(&["x", "y", "z"]),
            Reading::KnownTargets | Reading::UnknownTargets => {
                let of = |t: &TargetPoint| ["x", "y", "z"].map(|axis| format!("{}{axis}_{}", t.name, length.0));
                machine.targets.iter().flat_map(of).collect()
            }
            Reading::Heights | Reading::HeightsOverUnknownPlane => lengths(&["contact"]),
        };
        CsvTable { comments: Vec::new(), header, rows }
    }

    fn frames(&self, size: f64, rng: &mut ChaCha8Rng) -> Frames {
        let mut anywhere = |far: f64| Pose {
            position: Vector3::from(in_cube(far, rng)),
            rotation: Rotation3::new(Vector3::from(in_cube(1.5, rng))),
        };
        let (base, target) = (anywhere(3.0 * size), anywhere(0.3 * size));
        match self.frame {
            Frame::Base => Frames::default(),
            Frame::Tracker => Frames { base, target: Pose::identity() },
            Frame::TrackerAndTarget => Frames { base, target },
        }
    }
}

/// Names of temperatures that a machine may have.
fn temperatures(machine: &Machine) -> Vec<String> {
    let of_legs = (1..=machine.plain().joints().len()).map(|leg| format!("temp_leg{leg}"));
    let others = ["temp_platform", "temp_base", "temp_base1", "temp_base2", "temp_base3"];
    of_legs.chain(others.map(str::to_owned)).collect()
}

fn in_cube(half: f64, rng: &mut ChaCha8Rng) -> [f64; 3] {
    std::array::from_fn(|_| rng.random_range(-half..half))
}

fn joints(machine: &Machine, run: &[SimulatedSample]) -> CsvTable {
    let row = |s: &SimulatedSample| JointsAndPose { id: None, joints: s.joints.clone(), pose: s.measured };
    labelled_joints(machine, String::new(), &run.iter().map(row).collect::<Vec<_>>())
}

fn conditions(commands: &[Command]) -> CsvTable {
    let unit = |name: &str| match name {
        "elevation" => "rad",
        "payload" => "kg",
        "time" => "s",
        _ => "degC",
    };
    let names: Vec<(&String, &str)> = commands[0].state.covariates.keys().map(|n| (n, unit(n))).collect();
    let row = |c: &Command| names.iter().map(|(n, _)| number(c.state.covariates[*n])).collect();
    CsvTable {
        comments: Vec::new(),
        header: names.iter().map(|(n, unit)| format!("{n}_{unit}")).collect(),
        rows: commands.iter().map(row).collect(),
    }
}
