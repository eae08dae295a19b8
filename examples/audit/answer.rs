//! What the library says of a trial, and what is true.

use nalgebra::Vector3;
use paracal::conditions::Conditions;
use paracal::identification::{Calibration, CalibrationOptions, Identifier, LevenbergMarquardt, Robust, calibrate};
use paracal::mechanism::Mechanism;

use crate::chance::Chance;
use crate::dice::Dice;
use crate::effects::conditions;
use crate::readings::Reading;
use crate::rigid::{Rigid, angle_between, turn_by};
use crate::situations::{Flaw, Situation};
use crate::trial::{Stand, Trial};

/// A true error that is at most so many times the stated one agrees with it.
pub(crate) const AGREES: f64 = 1.5;
/// Data decide if they leave less than this part of the error of the drawing.
const DECIDES: f64 = 0.5;

/// What became of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    TrustedRight,
    TrustedWrong,
    RefusedGood,
    RefusedBad,
}

/// A trial that was judged.
pub(crate) struct Answer {
    pub(crate) mark: Mark,
    /// True over stated error, position and rotation, where something was stated.
    pub(crate) ratios: Option<[f64; 2]>,
    /// Which of them the readings tell of.
    pub(crate) seen: [bool; 2],
    pub(crate) chance: Option<Chance>,
    /// How far the library's mechanism with the true values is from where the generator has the true machine, over its
    /// size.
    pub(crate) disagreement: f64,
    /// True if a refused trial calibrates to a good result from the true machine.
    pub(crate) good_from_truth: bool,
    /// What was drawn and what was said.
    pub(crate) text: String,
    pub(crate) said: String,
}

/// Draws a trial and has it calibrated; `None` if none could be drawn.
pub(crate) fn ask(situation: &Situation, kind: Option<&str>, seed: u64, number: usize) -> Option<Answer> {
    let mut dice = Dice::of(seed, situation.key, number);
    let trial = Trial::draw(situation, kind, &mut dice)?;
    let result = calibrated(&trial, &trial.drawing, situation);
    let judged = result.as_ref().ok().map(|result| Judged::of(&trial, result));
    let trusted = result.as_ref().is_ok_and(|r| r.verdict.trusted);
    let agrees = judged.as_ref().is_some_and(|j| j.agrees);
    let good = judged.as_ref().is_some_and(|j| j.agrees && j.decides);
    let good_from_truth = !trusted && !good && !situation.is_false() && is_good_from_truth(&trial, situation);
    let mark = match (trusted, agrees) {
        (true, true) => Mark::TrustedRight,
        (true, false) => Mark::TrustedWrong,
        _ if situation.is_false() => Mark::RefusedBad,
        _ if good || result.is_err() && good_from_truth => Mark::RefusedGood,
        _ => Mark::RefusedBad,
    };
    let ratios = judged.as_ref().and_then(|j| j.ratios);
    let chance = result.as_ref().ok().zip(ratios).filter(|_| trusted);
    let chance = chance.and_then(|(result, ratios)| Chance::of(&trial, result, ratios, &mut dice));
    Some(Answer {
        mark,
        ratios,
        seen: [trial.reading.sees_position(), trial.reading.sees_rotation()],
        chance,
        disagreement: disagreement(&trial),
        good_from_truth,
        text: trial.text(),
        said: said(&result, judged.as_ref()),
    })
}

/// True if the data decide for whoever knows the machine.
fn is_good_from_truth(trial: &Trial, situation: &Situation) -> bool {
    calibrated(trial, &trial.truth, situation).is_ok_and(|result| {
        let judged = Judged::of(trial, &result);
        result.verdict.trusted && judged.agrees && judged.decides
    })
}

/// Largest difference of poses of the two forms of the true machine for the same joints; infinite if the library has
/// none.
fn disagreement(trial: &Trial) -> f64 {
    let Some(truth) = trial.true_mechanism() else { return f64::INFINITY };
    let apart = |stand: &Stand| {
        let found = truth.forward(truth.values(), &stand.joints, &conditions(stand.warmer), &stand.pose.pose());
        found.map_or(f64::INFINITY, |found| {
            let found = Rigid::of(&found);
            (found.at - stand.pose.at).norm() / trial.design.size + angle_between(&found.turn, &stand.pose.turn)
        })
    };
    trial.samples.iter().chain(&trial.fresh).map(apart).fold(0.0, f64::max)
}

/// The mechanism of these values, as a user's file would state it, calibrated with the options of the program.
fn calibrated(trial: &Trial, values: &[f64], situation: &Situation) -> Result<Calibration, String> {
    let mechanism = trial.mechanism(values)?;
    let options = CalibrationOptions { convention: trial.convention, ..CalibrationOptions::default() };
    let robust = matches!(situation.flaw, Flaw::Gross { robust: true, .. });
    let identifier: Box<dyn Identifier> =
        if robust { Box::new(Robust::default()) } else { Box::new(LevenbergMarquardt::default()) };
    calibrate(mechanism.as_ref(), &trial.data, Some(&trial.workspace()), identifier.as_ref(), &options)
        .map_err(|error| error.to_string())
}

/// A result against the truth.
struct Judged {
    /// True errors over fresh poses, m and rad.
    errors: [f64; 2],
    ratios: Option<[f64; 2]>,
    agrees: bool,
    decides: bool,
    /// Fresh poses that the calibrated mechanism did not reach from home.
    lost: usize,
}

