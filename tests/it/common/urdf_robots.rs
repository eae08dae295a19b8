//! One asymmetric mechanism of six legs, written as URDF in many ways; independent of the library's writer.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

pub type Frame = Isometry3<f64>;

/// How the loops of a robot are closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Closing frames on the tip and on the platform.
    Frames,
    /// Two revolutes at the tip, and closing frames with twins along z for the third.
    HingeFrames,
    /// Three revolutes at the tip, and closing frames for a fixed flange.
    FlangeFrames,
    LoopJoint,
    Drake,
    /// Two revolutes at the tip and a revolute closure, since URDF+ has no ball.
    UrdfPlus,
    Constraint,
    Gazebo,
    /// A ball joint from each tip into the platform.
    Parents,
    /// Nothing in the file: pairs are stated elsewhere.
    Pairs,
    /// A way of its own for each leg, and some stated twice.
    Mixed,
    /// The platform hangs on the first leg, the others end in closing frames.
    Hung,
    /// The legs hang from the platform, and their feet are closed with the base.
    FromPlatform,
}

pub const STYLES: [Style; 13] = [
    Style::Frames,
    Style::HingeFrames,
    Style::FlangeFrames,
    Style::LoopJoint,
    Style::Drake,
    Style::UrdfPlus,
    Style::Constraint,
    Style::Gazebo,
    Style::Parents,
    Style::Pairs,
    Style::Mixed,
    Style::Hung,
    Style::FromPlatform,
];

/// The numbers that a reader has to find.
#[derive(Clone, Debug)]
pub struct Expected {
    pub a: [Vector3<f64>; 6],
    pub b: [Vector3<f64>; 6],
    pub length: [f64; 6],
    pub range: [[f64; 2]; 6],
    pub joint: [String; 6],
    pub reversed: [bool; 6],
    pub home: Frame,
}

pub fn frame(xyz: [f64; 3], rpy: [f64; 3]) -> Frame {
    Frame::from_parts(Translation3::from(Vector3::from(xyz)), UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]))
}

/// The mechanism: metres, nothing symmetric, two slides that count the other way.
pub fn expected() -> Expected {
    let a = [
        [0.31, 0.04, -0.02],
        [0.13, 0.27, -0.015],
        [-0.2, 0.24, -0.03],
        [-0.3, -0.06, -0.025],
        [-0.12, -0.28, -0.01],
        [0.19, -0.23, -0.035],
    ]
    .map(Vector3::from);
    let b = [
        [0.48, 0.27, 0.03],
        [0.40, 0.38, 0.01],
        [-0.47, 0.29, 0.02],
        [-0.54, 0.13, 0.04],
        [0.02, -0.55, 0.0],
        [0.15, -0.52, 0.05],
    ]
    .map(Vector3::from);
    let home = frame([0.02, 0.015, 0.71], [0.04, 0.06, -0.11]);
    let length = std::array::from_fn(|k| (place(&home, &a[k]) - b[k]).norm());
    let reversed = [false, true, false, false, true, false];
    let range = std::array::from_fn(|k| [length[k] - 0.08 - 0.001 * k as f64, length[k] + 0.11]);
    let joint = ["a", "b", "c", "d", "e", "f"].map(|n| format!("drive_{n}"));
    Expected { a, b, length, range, joint, reversed, home }
}

pub fn place(frame: &Frame, p: &Vector3<f64>) -> Vector3<f64> {
    frame.rotation * p + frame.translation.vector
}

/// `xyz` and `rpy` of a frame; rounded to a number of decimals, if any.
pub fn pose(f: &Frame, decimals: Option<usize>) -> String {
    let t = f.translation.vector;
    let (r, p, y) = f.rotation.euler_angles();
    let list = |v: [f64; 3]| match decimals {
        None => v.map(|x| format!("{x:?}")).join(" "),
        Some(n) => v.map(|x| format!("{x:.n$}")).join(" "),
    };
    format!("xyz=\"{}\" rpy=\"{}\"", list([t.x, t.y, t.z]), list([r, p, y]))
}

/// A robot in pieces, so that tests can drop or change them.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    pub links: Vec<String>,
    pub joints: Vec<String>,
    pub tags: Vec<String>,
    pub decimals: Option<usize>,
}

