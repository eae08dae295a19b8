//! A platform or a point held in a plane by cables, some of which run over several segments.

use nalgebra::Vector3;

use super::{Tolerances, positive};
use crate::mechanism::closure::{Closure, ClosureMechanism, Column, Outline, Real, State, length};
use crate::mechanism::{Axis, GeometryError, ParameterRole};
use crate::pose::Pose;
use crate::units::Dimension;

/// A straight piece of cable between the platform and a fixed anchor, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Where it meets the platform, platform frame.
    pub platform: Vector3<f64>,
    /// Its anchor, base frame.
    pub base: Vector3<f64>,
}

/// One cable, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Cable {
    /// Its segments, from 0; one that it runs along twice (over a pulley on the platform) stands twice.
    pub segments: Vec<usize>,
    /// Radius of its drum: the joint is then the angle of the drum, else the length of the cable.
    pub drum: Option<f64>,
    /// By how much the radius of the drum grows in one turn; `None` if it does not.
    pub build_up: Option<f64>,
    /// True change of length since home less the read one.
    pub offset: f64,
    /// Smallest and largest reading.
    pub stroke: Option<[f64; 2]>,
}

/// Closure of cables in a plane of constant z.
///
/// Joints read zero at home: row `j` is `Σ_k w_jk (|l_k| - |l_k|₀) - (ρ_j h_j + o_j)`, with `|l_k|₀` for the same
/// parameters at home.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarCables {
    home: Pose,
    /// z of the platform points and of the anchors, by segment.
    heights: Vec<[f64; 2]>,
    /// Weight of each segment in each cable.
    weights: Vec<Vec<f64>>,
    /// First parameter of each cable, and whether a drum radius follows.
    cables: Vec<(usize, bool)>,
    /// True if all segments meet in the platform's origin.
    point: bool,
    /// By which a tilt becomes a length, m.
    size: f64,
}

impl PlanarCables {
    /// Cables between points of the plane z = `home.z`. Their joints control x and y, and γ unless all segments meet in
    /// the platform's origin, which is then a point without attitude.
    ///
    /// # Errors
    /// [`GeometryError`] if there are fewer cables than controlled coordinates, or they do not hold the platform.
    #[allow(clippy::new_ret_no_self)]
    pub fn new(
        name: &str,
        segments: &[Segment],
        cables: &[Cable],
        home: Pose,
        tolerances: Option<Tolerances>,
    ) -> Result<ClosureMechanism<Self>, GeometryError> {
        let point = segments.iter().all(|s| s.platform == Vector3::zeros());
        let needed = if point { 2 } else { 3 };
        if cables.len() < needed {
            let found = cables.len();
            return Err(GeometryError::Outline(format!(
                "{found} cables do not hold the platform in its plane; at least {needed} are needed"
            )));
        }
        let q = home.coordinates();
        let home = Pose::from_coordinates(&[q[0], q[1], q[2], 0.0, 0.0, if point { 0.0 } else { q[5] }]);
        // A file that was written by a calibration may be off by rounding.
        if home.motion_to(&Pose::from_coordinates(&q)).amax() > 1e-9 {
            return Err(GeometryError::Outline("home must lie in the plane z = constant: write zero rotations".into()));
        }
        let sigma = |f: fn(&Tolerances) -> f64| tolerances.as_ref().map(f);
        let equations = cables.len() + if point { 4 } else { 3 };
        let mut outline = Outline::new(name, equations, home).controls([true, true, false, false, false, !point]);
        for (leg, segment) in segments.iter().enumerate() {
            let platform = [("xA", 0), ("yA", 1)]
                .into_iter()
                .filter(|_| !point)
                .map(|(stem, k)| (stem, segment.platform[k], ParameterRole::PlatformPoint { leg, axis: Axis::ALL[k] }));
            let base = [("xB", 0), ("yB", 1)]
                .into_iter()
                .map(|(stem, k)| (stem, segment.base[k], ParameterRole::BasePoint { leg, axis: Axis::ALL[k] }));
            for (stem, value, role) in platform.chain(base) {
                let name = format!("{stem}{}", leg + 1);
                outline = outline.parameter(name, Dimension::Length, value, sigma(|t| t.anchor), role);
            }
        }
        let mut closure = Self {
            home,
            heights: segments.iter().map(|s| [s.platform.z, s.base.z]).collect(),
            weights: Vec::new(),
            cables: Vec::new(),
            point,
            size: segments.iter().map(|s| s.base.xy().norm()).fold(0.0, f64::max).max(1e-3),
        };
        for (leg, cable) in cables.iter().enumerate() {
            closure.cables.push((outline.parameters.len(), cable.drum.is_some()));
            closure.weights.push(weights(leg, cable, segments.len())?);
            let role = ParameterRole::JointOffset { leg };
            let name = format!("o{}", leg + 1);
            outline = outline.parameter(name, Dimension::Length, cable.offset, sigma(|t| t.length), role);
            if cable.build_up.is_some() {
                let problem = format!("cable {}: drums that grow are those of cables in space", leg + 1);
                return Err(GeometryError::Outline(problem));
            }
            let (dimension, near) = match cable.drum {
                Some(radius) => {
                    positive(leg, "drum", radius)?;
                    let (name, role) = (format!("d{}", leg + 1), ParameterRole::JointScale { leg });
                    outline = outline.parameter(name, Dimension::Length, radius, sigma(|t| t.length), role);
                    (Dimension::Angle, -cable.offset / radius)
                }
                None => (Dimension::Length, -cable.offset),
            };
            outline = outline.joint(format!("leg{}", leg + 1), dimension, near, cable.stroke);
        }
        ClosureMechanism::new(closure, outline)
    }