impl Judged {
    fn of(trial: &Trial, result: &Calibration) -> Self {
        let (errors, lost) = true_errors(trial, result);
        let Some(stated) = &result.predicted else {
            return Self { errors, ratios: None, agrees: false, decides: false, lost };
        };
        let ratios = [errors[0] / stated.position_rms, errors[1] / stated.rotation_rms];
        let decides = result.of_drawing.as_ref().is_some_and(|drawing| {
            let position = !trial.reading.sees_position() || stated.position_rms < DECIDES * drawing.position_rms;
            let rotation = !trial.reading.sees_rotation() || stated.rotation_rms < DECIDES * drawing.rotation_rms;
            position && rotation && (trial.reading.sees_position() || trial.reading.sees_rotation())
        });
        Self { errors, ratios: Some(ratios), agrees: ratios.iter().all(|r| *r <= AGREES), decides, lost }
    }
}

/// RMS errors of the calibrated mechanism at the fresh poses, in the frame of the measurement and at the pivot of its
/// poses; and how many it reached only from where they are, instead of from home.
fn true_errors(trial: &Trial, result: &Calibration) -> ([f64; 2], usize) {
    let gauge = gauge(trial, result);
    let mut squares = [0.0; 2];
    let mut lost = 0;
    for stand in &trial.fresh {
        let truth = trial.base.then(&stand.pose).then(&trial.target);
        let at = if trial.effect.is_some() { conditions(stand.warmer) } else { Conditions::unknown() };
        let mechanism = result.mechanism.as_ref();
        let reached = |seed| mechanism.forward(mechanism.values(), &stand.joints, &at, &seed);
        let found = reached(mechanism.home()).or_else(|_| {
            lost += 1;
            reached(truth.pose())
        });
        let Ok(found) = found else { return ([f64::INFINITY; 2], lost) };
        let found = Rigid::of(&found).then(&gauge);
        let pivot = &trial.convention.pivot;
        squares[0] += (found.place(pivot) - truth.place(pivot)).norm_squared();
        squares[1] += angle_between(&found.turn, &truth.turn).powi(2);
    }
    (squares.map(|sum| (sum / trial.fresh.len() as f64).sqrt()), lost)
}

/// The frame of the targets in that of the calibrated platform. Where the places of the targets are identified the
/// platform by itself has no place: what is predicted is the motion of the targets, and their frame is the best rigid
/// fit of the true places to the identified ones.
fn gauge(trial: &Trial, result: &Calibration) -> Rigid {
    let Reading::Targets(places, false) = &trial.reading else { return Rigid::identity() };
    let own = result.identification.own_values();
    let found: Vec<Vector3<f64>> = own.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let mut fit = Rigid::identity();
    // Gauss and Newton: the places are off by little.
    for _ in 0..20 {
        let mut normal = nalgebra::Matrix6::zeros();
        let mut pull = nalgebra::Vector6::zeros();
        for (place, found) in places.iter().zip(&found) {
            let arm = fit.turn * place;
            let mut rows = nalgebra::Matrix3x6::zeros();
            rows.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
            rows.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm.cross_matrix());
            normal += rows.transpose() * rows;
            pull += rows.transpose() * (found - fit.place(place));
        }
        let Some(step) = normal.lu().solve(&pull) else { break };
        fit = Rigid {
            at: fit.at + step.fixed_rows::<3>(0),
            turn: turn_by(&step.fixed_rows::<3>(3).into_owned()) * fit.turn,
        };
    }
    fit
}

fn said(result: &Result<Calibration, String>, judged: Option<&Judged>) -> String {
    let Ok(result) = result else {
        return format!("no result: {}", result.as_ref().err().map_or("", String::as_str));
    };
    let mut text = String::new();
    if let (Some(judged), Some(stated)) = (judged, &result.predicted) {
        text += &format!(
            "true {:.2e} m {:.2e} rad, stated {:.2e} m {:.2e} rad",
            judged.errors[0], judged.errors[1], stated.position_rms, stated.rotation_rms
        );
        if let Some(drawing) = &result.of_drawing {
            text += &format!(", drawing {:.1e} m {:.1e} rad", drawing.position_rms, drawing.rotation_rms);
        }
        if judged.lost > 0 {
            text += &format!(", {} not reached from home", judged.lost);
        }
    }
    let frames = if result.registration.applied { ", registered" } else { "" };
    let prior = if result.identification.prior { ", prior" } else { "" };
    text += &format!(
        "{frames}{prior}, misfit p {:.1e}, factors {:.2?}",
        result.identification.misfit.p_value().unwrap_or(f64::NAN),
        result.tolerance_factors
    );
    for reason in &result.verdict.reasons {
        text += &format!("; {reason}");
    }
    text
}

impl Trial {
    /// The library's mechanism of these values.
    pub(crate) fn mechanism(&self, values: &[f64]) -> Result<Box<dyn Mechanism>, String> {
        let kind = self.design.kind.as_ref();
        let plain = kind.build(values, &self.design.home, &self.stated).map_err(|e| format!("the drawing: {e}"))?;
        match &self.effect {
            None => Ok(plain),
            Some(effect) => effect.around(plain, 0.0).ok_or_else(|| format!("no effect {}", effect.name())),
        }
    }

    /// The library's mechanism of the true values, effects included.
    fn true_mechanism(&self) -> Option<Box<dyn Mechanism>> {
        let plain = self.design.kind.build(&self.truth, &self.design.home, &self.stated).ok()?;
        match &self.effect {
            None => Some(plain),
            Some(effect) => effect.around(plain, effect.size()),
        }
    }
}