impl Robot {
    pub fn text(&self) -> String {
        let line = |l: &String| format!("  {l}\n");
        let body: String = self.links.iter().chain(&self.joints).chain(&self.tags).map(line).collect();
        format!("<?xml version=\"1.0\"?>\n<robot name=\"asymmetric\">\n{body}</robot>\n")
    }

    fn link(&mut self, name: &str) {
        self.links.push(format!("<link name=\"{name}\"/>"));
    }

    pub fn joint(&mut self, name: &str, kind: &str, [parent, child]: [&str; 2], at: &Frame, more: &str) {
        let at = pose(at, self.decimals);
        self.joints.push(format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin {at}/>{more}</joint>"
        ));
    }

    /// A new link on a joint.
    fn grow(&mut self, name: &str, kind: &str, parent: &str, child: &str, at: &Frame, more: &str) {
        self.link(child);
        self.joint(name, kind, [parent, child], at, more);
    }
}

const TURN_X: &str = "<axis xyz=\"1 0 0\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";
const TURN_Y: &str = "<axis xyz=\"0 2 0\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";
const TURN_Z: &str = "<axis xyz=\"0 0 1\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";

/// The frame in `b` whose z axis points to the platform's anchor at home.
fn leg_frame(e: &Expected, k: usize) -> Frame {
    let u = (place(&e.home, &e.a[k]) - e.b[k]).normalize();
    let turn = Rotation3::face_towards(&u, &Vector3::new(0.3, 1.0, 0.1 * k as f64));
    Frame::from_parts(e.b[k].into(), UnitQuaternion::from_rotation_matrix(&turn))
}

/// The limits of a slide.
fn slide(e: &Expected, k: usize, axis: f64) -> String {
    let [from, to] = e.range[k].map(|v| v - e.length[k]);
    let [lower, upper] = if e.reversed[k] { [-to, -from] } else { [from, to] };
    format!("<axis xyz=\"0 0 {axis:?}\"/><limit lower=\"{lower:?}\" upper=\"{upper:?}\" effort=\"5\" velocity=\"1\"/>")
}

/// The robot in one of the styles.
pub fn robot(style: Style) -> Robot {
    robot_with(style, &expected(), None)
}

pub fn robot_with(style: Style, e: &Expected, decimals: Option<usize>) -> Robot {
    let mut r = Robot { decimals, ..Robot::default() };
    r.link("floor");
    r.grow("ground", "fixed", "floor", "base", &frame([0.3, -0.2, 0.1], [0.0, 0.1, 0.7]), "");
    r.link("platform");
    if style != Style::Hung {
        r.joint("free", "floating", ["base", "platform"], &e.home, "");
    }
    for k in 0..6 {
        if style == Style::FromPlatform {
            hanging_leg(&mut r, e, k);
        } else {
            standing_leg(&mut r, style, e, k);
        }
    }
    r
}

fn standing_leg(r: &mut Robot, style: Style, e: &Expected, k: usize) {
    let s = ["A", "B", "C", "D", "E", "F"][k];
    let part = |name: &str| format!("strut_{s}_{name}");
    let (foot, cross, tube, rod) = (part("foot"), part("cross"), part("tube"), part("rod"));
    let bracket = frame([0.4 * e.b[k].x, 0.5 * e.b[k].y, 0.02], [0.1, -0.2, 0.3 * k as f64]);
    r.grow(&part("bracket"), "fixed", "base", &foot, &bracket, "");
    let at = bracket.inverse() * leg_frame(e, k);
    if k == 2 {
        // A ball where the others have two hinges; the leg may then turn about itself.
        r.grow(&part("ball"), "spherical", &foot, &tube, &at, "");
    } else {
        r.grow(&part("u1"), "revolute", &foot, &cross, &at, TURN_X);
        r.grow(&part("u2"), "continuous", &cross, &tube, &Frame::identity(), "<axis xyz=\"0 2 0\"/>");
    }
    let up = frame([0.0, 0.0, 0.2], [0.0, 0.0, 0.5]);
    let axis = if e.reversed[k] { -1.0 } else { 0.5 };
    r.grow(&e.joint[k], "prismatic", &tube, &rod, &up, &slide(e, k, axis));
    let tip = frame([0.0, 0.0, e.length[k] - 0.2], [0.2, -0.1, 0.4]);
    // The pose of the tip in the platform at home, where the leg is straight.
    let tip_at_home = e.home.inverse() * leg_frame(e, k) * up * tip;
    let mut anchor = tip_at_home;
    anchor.translation = e.a[k].into();
    close(r, style, e, k, &rod, &tip, &anchor);
}

