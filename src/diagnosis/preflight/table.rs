//! What stands in a file: joints and readings by row, and the poses that they state under a reading.

use nalgebra::{Matrix3, Vector3};

use crate::conditions::Conditions;
use crate::diagnosis::preflight::mistakes::{point_without, pose_without, shift_and_scale};
use crate::diagnosis::preflight::reading::Reading;
use crate::measurement::{Dataset, Frames, PointReading, TargetFrame};
use crate::mechanism::{ForwardQuery, Mechanism};
use crate::pose::{Pose, PoseConvention, RotationOrder, fit_rigid_motion};
use crate::units::Dimension;

/// What was measured in a row.
#[derive(Clone, Debug)]
enum Seen {
    /// The six coordinates of a pose.
    Pose([f64; 6]),
    /// At least three points of known places on the platform.
    Points(Vec<PointReading>),
    /// One point; the attitude is taken as commanded.
    Point(PointReading),
}

/// The kind of readings that the rows have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SeenKind {
    Pose,
    Points,
    Point,
}

/// A row under a reading.
#[derive(Clone, Debug)]
pub(crate) struct ReadRow {
    pub(crate) joints: Vec<f64>,
    /// Pose of the target in the tracker's frame.
    pub(crate) pose: Pose,
}

/// The rows of a file that have a complete reading of one kind.
#[derive(Debug)]
pub(crate) struct StatedTable {
    joints: Vec<Vec<f64>>,
    seen: Vec<Seen>,
    pub(crate) kind: SeenKind,
    convention: PoseConvention,
    /// True for joints that are lengths.
    lengths: Vec<bool>,
}

/// Rows without which there is nothing to compare.
const FEWEST: usize = 8;

impl StatedTable {
    /// The rows with a pose, or else those with three targets, or else those with a point; `None` if these are few or nothing
    /// is commanded in them.
    pub(crate) fn of(mechanism: &dyn Mechanism, data: &Dataset, convention: &PoseConvention) -> Option<Self> {
        let known = data.model().target_frame() != TargetFrame::Identified;
        let kinds = [SeenKind::Pose, SeenKind::Points, SeenKind::Point];
        let table = |kind: SeenKind| {
            let (mut joints, mut seen) = (Vec::new(), Vec::new());
            for k in 0..data.len() {
                let (model, index) = data.reading(k);
                let reading = match kind {
                    SeenKind::Pose => model.coordinates(index).map(Seen::Pose),
                    SeenKind::Points => Some(model.points(index)).filter(|p| p.len() >= 3).map(Seen::Points),
                    SeenKind::Point => model.point(index).filter(|_| known).map(Seen::Point),
                };
                if let Some(reading) = reading {
                    seen.push(reading);
                    joints.push(data.sample(k).joints.clone());
                }
            }
            let lengths = mechanism.joints().iter().map(|j| j.dimension == Dimension::Length).collect();
            Self { joints, seen, kind, convention: *convention, lengths }
        };
        let complete = |t: &Self| t.seen.len() >= FEWEST && 2 * t.seen.len() > data.len();
        // Where nothing is commanded, readings have nothing to contradict.
        let moves = |t: &Self| t.joints.iter().any(|j| *j != t.joints[0]);
        kinds.into_iter().map(table).find(complete).filter(moves)
    }

    pub(crate) fn len(&self) -> usize {
        self.seen.len()
    }

    pub(crate) fn order(&self) -> RotationOrder {
        self.convention.order
    }

    /// Mean square of the distances of the targets from their middle, m², where there are targets.
    pub(crate) fn spread_of_targets(&self) -> Option<f64> {
        let Seen::Points(points) = self.seen.first()? else { return None };
        let n = points.len() as f64;
        let centre = points.iter().map(|p| p.place).sum::<Vector3<f64>>() / n;
        let spread: Matrix3<f64> = points.iter().map(|p| (p.place - centre) * (p.place - centre).transpose()).sum();
        Some(spread.trace() / n)
    }

