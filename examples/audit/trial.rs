//! One trial: a machine, how it differs from its drawing, and a campaign on it.

use nalgebra::Vector3;
use paracal::measurement::Dataset;
use paracal::mechanism::Workspace;
use paracal::pose::{PoseConvention, RotationOrder};

use crate::dice::Dice;
use crate::effects::TrueEffect;
use crate::machines::{Design, Spread, settled};
use crate::made::Made;
use crate::readings::{Campaign, Noise, Reading};
use crate::rigid::{Rigid, any_turn};
use crate::situations::{Flaw, Situation};

/// Poses at which a calibrated machine is examined.
const FRESH: usize = 100;
/// Draws of a machine that can do what it is drawn for.
const ATTEMPTS: usize = 200;

/// A pose of the platform in the base frame, and the joints of the true machine there.
pub(crate) struct Stand {
    pub(crate) pose: Rigid,
    pub(crate) joints: Vec<f64>,
    /// Temperature over the one at which the geometry holds, K.
    pub(crate) warmer: f64,
}

/// Everything of one trial.
pub(crate) struct Trial {
    pub(crate) design: Design,
    /// Values of the true machine.
    pub(crate) truth: Vec<f64>,
    /// Values of the drawing.
    pub(crate) drawing: Vec<f64>,
    /// Stated tolerances.
    pub(crate) stated: Spread,
    /// What is wrong with the drawing, in words.
    mistake: String,
    pub(crate) convention: PoseConvention,
    /// Where the base is in the frame of the instrument, and the target on the platform.
    pub(crate) base: Rigid,
    pub(crate) target: Rigid,
    pub(crate) reading: Reading,
    pub(crate) effect: Option<TrueEffect>,
    pub(crate) noise: Noise,
    pub(crate) data: Dataset,
    /// The poses that were measured.
    pub(crate) samples: Vec<Stand>,
    /// Further poses of the true machine, as the instrument would see them without noise.
    pub(crate) fresh: Vec<Stand>,
}

/// Where instrument and target are.
struct Seen {
    base: Rigid,
    target: Rigid,
}

impl Trial {
    /// A trial of a situation, on a machine of this kind; `None` if no sound one was found.
    pub(crate) fn draw(situation: &Situation, kind: Option<&str>, dice: &mut Dice) -> Option<Self> {
        (0..ATTEMPTS).find_map(|_| Self::attempt(situation, kind, dice))
    }

    fn attempt(situation: &Situation, kind: Option<&str>, dice: &mut Dice) -> Option<Self> {
        let design = match situation.flaw {
            Flaw::Singular => Design::near_singular(dice),
            Flaw::Extended => Design::hexapod(dice),
            _ => Design::draw(kind, dice),
        }?;
        let Made { truth, drawing, spread, mistake } = Made::of(&design, situation, dice)?;
        let effect = (situation.flaw == Flaw::Extended).then(|| TrueEffect::draw(&design, dice));
        let convention = convention(&design, dice);
        let reading = Reading::draw(&design, dice);
        let seen = seen(&design, &reading, dice);
        let noise = Noise::draw(situation, &design, dice);
        let count = dice.count(if reading.is_full() { 8 } else { 12 }, 80);
        let machine = |dice: &mut Dice, warm: bool| stand(&design, &truth, &convention, effect.as_ref(), warm, dice);
        let samples: Vec<Stand> = (0..count).map(|_| machine(dice, true)).collect::<Option<_>>()?;
        let fresh: Vec<Stand> = (0..FRESH).map(|_| machine(dice, false)).collect::<Option<_>>()?;
        let gross = match situation.flaw {
            Flaw::Gross { rows, .. } => dice.some_of(count, rows),
            _ => Vec::new(),
        };
        let elsewhere = seen.base.at != Vector3::zeros() || seen.target.at != Vector3::zeros();
        let campaign =
            Campaign { reading: &reading, convention: &convention, noise: &noise, design: &design, gross, elsewhere };
        let poses = samples.iter().map(|s| seen.base.then(&s.pose).then(&seen.target)).collect();
        let data = campaign.dataset(&samples, poses, dice);
        Some(Self {
            stated: spread.times(situation.tolerance),
            base: seen.base,
            target: seen.target,
            design,
            truth,
            drawing,
            mistake,
            convention,
            reading,
            effect,
            noise,
            data,
            samples,
            fresh,
        })
    }