/// Joins the rod with the platform.
fn close(r: &mut Robot, style: Style, e: &Expected, k: usize, rod: &str, tip: &Frame, anchor: &Frame) {
    let s = ["A", "B", "C", "D", "E", "F"][k];
    let part = |name: &str| format!("strut_{s}_{name}");
    let ball_anchor = Frame::from_parts(e.a[k].into(), UnitQuaternion::from_euler_angles(0.3, k as f64, 0.1));
    let frames = |r: &mut Robot, parent: &str, tip: &Frame, anchor: &Frame| {
        for (end, parent, at) in [(1, parent, tip), (2, "platform", anchor)] {
            let link = format!("closing_{s}_{end}");
            r.grow(&format!("{link}_frame"), "fixed", parent, &link, at, "");
        }
    };
    let hinges = |r: &mut Robot, count: usize| {
        let mut parent = rod.to_owned();
        for (n, axis) in [TURN_X, TURN_Y, TURN_Z].iter().enumerate().take(count) {
            let child = part(&format!("s{n}"));
            let at = if n == 0 { *tip } else { Frame::identity() };
            r.grow(&part(&format!("t{n}")), "revolute", &parent, &child, &at, axis);
            parent = child;
        }
        parent
    };
    let point = |f: &Frame| {
        let t = f.translation.vector;
        format!("{:?} {:?} {:?}", t.x, t.y, t.z)
    };
    match style {
        Style::Frames => frames(r, rod, tip, &ball_anchor),
        Style::HingeFrames => {
            let last = hinges(r, 2);
            frames(r, &last, &Frame::identity(), anchor);
            for end in [1, 2] {
                let (link, twin) = (format!("closing_{s}_{end}"), format!("closing_{s}_{end}_z"));
                r.grow(&format!("{twin}_frame"), "fixed", &link, &twin, &frame([0.0, 0.0, 0.1], [0.0; 3]), "");
            }
        }
        Style::FlangeFrames => {
            let last = hinges(r, if k == 2 { 2 } else { 3 });
            frames(r, &last, &Frame::identity(), anchor);
        }
        Style::LoopJoint => r.tags.push(format!(
            "<loop_joint name=\"close_{s}\" type=\"spherical\"><link1 link=\"{rod}\" {}/><link2 link=\"platform\" {}/>\
             </loop_joint>",
            pose(tip, r.decimals),
            pose(&ball_anchor, r.decimals)
        )),
        Style::Drake => r.tags.push(format!(
            "<drake:ball_constraint><drake:ball_constraint_body_A name=\"platform\"/>\
             <drake:ball_constraint_body_B name=\"{rod}\"/><drake:ball_constraint_p_AP value=\"{}\"/>\
             <drake:ball_constraint_p_BQ value=\"{}\"/></drake:ball_constraint>",
            point(&ball_anchor),
            point(tip)
        )),
        Style::UrdfPlus => {
            let last = hinges(r, 2);
            r.tags.push(format!(
                "<loop name=\"close_{s}\" type=\"revolute\"><predecessor link=\"{last}\"><origin xyz=\"0 0 0\"/>\
                 </predecessor><successor link=\"platform\"><origin {}/></successor><axis xyz=\"0 0 1\"/></loop>",
                pose(anchor, r.decimals)
            ));
        }
        Style::Constraint => r.tags.push(format!(
            "<constraint name=\"close_{s}\" type=\"ball\"><parent link=\"platform\"/><parent_origin {}/>\
             <child link=\"{rod}\"/><child_origin {}/></constraint>",
            pose(&ball_anchor, r.decimals),
            pose(tip, r.decimals)
        )),
        Style::Gazebo => r.tags.push(format!(
            "<gazebo><joint name=\"close_{s}\" type=\"ball\"><parent>platform</parent><child>{rod}</child>\
             <pose>{} 0 0 0</pose></joint></gazebo>",
            point(tip)
        )),
        Style::Parents => {
            let kind = if k < 3 { "ball" } else { "spherical" };
            // The origin of the child is its own: a link at the anchor stands for the platform's joint.
            let link = part("socket");
            r.grow(&part("socket_frame"), "fixed", "platform", &link, &ball_anchor, "");
            r.joint(&part("second"), kind, [rod, &link], tip, "");
        }
        Style::Pairs => {
            for (link, parent, at) in [(part("tip"), rod, tip), (part("seat"), "platform", &ball_anchor)] {
                r.grow(&format!("{link}_mount"), "fixed", parent, &link, at, "");
            }
        }
        Style::Mixed => {
            let one =
                [Style::Frames, Style::LoopJoint, Style::Drake, Style::Parents, Style::Pairs, Style::Constraint][k];
            close(r, one, e, k, rod, tip, anchor);
            if k < 2 {
                // The same again in another way.
                close(r, Style::Drake, e, k, rod, tip, anchor);
            }
        }
        Style::Hung if k == 0 => {
            let last = hinges(r, 3);
            r.joint(&part("flange"), "fixed", [&last, "platform"], &anchor.inverse(), "");
        }
        Style::Hung => frames(r, rod, tip, &ball_anchor),
        Style::FromPlatform => unreachable!("its legs hang"),
    }
}

