//! Information from more than six closure equations in addition to the pose.
//!
//! The pose of `m > 6` equations is that of least squares, and `m - 6` combinations of the closure residual remain:
//! `Nᵀ f` with `N` orthogonal to the columns of `J₁`. With exact joints they would be zero; with joint readings of
//! covariance `Σ_j` they have covariance `(Nᵀ J_j) Σ_j (Nᵀ J_j)ᵀ` and are rows of the identification like those of the
//! pose, with which they are correlated. Together the two lose nothing of the closure residual to first order.
//!
//! Combinations that no joint enters (structural constraints stated twice) say nothing and are left out.

use nalgebra::{DMatrix, DVector};

use crate::conditions::Conditions;
use crate::measurement::Sample;
use crate::mechanism::{Linearization, Mechanism};
use crate::pose::Pose;
use crate::solve::{singular_values, svd};

/// A combination that joints enter by less than this part of their largest effect is structural.
const SEEN: f64 = 1e-9;

/// The remaining combinations of a sample.
#[derive(Clone)]
pub(crate) struct Redundancy {
    work: Linearization,
    /// `Nᵀ f` of the last evaluation.
    pub(crate) residual: DVector<f64>,
    /// `Nᵀ J₂` (rows × L).
    pub(crate) parameters: DMatrix<f64>,
    /// `Nᵀ J_j` (rows × n).
    pub(crate) joints: DMatrix<f64>,
}

impl Redundancy {
    /// For a mechanism whose joints are read with noise; `None` if it has six equations or exact joints.
    pub(crate) fn of(mechanism: &dyn Mechanism, joint_noise: f64) -> Option<Self> {
        if mechanism.equations() <= 6 || !(joint_noise > 0.0) {
            return None;
        }
        let (c, home, at) = (mechanism.values(), mechanism.home(), Conditions::unknown());
        let mut work = Linearization::sized_for(mechanism);
        mechanism.linearize(c, &mechanism.inverse(c, &home, &at).ok()?, &home, &at, &mut work);
        let n = complement(&work.motion);
        let values = singular_values(n.tr_mul(&work.joints));
        let extra = values.iter().filter(|v| **v > SEEN * work.joints.norm()).count();
        if extra == 0 {
            return None;
        }
        Some(Self {
            work,
            residual: DVector::zeros(extra),
            parameters: DMatrix::zeros(extra, mechanism.parameters().len()),
            joints: DMatrix::zeros(extra, mechanism.joints().len()),
        })
    }

    /// Number of rows for each sample.
    pub(crate) fn rows(&self) -> usize {
        self.residual.len()
    }

    /// The combinations `N` (m × rows) that are rows of a sample, at its pose at the start: those that joints enter most.
    pub(crate) fn combinations(&mut self, mechanism: &dyn Mechanism, sample: &Sample, pose: &Pose) -> DMatrix<f64> {
        mechanism.linearize(mechanism.values(), &sample.joints, pose, &sample.conditions, &mut self.work);
        let n = complement(&self.work.motion);
        match svd(n.tr_mul(&self.work.joints), true, false).u {
            Some(u) => n * u.columns(0, self.rows()),
            None => n.columns(0, self.rows()).into_owned(),
        }
    }

    /// Evaluates the rows of a sample at its pose; `start` are its [`combinations`](Self::combinations).
    pub(crate) fn evaluate(
        &mut self,
        mechanism: &dyn Mechanism,
        c: &[f64],
        start: &DMatrix<f64>,
        sample: &Sample,
        pose: &Pose,
    ) {
        mechanism.linearize(c, &sample.joints, pose, &sample.conditions, &mut self.work);
        let q = self.work.motion.clone().qr().q();
        // The directions of the start, projected: so that they mean the same from one iteration to the next.
        let n = start - &q * (q.transpose() * start);
        self.residual.copy_from(&n.tr_mul(&self.work.residual));
        self.parameters.copy_from(&n.tr_mul(&self.work.parameters));
        self.joints.copy_from(&n.tr_mul(&self.work.joints));
    }
}

/// Orthonormal columns (m × (m - 6)) orthogonal to those of `J₁` (m × 6).
fn complement(motion: &DMatrix<f64>) -> DMatrix<f64> {
    let m = motion.nrows();
    let mut transposed = DMatrix::identity(m, m);
    motion.clone().qr().q_tr_mul(&mut transposed);
    transposed.rows(6, m - 6).transpose()
}
