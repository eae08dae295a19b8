//! One mechanism of each closure-defined kind, and the paper's mechanism as a closure.

use paracal::files::Machine;
use paracal::mechanism::closure::{Closure, ClosureMechanism, Column, Outline, Real, State, length};
use paracal::mechanism::kinds::{
    Cable, CrankLeg, HingedLeg, LinearDelta, PlanarCables, Rod, RodsOnCranks, RodsOnRails, RotaryStewart, Segment,
    Tolerances, Tripod,
};
use paracal::mechanism::{Leg, ParameterRole, Workspace};
use paracal::nalgebra::Vector3;
use paracal::pose::{Pose, PoseConvention};
use paracal::units::Dimension;

pub const TOLERANCES: Tolerances = Tolerances { anchor: 1e-4, length: 1e-4, angle: 3e-4 };

fn around(radius: f64, degrees: f64, z: f64) -> Vector3<f64> {
    let angle = degrees.to_radians();
    Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
}

pub fn about(home: &Pose, half: [f64; 6]) -> Workspace {
    let convention = PoseConvention::default();
    Workspace { convention, centre: convention.coordinates(home), half }
}

/// Six cranks on the base, in pairs that face away from each other.
pub fn rotary() -> ClosureMechanism<RodsOnCranks> {
    let home = Pose::from_coordinates(&[0.0, 0.0, 0.22, 0.0, 0.0, 0.0]);
    let legs: Vec<CrankLeg> = (0..6)
        .map(|i| {
            let (pair, side) = ((i / 2) as f64, if i % 2 == 0 { -1.0 } else { 1.0 });
            let (foot, ball) = (120.0 * pair + 20.0 * side, 120.0 * pair + 48.0 * side);
            let radial = around(1.0, 120.0 * pair, 0.0);
            // The crank turns in the vertical plane along the base's edge and points outwards from the pair.
            let zero = Vector3::z().cross(&radial) * side;
            CrankLeg {
                platform: around(0.16, ball, 0.0),
                base: around(0.20, foot, 0.01 * pair),
                rod: 0.23,
                crank: 0.07,
                axis: radial * -side,
                zero,
                offset: 0.0,
                stroke: Some([-1.2, 1.2]),
            }
        })
        .collect();
    RotaryStewart::new("rotary Stewart", &legs, home, Some(TOLERANCES)).unwrap()
}