    /// The workspace as the file of the machine states it.
    pub(crate) fn workspace(&self) -> Workspace {
        let centre = self.design.home.written(&self.convention);
        Workspace { convention: self.convention, centre, half: self.design.half }
    }

    /// What was drawn, in a line.
    pub(crate) fn text(&self) -> String {
        let moved = |frame: &Rigid| frame.at != Vector3::zeros();
        let frame = match (moved(&self.base), moved(&self.target)) {
            (false, false) => "base frame",
            (true, false) => "tracker",
            (false, true) => "target",
            (true, true) => "tracker and target",
        };
        let half = self.design.half;
        let effect = self.effect.as_ref().map_or(String::new(), |e| format!(", {}", e.name()));
        format!(
            "{} of {:.2} m, platform {:.2} m, {} x {}, {frame}, pivot {:.2} m, strokes {:.3} m {:.1} deg, \
             tolerance {:.1e} m, noise {:.1e} m {:.1e} rad{effect}{}",
            self.design.kind.name(),
            self.design.size,
            self.design.arm,
            self.data.len(),
            self.reading.name(),
            self.convention.pivot.norm(),
            half[..3].iter().copied().fold(0.0, f64::max),
            half[3..].iter().copied().fold(0.0, f64::max).to_degrees(),
            self.stated.anchor,
            self.noise.position,
            self.noise.rotation,
            self.mistake,
        )
    }
}

/// The true machine at a pose drawn in the workspace.
fn stand(
    design: &Design,
    truth: &[f64],
    convention: &PoseConvention,
    effect: Option<&TrueEffect>,
    warm: bool,
    dice: &mut Dice,
) -> Option<Stand> {
    let mut q = design.home.written(convention);
    for (value, half) in q.iter_mut().zip(design.half) {
        *value += dice.uniform(-half, half);
    }
    let warmer = if warm { dice.uniform(-8.0, 8.0) } else { 0.0 };
    let pose = settled(design.kind.as_ref(), truth, &Rigid::read(convention, &q))?;
    let side = design.kind.held(&design.values, &design.home);
    if side * design.kind.held(truth, &pose) <= 0.0 {
        return None;
    }
    let acting = design.kind.joints(truth, &pose)?;
    let joints = effect.map_or_else(|| acting.clone(), |effect| effect.commanded(&acting, warmer));
    Some(Stand { pose, joints, warmer })
}

fn convention(design: &Design, dice: &mut Dice) -> PoseConvention {
    let pivot = if dice.chance(0.5) { dice.in_cube(0.2 * design.size) } else { Vector3::zeros() };
    let order = if dice.chance(0.5) { RotationOrder::Zyx } else { RotationOrder::Xyz };
    PoseConvention { order, pivot }
}

/// Instrument and target: in the frames of the drawing, elsewhere, or one of them. A target that is known by its places
/// on the platform has none of its own, and one of which no attitude is measured is not turned.
fn seen(design: &Design, reading: &Reading, dice: &mut Dice) -> Seen {
    let choice = if design.carries_frames && reading.registers() { dice.pick(&[0.4, 0.2, 0.05, 0.35]) } else { 0 };
    let (tracker, target) = (choice == 1 || choice == 3, (choice == 2 || choice == 3) && reading.has_target_frame());
    let mut seen = Seen { base: Rigid::identity(), target: Rigid::identity() };
    if tracker {
        seen.base = Rigid { at: dice.in_cube(1.0).normalize() * dice.uniform(1.0, 8.0), turn: any_turn(dice) };
    }
    if target {
        seen.target.at = dice.in_cube(0.3 * design.size);
        if reading.is_full() {
            seen.target.turn = any_turn(dice);
        }
    }
    seen
}
