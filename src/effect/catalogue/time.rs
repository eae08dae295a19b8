//! Effects that change with time alone.
//!
//! A tracker drifts by 1 to 20 µm per hour; a bump moves it by 10 to 1000 µm; a coupling that slips or a homing run moves
//! one leg by 5 to 500 µm. Drifts are per run, 0 at its first row and 1 at its last. They describe the run and predict
//! nothing: neither is carried on by compensation. Confused with temperatures that rise through the run.

use nalgebra::Vector3;

use super::move_frame;
use crate::conditions::TIME;
use crate::effect::{
    ActsOn, AvailableData, Effect, EffectContext, EffectParameter, Perturbation, Scan, ScanPoint, Site,
};
use crate::units::Dimension;

/// How something goes on through the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// Evenly, from 0 at the first row to 1 at the last.
    Drift,
    /// At once, from 0 to 1 at a row.
    Step,
}

impl Course {
    /// How far it has gone at a sample; `None` outside of a run and before a step.
    fn part(self, at: &ScanPoint, site: &Site<'_>) -> Option<f64> {
        let run = site.conditions.run.as_ref()?;
        match self {
            Self::Drift => Some(run.part),
            Self::Step => (run.row >= at.row.unwrap_or(0)).then_some(1.0),
        }
    }
}

fn needs_run(available: &AvailableData) -> Vec<String> {
    if available.run { Vec::new() } else { vec!["rows in the order of measurement".into()] }
}

fn time() -> Vec<String> {
    vec![TIME.into()]
}

/// The frame of the instrument drifts or jumps: six parameters of a rigid motion about the origin of the base.
#[derive(Clone, Copy, Debug)]
pub struct FrameMoves(pub Course);

impl Effect for FrameMoves {
    fn name(&self) -> &str {
        match self.0 {
            Course::Drift => "drift.frame",
            Course::Step => "step.frame",
        }
    }

    fn cause(&self) -> &str {
        match self.0 {
            Course::Drift => "the frame of the instrument drifts during the run: the tracker or its stand moves",
            Course::Step => {
                "the frame of the instrument jumped between two rows: someone touched the tracker or the target"
            }
        }
    }

    fn remedy(&self) -> &str {
        match self.0 {
            Course::Drift => "repeat a reference pose every ten samples, and let the instrument warm up",
            Course::Step => "register the instrument again, or split the file at that row",
        }
    }

    fn acts_on(&self) -> ActsOn {
        ActsOn::Measurement
    }

    fn describes_one_run(&self) -> bool {
        true
    }

    fn missing(&self, _setting: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        needs_run(available)
    }

    fn parameters(&self, _setting: &EffectContext<'_>) -> Vec<EffectParameter> {
        let of = |(k, name): (usize, &&str)| {
            let dimension = if k < 3 { Dimension::Length } else { Dimension::Angle };
            EffectParameter::new(*name, dimension, 1e-5)
        };
        ["x", "y", "z", "rx", "ry", "rz"].iter().enumerate().map(of).collect()
    }

    fn scan(&self, _setting: &EffectContext<'_>, _recorded: &AvailableData) -> Scan {
        match self.0 {
            Course::Drift => Scan::None,
            Course::Step => Scan::Rows,
        }
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        time()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let Some(part) = self.0.part(at, site) {
            let shift = Vector3::new(theta[0], theta[1], theta[2]) * part;
            move_frame(shift, Vector3::new(theta[3], theta[4], theta[5]) * part, site, out);
        }
    }
}

/// One leg creeps or jumps: one parameter, its coordinate at the end.
#[derive(Clone, Copy, Debug)]
pub struct LegMoves(pub Course);

impl Effect for LegMoves {
    fn name(&self) -> &str {
        match self.0 {
            Course::Drift => "drift.leg",
            Course::Step => "step.leg",
        }
    }

    fn cause(&self) -> &str {
        match self.0 {
            Course::Drift => "one leg creeps during the run: its encoder, its brake, or its motor warming up",
            Course::Step => "one leg jumped between two rows: a coupling slipped, or it was homed again",
        }
    }

    fn remedy(&self) -> &str {
        match self.0 {
            Course::Drift => "check the encoder and the brake of that leg; home it again and repeat the run",
            Course::Step => "tighten the coupling of that leg, home it, and split the file at that row",
        }
    }

    fn describes_one_run(&self) -> bool {
        true
    }

    fn missing(&self, _setting: &EffectContext<'_>, available: &AvailableData) -> Vec<String> {
        needs_run(available)
    }

    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter> {
        let name = match self.0 {
            Course::Drift => "drift",
            Course::Step => "step",
        };
        vec![EffectParameter::new(name, context.mechanism.joints()[0].dimension, 1e-5)]
    }

    fn scan(&self, _setting: &EffectContext<'_>, _recorded: &AvailableData) -> Scan {
        match self.0 {
            Course::Drift => Scan::Legs,
            Course::Step => Scan::LegsAndRows,
        }
    }

    fn special_case_of(&self) -> &[&str] {
        match self.0 {
            Course::Drift => &["drift.frame"],
            Course::Step => &["step.frame"],
        }
    }

    fn covariates(&self, _at: &ScanPoint) -> Vec<String> {
        time()
    }

    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation) {
        if let (Some(part), Some(leg)) = (self.0.part(at, site), at.leg) {
            out.joints[leg] += theta[0] * part;
        }
    }
}
