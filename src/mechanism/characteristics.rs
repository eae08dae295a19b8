//! Size and conditioning of a mechanism.

use nalgebra::{DVector, Matrix6, Vector3, Vector6};

use super::{GeometryError, KinematicsError, Linearization, Mechanism, MotionBlock, ParameterRole, ParameterSpec};
use crate::conditions::Conditions;
use crate::pose::Pose;
use crate::solve::inverse6;

/// One of the two bodies that the legs join.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// The moving one; points `aᵢ`.
    Platform,
    /// The standing one; points `bᵢ`.
    Base,
}

impl Body {
    /// Leg and axis of a parameter that is a coordinate of one of this body's points.
    pub fn coordinate(self, role: ParameterRole) -> Option<(usize, usize)> {
        match (self, role) {
            (Self::Platform, ParameterRole::PlatformPoint { leg, axis })
            | (Self::Base, ParameterRole::BasePoint { leg, axis }) => Some((leg, axis.index())),
            _ => None,
        }
    }

    /// The body's points under the parameters `c`, by leg; legs without a point are skipped.
    pub fn points<M: Mechanism + ?Sized>(self, mechanism: &M, c: &[f64]) -> Vec<(usize, Vector3<f64>)> {
        self.points_among(mechanism.parameters(), c)
    }

    /// The parameters `c` with the body's points moved.
    pub(crate) fn moved<M: Mechanism + ?Sized>(self, mechanism: &M, c: &[f64], motion: &Pose) -> Vec<f64> {
        let points = self.points(mechanism, c);
        let moved = |spec: &ParameterSpec| {
            let (leg, axis) = self.coordinate(spec.role)?;
            let (_, point) = points.iter().find(|(l, _)| *l == leg)?;
            Some(motion.place(point)[axis])
        };
        mechanism.parameters().iter().zip(c).map(|(spec, value)| moved(spec).unwrap_or(*value)).collect()
    }

    /// The body's points among any parameters and their values, by leg.
    pub(super) fn points_among(self, specs: &[ParameterSpec], c: &[f64]) -> Vec<(usize, Vector3<f64>)> {
        let mut points: Vec<(usize, Vector3<f64>)> = Vec::new();
        for (spec, value) in specs.iter().zip(c) {
            if let Some((leg, axis)) = self.coordinate(spec.role) {
                if points.last().is_none_or(|(last, _)| *last != leg) {
                    points.push((leg, Vector3::zeros()));
                }
                if let Some((_, point)) = points.last_mut() {
                    point[axis] = *value;
                }
            }
        }
        points
    }
}

/// The six directions of the parameters in which all points of a body move as one rigid body, in parameters over
/// `scale`: shifts along x, y, z, then turns about the axes through the centroid.
pub fn rigid_directions<M: Mechanism + ?Sized>(mechanism: &M, body: Body, scale: &[f64]) -> [DVector<f64>; 6] {
    let specs = mechanism.parameters();
    let points = body.points(mechanism, mechanism.values());
    let centre = points.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    std::array::from_fn(|which| {
        let unit = Vector3::ith(which % 3, 1.0);
        let mut direction = DVector::zeros(specs.len());
        for (k, spec) in specs.iter().enumerate() {
            let Some((leg, axis)) = body.coordinate(spec.role) else { continue };
            let point = points.iter().find(|(l, _)| *l == leg).map_or(centre, |(_, p)| *p);
            let motion = if which < 3 { unit } else { unit.cross(&(point - centre)) };
            direction[k] = motion[axis] / scale[k];
        }
        direction
    })
}

/// A motion that the points of a body carry is met to this part.
const CARRIED: f64 = 1e-6;

