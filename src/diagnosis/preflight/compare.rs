//! Was the file read rightly? Asked before anything is fitted for good.
//!
//! Under each of some forty readings the parameters are fitted to the closure at the measured poses (no forward
//! kinematics, which may not exist for a misread file), and the medians of the whitened misfits are compared. A reading
//! is only believed if it makes the misfit less than half.

use std::cell::OnceCell;

use nalgebra::{DMatrix, Vector3, Vector6};

use crate::conditions::Conditions;
use crate::diagnosis::answer::result::Misread;
use crate::diagnosis::preflight::assignment::{best_assignment, correlation};
use crate::diagnosis::preflight::misreadings::{Reading, StatedRows};
use crate::identification::{ClosureFit, ClosureRow, Look, Prior, register};
use crate::measurement::{Dataset, Frames, MeasurementModel, PoseMeasurement, TargetFrame};
use crate::mechanism::{Mechanism, characteristic_length};
use crate::pose::{Pose, PoseConvention, rotation_vector};

/// A reading must make the misfit this many times smaller.
const BETTER: f64 = 2.0;
/// Misfit over the spread of the measured poses that a reading may leave.
const EXPLAINED: f64 = 0.05;
/// Measured and commanded spread may differ by this factor where a reading makes numbers smaller.
const SPREAD: f64 = 3.0;
/// Rows that the first look takes.
const FEW: usize = 36;
/// Readings that get a second look.
const SECOND: f64 = 4.0;

/// How the file should have been read, if not as it stands; `None` also where poses are not measured in full.
pub(crate) fn preflight(
    mechanism: &dyn Mechanism,
    data: &Dataset,
    convention: &PoseConvention,
    prior: &Prior,
) -> Option<Misread> {
    let trial = Trial::new(mechanism, data, convention, prior)?;
    let few: Vec<usize> = evenly(data.len(), FEW);
    let all: Vec<usize> = (0..data.len()).collect();
    let mut readings = Reading::all(mechanism);
    readings.extend(trial.leg_order());
    // Most files are in the base frame when they are read rightly; finding frames for every reading is the dear way.
    let mut ways = vec![false];
    if trial.elsewhere {
        ways.push(true);
    }
    let stated = |rows: &[usize], look: Look| {
        let of = |way: &bool| trial.misfit(&Reading::AsStated, rows, look, *way);
        ways.iter().filter_map(of).fold(f64::INFINITY, f64::min)
    };
    let at_first = stated(&few, Look::First);
    // Asked only if a reading comes near.
    let at_last = OnceCell::new();
    let at_last = || *at_last.get_or_init(|| stated(&all, Look::Second));
    readings.retain(|reading| trial.is_commanded(reading, &few));
    let mut sure: Vec<(Reading, f64)> = Vec::new();
    for way in &ways {
        let mut found: Vec<(&Reading, f64)> = readings
            .iter()
            // The order is read off poses in the base frame; with frames that are found, many a wrong one fits.
            .filter(|reading| !*way || !matches!(reading, Reading::LegOrder(_)))
            .filter_map(|reading| Some((reading, trial.misfit(reading, &few, Look::First, *way)?)))
            .filter(|(_, misfit)| misfit * BETTER < at_first * SECOND)
            .collect();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        found.truncate(6);
        sure = found
            .into_iter()
            .filter_map(|(reading, _)| Some((reading.clone(), trial.misfit(reading, &all, Look::Second, *way)?)))
            .filter(|(reading, misfit)| misfit * BETTER < at_last() && trial.explains(reading, *misfit))
            .collect();
        if !sure.is_empty() {
            break;
        }
    }
    sure.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (best, misfit) = sure.first().filter(|_| at_last().is_finite())?.clone();
    let rivals = sure[1..].iter().filter(|(_, other)| *other < BETTER * misfit);
    Some(Misread {
        reading: best.name().into(),
        detail: best.detail(),
        factor: at_last() / misfit,
        tied_with: rivals.map(|(r, _)| format!("{}: {}", r.name(), r.detail())).collect(),
    })
}

/// Root mean square of the moves from one pose to the next: shifts, or turns. It is the same in every frame.
fn spread_of(poses: &[Pose], turns: bool) -> f64 {
    let moves = poses.windows(2).map(|pair| {
        let (a, b) = (&pair[0], &pair[1]);
        let moved: Vector3<f64> =
            if turns { rotation_vector(&(a.rotation.inverse() * b.rotation)) } else { b.position - a.position };
        moved.norm_squared()
    });
    (moves.sum::<f64>() / poses.len().max(1) as f64).sqrt()
}

/// About `count` numbers below `n`, evenly spread.
fn evenly(n: usize, count: usize) -> Vec<usize> {
    let step = n.div_ceil(count).max(1);
    (0..n).step_by(step).collect()
}

struct Trial<'a> {
    mechanism: &'a dyn Mechanism,
    data: &'a Dataset,
    table: StatedRows,
    home: Vec<f64>,
    fit: ClosureFit<'a>,
    /// One over the σ of positions and angles.
    weights: Vector6<f64>,
    /// True if the file as it stands is not in the base frame.
    elsewhere: bool,
}

