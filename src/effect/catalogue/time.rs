//! What changes with time alone.
//!
//! A tracker drifts by 1 to 20 µm per hour; a bump moves it by 10 to 1000 µm; a coupling that slips or a homing run moves
//! one leg by 5 to 500 µm. Drifts are per run, 0 at its first row and 1 at its last. They describe the run and predict
//! nothing: neither is carried on by compensation. Confused with temperatures that rise through the run.

use nalgebra::Vector3;

use super::{describe, move_frame};
use crate::effect::{Acts, Effect, EffectParameter, Perturbation, Recorded, Scan, ScanPoint, Setting, Site};
use crate::units::Dimension;

fn needs_run(recorded: &Recorded) -> Vec<String> {
    if recorded.run { Vec::new() } else { vec!["rows in the order of measuring".into()] }
}

fn rigid() -> Vec<EffectParameter> {
    let of = |(k, name): (usize, &&str)| {
        let dimension = if k < 3 { Dimension::Length } else { Dimension::Angle };
        EffectParameter::new(*name, dimension, 1e-5)
    };
    ["x", "y", "z", "rx", "ry", "rz"].iter().enumerate().map(of).collect()
}

/// A part of a rigid motion with these six values.
fn move_part(theta: &[f64], part: f64, site: &Site<'_>, out: &mut Perturbation) {
    let shift = Vector3::new(theta[0], theta[1], theta[2]) * part;
    move_frame(shift, Vector3::new(theta[3], theta[4], theta[5]) * part, site, out);
}

/// True from the row of the scan on.
fn after(at: &ScanPoint, site: &Site<'_>) -> bool {
    let row = at.row.unwrap_or(0);
    site.conditions.run.as_ref().is_some_and(|run| run.row >= row)
}

fn time() -> Vec<String> {
    vec!["time".into()]
}

/// The frame of the instrument drifts.
#[derive(Clone, Copy, Debug)]
pub struct DriftFrame;

impl Effect for DriftFrame {
    describe!(
        "drift.frame",
        "the frame of the instrument drifts through the run: a tracker or a stand that moves",
        "measure one reference pose again every ten samples, and let the instrument warm up"
    );

    fn acts_on(&self) -> Acts {
        Acts::Measurement
    }

    fn missing(&self, _setting: &Setting<'_>, recorded: &Recorded) -> Vec<String> {
        needs_run(recorded)
    }

    fn parameters(&self, _setting: &Setting<'_>) -> Vec<EffectParameter> {
        rigid()
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        time()
    }

    fn perturb(&self, theta: &[f64], _at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let Some(run) = &site.conditions.run {
            move_part(theta, run.part, site, out);
        }
    }
}

/// The length of one leg drifts.
#[derive(Clone, Copy, Debug)]
pub struct DriftLeg;

impl Effect for DriftLeg {
    describe!(
        "drift.leg",
        "one leg creeps through the run: its encoder, its brake or its warming motor",
        "look at the encoder and the brake of that leg; home it again and repeat the run"
    );

    fn missing(&self, _setting: &Setting<'_>, recorded: &Recorded) -> Vec<String> {
        needs_run(recorded)
    }

    fn parameters(&self, setting: &Setting<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("drift", setting.mechanism.joints()[0].dimension, 1e-5)]
    }

    fn scan(&self, _setting: &Setting<'_>, _recorded: &Recorded) -> Scan {
        Scan::Legs
    }

    fn special_case_of(&self) -> &[&str] {
        &["drift.frame"]
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        time()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let (Some(run), Some(leg)) = (&site.conditions.run, at.leg) {
            out.joints[leg] += theta[0] * run.part;
        }
    }
}

/// The frame of the instrument jumps.
#[derive(Clone, Copy, Debug)]
pub struct StepFrame;

impl Effect for StepFrame {
    describe!(
        "step.frame",
        "the frame of the instrument jumped between two rows: somebody touched the tracker or the target",
        "register the instrument again, or split the file at that row"
    );

    fn acts_on(&self) -> Acts {
        Acts::Measurement
    }

    fn missing(&self, _setting: &Setting<'_>, recorded: &Recorded) -> Vec<String> {
        needs_run(recorded)
    }

    fn parameters(&self, _setting: &Setting<'_>) -> Vec<EffectParameter> {
        rigid()
    }

    fn scan(&self, _setting: &Setting<'_>, _recorded: &Recorded) -> Scan {
        Scan::Rows
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        time()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if after(at, site) {
            move_part(theta, 1.0, site, out);
        }
    }
}

/// The length of one leg jumps.
#[derive(Clone, Copy, Debug)]
pub struct StepLeg;

impl Effect for StepLeg {
    describe!(
        "step.leg",
        "one leg jumped between two rows: a coupling slipped, or it was homed again",
        "tighten the coupling of that leg, home it, and split the file at that row"
    );

    fn missing(&self, _setting: &Setting<'_>, recorded: &Recorded) -> Vec<String> {
        needs_run(recorded)
    }

    fn parameters(&self, setting: &Setting<'_>) -> Vec<EffectParameter> {
        vec![EffectParameter::new("step", setting.mechanism.joints()[0].dimension, 1e-5)]
    }

    fn scan(&self, _setting: &Setting<'_>, _recorded: &Recorded) -> Scan {
        Scan::LegsAndRows
    }

    fn special_case_of(&self) -> &[&str] {
        &["step.frame"]
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        time()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let (Some(leg), true) = (at.leg, after(at, site)) {
            out.joints[leg] += theta[0];
        }
    }
}
