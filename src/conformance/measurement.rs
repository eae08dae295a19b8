//! Laws of a [`MeasurementModel`].

use std::panic::{AssertUnwindSafe, catch_unwind};

use nalgebra::{DMatrix, DVector, Rotation3, Vector3, Vector6};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::mechanism::{MOTIONS, STEP, compare, differences, shown};
use super::{Violation, violation};
use crate::measurement::{Frames, MeasurementModel, RowKind, Rows, Sample, TargetFrame};
use crate::pose::Pose;

/// Derivatives are checked this far from the poses that were given, m and rad.
const NEARBY: f64 = 1e-2;
/// Places of tracker and target for which every law is checked, the identity among them.
const PLACES: usize = 3;
/// A pose that was built from a reading may miss the reading by this many σ.
const NOISE: f64 = 10.0;

/// Checks a measurement model of these samples, of which the `k`-th was measured with the platform near `poses[k]` (base
/// frame, tracker and target in the identity frames), without gross errors.
///
/// * rows, covariance and own parameters agree in number, names are unique;
/// * own parameters start at finite values, also without some of the samples;
/// * covariances are symmetric and positive definite;
/// * `motion` and `own` agree with central differences at random poses near those given, with tracker and target in the
///   identity frames and elsewhere;
/// * the same input gives the same bits;
/// * a pose that is not a number gives neither a finite residual nor a panic;
/// * where a reading states a pose or a point of the platform ([`MeasurementModel::rigid_pose`],
///   [`MeasurementModel::point`]), the rows vanish there, to ten σ; points at unknown places
///   ([`TargetFrame::Identified`]) state those of a frame of their own and are left out.
///
/// # Errors
/// The first [`Violation`].
pub fn measurement(model: &dyn MeasurementModel, samples: &[Sample], poses: &[Pose]) -> Result<(), Violation> {
    sizes(model, samples, poses)?;
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for place in 0..PLACES {
        let bench = Bench::new(model, samples, poses, place, &mut rng)?;
        for sample in 0..model.samples() {
            bench.covariance(sample)?;
            bench.derivatives(sample, &mut rng)?;
            bench.not_a_number(sample)?;
            bench.points(sample)?;
        }
        bench.rigid_poses()?;
    }
    Ok(())
}

fn sizes(model: &dyn MeasurementModel, samples: &[Sample], poses: &[Pose]) -> Result<(), Violation> {
    const LAW: &str = "samples, rows and parameters agree in number";
    if model.samples() != poses.len() {
        return Err(violation(LAW, format!("{} samples, {} poses", model.samples(), poses.len())));
    }
    if model.samples() != samples.len() {
        return Err(violation(LAW, format!("the model has {} samples, {} are given", model.samples(), samples.len())));
    }
    for sample in 0..model.samples() {
        let (rows, shape) = (model.rows(sample).len(), model.covariance(sample, &Frames::default()).shape());
        if shape != (rows, rows) {
            return Err(violation(LAW, format!("sample {sample}: {rows} rows, covariance {} × {}", shape.0, shape.1)));
        }
    }
    let own = model.nuisance_parameters();
    for (k, spec) in own.iter().enumerate() {
        if own[..k].iter().any(|s| s.name == spec.name) {
            return Err(violation(LAW, format!("two own parameters are called {}", spec.name)));
        }
    }
    Ok(())
}

/// Start values of the own parameters, checked.
fn start(model: &dyn MeasurementModel, poses: &[Option<Pose>], frames: &Frames) -> Result<Vec<f64>, Violation> {
    const LAW: &str = "own parameters start at finite values";
    let (found, again) = (model.start(poses, frames), model.start(poses, frames));
    let specs = model.nuisance_parameters();
    if found.len() != specs.len() {
        return Err(violation(LAW, format!("{} parameters, {} values", specs.len(), found.len())));
    }
    if let Some((spec, value)) = specs.iter().zip(&found).find(|(_, v)| !v.is_finite()) {
        return Err(violation(LAW, format!("{} starts at {value}", spec.name)));
    }
    if found != again {
        return Err(violation("the same input gives the same bits", "start values of the own parameters"));
    }
    Ok(found)
}

