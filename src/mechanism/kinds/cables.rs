//! A platform or a point in space, held by cables over swivelling pulleys, from drums that may grow as they are wound.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::planar_cables::weights;
use super::{Cable, Segment, Tolerances, positive, unit};
use crate::mechanism::closure::{Closure, ClosureMechanism, Column, Outline, Real, State, along, length};
use crate::mechanism::{GeometryError, ParameterRole};
use crate::pose::Pose;
use crate::units::Dimension;

/// A pulley that swivels about an axis through the anchor, at which the cable meets it. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Pulley {
    /// Radius at the middle of the cable.
    pub radius: f64,
    /// Direction in which the cable comes in, along the axis about which the pulley swivels, base frame; any length.
    pub swivel: Vector3<f64>,
}

/// Closure of cables in space.
///
/// Joints read zero at home: row `j` is `Σ_k w_jk (l_k - l_k₀) - (ρ_j h_j + ½ κ_j h_j² + o_j)`, with the length `l_k₀` for the
/// same parameters at home, the radius `ρ` of a drum and its growth `κ` per radian. Over a pulley of radius `R` a cable is
/// `R β + √(d² - R²)` long, where `d` is the distance of the platform point from the pulley's centre and `β` the angle along
/// which the cable lies on it (Pott 2012).
#[derive(Clone, Debug, PartialEq)]
pub struct Cables {
    home: Pose,
    /// Pulley of each segment, its direction of length one.
    pulleys: Vec<Option<Pulley>>,
    /// Weight of each segment in each cable.
    weights: Vec<Vec<f64>>,
    cables: Vec<Winch>,
    /// True if all segments meet in the platform's origin.
    point: bool,
    /// By which a tilt becomes a length, m.
    size: f64,
}

/// Where the parameters of a cable are: `o`, then `d` and `k` where it has them.
#[derive(Clone, Debug, PartialEq)]
struct Winch {
    first: usize,
    drum: bool,
    build_up: bool,
}

impl Winch {
    /// One past its last parameter.
    fn end(&self) -> usize {
        self.first + 1 + usize::from(self.drum) + usize::from(self.build_up)
    }
}

impl Cables {
    /// Cables between points of the platform and anchors, with the pulley of each segment. Their joints control all six
    /// coordinates, or x, y and z where all segments meet in the platform's origin, which is then a point without attitude.
    ///
    /// # Errors
    /// [`GeometryError`] if there are fewer cables than controlled coordinates, or they do not hold the platform.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        segments: &[(Segment, Option<Pulley>)],
        cables: &[Cable],
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<Self>, GeometryError> {
        let point = segments.iter().all(|(s, _)| s.platform == Vector3::zeros());
        let (needed, held) = if point { (3, "a point") } else { (6, "a platform") };
        if cables.len() < needed {
            let found = cables.len();
            return Err(GeometryError::Outline(format!(
                "{found} cables do not hold {held} in space; at least {needed} are needed"
            )));
        }
        let q = home.coordinates();
        let home = if point { Pose::from_coordinates(&[q[0], q[1], q[2], 0.0, 0.0, 0.0]) } else { home };
        if home.motion_to(&Pose::from_coordinates(&q)).amax() > 1e-9 {
            return Err(GeometryError::Outline("a point has no attitude: write zero rotations for home".into()));
        }
        let sigma = |f: fn(&Tolerances) -> f64| tolerances.as_ref().map(f);
        let controlled = [true, true, true, !point, !point, !point];
        let mut outline = Outline::new(name, cables.len() + if point { 3 } else { 0 }, home).controls(controlled);
        let mut closure = Self {
            home,
            pulleys: Vec::new(),
            weights: Vec::new(),
            cables: Vec::new(),
            point,
            size: segments.iter().map(|(s, _)| s.base.norm()).fold(0.0, f64::max).max(1e-3),
        };
        for (leg, (segment, pulley)) in segments.iter().enumerate() {
            if !point {
                outline = outline.platform_point(leg, segment.platform.into(), sigma(|t| t.anchor));
            }
            outline = outline.base_point(leg, segment.base.into(), sigma(|t| t.anchor));
            closure.pulleys.push(pulley.as_ref().map(|p| checked(leg, p)).transpose()?);
        }
        for (leg, cable) in cables.iter().enumerate() {
            let (drum, build_up) = (cable.drum.is_some(), cable.build_up.is_some());
            closure.cables.push(Winch { first: outline.parameters.len(), drum, build_up });
            closure.weights.push(weights(leg, cable, segments.len())?);
            outline = winch(outline, leg, cable, tolerances.as_ref())?;
        }
        ClosureMechanism::new(closure, outline)
    }

