//! Machines that are no hexapods, with a few effects each: a printer's delta of three carriages and six rods, and a
//! positioner of which only the poses are known.

use std::fmt::Write;

use nalgebra::{DMatrix, DVector, Matrix6, Rotation3, Vector3, Vector6};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::cases::{Case, Truth};
use super::hexapod::Pose;
use super::limits::noncentrality;
use super::run::{direction, normal};

/// Which machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    Delta,
    Positioner,
}

/// Over what an effect is searched for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scan {
    None,
    Joint,
    Row,
    JointAndRow,
}

/// Name, usual sizes and scan.
type Known = (&'static str, &'static [f64], Scan);

const OF_DELTAS: [Known; 9] = [
    ("thermal.frame", &[1e-5; 6], Scan::None),
    ("scale.common", &[2e-3], Scan::None),
    ("scale.per_leg", &[2e-3; 3], Scan::None),
    ("length.quadratic", &[5e-2; 3], Scan::None),
    ("backlash", &[5e-6; 3], Scan::None),
    ("drift.frame", &[1e-5; 6], Scan::None),
    ("drift.leg", &[1e-5], Scan::Joint),
    ("step.frame", &[1e-5; 6], Scan::Row),
    ("step.leg", &[1e-5], Scan::JointAndRow),
];

const OF_POSITIONERS: [Known; 6] = [
    ("sag.linear", &[1e-5; 18], Scan::None),
    ("thermal.pose", &[1e-5; 6], Scan::None),
    ("drift.frame", &[1e-5; 6], Scan::None),
    ("step.frame", &[1e-5; 6], Scan::Row),
    ("axis.scale", &[3e-4], Scan::Joint),
    ("axis.backlash", &[5e-6], Scan::Joint),
];

/// An effect with values, of a joint from 0 and from a row on.
struct Planted {
    known: Known,
    joint: usize,
    row: usize,
    theta: Vec<f64>,
}

/// One row of a run.
struct Row {
    /// From 0 to 1 through the run.
    elapsed: f64,
    commanded: Vec<f64>,
    before: Vec<f64>,
    /// Minus its mean.
    temperature: f64,
    elevation: f64,
}

impl Other {
    /// What may be hidden in it.
    fn catalogue(self) -> &'static [Known] {
        match self {
            Self::Delta => &OF_DELTAS,
            Self::Positioner => &OF_POSITIONERS,
        }
    }

    /// Noise of a position and of an angle, m and rad; the same is stated.
    fn noise(self) -> [f64; 2] {
        match self {
            Self::Delta => [20e-6, 0.01_f64.to_radians()],
            Self::Positioner => [1e-6, 0.5e-3_f64.to_radians()],
        }
    }

    /// Number of things that are not as drawn, and their standard deviation, m and rad.
    fn errors(self) -> (usize, f64) {
        match self {
            Self::Delta => (42, 0.2e-3),
            Self::Positioner => (6, 1e-4),
        }
    }

    fn home(self) -> Vector6<f64> {
        match self {
            Self::Delta => Vector6::new(0.0, 0.0, 0.1, 0.0, 0.0, 0.0),
            Self::Positioner => Vector6::zeros(),
        }
    }

    /// Commanded joints at a pose of the machine as drawn.
    fn joints(self, pose: &Vector6<f64>) -> Vec<f64> {
        match self {
            Self::Delta => {
                [0, 2, 4].map(|rod| carriage(&rods(&[0.0; 42])[rod], &pose.fixed_rows::<3>(0).into())).to_vec()
            }
            Self::Positioner => pose.iter().copied().collect(),
        }
    }

    /// The pose of a machine with errors at joints.
    fn reach(self, errors: &[f64], joints: &[f64]) -> Option<Vector6<f64>> {
        match self {
            Self::Delta => delta_pose(&rods(errors), joints, self.home()),
            Self::Positioner => Some(Vector6::from_fn(|k, _| joints[k] + errors[k])),
        }
    }
}

/// A rod: its end on the platform, its end on the carriage at height zero, its length, and its carriage.
struct Rod {
    platform: Vector3<f64>,
    base: Vector3<f64>,
    length: f64,
    carriage: usize,
}