/// A model with tracker and target somewhere.
struct Bench<'a> {
    model: &'a dyn MeasurementModel,
    samples: &'a [Sample],
    frames: Frames,
    /// Which place it is, for messages.
    place: &'static str,
    /// The platform at each sample, for readings that are what they are.
    poses: Vec<Pose>,
    own: Vec<f64>,
}

impl<'a> Bench<'a> {
    fn new(
        model: &'a dyn MeasurementModel,
        samples: &'a [Sample],
        poses: &[Pose],
        place: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, Violation> {
        let mut somewhere = || {
            let mut three = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-size..size));
            Pose { position: three(3.0), rotation: Rotation3::from_scaled_axis(three(1.5)) }
        };
        let elsewhere = Frames { base: somewhere(), target: somewhere() };
        // A target whose place is known, or identified point by point, has no frame beside the platform's.
        let own_target = model.target_frame() == TargetFrame::Convention;
        let (frames, place) = match place {
            0 => (Frames::default(), ""),
            1 => (Frames { target: Pose::identity(), ..elsewhere }, " with the tracker elsewhere"),
            _ if own_target => (elsewhere, " with tracker and target elsewhere"),
            _ => (Frames { target: Pose::identity(), ..elsewhere }, " with the tracker at another place"),
        };
        let poses: Vec<Pose> = poses.iter().map(|p| frames.platform(p)).collect();
        let all: Vec<Option<Pose>> = poses.iter().copied().map(Some).collect();
        let half: Vec<Option<Pose>> = poses.iter().enumerate().map(|(k, p)| (k % 2 == 0).then_some(*p)).collect();
        start(model, &half, &frames)?;
        let own = start(model, &all, &frames)?;
        Ok(Self { model, samples, frames, place, poses, own })
    }

    fn rows(&self, sample: usize, pose: &Pose, own: &[f64]) -> Rows {
        let mut rows = Rows::sized(self.model.rows(sample).len(), own.len());
        self.model.evaluate(sample, &self.samples[sample], pose, &self.frames, own, &mut rows);
        rows
    }

    fn covariance(&self, sample: usize) -> Result<(), Violation> {
        const LAW: &str = "covariances are symmetric and positive definite";
        let c = self.model.covariance(sample, &self.frames);
        let n = c.nrows();
        let name = format!("sample {sample}{}", self.place);
        for k in 0..n {
            if !(c[(k, k)] > 0.0 && c[(k, k)].is_finite()) {
                return Err(violation(LAW, format!("{name}: the variance of row {} is {:.3e}", k + 1, c[(k, k)])));
            }
        }
        let correlation = DMatrix::from_fn(n, n, |i, j| c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt());
        for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
            if !((correlation[(i, j)] - correlation[(j, i)]).abs() <= 1e-9) {
                let (a, b) = (c[(i, j)], c[(j, i)]);
                return Err(violation(LAW, format!("{name}: rows {} and {}: {a:.6e} and {b:.6e}", i + 1, j + 1)));
            }
        }
        if n > 0 && correlation.cholesky().is_none() {
            return Err(violation(LAW, format!("{name}: not positive definite")));
        }
        Ok(())
    }

    fn derivatives(&self, sample: usize, rng: &mut ChaCha8Rng) -> Result<(), Violation> {
        let away = Vector6::from_fn(|_, _| rng.random_range(-NEARBY..NEARBY));
        let pose = self.poses[sample].moved(&away);
        let (here, again) = (self.rows(sample, &pose, &self.own), self.rows(sample, &pose, &self.own));
        let (k, p) = (self.model.rows(sample).len(), self.own.len());
        let at = || format!("sample {sample}{}", self.place);
        if (here.residual.len(), here.motion.shape(), here.own.shape()) != (k, (k, 6), (k, p)) {
            let detail = format!("{}: evaluation changes the size of its rows", at());
            return Err(violation("samples, rows and parameters agree in number", detail));
        }
        if here != again {
            return Err(violation("the same input gives the same bits", format!("{}: {}", at(), shown(&pose))));
        }
        for (c, name) in MOTIONS.iter().enumerate() {
            let mut d = Vector6::zeros();
            d[c] = STEP;
            let (plus, minus) =
                (self.rows(sample, &pose.moved(&d), &self.own), self.rows(sample, &pose.moved(&-d), &self.own));
            let numeric = (plus.residual - minus.residual) / (2.0 * STEP);
            let name = format!("{}, {name}", at());
            compare("motion agrees with differences", &name, &pose, &here.motion.column(c).into_owned(), &numeric)?;
        }
        for (c, spec) in self.model.nuisance_parameters().iter().enumerate() {
            let numeric = differences(&self.own, c, |own| self.rows(sample, &pose, own).residual);
            let name = format!("{}, {}", at(), spec.name);
            compare("own agrees with differences", &name, &pose, &here.own.column(c).into_owned(), &numeric)?;
        }
        Ok(())
    }

    fn not_a_number(&self, sample: usize) -> Result<(), Violation> {
        const LAW: &str = "a pose that is not a number gives neither a finite residual nor a panic";
        let nan = Vector3::repeat(f64::NAN);
        let turned = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::repeat(f64::NAN));
        let pose = Pose { position: nan, rotation: turned };
        let Ok(rows) = catch_unwind(AssertUnwindSafe(|| self.rows(sample, &pose, &self.own))) else {
            return Err(violation(LAW, format!("sample {sample}{}: panic", self.place)));
        };
        match rows.residual.iter().position(|r| r.is_finite()) {
            Some(row) => {
                let detail = format!("sample {sample}{}, row {}: {}", self.place, row + 1, rows.residual[row]);
                Err(violation(LAW, detail))
            }
            None => Ok(()),
        }
    }

    /// Residuals over their σ.
    fn whitened(&self, sample: usize, pose: &Pose, own: &[f64]) -> DVector<f64> {
        let covariance = self.model.covariance(sample, &self.frames);
        let mut residual = self.rows(sample, pose, own).residual;
        for (k, r) in residual.iter_mut().enumerate() {
            *r /= covariance[(k, k)].sqrt();
        }
        residual
    }

    fn rigid_poses(&self) -> Result<(), Violation> {
        const LAW: &str = "the rows vanish at the pose that a reading states";
        let stated = |k: usize| self.model.rigid_pose(k).map(|seen| self.frames.platform(&seen));
        let poses: Vec<Option<Pose>> = (0..self.model.samples()).map(stated).collect();
        if self.model.target_frame() == TargetFrame::Identified || poses.iter().all(Option::is_none) {
            return Ok(());
        }
        let own = start(self.model, &poses, &self.frames)?;
        for (sample, pose) in poses.iter().enumerate().filter_map(|(k, p)| Some((k, p.as_ref()?))) {
            let missed = self.whitened(sample, pose, &own);
            if let Some(row) = missed.iter().position(|r| !(r.abs() <= NOISE)) {
                let detail = format!("sample {sample}{}, row {}: {:.3e} sigma", self.place, row + 1, missed[row]);
                return Err(violation(LAW, format!("{detail} at {}", shown(pose))));
            }
        }
        Ok(())
    }

    /// With the stated point at its place, three rows of a position vanish.
    fn points(&self, sample: usize) -> Result<(), Violation> {
        const LAW: &str = "three rows vanish where a reading states a point";
        let Some(seen) = self.model.point(sample).filter(|_| self.model.target_frame() != TargetFrame::Identified)
        else {
            return Ok(());
        };
        let mut pose = self.poses[sample];
        let arm = pose.rotation * self.frames.target.place(&seen.place);
        pose.position = self.frames.base.inverse().place(&seen.position) - arm;
        let missed = self.whitened(sample, &pose, &self.own);
        let kinds = self.model.rows(sample);
        let near = kinds.iter().zip(missed.iter()).filter(|(k, r)| **k == RowKind::Position && r.abs() <= NOISE);
        match near.count() {
            0..3 => {
                let least = missed.iter().map(|r| r.abs()).fold(f64::INFINITY, f64::min);
                let detail = format!("sample {sample}{}: the smallest row is {least:.3e} sigma", self.place);
                Err(violation(LAW, format!("{detail} at {}", shown(&pose))))
            }
            _ => Ok(()),
        }
    }
}