impl<'a> Trial<'a> {
    fn new(
        mechanism: &'a dyn Mechanism,
        data: &'a Dataset,
        convention: &PoseConvention,
        prior: &Prior,
    ) -> Option<Self> {
        if data.model().target_frame() != TargetFrame::Convention || data.len() < 8 {
            return None;
        }
        // Where nothing is commanded, poses have nothing to contradict.
        let still = data.iter().all(|s| s.joints == data.sample(0).joints);
        if still {
            return None;
        }
        let mut table = StatedRows { joints: Vec::new(), poses: Vec::new(), convention: *convention };
        for k in 0..data.len() {
            let (model, index) = data.reading(k);
            table.poses.push(model.coordinates(index)?);
            table.joints.push(data.sample(k).joints.clone());
        }
        let home = mechanism.inverse(mechanism.values(), &mechanism.home(), &Conditions::unknown()).ok()?;
        let (p, r) = (1.0 / data.noise.position, 1.0 / data.noise.rotation);
        let elsewhere = register(mechanism, data).applied;
        let weights = Vector6::new(p, p, p, r, r, r);
        let fit = ClosureFit::new(mechanism, prior, weights);
        Some(Self { mechanism, data, table, home, fit, weights, elsewhere })
    }

    /// True if a misfit is a small part of what was measured: of garbage some reading is always the best.
    fn explains(&self, reading: &Reading, misfit: f64) -> bool {
        let all = 0..self.table.poses.len();
        let poses: Vec<Pose> = all.filter_map(|k| Some(reading.row(&self.table, &self.home, k)?.1)).collect();
        let moved = spread_of(&poses, false).max(spread_of(&poses, true) * characteristic_length(self.mechanism));
        misfit / self.weights[0] < EXPLAINED * moved
    }

    /// False for a reading that makes numbers smaller which the commands do not ask for: it would fit by hiding their noise.
    fn is_commanded(&self, reading: &Reading, rows: &[usize]) -> bool {
        let turns = match reading {
            Reading::AngleUnit(_, factor) if *factor < 1.0 => true,
            Reading::LengthUnit(_, factor, false) if *factor < 1.0 => false,
            _ => return true,
        };
        let at = Conditions::unknown();
        let home = self.mechanism.home();
        let commanded: Option<Vec<Pose>> = rows
            .iter()
            .map(|k| self.mechanism.forward(self.mechanism.values(), &self.table.joints[*k], &at, &home).ok())
            .collect();
        let read: Option<Vec<Pose>> = rows.iter().map(|k| Some(reading.row(&self.table, &self.home, *k)?.1)).collect();
        let (Some(commanded), Some(read)) = (commanded, read) else { return true };
        let (asked, seen) = (spread_of(&commanded, turns), spread_of(&read, turns));
        asked < SPREAD * seen && seen < SPREAD * asked
    }

    /// The order in which the columns of the legs go best with the lengths that the measured poses ask for, if it is
    /// another one than stated.
    fn leg_order(&self) -> Option<Reading> {
        let n = self.home.len();
        if n > 8 {
            return None;
        }
        let at = Conditions::unknown();
        let asked: Vec<Vec<f64>> = (0..self.table.poses.len())
            .filter_map(|row| {
                let (_, pose) = Reading::AsStated.row(&self.table, &self.home, row)?;
                self.mechanism.inverse(self.mechanism.values(), &pose, &at).ok()
            })
            .collect();
        if asked.len() != self.table.poses.len() {
            return None;
        }
        let score = DMatrix::from_fn(n, n, |leg, column| {
            let pairs = asked.iter().zip(&self.table.joints).map(|(a, j)| (a[leg], j[column]));
            correlation(pairs)
        });
        let order = best_assignment(&score);
        order.iter().enumerate().any(|(i, k)| i != *k).then_some(Reading::LegOrder(order))
    }

    /// Median length of the whitened misfit of a row after the parameters are fitted, in the base frame or in frames that
    /// are found first.
    fn misfit(&self, reading: &Reading, rows: &[usize], look: Look, find_frames: bool) -> Option<f64> {
        let read: Vec<(Vec<f64>, Pose)> =
            rows.iter().filter_map(|row| reading.row(&self.table, &self.home, *row)).collect();
        if read.len() < 6 || read.iter().any(|(_, pose)| !pose.is_finite()) {
            return None;
        }
        let at = Conditions::unknown();
        let rows_read: Vec<ClosureRow<'_>> =
            read.iter().map(|(joints, pose)| ClosureRow { joints, pose: *pose, at: &at }).collect();
        let closure_misfit = |frames: &Frames| self.fit.fit(&rows_read, frames, look).map(|fitted| fitted.misfit);
        if !find_frames {
            return closure_misfit(&Frames::default());
        }
        let poses: Vec<Pose> = read.iter().map(|(_, pose)| *pose).collect();
        let mut samples: Vec<_> = rows.iter().take(read.len()).map(|k| self.data.sample(*k).clone()).collect();
        samples.iter_mut().zip(&read).for_each(|(s, (joints, _))| s.joints.clone_from(joints));
        let noise = self.data.noise;
        let model: std::sync::Arc<dyn MeasurementModel> =
            std::sync::Arc::new(PoseMeasurement::full(self.table.convention, &poses, noise.position, noise.rotation));
        let found = register(self.mechanism, &Dataset::new(samples, model, noise));
        closure_misfit(&found.frames)
    }
}