/// Three vertical rails with two rods each.
pub fn delta() -> ClosureMechanism<RodsOnRails> {
    let home = Pose::from_coordinates(&[0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
    let rods: Vec<Rod> = (0..6)
        .map(|i| {
            let (tower, side) = (120.0 * (i / 2) as f64 + 90.0, if i % 2 == 0 { -1.0 } else { 1.0 });
            let across = around(0.025 * side, tower + 90.0, 0.0);
            Rod {
                platform: around(0.03, tower, 0.02) + across,
                base: around(0.2, tower, 0.0) + across,
                length: 0.34,
                carriage: i / 2,
                rail: Vector3::z(),
                stroke: Some([0.0, 0.8]),
            }
        })
        .collect();
    LinearDelta::new("linear delta", &rods, home, Some(TOLERANCES)).unwrap()
}

/// Three legs on hinges.
pub fn tripod() -> ClosureMechanism<Tripod> {
    let home = Pose::from_coordinates(&[0.0, 0.0, 0.6, 0.0, 0.0, 0.0]);
    let legs: Vec<HingedLeg> = (0..3)
        .map(|i| {
            let angle = 120.0 * f64::from(i) + 10.0;
            HingedLeg {
                platform: around(0.3, angle, 0.0),
                base: around(0.45, angle, 0.0),
                axis: around(1.0, angle + 90.0, 0.0),
                tilt: [0.0; 2],
                offset: 0.0,
                stroke: Some([0.4, 0.9]),
            }
        })
        .collect();
    Tripod::new("tripod", &legs, home, Some(TOLERANCES)).unwrap()
}

/// A plate between four anchors; the fourth cable runs along its segment twice.
pub fn cables() -> ClosureMechanism<PlanarCables> {
    let home = Pose::from_coordinates(&[0.05, -0.02, 0.0, 0.0, 0.0, 0.0]);
    let at = |x: f64, y: f64| Vector3::new(x, y, 0.0);
    let segments: Vec<Segment> = [
        (at(-0.1, 0.06), at(-0.8, 0.7)),
        (at(0.1, 0.06), at(0.8, 0.75)),
        (at(0.1, -0.06), at(0.85, -0.7)),
        (at(-0.1, -0.06), at(-0.8, -0.65)),
    ]
    .map(|(platform, base)| Segment { platform, base })
    .into();
    let cable =
        |segments: &[usize], drum| Cable { segments: segments.into(), drum, build_up: None, offset: 0.0, stroke: None };
    let cables =
        [cable(&[0], Some(0.03)), cable(&[1], Some(0.03)), cable(&[2], Some(0.03)), cable(&[3, 3], Some(0.04))];
    PlanarCables::new("planar cable robot", &segments, &cables, home, Some(TOLERANCES)).unwrap()
}

/// The paper's mechanism as one function.
#[derive(Clone, Debug)]
pub struct Hardpoint {
    pub lengths: Vec<f64>,
}

impl Closure for Hardpoint {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (leg, row) in out.iter_mut().enumerate() {
            let l = s.place(&s.point(7 * leg)) - s.point(7 * leg + 4);
            *row = length(&l) - s.joints[leg] - s.parameters[7 * leg + 3] + self.lengths[leg];
        }
    }

    fn depends(&self, row: usize, on: Column) -> bool {
        match on {
            Column::Parameter(k) => k / 7 == row,
            Column::Joint(k) => k == row,
        }
    }
}

pub fn hardpoint(legs: &[Leg], home: Pose) -> ClosureMechanism<Hardpoint> {
    let mut outline = Outline::new("six hardpoints as a closure", 6, home);
    for (leg, l) in legs.iter().enumerate() {
        let role = ParameterRole::JointOffset { leg };
        outline = outline
            .platform_point(leg, l.platform.into(), None)
            .parameter(format!("h{}", leg + 1), Dimension::Length, l.length, None, role)
            .base_point(leg, l.base.into(), None)
            .joint(format!("leg{}", leg + 1), Dimension::Length, l.length, l.stroke);
    }
    ClosureMechanism::new(Hardpoint { lengths: legs.iter().map(|l| l.length).collect() }, outline).unwrap()
}

/// The kinds with a box to work in.
pub fn all() -> Vec<(Box<dyn paracal::mechanism::Mechanism>, Workspace)> {
    let (r, d, t, c) = (rotary(), delta(), tripod(), cables());
    let home = |m: &dyn paracal::mechanism::Mechanism| m.home();
    let boxes = [
        about(&home(&r), [0.03, 0.03, 0.03, 0.15, 0.15, 0.15]),
        about(&home(&d), [0.1, 0.1, 0.08, 0.0, 0.0, 0.0]),
        about(&home(&t), [0.0, 0.0, 0.1, 0.2, 0.2, 0.0]),
        about(&home(&c), [0.3, 0.3, 0.0, 0.0, 0.0, 0.2]),
    ];
    let kinds: [Box<dyn paracal::mechanism::Mechanism>; 4] = [Box::new(r), Box::new(d), Box::new(t), Box::new(c)];
    let of_files = [
        include_str!("../../../mechanisms/rotary-delta.toml"),
        include_str!("../../../mechanisms/six-carriages.toml"),
        include_str!("../../../mechanisms/cables.toml"),
        include_str!("../../../mechanisms/delta-printer.toml"),
    ]
    .map(|text| {
        let machine = Machine::from_text(text, "m.toml".as_ref()).unwrap();
        (machine.mechanism, machine.workspace.unwrap())
    });
    kinds.into_iter().zip(boxes).chain(of_files).collect()
}
