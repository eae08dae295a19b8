//! How well a reading fits: the parameters are fitted to the closure at the poses, and what they leave is counted together
//! with what it costs to have them.

use nalgebra::Vector6;

use crate::conditions::Conditions;
use crate::diagnosis::preflight::mistakes::Mistake;
use crate::diagnosis::preflight::reading::Reading;
use crate::diagnosis::preflight::regression::{Regression, regress};
use crate::diagnosis::preflight::table::{SeenKind, StatedTable};
use crate::diagnosis::question::TOLERANCES;
use crate::identification::{ClosureFit, ClosureRow, Conventions, Look, Prior, SeenPose, frames_between};
use crate::measurement::{Dataset, Frames};
use crate::mechanism::{Mechanism, characteristic_length};
use crate::pose::{Pose, PoseConvention, rotation_vector};
use crate::units::Dimension;

/// Rows that a first look takes, and those that the last one does.
const FEW: usize = 24;
const MANY: usize = 360;
/// Misfit over the spread of the measured poses that a reading may leave: of garbage some reading is always the best.
const EXPLAINED: f64 = 0.05;
/// Measured and commanded spread may differ by this factor where a reading makes numbers smaller.
const SPREAD: f64 = 3.0;
/// Part of the rows that must be reached for frames to be looked for.
const REACHED: f64 = 0.6;

/// What a reading leaves.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    /// Median length of the whitened misfit of a row, with the share of each row in the deviations of the parameters from the
    /// drawing: root of the sum of squares.
    pub(crate) value: f64,
    /// The misfit alone.
    pub(crate) misfit: f64,
    /// Whitened misfit of each row.
    pub(crate) lengths: Vec<f64>,
    pub(crate) frames: Frames,
}

/// A mechanism and a file whose readings are compared.
pub(crate) struct Trial<'a> {
    pub(crate) mechanism: &'a dyn Mechanism,
    pub(crate) table: StatedTable,
    pub(crate) few: Vec<usize>,
    pub(crate) all: Vec<usize>,
    /// With zeros of the joints that are a convention, and with zeros as they are drawn.
    fits: [ClosureFit<'a>; 2],
    /// One over the σ of positions and angles.
    weights: Vector6<f64>,
    /// True if the joints as stated lead to poses.
    reached: bool,
}

impl<'a> Trial<'a> {
    /// `None` if the file says too little.
    pub(crate) fn new(mechanism: &'a dyn Mechanism, data: &Dataset, convention: &PoseConvention) -> Option<Self> {
        let table = StatedTable::of(mechanism, data, convention)?;
        let position = data.noise.position;
        let rotation = match (table.kind, table.spread_of_targets()) {
            (SeenKind::Pose, _) => data.noise.rotation,
            (SeenKind::Points, Some(spread)) if spread > 0.0 => position / spread.sqrt(),
            _ => f64::INFINITY,
        };
        let (p, r) = (1.0 / position, 1.0 / rotation);
        let weights = Vector6::new(p, p, p, r, r, r);
        let fit = |zeros: bool| {
            let prior = Prior::wide(mechanism, TOLERANCES, Conventions { zeros, ..Conventions::FRAMES });
            ClosureFit::new(mechanism, &prior, weights)
        };
        let fits = [fit(true), fit(false)];
        let (few, all) = (evenly(table.len(), FEW), evenly(table.len(), MANY));
        let mut trial = Self { mechanism, table, few, all, fits, weights, reached: true };
        let stated = trial.stated();
        let reached = trial.table.commanded(mechanism, &stated, &trial.few);
        trial.reached = reached.iter().flatten().count() as f64 >= REACHED * trial.few.len() as f64;
        Some(trial)
    }

    /// The file as it stands.
    pub(crate) fn stated(&self) -> Reading {
        Reading::stated(self.mechanism.joints().len())
    }

    /// The mistakes in the readings that may have been made. A mechanism without a size is in no unit: smaller, its readings
    /// would only hide what is left.
    pub(crate) fn mistakes(&self) -> Vec<Mistake> {
        let specs = self.mechanism.parameters().iter().zip(self.mechanism.values());
        let has_size = specs.into_iter().any(|(spec, v)| spec.dimension == Dimension::Length && *v != 0.0);
        let mut all = Mistake::all(self.table.order(), self.table.kind == SeenKind::Pose);
        all.retain(|m| has_size || !matches!(m, Mistake::FileUnit(_)));
        all
    }

    /// What the joints that are asked for by the poses of a reading say of the columns of the joints, in the base frame.
    pub(crate) fn regression(&self, reading: &Reading, frames: &Frames) -> Option<Regression> {
        let at = Conditions::unknown();
        let (mut asked, mut stated) = (Vec::new(), Vec::new());
        for row in &self.few {
            let Some(read) = self.table.rows(self.mechanism, reading, &[*row], frames).pop() else { continue };
            let pose = frames.platform(&read.pose);
            if let Ok(joints) = self.mechanism.inverse(self.mechanism.values(), &pose, &at) {
                asked.push(joints);
                stated.push(self.table.columns(reading, *row));
            }
        }
        if 2 * asked.len() < self.few.len() {
            return None;
        }
        regress(self.mechanism, &asked, &stated, self.reached)
    }

