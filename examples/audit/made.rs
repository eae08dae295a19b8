//! How a machine was made, and what its drawing says of it.

use crate::dice::Dice;
use crate::machines::{Design, Part, Spread};
use crate::situations::{Flaw, Situation};

/// A machine and its drawing.
pub(crate) struct Made {
    /// Values of the true machine.
    pub(crate) truth: Vec<f64>,
    /// Values of the drawing.
    pub(crate) drawing: Vec<f64>,
    /// How far the true values spread about those of the design.
    pub(crate) spread: Spread,
    /// What is wrong with the drawing, in words.
    pub(crate) mistake: String,
}

impl Made {
    /// A machine of a design; `None` where the mistake of the situation makes no difference to it.
    pub(crate) fn of(design: &Design, situation: &Situation, dice: &mut Dice) -> Option<Self> {
        let anchor = dice.log_uniform(1e-4, 1e-3) * design.size;
        let length = anchor * design.finer * dice.log_uniform(0.3, 1.0);
        let spread = Spread { anchor, length, angle: dice.log_uniform(1e-4, 3e-3) };
        let parts = design.kind.parts();
        let mut truth: Vec<f64> =
            design.values.iter().zip(&parts).map(|(v, part)| v + spread.of(*part) * dice.normal()).collect();
        let mut drawing = design.values.clone();
        let mistake = match situation.flaw {
            Flaw::Zeros => move_zeros(&mut truth, design, dice)?,
            Flaw::Signs => turn_signs(&mut drawing, &parts, design.size, dice)?,
            _ => String::new(),
        };
        Some(Self { truth, drawing, spread, mistake })
    }
}

/// Zeros of joints that are off by 1 to 50 mm on a machine of 1 m, all alike or each for itself.
fn move_zeros(truth: &mut [f64], design: &Design, dice: &mut Dice) -> Option<String> {
    let common = dice.chance(0.5);
    let size = dice.sign() * dice.log_uniform(1e-3, 50e-3);
    let mut any = false;
    for (value, part) in truth.iter_mut().zip(design.kind.parts()) {
        let scale = match part {
            Part::ZeroLength | Part::ZeroUnknown => design.size,
            Part::ZeroAngle => 1.0,
            _ => continue,
        };
        any = true;
        *value += size * scale * if common { 1.0 } else { dice.uniform(-1.0, 1.0) };
    }
    let how = if common { "all" } else { "each at most" };
    any.then(|| format!(", {how} zeros off by {:.1e} m or {size:.1e} rad", size * design.size))
}

/// The wrong sign for one coordinate of all points of one body, where that makes a difference.
fn turn_signs(drawing: &mut [f64], parts: &[Part], size: f64, dice: &mut Dice) -> Option<String> {
    let axis = dice.count(0, 2);
    let wrong = if dice.chance(0.5) { Part::Platform(axis) } else { Part::Base(axis) };
    let mut farthest = 0.0_f64;
    for (value, part) in drawing.iter_mut().zip(parts) {
        if *part == wrong {
            *value = -*value;
            farthest = farthest.max(value.abs());
        }
    }
    (farthest > 0.01 * size).then(|| format!(", {wrong:?} with the wrong sign, at most {farthest:.1e} m"))
}
