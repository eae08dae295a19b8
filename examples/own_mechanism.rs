//! A mechanism from outside the crate by one function: six rods on vertical slides (6-PUS).
//!
//! The closure says when the rods fit; everything else comes from the library: Jacobians by dual numbers, kinematics, choice
//! of poses, identification, judgement, and, once [`Machine::of`] has made a machine of it, tables, a calibrated file, a
//! diagnosis and a page. Run with `cargo run --release --example own_mechanism -- FOLDER`; without an argument the files go
//! to a temporary folder.

use std::error::Error;
use std::path::{Path, PathBuf};

use paracal::diagnosis::{Question, diagnose};
use paracal::files::{JointsAndPose, Machine, Measurement, ReadOptions, joints_and_poses, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate, evaluate};
use paracal::measurement::Noise;
use paracal::mechanism::closure::{Closure, ClosureMechanism, Outline, Real, State, length};
use paracal::mechanism::{GeometryError, Mechanism, ParameterRole, Workspace};
use paracal::nalgebra::{Rotation3, Vector3};
use paracal::observability::{O1, Scaling};
use paracal::pose::{Pose, PoseConvention};
use paracal::report::html::{self, Measured, ModelResiduals, Subject};
use paracal::report::text;
use paracal::selection::{Campaign, Exchange, Objective, SelectionTask, Sources, select};
use paracal::simulation::{SimulatedSample, draw_parameters, simulate};
use paracal::units::Dimension;
use rand::SeedableRng;

/// When the rods fit.
#[derive(Clone, Debug)]
pub struct VerticalSlides;

impl Closure for VerticalSlides {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (leg, row) in out.iter_mut().enumerate() {
            // Carriages slide along z: |t + R a - b - h z| = s.
            let mut rod = s.place(&s.point(7 * leg)) - s.point(7 * leg + 3);
            rod.z -= s.joints[leg];
            *row = length(&rod) - s.parameters[7 * leg + 6];
        }
    }
}

/// The mechanism as it was drawn: points, rods and slides, with 0.2 mm of tolerance.
pub fn drawn() -> Result<ClosureMechanism<VerticalSlides>, GeometryError> {
    let mut outline = Outline::new("vertical slides", 6, Pose::from_coordinates(&[0.0; 6]));
    for leg in 0..6 {
        let (pair, side) = (120.0 * (leg / 2) as f64, if leg % 2 == 0 { -1.0 } else { 1.0 });
        let around = |radius: f64, degrees: f64| {
            Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians()) * Vector3::x() * radius
        };
        let (ball, foot) = (around(0.15, pair + 48.0 * side), around(0.35, pair + 15.0 * side));
        let (rod, above) = (0.5, f64::sqrt(0.25 - (ball - foot).norm_squared()));
        outline = outline
            .platform_point(leg, ball.into(), Some(2e-4))
            .base_point(leg, foot.into(), Some(2e-4))
            .parameter(format!("s{}", leg + 1), Dimension::Length, rod, Some(2e-4), ParameterRole::LegDimension { leg })
            .joint(format!("slide{}", leg + 1), Dimension::Length, above, None);
    }
    ClosureMechanism::new(VerticalSlides, outline)
}

/// What a tracker sees of a mechanism with errors of its tolerances, at 25 poses chosen for its calibration.
pub fn measured(machine: &Machine) -> Result<Vec<SimulatedSample>, Box<dyn Error>> {
    let nominal = machine.plain();
    let (space, noise) = (machine.workspace.ok_or("no workspace")?, machine.noise.ok_or("no noise")?);
    let campaign = Campaign::new(nominal, &space, Some(&noise), Scaling::Whitened)?;
    let task = SelectionTask {
        campaign: &campaign,
        forecaster: None,
        aim: Objective::Index(&O1),
        given: &[],
        seed: 0,
        watch: &|_| {},
    };
    let sources = Sources { random: 500, corners_and_grid: true, ..Sources::default() };
    let chosen = select(&task, &Exchange::default(), &sources, 25)?;

    let mut rng = rand::rngs::ChaCha8Rng::seed_from_u64(1);
    let truth = nominal.with_values(&draw_parameters(nominal, None, &mut rng), nominal.home())?;
    let samples = simulate(nominal, truth.as_ref(), &chosen.poses, &machine.convention, &noise, &mut rng);
    Ok(samples.map_err(|(row, cause)| format!("pose {row}: {cause}"))?)
}

/// The machine, and its measurements by way of a table in this folder.
pub fn campaign(folder: &Path) -> Result<(Machine, Measurement), Box<dyn Error>> {
    let mechanism = drawn()?;
    let convention = PoseConvention::default();
    let centre = convention.coordinates(&mechanism.home());
    let space = Workspace { convention, centre, half: [0.05, 0.05, 0.05, 0.15, 0.15, 0.15] };
    let machine = Machine::of(mechanism, Some(&space), Some(&Noise::stated(5e-6, 2e-5)))?;
    let row = |s: SimulatedSample| JointsAndPose { id: None, joints: s.joints, pose: s.measured };
    let rows: Vec<JointsAndPose> = measured(&machine)?.into_iter().map(row).collect();
    let table = folder.join("data.csv");
    std::fs::write(&table, joints_and_poses(&machine, "simulated".into(), &rows).to_text())?;
    let measurement = read_measurement(&table, &machine)?;
    Ok((machine, measurement))
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    let (machine, measurement) = campaign(&folder)?;
    let (nominal, data) = (machine.plain(), &measurement.data);

    let options = CalibrationOptions::default();
    let result = calibrate(nominal, data, machine.workspace.as_ref(), &LevenbergMarquardt::default(), &options)?;
    print!("{}", text::calibration(&result));

    // The calibrated file holds the values; who reads it brings the mechanism.
    let file = folder.join("calibrated.toml");
    std::fs::write(&file, machine.calibrated_document(&result, &measurement)?.to_text())?;
    let calibrated = Machine::read_with(&file, &ReadOptions::default().with_mechanism(drawn()?))?;
    let errors = evaluate(calibrated.mechanism.as_ref(), &[], data)?.rms();
    println!("\nread back: {:.2} um RMS", 1e6 * errors.position.unwrap_or(f64::NAN));

    print!("\n{}", text::diagnosis(&diagnose(&Question::of(&machine, data))?, nominal.name()));

    let models = [
        ModelResiduals::new("calibrated", calibrated.mechanism.as_ref(), &[], data)?,
        ModelResiduals::new("as drawn", nominal, &[], data)?,
    ];
    let subject = Subject {
        mechanism: calibrated.mechanism.as_ref(),
        frames: html::frames_of(calibrated.mechanism.as_ref(), nominal),
        convention: &machine.convention,
        condition_kinds: machine.condition_kinds(),
        noise: machine.noise.map(|n| [n.position, n.rotation]),
        warnings: Vec::new(),
        settings: Vec::new(),
    };
    let page = html::calibration(&result, &subject, &Measured { data, models: &models });
    std::fs::write(folder.join("report.html"), page.html())?;
    Ok(())
}