    /// Median length of the noise of a row, whitened.
    pub(crate) fn of_noise(&self) -> f64 {
        // That of χ² is two thirds below its degrees of freedom.
        (self.weights.iter().filter(|w| **w > 0.0).count() as f64 - 2.0 / 3.0).sqrt()
    }

    /// The score of a reading in given frames; `None` where most rows have no number. `drawn` holds the zeros of the joints where
    /// they are drawn.
    pub(crate) fn score(
        &self,
        reading: &Reading,
        rows: &[usize],
        look: Look,
        frames: &Frames,
        drawn: bool,
    ) -> Option<Score> {
        let read = self.table.rows(self.mechanism, reading, rows, frames);
        if read.len() < 6 || 2 * read.len() < rows.len() {
            return None;
        }
        let at = Conditions::unknown();
        let rows_read: Vec<ClosureRow<'_>> =
            read.iter().map(|row| ClosureRow { joints: &row.joints, pose: row.pose, at: &at }).collect();
        let fitted = self.fits[usize::from(drawn)].fit(&rows_read, frames, look)?;
        let value = (fitted.misfit.powi(2) + fitted.penalty / read.len() as f64).sqrt();
        value.is_finite().then_some(Score { value, misfit: fitted.misfit, lengths: fitted.lengths, frames: *frames })
    }

    /// The frames in which rows of a reading are nearest to the poses to which its joints lead, and the median distance, m.
    pub(crate) fn frames(&self, reading: &Reading, rows: &[usize]) -> Option<(Frames, f64)> {
        let commanded = self.table.commanded(self.mechanism, reading, rows);
        let seen = |(row, nominal): (&usize, Option<Pose>)| {
            let nominal = nominal?;
            if let Some(point) = self.table.point(reading, *row) {
                return Some(SeenPose { nominal, point: point.position, place: point.place, rotation: None });
            }
            let pose = self.table.measured(reading, *row).filter(Pose::is_finite)?;
            Some(SeenPose { nominal, point: pose.position, place: Default::default(), rotation: Some(pose.rotation) })
        };
        let seen: Vec<SeenPose> = rows.iter().zip(commanded).filter_map(seen).collect();
        if (seen.len() as f64) < REACHED * rows.len() as f64 {
            return None;
        }
        frames_between(self.mechanism, &seen, self.table.kind == SeenKind::Points)
    }

    /// True if a misfit is a small part of what was measured.
    pub(crate) fn explains(&self, reading: &Reading, score: &Score) -> bool {
        let poses = self.poses(reading, &self.all, &score.frames);
        let moved = spread_of(&poses, false).max(spread_of(&poses, true) * characteristic_length(self.mechanism));
        score.misfit / self.weights[0] < EXPLAINED * moved
    }

    /// False for a reading that makes numbers smaller which the commands do not ask for: it would fit by hiding their noise.
    pub(crate) fn is_commanded(&self, reading: &Reading, frames: &Frames) -> bool {
        let smaller = |turns: bool| {
            reading.mistakes.iter().any(|m| match m {
                Mistake::AngleUnit(unit) => turns && unit.factor < 1.0,
                Mistake::LengthUnit(unit) => !turns && unit.factor < 1.0,
                _ => false,
            })
        };
        let commanded: Option<Vec<Pose>> =
            self.table.commanded(self.mechanism, reading, &self.few).into_iter().collect();
        let Some(commanded) = commanded else { return true };
        let read = self.poses(reading, &self.few, frames);
        [false, true].into_iter().filter(|turns| smaller(*turns)).all(|turns| {
            let (asked, seen) = (spread_of(&commanded, turns), spread_of(&read, turns));
            asked < SPREAD * seen && seen < SPREAD * asked
        })
    }

    fn poses(&self, reading: &Reading, rows: &[usize], frames: &Frames) -> Vec<Pose> {
        self.table.rows(self.mechanism, reading, rows, frames).into_iter().map(|row| row.pose).collect()
    }
}

/// Root mean square of the moves from one pose to the next: shifts, or turns. It is the same in every frame.
fn spread_of(poses: &[Pose], turns: bool) -> f64 {
    let moves = poses.windows(2).map(|pair| {
        let (a, b) = (&pair[0], &pair[1]);
        if turns {
            rotation_vector(&(a.rotation.inverse() * b.rotation)).norm_squared()
        } else {
            (b.position - a.position).norm_squared()
        }
    });
    (moves.sum::<f64>() / poses.len().max(1) as f64).sqrt()
}

/// About `count` numbers below `n`, evenly spread.
fn evenly(n: usize, count: usize) -> Vec<usize> {
    let step = n.div_ceil(count).max(1);
    (0..n).step_by(step).collect()
}