/// A leg from the platform down to the base, with its foot closed by frames.
fn hanging_leg(r: &mut Robot, e: &Expected, k: usize) {
    let s = ["A", "B", "C", "D", "E", "F"][k];
    let part = |name: &str| format!("strut_{s}_{name}");
    let (cross, rod, tube) = (part("cross"), part("rod"), part("tube"));
    let mut top = leg_frame(e, k);
    top.translation = place(&e.home, &e.a[k]).into();
    r.grow(&part("u1"), "revolute", "platform", &cross, &(e.home.inverse() * top), TURN_X);
    r.grow(&part("u2"), "revolute", &cross, &rod, &Frame::identity(), TURN_Y);
    // The child is now the side of the base: moved along +z it comes nearer to the platform.
    let axis = if e.reversed[k] { 1.0 } else { -1.0 };
    let half = -0.5 * e.length[k];
    r.grow(&e.joint[k], "prismatic", &rod, &tube, &frame([0.0, 0.0, half], [0.0; 3]), &slide(e, k, axis));
    for (end, parent, at) in [
        (1, tube.as_str(), frame([0.0, 0.0, half], [0.1, 0.2, 0.3])),
        (2, "base", { frame([e.b[k].x, e.b[k].y, e.b[k].z], [0.3, 0.0, 0.1]) }),
    ] {
        let link = format!("closing_{s}_{end}");
        r.grow(&format!("{link}_frame"), "fixed", parent, &link, &at, "");
    }
}

/// Names of the frames to pair for [`Style::Pairs`].
pub fn pairs() -> Vec<[String; 2]> {
    let pair = |s: &&str| [format!("strut_{s}_tip"), format!("strut_{s}_seat")];
    ["A", "B", "C", "D", "E", "F"].iter().map(pair).collect()
}

/// As a CAD plugin exports it: numbers with six decimals, shapes that `urdf-rs` refuses, and files that do not exist.
pub fn cad_export() -> String {
    let robot = robot_with(Style::Frames, &expected(), Some(6));
    let shape = "<inertial><mass value=\"0.2\"/><inertia ixx=\"1e-3\" iyy=\"1e-3\" izz=\"1e-3\"/></inertial>\
                 <visual><geometry><mesh filename=\"package://nowhere/meshes/part.stl\" scale=\"0.001 0.001 0.001\"/>\
                 </geometry><material name=\"silver\"/><material/></visual><collision><geometry/></collision>";
    let text = robot.text().replace("_rod\"/>\n", &format!("_rod\">{shape}</link>\n"));
    text.replace(" velocity=\"1\"", "").replace("<?xml version=\"1.0\"?>", "<?xml version=\"1.0\" encoding=\"utf-8\"?>")
}