    /// The joints of a row as read.
    pub(crate) fn joints(&self, reading: &Reading, row: usize) -> Vec<f64> {
        let (_, scale) = shift_and_scale(&reading.mistakes);
        let scaled = self.joints[row].iter().zip(&self.lengths).map(|(v, l)| if *l { v * scale } else { *v });
        reading.joints.joints(&scaled.collect::<Vec<f64>>())
    }

    /// The joints of a row before they are read otherwise, in the unit of the mechanism file.
    pub(crate) fn columns(&self, reading: &Reading, row: usize) -> Vec<f64> {
        let plain =
            Reading { joints: super::joint_columns::JointColumns::stated(self.lengths.len()), ..reading.clone() };
        self.joints(&plain, row)
    }

    /// The row whose reading goes with the joints of this one.
    fn partner(&self, reading: &Reading, row: usize) -> Option<usize> {
        let (shift, _) = shift_and_scale(&reading.mistakes);
        row.checked_add_signed(shift).filter(|k| *k < self.len())
    }

    /// The measured pose that goes with a row, where the attitude does not have to be commanded.
    pub(crate) fn measured(&self, reading: &Reading, row: usize) -> Option<Pose> {
        match &self.seen[self.partner(reading, row)?] {
            Seen::Pose(q) => Some(pose_without(&reading.mistakes, &self.convention, q)),
            Seen::Points(points) => {
                let from: Vec<Vector3<f64>> = points.iter().map(|p| p.place).collect();
                let to: Vec<Vector3<f64>> =
                    points.iter().map(|p| point_without(&reading.mistakes, &p.position)).collect();
                fit_rigid_motion(&from, &to)
            }
            Seen::Point(_) => None,
        }
    }

    /// The measured point that goes with a row, where nothing else was measured.
    pub(crate) fn point(&self, reading: &Reading, row: usize) -> Option<PointReading> {
        match &self.seen[self.partner(reading, row)?] {
            Seen::Point(p) => {
                Some(PointReading { position: point_without(&reading.mistakes, &p.position), place: p.place })
            }
            _ => None,
        }
    }

    /// The poses to which the joints of rows lead as read.
    pub(crate) fn commanded(&self, mechanism: &dyn Mechanism, reading: &Reading, rows: &[usize]) -> Vec<Option<Pose>> {
        let at = Conditions::unknown();
        let joints: Vec<Vec<f64>> = rows.iter().map(|row| self.joints(reading, *row)).collect();
        let home = mechanism.home();
        let queries: Vec<ForwardQuery<'_>> = joints.iter().map(|j| ForwardQuery::new(j, &at, home)).collect();
        mechanism.forward_batch(mechanism.values(), &queries).into_iter().map(Result::ok).collect()
    }

    /// Rows as read, without those that have no partner. Where one point was measured, the attitude is that to which the joints
    /// lead, seen in these frames.
    pub(crate) fn rows(
        &self,
        mechanism: &dyn Mechanism,
        reading: &Reading,
        rows: &[usize],
        frames: &Frames,
    ) -> Vec<ReadRow> {
        let attitudes = match self.kind {
            SeenKind::Point if !mechanism.controlled()[3..].contains(&true) => vec![Some(mechanism.home()); rows.len()],
            SeenKind::Point => self.commanded(mechanism, reading, rows),
            _ => vec![None; rows.len()],
        };
        let read = |(row, attitude): (&usize, Option<Pose>)| {
            let pose = match self.point(reading, *row) {
                Some(point) => {
                    let rotation = frames.measured(&attitude?).rotation;
                    Pose { position: point.position - rotation * point.place, rotation }
                }
                None => self.measured(reading, *row)?,
            };
            pose.is_finite().then(|| ReadRow { joints: self.joints(reading, *row), pose })
        };
        rows.iter().zip(attitudes).filter_map(read).collect()
    }
}