/// The six rods, each with seven errors.
fn rods(errors: &[f64]) -> Vec<Rod> {
    let rod = |k: usize| {
        let (carriage, side) = (k / 2, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
        let turned = |x: f64, y: f64, z: f64| {
            Rotation3::from_axis_angle(&Vector3::z_axis(), 120_f64.to_radians() * carriage as f64)
                * Vector3::new(x, y, z)
        };
        let e = |i: usize| errors[7 * k + i];
        Rod {
            platform: turned(side * 0.025, 0.030, 0.020) + Vector3::new(e(0), e(1), e(2)),
            base: turned(side * 0.025, 0.200, 0.0) + Vector3::new(e(3), e(4), e(5)),
            length: 0.340 + e(6),
            carriage,
        }
    };
    (0..6).map(rod).collect()
}

/// Height of a carriage above an upright platform at a place.
fn carriage(rod: &Rod, place: &Vector3<f64>) -> f64 {
    let end = place + rod.platform;
    let across = (end - rod.base).xy().norm_squared();
    end.z + (rod.length * rod.length - across).sqrt()
}

/// The platform that six rods hold, by Newton's method with differences.
fn delta_pose(rods: &[Rod], joints: &[f64], near: Vector6<f64>) -> Option<Vector6<f64>> {
    let left = |q: &Vector6<f64>| {
        let pose = Pose::of((*q).into());
        Vector6::from_fn(|k, _| {
            let rod = &rods[k];
            let end = rod.base + Vector3::z() * joints[rod.carriage];
            (pose.t + pose.r * rod.platform - end).norm() - rod.length
        })
    };
    let mut q = near;
    for _ in 0..40 {
        let at = left(&q);
        if at.amax() < 1e-14 {
            break;
        }
        let column = |k: usize| {
            let mut ahead = q;
            ahead[k] += 1e-7;
            let mut behind = q;
            behind[k] -= 1e-7;
            (left(&ahead) - left(&behind)) / 2e-7
        };
        let columns: Vec<Vector6<f64>> = (0..6).map(column).collect();
        q -= Matrix6::from_columns(&columns).lu().solve(&at)?;
    }
    (left(&q).amax() < 1e-11).then_some(q)
}

impl Planted {
    /// What it adds to the joints of a row.
    fn push(&self, machine: Other, row: &Row, k: usize, joints: &mut [f64]) {
        let home = machine.joints(&machine.home());
        let travel = |j: usize| row.commanded[j] - home[j];
        let each = joints.iter_mut().enumerate();
        let t = |j: usize| self.theta[j];
        match self.known.0 {
            "scale.common" => each.for_each(|(j, h)| *h += t(0) * travel(j)),
            "scale.per_leg" => each.for_each(|(j, h)| *h += t(j) * travel(j)),
            "length.quadratic" => each.for_each(|(j, h)| *h += t(j) * travel(j).powi(2)),
            "backlash" => each.for_each(|(j, h)| *h += 0.5 * t(j) * (row.commanded[j] - row.before[j]).signum()),
            "drift.leg" => joints[self.joint] += t(0) * row.elapsed,
            "step.leg" if k >= self.row => joints[self.joint] += t(0),
            "axis.scale" => joints[self.joint] += t(0) * travel(self.joint),
            "axis.backlash" => {
                joints[self.joint] += 0.5 * t(0) * (row.commanded[self.joint] - row.before[self.joint]).signum();
            }
            _ => {}
        }
    }

    /// The small motion with which the platform is seen.
    fn motion(&self, row: &Row, k: usize) -> Vector6<f64> {
        let by = match self.known.0 {
            "thermal.frame" | "thermal.pose" => row.temperature,
            "drift.frame" => row.elapsed,
            "step.frame" => f64::from(u8::from(k >= self.row)),
            "sag.linear" => {
                let down = [row.elevation.cos(), 0.0, -row.elevation.sin()];
                return Vector6::from_fn(|i, _| (0..3).map(|j| self.theta[3 * i + j] * down[j]).sum());
            }
            _ => return Vector6::zeros(),
        };
        Vector6::from_fn(|i, _| self.theta[i] * by)
    }
}

/// The poses that are seen, without noise.
fn seen(machine: Other, rows: &[Row], errors: &[f64], hidden: &[&Planted]) -> Option<Vec<Vector6<f64>>> {
    let one = |(k, row): (usize, &Row)| {
        let mut joints = row.commanded.clone();
        hidden.iter().for_each(|h| h.push(machine, row, k, &mut joints));
        let mut q = machine.reach(errors, &joints)?;
        for motion in hidden.iter().map(|h| h.motion(row, k)) {
            match machine {
                // Coordinates are what they are.
                Other::Positioner => q += motion,
                Other::Delta => {
                    let part = |first: usize| Vector3::new(motion[first], motion[first + 1], motion[first + 2]);
                    q = Pose::of(q.into()).carried(part(0), part(3)).coordinates().into();
                }
            }
        }
        Some(q)
    };
    rows.iter().enumerate().map(one).collect()
}

/// A run about home.
fn run(machine: Other, n: usize, rng: &mut ChaCha8Rng) -> Vec<Row> {
    let home = machine.home();
    let mut before = machine.joints(&home);
    let mut wander = 0.0;
    let mut rows: Vec<Row> = (0..n)
        .map(|k| {
            let mut unit = |half: f64| half * rng.random_range(-1.0..1.0);
            let q = match machine {
                Other::Delta => home + Vector6::new(unit(0.09), unit(0.09), unit(0.07), 0.0, 0.0, 0.0),
                Other::Positioner => Vector6::from_fn(|_, _| unit(5e-3)),
            };
            let commanded = machine.joints(&q);
            wander = 0.9 * wander + 0.4 * normal(rng);
            let elapsed = k as f64 / (n - 1) as f64;
            Row {
                elapsed,
                before: std::mem::replace(&mut before, commanded.clone()),
                commanded,
                temperature: 2.0 * (9.0 * elapsed).sin() + wander,
                elevation: rng.random_range(20_f64..85.0).to_radians(),
            }
        })
        .collect();
    let mean = rows.iter().map(|row| row.temperature).sum::<f64>() / n as f64;
    rows.iter_mut().for_each(|row| row.temperature -= mean);
    rows
}

/// In units of the noise.
fn whitened(machine: Other, moved: &[Vector6<f64>], from: &[Vector6<f64>]) -> DVector<f64> {
    let noise = machine.noise();
    let all = moved.iter().zip(from).flat_map(|(m, f)| (0..6).map(move |k| (m[k] - f[k]) / noise[usize::from(k >= 3)]));
    DVector::from_iterator(6 * moved.len(), all)
}

/// How much of an effect stands out of what the errors of the machine take up: √λ.
fn prominence(machine: Other, rows: &[Row], effect: &Planted) -> Option<f64> {
    const STEP: f64 = 1e-6;
    let (count, size) = machine.errors();
    let drawn = vec![0.0; count];
    let undisturbed = seen(machine, rows, &drawn, &[])?;
    let (numbers, prior) = (6 * rows.len(), 2.0 * size);
    let mut columns = DMatrix::zeros(numbers + count, count);
    for j in 0..count {
        let mut errors = drawn.clone();
        errors[j] = STEP;
        let column = whitened(machine, &seen(machine, rows, &errors, &[])?, &undisturbed) * (prior / STEP);
        columns.view_mut((0, j), (numbers, 1)).copy_from(&column);
        columns[(numbers + j, j)] = 1.0;
    }
    let absorbed = columns.qr().q();
    let change = whitened(machine, &seen(machine, rows, &drawn, &[effect])?, &undisturbed);
    let change = change.resize_vertically(numbers + count, 0.0);
    Some((&change - &absorbed * absorbed.tr_mul(&change)).norm())
}

/// Case `number`: nothing, or one effect of a size in multiples of its detection limit.
pub fn draw(machine: Other, size: Option<f64>, n: usize, seed: u64, number: usize) -> Option<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let kind = 2 * machine as u64 + u64::from(size.is_some());
    rng.set_stream(((1_000_000 + 1000 * kind + size.unwrap_or(0.0) as u64) << 32) | number as u64);
    let rows = run(machine, n, &mut rng);
    let (count, error) = machine.errors();
    let errors: Vec<f64> = (0..count).map(|_| error * normal(&mut rng)).collect();
    let mut truth = Truth::default();
    let mut hidden = Vec::new();
    if let Some(size) = size {
        let known = machine.catalogue()[number % machine.catalogue().len()];
        let joints = rows[0].commanded.len();
        let (joint, row) = (rng.random_range(0..joints), rng.random_range(n / 10..n - n / 10));
        let theta: Vec<f64> =
            direction(known.1.len(), &mut rng).iter().zip(known.1).map(|(d, s)| 0.1 * d * s).collect();
        let mut planted = Planted { known, joint, row, theta };
        let places = match known.2 {
            Scan::None => 1,
            Scan::Joint => joints,
            Scan::Row => n - 2,
            Scan::JointAndRow => joints * (n - 2),
        };
        let limit = noncentrality(known.1.len(), 0.004 / 20.0 / places as f64).sqrt();
        let by = size * limit / prominence(machine, &rows, &planted)?;
        planted.theta.iter_mut().for_each(|t| *t *= by);
        truth.effects.push(known.0.to_owned());
        let at_joint = matches!(known.2, Scan::Joint | Scan::JointAndRow);
        truth.legs.push(at_joint.then_some(joint + 1));
        truth.rows.push(matches!(known.2, Scan::Row | Scan::JointAndRow).then_some(row));
        truth.parameters.push(planted.theta.clone());
        hidden.push(planted);
    }
    let mut poses = seen(machine, &rows, &errors, &hidden.iter().collect::<Vec<_>>())?;
    let noise = machine.noise();
    poses.iter_mut().for_each(|q| (0..6).for_each(|k| q[k] += noise[usize::from(k >= 3)] * normal(&mut rng)));
    Some(Case { mechanism: mechanism(machine), data: csv(machine, &rows, &poses), truth })
}

