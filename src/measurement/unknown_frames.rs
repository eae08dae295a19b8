//! Readings of which it is not known exactly where the tracker stands and where the target sits.

use std::sync::Arc;

use nalgebra::{DMatrix, Matrix6, Vector3, Vector6};

use super::{Dataset, Frames, MeasurementModel, PointReading, RowKind, Rows, Sample, TargetFrame};
use crate::mechanism::{ParameterRole, ParameterSpec};
use crate::pose::Pose;
use crate::units::Dimension;

/// A measurement with small motions of its frames as parameters of its own, behind those that it has: `B` moves in the axes of
/// the tracker, `A` in those of the platform.
///
/// They stand for what the points of a mechanism cannot take up: a rail keeps its direction when the base points turn.
#[derive(Debug)]
pub(crate) struct UnknownFrames {
    inner: Arc<dyn MeasurementModel>,
    free: Free,
    specs: Vec<ParameterSpec>,
}

/// Which of the six motions (shifts along x, y, z, turns about them) of each frame are parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Free {
    pub(crate) tracker: Vec<usize>,
    pub(crate) target: Vec<usize>,
}

impl Free {
    /// Number of parameters.
    pub(crate) fn count(&self) -> usize {
        self.tracker.len() + self.target.len()
    }

    /// The frames moved by these values.
    pub(crate) fn moved(&self, frames: &Frames, values: &[f64]) -> Frames {
        let motion = |which: &[usize], values: &[f64]| {
            let mut motion = Vector6::zeros();
            which.iter().zip(values).for_each(|(k, v)| motion[*k] = *v);
            motion
        };
        let (tracker, target) = values.split_at(self.tracker.len());
        Frames {
            base: frames.base.moved(&motion(&self.tracker, tracker)),
            target: frames.target.moved(&motion(&self.target, target)),
        }
    }

    /// Small motion of the platform, base axes, that does to a reading what each parameter does (6 × parameters).
    fn motion(&self, pose: &Pose, frames: &Frames) -> DMatrix<f64> {
        let back = frames.base.rotation.inverse();
        let arm = frames.base.rotation * pose.position;
        let of_tracker = Matrix6::from_columns(&std::array::from_fn::<_, 6, _>(|k| {
            let (t, w) = (shift(k), turn(k));
            joined(&(back * (t + w.cross(&arm))), &(back * w))
        }));
        let of_target = Matrix6::from_columns(&std::array::from_fn::<_, 6, _>(|k| {
            let (t, w) = (shift(k), turn(k));
            joined(&(pose.rotation * (t - w.cross(&frames.target.position))), &(pose.rotation * w))
        }));
        let columns = self.tracker.iter().map(|k| of_tracker.column(*k).into_owned());
        let columns: Vec<_> = columns.chain(self.target.iter().map(|k| of_target.column(*k).into_owned())).collect();
        DMatrix::from_fn(6, columns.len(), |i, k| columns[k][i])
    }
}

fn shift(k: usize) -> Vector3<f64> {
    if k < 3 { Vector3::ith(k, 1.0) } else { Vector3::zeros() }
}

fn turn(k: usize) -> Vector3<f64> {
    if k < 3 { Vector3::zeros() } else { Vector3::ith(k - 3, 1.0) }
}

fn joined(shift: &Vector3<f64>, turn: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

impl UnknownFrames {
    /// These data with free motions of their frames; the same data if there are none.
    pub(crate) fn wrap(data: &Dataset, free: &Free) -> Dataset {
        if free.count() == 0 {
            return data.clone();
        }
        let inner = Arc::clone(data.model());
        let spec = |frame: &str, k: &usize| ParameterSpec {
            name: format!("{frame}.{}", ["x", "y", "z", "rx", "ry", "rz"][*k]),
            dimension: if *k < 3 { Dimension::Length } else { Dimension::Angle },
            nominal: 0.0,
            tolerance: None,
            role: ParameterRole::Other,
        };
        let mut specs = inner.nuisance_parameters().to_vec();
        specs.extend(free.tracker.iter().map(|k| spec("tracker", k)));
        specs.extend(free.target.iter().map(|k| spec("target", k)));
        data.with_model(Arc::new(Self { inner, free: free.clone(), specs }))
    }

    /// How many own parameters are those of the readings themselves.
    fn of_inner(&self) -> usize {
        self.specs.len() - self.free.count()
    }
}

impl MeasurementModel for UnknownFrames {
    fn describe(&self) -> String {
        self.inner.describe()
    }

    fn samples(&self) -> usize {
        self.inner.samples()
    }

    fn rows(&self, sample: usize) -> Vec<RowKind> {
        self.inner.rows(sample)
    }

    fn row_of_each(&self, sample: usize) -> Vec<Option<usize>> {
        self.inner.row_of_each(sample)
    }

    fn nuisance_parameters(&self) -> &[ParameterSpec] {
        &self.specs
    }

    fn nuisance_heading(&self) -> &'static str {
        self.inner.nuisance_heading()
    }

    fn start(&self, poses: &[Option<Pose>], frames: &Frames) -> Vec<f64> {
        let mut start = self.inner.start(poses, frames);
        start.resize(self.specs.len(), 0.0);
        start
    }

    fn evaluate(&self, index: usize, sample: &Sample, pose: &Pose, frames: &Frames, own: &[f64], out: &mut Rows) {
        let (inner, motion) = own.split_at(self.of_inner());
        let frames = self.free.moved(frames, motion);
        let mut rows = Rows::sized(out.residual.len(), inner.len());
        self.inner.evaluate(index, sample, pose, &frames, inner, &mut rows);
        out.own.columns_mut(0, inner.len()).copy_from(&rows.own);
        out.own.columns_mut(inner.len(), motion.len()).copy_from(&(&rows.motion * self.free.motion(pose, &frames)));
        out.residual = rows.residual;
        out.motion = rows.motion;
    }

    fn covariance(&self, sample: usize, frames: &Frames) -> DMatrix<f64> {
        self.inner.covariance(sample, frames)
    }

    fn rigid_pose(&self, sample: usize) -> Option<Pose> {
        self.inner.rigid_pose(sample)
    }

    fn coordinates(&self, sample: usize) -> Option<[f64; 6]> {
        self.inner.coordinates(sample)
    }

    fn target_frame(&self) -> TargetFrame {
        self.inner.target_frame()
    }

    fn platform_motion(&self, own: &[f64], pose: &Pose, frames: &Frames) -> Option<DMatrix<f64>> {
        let (inner, values) = own.split_at(self.of_inner());
        let frames = self.free.moved(frames, values);
        let of_inner = self.inner.platform_motion(inner, pose, &frames);
        let mut motion = of_inner.unwrap_or_else(|| DMatrix::zeros(6, inner.len())).resize_horizontally(own.len(), 0.0);
        motion.columns_mut(inner.len(), values.len()).copy_from(&self.free.motion(pose, &frames));
        Some(motion)
    }

    fn points(&self, sample: usize) -> Vec<PointReading> {
        self.inner.points(sample)
    }

    fn point(&self, sample: usize) -> Option<PointReading> {
        self.inner.point(sample)
    }
}