    fn per_segment(&self) -> usize {
        if self.point { 2 } else { 4 }
    }

    /// Platform point and anchor of a segment.
    fn ends<T: Real>(&self, s: &State<'_, T>, segment: usize) -> (Vector3<T>, Vector3<T>) {
        let first = self.per_segment() * segment;
        let [a, b] = self.heights[segment].map(T::from);
        let c = &s.parameters[first..];
        if self.point {
            (Vector3::from_element(T::from(0.0)), Vector3::new(c[0], c[1], b))
        } else {
            (Vector3::new(c[0], c[1], a), Vector3::new(c[2], c[3], b))
        }
    }
}

/// How often a cable runs along each segment.
pub(super) fn weights(leg: usize, cable: &Cable, segments: usize) -> Result<Vec<f64>, GeometryError> {
    let mut weights = vec![0.0; segments];
    for k in &cable.segments {
        let Some(weight) = weights.get_mut(*k) else {
            let (cable, segment) = (leg + 1, k + 1);
            return Err(GeometryError::Outline(format!(
                "cable {cable} runs along segment {segment}, but there are {segments}"
            )));
        };
        *weight += 1.0;
    }
    if cable.segments.is_empty() {
        return Err(GeometryError::Outline(format!("cable {} has no segment", leg + 1)));
    }
    Ok(weights)
}

impl Closure for PlanarCables {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        let at_home = State {
            position: self.home.position.map(T::from),
            rotation: self.home.rotation.matrix().map(T::from),
            ..*s
        };
        let change = |segment: usize| {
            let (a, b) = self.ends(s, segment);
            length(&(s.place(&a) - b)) - length(&(at_home.place(&a) - b))
        };
        let changes: Vec<T> = (0..self.heights.len()).map(change).collect();
        for (cable, (first, drum)) in self.cables.iter().enumerate() {
            let paid_out = s.joints[cable] * if *drum { s.parameters[first + 1] } else { T::from(1.0) };
            out[cable] = -paid_out - s.parameters[*first];
            for (weight, change) in self.weights[cable].iter().zip(&changes) {
                out[cable] += *change * *weight;
            }
        }
        let structural = &mut out[self.cables.len()..];
        structural[0] = s.position.z - self.home.position.z;
        structural[1] = s.rotation[(0, 2)] * self.size;
        structural[2] = s.rotation[(1, 2)] * self.size;
        if self.point {
            structural[3] = s.rotation[(1, 0)] * self.size;
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        let Some((first, _)) = self.cables.get(row) else { return false };
        match on {
            Column::Joint(k) => k == row,
            Column::Parameter(k) => match self.weights[row].get(k / self.per_segment()) {
                Some(weight) => *weight != 0.0,
                None => k == *first || k == first + 1,
            },
        }
    }
}