fn csv(machine: Other, rows: &[Row], poses: &[Vector6<f64>]) -> String {
    let angle = |k: usize, v: f64| if k < 3 { 1e3 * v } else { v.to_degrees() };
    let names = ["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"];
    let mut head = vec!["time_s".to_owned()];
    match machine {
        Other::Delta => head.extend((1..=3).map(|k| format!("leg{k}_mm"))),
        Other::Positioner => head.extend(names.map(|name| format!("cmd_{name}"))),
    }
    head.extend(names.map(str::to_owned));
    head.extend(["temp_ambient_degC", "elevation_deg"].map(str::to_owned));
    let mut text = head.join(",") + "\n";
    for (row, pose) in rows.iter().zip(poses) {
        let mut cells = vec![format!("{:.1}", 14400.0 * row.elapsed)];
        cells.extend(row.commanded.iter().enumerate().map(|(k, v)| format!("{:.9}", angle(k, *v))));
        cells.extend(pose.iter().enumerate().map(|(k, v)| format!("{:.9}", angle(k, *v))));
        cells.extend([20.0 + row.temperature, row.elevation.to_degrees()].map(|v| format!("{v:.6}")));
        text += &(cells.join(",") + "\n");
    }
    text
}

fn mechanism(machine: Other) -> String {
    let head = "name = \"other\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\n";
    let [position, rotation] = machine.noise();
    let (_, error) = machine.errors();
    let noise = format!("[noise]\nposition = {:.6}\nrotation = {:.6}\n", 1e3 * position, rotation.to_degrees());
    let tolerance = 1e3 * error;
    match machine {
        Other::Positioner => format!("{head}type = \"pose\"\n{noise}"),
        Other::Delta => {
            let mut text = format!("{head}type = \"linear-delta\"\n");
            let list = |v: &Vector3<f64>| format!("[{:.9}, {:.9}, {:.9}]", 1e3 * v.x, 1e3 * v.y, 1e3 * v.z);
            for rod in rods(&[0.0; 42]) {
                // Writing to a string cannot fail.
                let _ = write!(
                    text,
                    "[[leg]]\nplatform = {}\nbase = {}\nlength = {:.6}\ncarriage = {}\nrail = [0.0, 0.0, 1.0]\n",
                    list(&rod.platform),
                    list(&rod.base),
                    1e3 * rod.length,
                    rod.carriage + 1
                );
            }
            text + &format!(
                "[home]\nposition = [0.0, 0.0, 100.0]\nrotation = [0.0, 0.0, 0.0]\n[workspace]\nposition = [90.0, 90.0, 70.0]\n\
                 rotation = [0.0, 0.0, 0.0]\n[tolerance]\nanchor = {tolerance}\nlength = {tolerance}\n{noise}"
            )
        }
    }
}