/// The motions of a body (shifts along x, y, z, turns about them) that the points among the parameters do not carry, because
/// something else of the body, such as a rail, keeps its direction. Compared at home and next to it.
pub(crate) fn not_carried(mechanism: &dyn Mechanism, body: Body) -> Vec<usize> {
    let (c, at) = (mechanism.values(), Conditions::unknown());
    let ones = vec![1.0; c.len()];
    let points = body.points(mechanism, c);
    let centre = points.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let directions = rigid_directions(mechanism, body, &ones);
    let size = characteristic_length(mechanism);
    let beside = |k: usize| {
        let motion = Vector6::ith(k, if k < 3 { 0.1 * size } else { 0.1 });
        super::consistent(mechanism, c, &mechanism.home().moved(&motion), &at)
    };
    let mut carried = [true; 6];
    let mut block = MotionBlock::sized_for(mechanism);
    for (pose, joints) in (0..6).filter_map(|k| beside(k).ok()) {
        if mechanism.motion_block(c, &joints, &pose, &at, &mut block).is_err() {
            continue;
        }
        for (k, carried) in carried.iter_mut().enumerate() {
            let (t, w) =
                (Vector3::ith(k % 3, f64::from(u8::from(k < 3))), Vector3::ith(k % 3, f64::from(u8::from(k >= 3))));
            let expected = match body {
                Body::Base => [t + w.cross(&(pose.position - centre)), w],
                Body::Platform => [-(pose.rotation * (t - w.cross(&centre))), -(pose.rotation * w)],
            };
            let moved = &block.parameters * &directions[k];
            let off = Vector6::from_fn(|i, _| moved[i] - expected[i / 3][i % 3]);
            *carried &= off.rows(0, 3).norm() + size * off.rows(3, 3).norm() < CARRIED * (1.0 + size);
        }
    }
    (0..6).filter(|k| !carried[*k]).collect()
}

/// Mean distance of the platform points from their centroid, m: the arm by which an angle becomes a length.
/// Mechanisms without platform points count as one metre.
pub fn characteristic_length<M: Mechanism + ?Sized>(mechanism: &M) -> f64 {
    let points = mechanism.platform_points();
    let n = points.len().max(1) as f64;
    let centre = points.iter().sum::<Vector3<f64>>() / n;
    let mean = points.iter().map(|p| (p - centre).norm()).sum::<f64>() / n;
    if mean > 0.0 { mean } else { 1.0 }
}

/// Condition number of `J₁` with the angles scaled by the [`characteristic_length`]; infinite at a
/// singularity.
pub fn condition<M: Mechanism + ?Sized>(mechanism: &M, c: &[f64], joints: &[f64], pose: &Pose, at: &Conditions) -> f64 {
    let mut work = Linearization::sized_for(mechanism);
    mechanism.linearize(c, joints, pose, at, &mut work);
    let size = characteristic_length(mechanism);
    for k in 3..6 {
        work.motion.column_mut(k).unscale_mut(size);
    }
    if work.motion.iter().any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    let sigma = work.motion.singular_values();
    sigma.max() / sigma.min()
}

/// A home pose with a worse condition does not hold its platform.
const WORST_CONDITION: f64 = 1e7;
/// One over the product of the sizes of `J₁` and its inverse, below which a pose is singular.
const SINGULAR: f64 = 1e-13;

/// Refuses a mechanism whose joints do not hold the platform at home.
///
/// # Errors
/// [`GeometryError::SingularHome`].
pub(super) fn check_held<M: Mechanism + ?Sized>(mechanism: &M, home_joints: &[f64]) -> Result<(), GeometryError> {
    let condition = condition(mechanism, mechanism.values(), home_joints, &mechanism.home(), &Conditions::unknown());
    if condition < WORST_CONDITION { Ok(()) } else { Err(GeometryError::SingularHome { condition }) }
}

/// `J₁⁻¹` of six closure equations.
///
/// # Errors
/// [`KinematicsError::Singular`] where there is none.
pub(super) fn inverse_motion(motion: &Matrix6<f64>) -> Result<Matrix6<f64>, KinematicsError> {
    let singular = |pivot_ratio| KinematicsError::Singular { pivot_ratio };
    let inverse = inverse6(motion).ok_or(singular(0.0))?;
    // The product of the two sizes bounds the condition; its inverse stands for the ratio of the pivots.
    let ratio = 1.0 / (inverse.norm() * motion.norm());
    if ratio > SINGULAR { Ok(inverse) } else { Err(singular(ratio)) }
}
