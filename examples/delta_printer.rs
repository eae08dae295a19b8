//! A measured delta printer: six parameters from 41 touches of a flat bed.
//!
//! The mechanism is stated by its closure (three arms and a platform that does not turn), the measurement by a plane
//! that the tip touches. The data are not part of this project: the example reads `delta-printer-41/measured.csv` from
//! the folder that `PARACAL_DATA` names, and says so if it cannot. Run with
//! `PARACAL_DATA=… cargo run --release --example delta_printer`.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use paracal::identification::{CalibrationOptions, LevenbergMarquardt, PriorPolicy, calibrate, evaluate};
use paracal::measurement::{Contact, ContactReading, DataRow, Dataset, Noise, PlaneContact, Sample};
use paracal::mechanism::ParameterRole;
use paracal::mechanism::closure::{Closure, ClosureMechanism, Outline, Real, State, length};
use paracal::nalgebra::Vector3;
use paracal::pose::Pose;
use paracal::units::Dimension;

/// Carriage steps per metre.
const STEPS: f64 = 106_667.0;
/// Arms, radius of the towers less that of the platform, and height of the tip with all carriages at their endstops, m.
const ARM: f64 = 0.340;
const RADIUS: f64 = 0.172;
const TOP: f64 = 0.333;
/// Where the towers stand, degrees.
const TOWERS: [f64; 3] = [210.0, 330.0, 90.0];

#[derive(Clone, Debug)]
struct Printer;

impl Closure for Printer {
    /// Parameters: three endstops, the radius, the angles of the first two towers against the third.
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for tower in 0..3 {
            let turn = if tower < 2 { s.parameters[4 + tower] } else { T::from(0.0) };
            let (sin, cos) = (turn + TOWERS[tower].to_radians()).sin_cos();
            let carriage =
                Vector3::new(s.parameters[3] * cos, s.parameters[3] * sin, s.parameters[tower] - s.joints[tower]);
            out[tower] = length(&(s.position - carriage)) - ARM;
        }
        // The platform does not turn; as lengths, by an arm of the radius.
        out[3] = s.rotation[(2, 1)] * RADIUS;
        out[4] = s.rotation[(0, 2)] * RADIUS;
        out[5] = s.rotation[(1, 0)] * RADIUS;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    match std::env::var_os("PARACAL_DATA") {
        Some(folder) => run(Path::new(&folder)).map(drop),
        None => {
            println!("skipped: PARACAL_DATA does not name the folder of the measured data");
            Ok(())
        }
    }
}

/// Prints the table; RMS height of the touches with the identified parameters, m.
pub fn run(folder: &Path) -> Result<f64, Box<dyn Error>> {
    let text = std::fs::read_to_string(folder.join("delta-printer-41/measured.csv"))?;
    let numbers = |line: &str| line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
    let rows: Vec<Vec<f64>> =
        text.lines().filter(|l| !l.starts_with('#')).skip(1).map(numbers).collect::<Result<_, _>>()?;

    let above = (ARM * ARM - RADIUS * RADIUS).sqrt();
    let mut outline =
        Outline::new("delta printer", 6, Pose::identity()).controls([true, true, true, false, false, false]);
    for leg in 0..3 {
        let role = ParameterRole::JointOffset { leg };
        outline = outline.parameter(format!("endstop{}", leg + 1), Dimension::Length, TOP + above, None, role).joint(
            format!("carriage{}", leg + 1),
            Dimension::Length,
            TOP,
            None,
        );
    }
    outline = outline
        .parameter("radius", Dimension::Length, RADIUS, None, ParameterRole::Other)
        .parameter("angle1", Dimension::Angle, 0.0, None, ParameterRole::Other)
        .parameter("angle2", Dimension::Angle, 0.0, None, ParameterRole::Other);
    let printer = ClosureMechanism::new(Printer, outline)?;

    let sample = |(row, r): (usize, &Vec<f64>)| Sample {
        row: DataRow(row),
        joints: r.iter().map(|steps| steps / STEPS).collect(),
        ..Sample::default()
    };
    let samples: Vec<Sample> = rows.iter().enumerate().map(sample).collect();
    let touch = ContactReading { height: Some(0.0), sigma: 40e-6 };
    let model = PlaneContact::new(Contact::default(), vec![touch; rows.len()]);
    let noise = Noise { known: false, ..Noise::stated(40e-6, 1.0) };
    let data = Dataset::new(samples, Arc::new(model), noise);
    let options = CalibrationOptions { prior: PriorPolicy::None, ..CalibrationOptions::default() };
    let result = calibrate(&printer, &data, None, &LevenbergMarquardt::default(), &options)?;

    println!("parameter     nominal       value       sigma");
    for p in &result.parameters {
        let (factor, unit) =
            if p.spec.dimension == Dimension::Angle { (1f64.to_degrees(), "deg") } else { (1e3, "mm") };
        let sigma = factor * p.sigma.unwrap_or(f64::NAN);
        println!("{:<9} {:11.4} {:11.4} {sigma:11.4} {unit}", p.spec.name, factor * p.spec.nominal, factor * p.value);
    }
    let height = |e: &paracal::identification::ErrorSummary| 1e6 * e.position.unwrap_or(f64::NAN);
    println!(
        "\nRMS height of {} touches: {:.0} um -> {:.1} um",
        rows.len(),
        height(&result.before),
        height(&result.after)
    );
    if let Some(held) = &result.held_out {
        println!("held out (5 folds): {:.1} um", height(&held.rms));
    }
    // What remains, by how far out the tip touched.
    let errors = evaluate(result.mechanism.as_ref(), &[], &data)?;
    println!("\nremaining, by distance from the centre");
    for [from, to] in [[0.0, 0.02], [0.02, 0.05], [0.05, 0.1], [0.1, 0.2]] {
        let ring = errors.samples.iter().zip(&result.identification.poses);
        let inside = ring.filter(|(_, pose)| (from..to).contains(&pose.position.xy().norm()));
        let squares: Vec<f64> = inside.filter_map(|(e, _)| e.position).map(|e| e * e).collect();
        let rms = 1e6 * (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        println!("  {:3.0} to {:3.0} mm: {:2} touches, {rms:5.1} um", 1e3 * from, 1e3 * to, squares.len());
    }
    Ok(result.after.position.unwrap_or(f64::NAN))
}
