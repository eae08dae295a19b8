//! What more than six closure equations say beside the pose.
//!
//! The pose of `m > 6` equations is that of least squares, and `m - 6` combinations of the closure residual remain:
//! `Nᵀ f` with `N` orthogonal to the columns of `J₁`. With exact joints they would be zero; with joint readings of
//! covariance `Σ_j` they have covariance `(Nᵀ J_j) Σ_j (Nᵀ J_j)ᵀ` and are rows of the identification like those of the
//! pose, with which they are correlated. Together the two lose nothing of the closure residual.

use nalgebra::{DMatrix, DVector};

use crate::measurement::Sample;
use crate::mechanism::{Linearization, Mechanism};
use crate::pose::Pose;

/// The remaining combinations of each sample.
pub(super) struct Redundancy {
    /// `N` (m × (m - 6)) of each sample at the start.
    bases: Vec<DMatrix<f64>>,
    work: Linearization,
    /// `Nᵀ f` (m - 6) of the last evaluation.
    pub(super) residual: DVector<f64>,
    /// `Nᵀ J₂` ((m - 6) × L).
    pub(super) parameters: DMatrix<f64>,
    /// `Nᵀ J_j` ((m - 6) × n).
    pub(super) joints: DMatrix<f64>,
}

impl Redundancy {
    /// For a mechanism whose joints are read with noise; `None` if it has six equations or exact joints.
    pub(super) fn of(mechanism: &dyn Mechanism, joint_noise: f64) -> Option<Self> {
        let extra = mechanism.equations().checked_sub(6).filter(|extra| *extra > 0 && joint_noise > 0.0)?;
        Some(Self {
            bases: Vec::new(),
            work: Linearization::sized_for(mechanism),
            residual: DVector::zeros(extra),
            parameters: DMatrix::zeros(extra, mechanism.parameters().len()),
            joints: DMatrix::zeros(extra, mechanism.joints().len()),
        })
    }

    /// Number of rows for each sample.
    pub(super) fn rows(&self) -> usize {
        self.residual.len()
    }

    /// Evaluates the rows of the `k`-th sample at its pose. Samples are first evaluated in order.
    pub(super) fn evaluate(&mut self, mechanism: &dyn Mechanism, c: &[f64], k: usize, sample: &Sample, pose: &Pose) {
        mechanism.linearize(c, &sample.joints, pose, &sample.conditions, &mut self.work);
        let (m, extra) = (self.work.motion.nrows(), self.rows());
        let qr = self.work.motion.clone().qr();
        if self.bases.len() == k {
            // Q applied to the last unit vectors: the transpose is at hand, so its inverse is taken row by row.
            let mut transposed = DMatrix::identity(m, m);
            qr.q_tr_mul(&mut transposed);
            self.bases.push(transposed.rows(6, extra).transpose());
        }
        // The directions of the start, projected: so that they mean the same from one iteration to the next.
        let q = qr.q();
        let start = &self.bases[k];
        let n = start - &q * (q.transpose() * start);
        self.residual.copy_from(&n.tr_mul(&self.work.residual));
        self.parameters.copy_from(&n.tr_mul(&self.work.parameters));
        self.joints.copy_from(&n.tr_mul(&self.work.joints));
    }
}
