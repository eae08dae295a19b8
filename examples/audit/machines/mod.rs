//! Machines of the generator: what each kind is made of, and its inverse kinematics in closed form.

mod cables;
mod delta;
mod hexapod;
mod positioner;
mod rotary;
mod tripod;

use nalgebra::{DMatrix, DVector, Vector3};
use paracal::mechanism::{GeometryError, Mechanism};

use crate::dice::Dice;
use crate::rigid::Rigid;

/// What a parameter is, as far as tolerances and mistakes in the drawing are concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// A coordinate, 0 to 2, of a point of the platform.
    Platform(usize),
    /// A coordinate of a point of the base.
    Base(usize),
    /// A length of a member.
    Length,
    /// An angle of a member.
    Angle,
    /// Where a joint counts from, m.
    ZeroLength,
    /// The same of a joint that turns, rad.
    ZeroAngle,
    /// Where a joint counts from, m, in a machine whose parameters have no place for it: nobody tolerates that it is
    /// off.
    ZeroUnknown,
}

/// Standard deviations of manufacture: of coordinates of points, m, of lengths, m, and of angles, rad.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    pub(crate) anchor: f64,
    pub(crate) length: f64,
    pub(crate) angle: f64,
}

impl Spread {
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { anchor: self.anchor * factor, length: self.length * factor, angle: self.angle * factor }
    }

    pub(crate) fn of(&self, part: Part) -> f64 {
        match part {
            Part::Platform(_) | Part::Base(_) => self.anchor,
            Part::Length | Part::ZeroLength => self.length,
            Part::Angle | Part::ZeroAngle => self.angle,
            Part::ZeroUnknown => 0.0,
        }
    }
}

/// A kind of machine, with what is constant in it.
pub(crate) trait Kind: Send + Sync {
    fn name(&self) -> &'static str;

    /// What each of its values is.
    fn parts(&self) -> Vec<Part>;

    /// The joints at a pose on which the machine can stand; `None` out of reach.
    fn joints(&self, values: &[f64], pose: &Rigid) -> Option<Vec<f64>>;

    /// The motions (three shifts, three turns) that are not commanded but follow.
    fn follows(&self) -> &[usize] {
        &[]
    }

    /// As many numbers, which are zero where the machine can stand.
    fn misses(&self, _values: &[f64], _pose: &Rigid) -> Vec<f64> {
        Vec::new()
    }

    /// How well its joints hold it at a pose: zero at a singularity, with the sign of the side on which it is.
    fn held(&self, _values: &[f64], _pose: &Rigid) -> f64 {
        1.0
    }

    /// The library's mechanism with these values.
    fn build(&self, values: &[f64], home: &Rigid, spread: &Spread) -> Result<Box<dyn Mechanism>, GeometryError>;
}

/// The kinds, as files of machines call them.
pub(crate) const KINDS: [&str; 6] =
    ["six-hardpoint", "rotary-stewart", "linear-delta", "tripod-3rps", "planar-cables", "pose"];

/// A machine as it was designed.
pub(crate) struct Design {
    pub(crate) kind: Box<dyn Kind>,
    pub(crate) values: Vec<f64>,
    pub(crate) home: Rigid,
    /// Half-ranges of its workspace, m and rad; 0 for what is not commanded.
    pub(crate) half: [f64; 6],
    /// Radius of the base.
    pub(crate) size: f64,
    /// Radius of the platform.
    pub(crate) arm: f64,
    /// How much finer than points lengths are made.
    pub(crate) finer: f64,
    /// False if instrument and target must be in the frames of the drawing.
    pub(crate) carries_frames: bool,
    /// False if it has no points of the platform.
    pub(crate) has_platform: bool,
}

impl Design {
    fn new(kind: impl Kind + 'static, values: Vec<f64>, home: Rigid, half: [f64; 6], size: f64, arm: f64) -> Self {
        let kind = Box::new(kind);
        Self { kind, values, home, half, size, arm, finer: 1.0, carries_frames: true, has_platform: true }
    }

    /// A machine of one kind or of any, most often a hexapod then.
    pub(crate) fn draw(kind: Option<&str>, dice: &mut Dice) -> Option<Self> {
        let any = dice.pick(&[0.7, 0.08, 0.06, 0.06, 0.06, 0.04]);
        match kind.unwrap_or(KINDS[any]) {
            "rotary-stewart" => rotary::draw(dice),
            "linear-delta" => delta::draw(dice),
            "tripod-3rps" => tripod::draw(dice),
            "planar-cables" => cables::draw(dice),
            "pose" => positioner::draw(dice),
            _ => hexapod::draw(dice),
        }
    }

    pub(crate) fn hexapod(dice: &mut Dice) -> Option<Self> {
        hexapod::draw(dice)
    }

    pub(crate) fn near_singular(dice: &mut Dice) -> Option<Self> {
        hexapod::draw_near_singular(dice)
    }
}

/// The pose near `pose` on which the machine can stand, by Newton's method with differences for derivatives.
pub(crate) fn settled(kind: &dyn Kind, values: &[f64], pose: &Rigid) -> Option<Rigid> {
    const STEP: f64 = 1e-6;
    let follows = kind.follows();
    let n = follows.len();
    let mut pose = *pose;
    if n == 0 {
        return Some(pose);
    }
    let along = |pose: &Rigid, k: usize, by: f64| {
        let mut motion = [Vector3::zeros(), Vector3::zeros()];
        motion[follows[k] / 3][follows[k] % 3] = by;
        pose.moved(&motion[0], &motion[1])
    };
    for _ in 0..30 {
        let misses = DVector::from_vec(kind.misses(values, &pose));
        let mut rates = DMatrix::zeros(n, n);
        for k in 0..n {
            let [plus, minus] = [STEP, -STEP].map(|step| kind.misses(values, &along(&pose, k, step)));
            for row in 0..n {
                rates[(row, k)] = (plus[row] - minus[row]) / (2.0 * STEP);
            }
        }
        let step = rates.lu().solve(&misses)?;
        if !step.iter().all(|v| v.is_finite()) {
            return None;
        }
        for k in 0..n {
            pose = along(&pose, k, -step[k]);
        }
        if step.amax() < 1e-14 {
            break;
        }
    }
    (kind.misses(values, &pose).iter().all(|m| m.abs() < 1e-12)).then_some(pose)
}

/// A point of the flat list of values.
fn point(values: &[f64], first: usize) -> Vector3<f64> {
    Vector3::new(values[first], values[first + 1], values[first + 2])
}

/// A point on a circle, at an angle in degrees.
fn on_circle(radius: f64, degrees: f64, z: f64) -> Vector3<f64> {
    let (s, c) = degrees.to_radians().sin_cos();
    Vector3::new(radius * c, radius * s, z)
}
