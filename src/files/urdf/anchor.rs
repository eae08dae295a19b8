//! One end of a leg: what its joints leave of the place of its anchor.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use super::closures::{Frame, Motion};
use crate::files::finding::FindingKind as K;
use crate::solve::symmetric_eigen;

/// One end of a leg: the constraints that its joints put on the anchor, in the frame of the leg.
#[derive(Default)]
pub(super) struct End {
    /// A point, or a point and a direction.
    pub(super) lines: Vec<(Vector3<f64>, Vector3<f64>)>,
    pub(super) points: Vec<Vector3<f64>>,
    pub(super) undecided: Vec<Vector3<f64>>,
    pub(super) turns: usize,
    /// From the frame of the leg into the body of base or platform.
    pub(super) carry: Frame,
    /// The last link of the leg, and its pose in the frame of the leg.
    pub(super) last: (usize, Frame),
}

impl End {
    /// Takes note of a joint whose frame stands at `here`.
    pub(super) fn add(&mut self, motion: Motion, here: &Frame) -> Result<(), &'static str> {
        let point = here.translation.vector;
        match motion {
            Motion::Hinge(axis) => {
                self.lines.push((point, here.rotation * axis));
                self.turns += 1;
            }
            Motion::Point(turns) => {
                self.points.push(point);
                self.turns += turns;
            }
            Motion::Undecided => self.undecided.push(point),
            Motion::Fixed => {}
            Motion::Slide(_) | Motion::Planar | Motion::Floating => {
                return Err("cannot be in a leg in addition to the slide; use revolute or spherical joints");
            }
        }
        Ok(())
    }
}

/// Decides what closing frames leave free: as much as makes six or seven freedoms of the leg, its slide included.
pub(super) fn decide(ends: &mut [End; 2]) -> Result<(), String> {
    let count = ends[0].undecided.len() + ends[1].undecided.len();
    let turns = ends[0].turns + ends[1].turns;
    let fits = |turns: usize| (5..=6).contains(&turns);
    if count > 0 && fits(turns + 3 * count) {
        for end in ends.iter_mut() {
            end.turns += 3 * end.undecided.len();
            end.points.append(&mut end.undecided);
        }
        return Ok(());
    }
    if fits(turns) || (count == 0 && turns == 7) {
        return Ok(());
    }
    Err(match count {
        0 => format!(
            "has {turns} rotational freedoms besides its slide and needs 5 or 6 to leave the platform free; add the \
             joint that is missing, or correct the type of a closure"
        ),
        _ => format!(
            "has {turns} rotational freedoms and a closure of unknown kind, which fits neither a ball (2 or 3) nor a \
             fixed flange (5 or 6); state the kind of the closure"
        ),
    })
}

/// The point nearest to the axes of an end, or the closing point if there is one.
pub(super) fn common_point(end: &End, what: &str, joint: &str) -> Result<Vector3<f64>, (K, String)> {
    if !end.points.is_empty() {
        return Ok(end.points.iter().sum::<Vector3<f64>>() / end.points.len() as f64);
    }
    if end.lines.is_empty() {
        let text = format!(
            "the leg of joint '{joint}' has no rotational joint at its {what} end, as in a hexaglide (6-PUS); a leg \
             of this kind has joints at both ends"
        );
        return Err((K::SlideOnBase, text));
    }
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    // Relative to the first point, so that anchors far from the origin keep their digits.
    let origin = end.lines[0].0;
    for (point, direction) in &end.lines {
        let across = Matrix3::identity() - direction * direction.transpose();
        normal += across;
        right += across * (point - origin);
    }
    let weakest = symmetric_eigen(normal).eigenvalues.min() / end.lines.len() as f64;
    let solution = normal.lu().solve(&right).filter(|_| weakest > 1e-4);
    solution.map(|p| origin + p).ok_or_else(|| {
        let text = format!(
            "the {what} end of the leg of joint '{joint}' rotates about one direction only, so its anchor is not \
             determined (an RPS leg?); a leg of this kind has two or three axes there"
        );
        (K::AnchorUndetermined, text)
    })
}

/// Directions of the axes of an end in the frame of the leg, after some turn of each joint. The joints come in order
/// from the body to the slide.
fn directions(end: &End, turn: f64) -> Vec<Vector3<f64>> {
    let mut turned = Rotation3::identity();
    let mut found = Vec::with_capacity(end.lines.len());
    for (k, (_, axis)) in end.lines.iter().rev().enumerate() {
        let now = turned * axis;
        found.push(now);
        let angle = turn * (1.0 + 0.37 * (k % 5) as f64);
        turned = Rotation3::from_axis_angle(&Unit::new_normalize(now), angle) * turned;
    }
    found
}

/// Number of independent directions that `part` makes of the axes of an end, in the best of some of its postures: in
/// a single one, axes may be parallel by chance.
fn rank(end: &End, part: impl Fn(Vec<Vector3<f64>>) -> Vec<Vector3<f64>>) -> usize {
    let one = |turn: f64| {
        let products: Matrix3<f64> = part(directions(end, turn)).iter().map(|d| d * d.transpose()).sum();
        symmetric_eigen(products).eigenvalues.iter().filter(|v| **v > 1e-4).count()
    };
    [0.0, 0.5, 1.1, 1.9].map(one).into_iter().fold(0, usize::max)
}

/// Requires that a leg can tilt at both ends and leaves the platform all turns, whatever the number of its joints.
/// `rod` is the direction of the leg.
pub(super) fn check_turns(ends: &[End; 2], rod: &Vector3<f64>, joint: &str) -> Result<(), (K, String)> {
    let across = |turns: Vec<Vector3<f64>>| turns.iter().map(|d| d - rod * d.dot(rod)).collect();
    for (k, end) in ends.iter().enumerate() {
        if end.points.is_empty() && rank(end, across) < 2 {
            let text = format!(
                "the {} end of the leg of joint '{joint}' tilts in one plane only, and rotates about the leg itself; \
                 give it two axes across the leg, or a ball",
                ["base", "platform"][k]
            );
            return Err((K::AnchorUndetermined, text));
        }
    }
    if ends.iter().any(|e| !e.points.is_empty()) {
        return Ok(());
    }
    // The place of the anchor held, an end turns about the leg only if it has three directions.
    let about_itself = rank(&ends[0], |turns| turns) == 3;
    let with_leg = |turns: Vec<Vector3<f64>>| turns.into_iter().chain(about_itself.then_some(*rod)).collect();
    if rank(&ends[1], with_leg) < 3 {
        let text = format!(
            "the leg of joint '{joint}' leaves the platform two rotations instead of three, since axes of its ends \
             are parallel; correct the axes, or the axis of the closure"
        );
        return Err((K::LegMobility, text));
    }
    Ok(())
}

/// How far the joints of an end are from a point.
pub(super) fn largest_miss(end: &End, anchor: &Vector3<f64>) -> f64 {
    let lines = end.lines.iter().map(|(p, d)| (anchor - p).cross(d).norm());
    lines.chain(end.points.iter().map(|p| (anchor - p).norm())).fold(0.0, f64::max)
}
