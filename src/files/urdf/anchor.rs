//! One end of a leg: what its joints leave of the place of its anchor.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::closures::{Frame, Motion};
use super::finding::FindingKind as K;

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
                return Err("has no place in a leg beside the slide; use revolute or spherical joints");
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
            "has {turns} turning freedoms beside its slide and needs 5 or 6 to leave the platform free; add the joint that \
             is missing, or correct the type of a closure"
        ),
        _ => format!(
            "has {turns} turning freedoms and a closure of unknown kind, which fits neither a ball (2 or 3) nor a fixed \
             flange (5 or 6); state the kind of the closure"
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
            "the leg of joint '{joint}' has no turning joint at its {what} end, as in a hexaglide (6-PUS); a leg of this \
             kind has joints at both ends"
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
    let weakest = SymmetricEigen::new(normal).eigenvalues.min() / end.lines.len() as f64;
    let solution = normal.lu().solve(&right).filter(|_| weakest > 1e-4);
    solution.map(|p| origin + p).ok_or_else(|| {
        let text = format!(
            "the {what} end of the leg of joint '{joint}' turns about one direction only, so its anchor is not determined \
             (an RPS leg?); a leg of this kind has two or three axes there"
        );
        (K::AnchorUndetermined, text)
    })
}

/// How far the joints of an end are from a point.
pub(super) fn largest_miss(end: &End, anchor: &Vector3<f64>) -> f64 {
    let lines = end.lines.iter().map(|(p, d)| (anchor - p).cross(d).norm());
    lines.chain(end.points.iter().map(|p| (anchor - p).norm())).fold(0.0, f64::max)
}
