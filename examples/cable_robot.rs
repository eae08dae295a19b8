//! A measured cable robot: eight anchor coordinates from 31 stereo-measured positions and the angles of three drums.
//!
//! The robot is planar; its second and third cable run along a segment twice. The positions are taken as exact, the
//! changes of the cables since the first row as what is read with noise, and all rows count alike. The data are not part
//! of this project: the example reads `kamal-cdpr/measured.csv` from the folder that `PARACAL_DATA` names, and says so
//! if it cannot. Run with `PARACAL_DATA=… cargo run --release --example cable_robot`.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use paracal::conditions::Conditions;
use paracal::diagnosis::{Question, diagnose};
use paracal::effect::{Catalogue, Environment};
use paracal::identification::{Identifier, LevenbergMarquardt, PriorPolicy, Task};
use paracal::measurement::{DataRow, Dataset, Noise, PoseMeasurement, PoseReading, Sample};
use paracal::mechanism::kinds::{Cable, PlanarCables, Segment};
use paracal::mechanism::{Linearization, Mechanism};
use paracal::nalgebra::Vector3;
use paracal::pose::{Pose, PoseConvention};
use paracal::report::text;

/// Radius of each drum, m, as its makers state it.
const DRUMS: [f64; 3] = [0.025, 0.035, 0.035];
/// Segments of each cable: m + n, m + 2k, n + 2h.
const CABLES: [&[usize]; 3] = [&[0, 1], &[0, 2, 2], &[1, 3, 3]];
/// Where the anchors are looked for, in a frame in which the first position is `FIRST`, m.
const ANCHORS: [[f64; 2]; 4] = [[0.0, 1.9], [1.2, 1.9], [0.0, 0.0], [1.2, 0.0]];
const FIRST: [f64; 2] = [0.6, 1.1];

fn main() -> Result<(), Box<dyn Error>> {
    match std::env::var_os("PARACAL_DATA") {
        Some(folder) => run(Path::new(&folder)).map(drop),
        None => {
            println!("skipped: PARACAL_DATA does not name the folder of the measured data");
            Ok(())
        }
    }
}

/// Prints the table; RMS of the three cables with the identified anchors, mm.
pub fn run(folder: &Path) -> Result<[f64; 3], Box<dyn Error>> {
    let text = std::fs::read_to_string(folder.join("kamal-cdpr/measured.csv"))?;
    let numbers = |line: &str| line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
    let rows: Vec<Vec<f64>> =
        text.lines().filter(|l| !l.starts_with('#')).skip(1).map(numbers).collect::<Result<_, _>>()?;

    let first = &rows[0];
    let home = Pose::from_coordinates(&[first[3], first[4], 0.0, 0.0, 0.0, 0.0]);
    let anchor = |[x, y]: [f64; 2]| Vector3::new(x - FIRST[0] + first[3], y - FIRST[1] + first[4], 0.0);
    let segments = ANCHORS.map(|a| Segment { platform: Vector3::zeros(), base: anchor(a) });
    // Joints are cable lengths: drum angle times radius. Only the anchors are identified.
    let cable =
        |segments: &[usize]| Cable { segments: segments.into(), drum: None, build_up: None, offset: 0.0, stroke: None };
    let robot = PlanarCables::new("cable robot", &segments, &CABLES.map(cable), home, None)?;
    let robot = robot.identifying(|p| p.name.contains('B'))?;

    let lengths = |r: &Vec<f64>| -> Vec<f64> { (0..3).map(|k| r[k] * DRUMS[k]).collect() };
    let mut states = vec![Conditions::unknown(); rows.len()];
    Conditions::put_in_run(&mut states, rows.iter().map(lengths).collect(), Some(&[0.0; 3]));
    let sample = |((row, r), conditions): ((usize, &Vec<f64>), Conditions)| Sample {
        row: DataRow(row),
        joints: lengths(r),
        conditions,
        ..Sample::default()
    };
    let samples: Vec<Sample> = rows.iter().enumerate().zip(states).map(sample).collect();
    let reading = |r: &Vec<f64>| PoseReading {
        values: [r[3], r[4], 0.0, 0.0, 0.0, 0.0],
        measured: [true, true, false, false, false, false],
        sigma: [1e-9; 6],
    };
    let model = PoseMeasurement::new(PoseConvention::default(), rows.iter().map(reading).collect());
    let noise = Noise { joint: 2e-3, known: false, ..Noise::stated(1e-9, 1e-9) };
    let data = Dataset::new(samples, Arc::new(model), noise);
    let found =
        LevenbergMarquardt::default().identify(&Task { prior: PriorPolicy::None, ..Task::new(&robot, &data) })?;

    println!("anchor       x mm   sigma      y mm   sigma");
    for (k, pair) in found.parameters.chunks(2).enumerate() {
        let cells = pair.iter().map(|p| format!("{:9.1} {:7.1}", 1e3 * p.value, 1e3 * p.sigma.unwrap_or(f64::NAN)));
        println!("{:<7} {}", k + 1, cells.collect::<Vec<_>>().join(" "));
    }
    let (mut squares, mut remaining) = ([[0.0; 3]; 2], Vec::new());
    for (which, c) in [robot.values().to_vec(), found.mechanism_values()].iter().enumerate() {
        for (s, r) in data.iter().zip(&rows) {
            let pose = Pose::from_coordinates(&[r[3], r[4], 0.0, 0.0, 0.0, 0.0]);
            let mut closure = Linearization::sized_for(&robot);
            robot.linearize(c, &s.joints, &pose, &Conditions::unknown(), &mut closure);
            (0..3).for_each(|k| squares[which][k] += closure.residual[k].powi(2));
            if which == 1 {
                remaining.push([closure.residual[0], closure.residual[1], closure.residual[2]]);
            }
        }
    }
    let rms = squares.map(|s| s.map(|v| 1e3 * (v / rows.len() as f64).sqrt()));
    println!("\nRMS of {} changes of length, mm   cable 1  cable 2  cable 3", rows.len());
    for (name, r) in ["anchors as stated", "anchors identified"].iter().zip(rms) {
        println!("{name:<33} {:8.2} {:8.2} {:8.2}", r[0], r[1], r[2]);
    }
    println!(
        "\nThe makers report 3, 5 and 3 mm after their calibration. What remains against the change of the cable itself:"
    );
    for k in 0..3 {
        // A drum whose radius is not the stated one would leave a slope.
        let (x, y): (Vec<f64>, Vec<f64>) = data.iter().zip(&remaining).map(|(s, r)| (s.joints[k], r[k])).unzip();
        let slope = x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>() / x.iter().map(|x| x * x).sum::<f64>();
        let rest = x.iter().zip(&y).map(|(x, y)| (y - slope * x).powi(2)).sum::<f64>();
        let without = 1e3 * (rest / x.len() as f64).sqrt();
        println!("  cable {}: {:+.2} mm per m, {without:.2} mm RMS without that", k + 1, 1e3 * slope);
    }
    let calibrated = robot.with_values(&found.mechanism_values(), robot.home())?;
    let question = Question {
        mechanism: calibrated.as_ref(),
        data: &data,
        environment: Environment::default(),
        convention: PoseConvention::default(),
        catalogue: Catalogue::standard(),
        noise_known: false,
        seed: 0,
    };
    println!("\nAnd what the diagnosis says of it:\n\n{}", text::diagnosis(&diagnose(&question)?, robot.name()));
    Ok(rms[1])
}