    fn per_segment(&self) -> usize {
        if self.point { 3 } else { 6 }
    }

    /// The length of a segment from its pulley on.
    fn segment<T: Real>(&self, s: &State<'_, T>, segment: usize) -> T {
        let first = self.per_segment() * segment;
        let (a, b) = match self.point {
            true => (Vector3::from_element(T::from(0.0)), s.point(first)),
            false => (s.point(first), s.point(first + 3)),
        };
        let reach = s.place(&a) - b;
        match &self.pulleys[segment] {
            Some(pulley) => over_pulley(&reach, pulley),
            None => length(&reach),
        }
    }
}

/// The length of a cable from where it comes in to a point as far away as `reach`.
fn over_pulley<T: Real>(reach: &Vector3<T>, pulley: &Pulley) -> T {
    let radius = pulley.radius;
    let up = along(reach, &pulley.swivel);
    let level = Vector3::from_fn(|k, _| reach[k] - up * pulley.swivel[k]);
    let out = length(&level) - radius;
    let square = out * out + up * up;
    let free = (square - radius * radius).sqrt();
    // From the incoming direction to the point as seen from the centre, and from there to the tangent.
    let wrapped = out.atan2(up) + T::from(radius).atan2(free);
    free + wrapped * radius
}

fn checked(leg: usize, pulley: &Pulley) -> Result<Pulley, GeometryError> {
    positive(leg, "pulley", pulley.radius)?;
    Ok(Pulley { radius: pulley.radius, swivel: unit(leg, "swivel", &pulley.swivel)? })
}

/// Adds the parameters and the joint of a cable.
fn winch(
    mut outline: Outline,
    leg: usize,
    cable: &Cable,
    tolerances: Option<&Tolerances>,
) -> Result<Outline, GeometryError> {
    let n = leg + 1;
    let sigma = tolerances.map(|t| t.length);
    outline =
        outline.parameter(format!("o{n}"), Dimension::Length, cable.offset, sigma, ParameterRole::JointOffset { leg });
    let Some(radius) = cable.drum else {
        return Ok(outline.joint(format!("leg{n}"), Dimension::Length, -cable.offset, cable.stroke));
    };
    positive(leg, "drum", radius)?;
    outline = outline.parameter(format!("d{n}"), Dimension::Length, radius, sigma, ParameterRole::JointScale { leg });
    if let Some(growth) = cable.build_up {
        let role = ParameterRole::LegDimension { leg };
        outline = outline.parameter(format!("k{n}"), Dimension::Length, growth, sigma, role);
    }
    Ok(outline.joint(format!("leg{n}"), Dimension::Angle, -cable.offset / radius, cable.stroke))
}

impl Closure for Cables {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        let at_home = State {
            position: self.home.position.map(T::from),
            rotation: self.home.rotation.matrix().map(T::from),
            ..*s
        };
        let change = |k: usize| self.segment(s, k) - self.segment(&at_home, k);
        let changes: Vec<T> = (0..self.pulleys.len()).map(change).collect();
        for (cable, winch) in self.cables.iter().enumerate() {
            let h = s.joints[cable];
            let mut wound = h;
            if winch.drum {
                wound = h * s.parameters[winch.first + 1];
            }
            if winch.build_up {
                // The radius grows with the angle: its growth in one turn over 2π is that per radian.
                wound += h * h * s.parameters[winch.first + 2] * (0.5 / TAU);
            }
            out[cable] = -wound - s.parameters[winch.first];
            for (weight, change) in self.weights[cable].iter().zip(&changes) {
                out[cable] += *change * *weight;
            }
        }
        if self.point {
            let attitude = &mut out[self.cables.len()..];
            for (row, (i, k)) in attitude.iter_mut().zip([(2, 1), (0, 2), (1, 0)]) {
                *row = s.rotation[(i, k)] * self.size;
            }
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        let Some(winch) = self.cables.get(row) else { return false };
        match on {
            Column::Joint(k) => k == row,
            Column::Parameter(k) => match self.weights[row].get(k / self.per_segment()) {
                Some(weight) => *weight != 0.0,
                None => (winch.first..winch.end()).contains(&k),
            },
        }
    }
}
