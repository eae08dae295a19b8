//! Perturbation by an effect at one sample.

use nalgebra::{Matrix6xX, Vector6};

use super::{ActiveEffect, Site};
use crate::mechanism::MotionBlock;

/// Changes of parameters, joints and measured pose, SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Perturbation {
    /// `δC`, in the order of the parameters of the mechanism.
    pub parameters: Vec<f64>,
    /// `δh`: true joint coordinate less the commanded one.
    pub joints: Vec<f64>,
    /// `δq`: small motion `(δt, δω)` of the measured platform, base axes; it turns about the platform's origin.
    pub pose: Vector6<f64>,
}

impl Perturbation {
    /// Zeros for so many parameters and joints.
    pub fn sized(parameters: usize, joints: usize) -> Self {
        Self { parameters: vec![0.0; parameters], joints: vec![0.0; joints], pose: Vector6::zeros() }
    }

    /// What each parameter of these effects does at a site, per unit.
    pub(super) fn per_unit(effects: &[ActiveEffect], site: &Site<'_>) -> Vec<Self> {
        let mut all = Vec::new();
        for effect in effects {
            let mut unit = vec![0.0; effect.values.len()];
            for k in 0..unit.len() {
                unit[k] = 1.0;
                let mut out = Self::sized(site.values.len(), site.joints.len());
                effect.effect.perturb(&unit, &effect.at, site, &mut out);
                unit[k] = 0.0;
                all.push(out);
            }
        }
        all
    }

    /// The small motion of the measured pose that follows, to first order: `J_b δC + J_h δh + δq`.
    pub fn motion(&self, block: &MotionBlock) -> Vector6<f64> {
        let mut motion = self.pose;
        let add = |values: &[f64], columns: &Matrix6xX<f64>, motion: &mut Vector6<f64>| {
            for (k, value) in values.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                motion.axpy(*value, &columns.column(k), 1.0);
            }
        };
        add(&self.parameters, &block.parameters, &mut motion);
        add(&self.joints, &block.joints, &mut motion);
        motion
    }
}
