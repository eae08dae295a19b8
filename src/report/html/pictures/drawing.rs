//! The mechanism in perspective.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{ModelResiduals, Standing, round_up};
use crate::measurement::DataRow;
use crate::mechanism::{Mechanism, characteristic_length};
use crate::pose::Pose;
use crate::report::chart::{Arrow, LineSegment, Scene, Silhouette, Triad};
use crate::report::html::typeset::in_print;
use crate::units::{show_length, three_digits};

/// Longest arrow and widest spread of the poses, in radii of the platform.
const ARROW: f64 = 0.5;
const SPREAD: f64 = 0.35;
/// Largest tilt of a drawn pose, rad, where tilts are drawn larger than they are.
const TILT: f64 = 0.8;
/// Frames nearer than this, in radii of the platform, are one.
const NEAR: f64 = 0.05;
/// Part of a direction that must lie level for its arrow to do so.
const LEVEL: f64 = 0.3;
/// Length of the axes of a frame, in radii of the platform.
const AXES: f64 = 0.35;

/// Errors at poses, to be drawn as arrows.
pub(in crate::report::html) struct Displacements {
    /// The model that misses.
    name: String,
    /// Pose, and motion of the centre of the platform from where the model says to where it was measured, m.
    errors: Vec<(Pose, Vector3<f64>)>,
}

impl Displacements {
    /// The errors of a model, without those of gross rows, beside which no other could be seen.
    pub(in crate::report::html) fn of(seen: &ModelResiduals, standing: &Standing, gross: &[DataRow]) -> Self {
        let centre = standing.centre();
        let error = |pose: &Pose, motion: &nalgebra::Vector6<f64>| {
            let turn = Vector3::new(motion[3], motion[4], motion[5]);
            Vector3::new(motion[0], motion[1], motion[2]) + turn.cross(&(pose.place(&centre) - pose.position))
        };
        let usual = seen.deviations.iter().filter(|d| !gross.contains(&d.row));
        let errors = usual.map(|d| (d.pose, error(&d.pose, &d.motion))).collect();
        Self { name: seen.name.clone(), errors }
    }
}

/// The mechanism at home in its base frame, the platform at `poses`, errors as arrows, and where the instrument is;
/// `marked` legs stand out. `None` if nothing is known of where the legs stand.
pub(in crate::report::html) fn drawing(
    mechanism: &dyn Mechanism,
    standing: &Standing,
    poses: &[Pose],
    errors: Option<&Displacements>,
    marked: &[usize],
) -> Option<Scene> {
    let Standing { base, platform, home, .. } = standing;
    if platform.len() < 3 || base.len() < 2 {
        return None;
    }
    let size = characteristic_length(mechanism);
    let corners: Vec<Vector3<f64>> = platform.iter().map(|(_, p)| *p).collect();
    let mut notes = Vec::new();
    let spread = poses.iter().map(|p| (p.position - home.position).norm()).fold(0.0, f64::max);
    let tilt = poses.iter().map(|p| home.motion_to(p).rows(3, 3).norm()).fold(0.0, f64::max);
    let of_poses = match spread {
        s if s > 0.0 && s < 0.1 * size => {
            round_up(0.2 * SPREAD * size / s).min(round_up(0.2 * TILT / tilt.max(1e-9))).max(1.0)
        }
        _ => 1.0,
    };
    if of_poses > 1.0 {
        notes.push(format!(
            "Displacements and tilts of the poses from home are magnified {} times.",
            three_digits(of_poses)
        ));
    }
    let drawn = |pose: &Pose| {
        let motion = home.motion_to(pose);
        home.moved(&(motion * of_poses))
    };
    let mut scene = Scene {
        title: match errors {
            Some(errors) => format!("Errors in perspective, {}", errors.name),
            None => format!("{} at home", mechanism.name()),
        },
        description:
            "The legs between base and platform in perspective, with the frames of both, the platform at the poses \
                      and errors as arrows where there are any."
                .into(),
        unit: if size < 0.5 { ("mm", 1e-3) } else { ("m", 1.0) },
        outlines: vec![
            outline("base", 6, &ring(&base.iter().map(|(_, p)| *p).collect::<Vec<_>>()), false),
            outline("platform at home", 0, &placed(home, &corners), false),
        ],
        ..Scene::default()
    };
    scene.outlines[1].filled = true;
    for pose in poses {
        scene.outlines.push(outline("platform at the poses", 2, &placed(&drawn(pose), &corners), true));
    }
    scene.legs = legs(base, platform, home, marked);
    let axes = |pose: &Pose| [0, 1, 2].map(|k| pose.rotation.matrix().column(k).into_owned().into());
    let triad = |label: &str, pose: &Pose| Triad {
        label: label.into(),
        origin: pose.position.into(),
        axes: axes(pose),
        length: AXES * size,
    };
    scene.frames = vec![triad("base", &Pose::identity()), triad("platform", home)];
    if let Some(errors) = errors {
        notes.extend(add_arrows(&mut scene, errors, size, &standing.centre(), drawn));
    }
    notes.push("Drawn in the base frame.".into());
    notes.extend(add_instrument(&mut scene, standing, size));
    scene.note = in_print(&notes.join(" "));
    Some(scene)
}

/// The legs at home; `marked` ones stand out.
fn legs(
    base: &[(usize, Vector3<f64>)],
    platform: &[(usize, Vector3<f64>)],
    home: &Pose,
    marked: &[usize],
) -> Vec<LineSegment> {
    let leg = |(leg, from): &(usize, Vector3<f64>)| {
        let (_, to) = platform.iter().find(|(l, _)| l == leg)?;
        let stands_out = marked.contains(leg);
        Some(LineSegment {
            name: if stands_out { "leg named by a cause".into() } else { "leg".into() },
            colour: if stands_out { 1 } else { 5 },
            from: (*from).into(),
            to: home.place(to).into(),
            label: (leg + 1).to_string(),
        })
    };
    base.iter().filter_map(leg).collect()
}

/// Adds an arrow for each error, where `drawn` puts the pose, and says how long they are drawn.
fn add_arrows(
    scene: &mut Scene,
    errors: &Displacements,
    size: f64,
    centre: &Vector3<f64>,
    drawn: impl Fn(&Pose) -> Pose,
) -> Option<String> {
    let largest = errors.errors.iter().map(|(_, e)| e.norm()).filter(|e| e.is_finite()).fold(0.0, f64::max);
    if !(largest > 0.0) {
        return None;
    }
    let magnified = round_up(0.4 * ARROW * size / largest);
    for (pose, error) in &errors.errors {
        let from = drawn(pose).place(centre);
        scene.arrows.push(Arrow {
            name: format!("error, {}", errors.name),
            colour: 1,
            from: from.into(),
            to: (from + magnified * error).into(),
            tip: show_length(error.norm()),
            label: String::new(),
        });
    }
    Some(format!(
        "Arrows are {} times as long as the errors at the centre of the platform, the longest of which is {}.",
        three_digits(magnified),
        show_length(largest)
    ))
}

/// Adds the direction to the origin of the instrument's frame, if that is not the origin of the base, and says where it is.
/// It is far outside of the picture, or else the machine could not be seen.
fn add_instrument(scene: &mut Scene, standing: &Standing, size: f64) -> Option<String> {
    let distance = standing.instrument.norm();
    if !(distance > NEAR * size) {
        return None;
    }
    let middle = centre(standing.base.iter().map(|(_, p)| p));
    let reach = standing.base.iter().map(|(_, p)| (p - middle).norm()).fold(0.0, f64::max);
    // The arrow lies level, because a steep one would leave the ground; only what is above or below is seen there.
    let mut way = standing.instrument - middle;
    let height = standing.instrument.z;
    if way.xy().norm() > LEVEL * way.norm() {
        way.z = 0.0;
    }
    // Seen from here the arrow points to the right, a little to the front.
    scene.view.azimuth = way.y.atan2(way.x) - FRAC_PI_2 + 0.35;
    let toward = way / way.norm().max(f64::MIN_POSITIVE);
    let [foot, head] = [1.15, 1.75].map(|part| middle + toward * (part * reach).min(way.norm()));
    scene.arrows.push(Arrow {
        name: "to the tracker".into(),
        colour: 4,
        from: foot.into(),
        to: head.into(),
        tip: format!("origin of the tracker's frame, {} from that of the base", show_length(distance)),
        label: format!("tracker, {} away", show_length(distance)),
    });
    let side = if height < 0.0 { "below" } else { "above" };
    let level = if height.abs() > NEAR * size {
        format!(" and {} {side} it", show_length(height.abs()))
    } else {
        String::new()
    };
    Some(format!(
        "The origin of the tracker's frame is {} from that of the base, in the direction of its arrow{level}.",
        show_length(distance)
    ))
}

fn outline(name: &str, colour: usize, points: &[Vector3<f64>], thin: bool) -> Silhouette {
    Silhouette { name: name.into(), colour, points: points.iter().map(|p| (*p).into()).collect(), filled: false, thin }
}

/// The mean of some points.
pub(super) fn centre<'a>(points: impl ExactSizeIterator<Item = &'a Vector3<f64>>) -> Vector3<f64> {
    let n = points.len().max(1) as f64;
    points.sum::<Vector3<f64>>() / n
}

fn placed(pose: &Pose, corners: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    ring(&corners.iter().map(|a| pose.place(a)).collect::<Vec<_>>())
}

/// Points in order around their centre, seen from above.
fn ring(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let centre = centre(points.iter());
    let mut ordered = points.to_vec();
    let angle = |p: &Vector3<f64>| (p.y - centre.y).atan2(p.x - centre.x);
    ordered.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    ordered
}
