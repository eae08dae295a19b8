//! The stage of a run: which machine, seen by what, from where. The reference is a positioner of two metres whose poses are
//! measured in its base frame.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{Rng, RngExt};

use super::hexapod::{Disturbance, Geometry, HOME_LENGTH, Pose};
use super::run::{angle, direction};

/// A machine as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    pub geometry: Geometry,
    pub home: Pose,
    /// Commanded lengths at home, m.
    pub lengths: [f64; 6],
    /// How far runs go from home to each side, m and rad.
    pub half: [f64; 2],
    /// Noise of one measured coordinate, m and rad.
    pub noise: [f64; 2],
    /// Standard deviation of each of the 42 errors of the true machine, which is also the tolerance, m.
    pub error: f64,
    /// Places of the targets on the platform, m.
    pub targets: [Vector3<f64>; 4],
}

/// Which machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Make {
    /// Table 5 of Yu, Wu, Wang 2023.
    Reference,
    /// A desk hexapod of 100 mm.
    Desk,
    /// Three corners above and three below, each of two legs.
    ThreeThree,
    /// Flat, with points that are in no plane, as the hexapods of a camera.
    Camera,
    /// The reference, moved by ±50 mm and ±5°.
    Wide,
}

impl Make {
    pub fn design(self) -> Design {
        match self {
            Self::Reference => reference([0.010, 0.5]),
            Self::Wide => reference([0.050, 5.0]),
            Self::Desk => ring([0.060, 0.100], [44.0, 14.0], 0.120, [0.008, 4.0], [1e-6, 2e-4], 0.1e-3),
            Self::ThreeThree => ring([0.300, 0.500], [60.0, 0.0], 0.600, [0.010, 0.5], [1e-6, 1e-4], 0.2e-3),
            Self::Camera => {
                let mut design = ring([0.720, 0.850], [50.0, 16.0], 0.500, [0.006, 0.2], [1e-6, 5e-5], 0.2e-3);
                for (i, (a, b)) in design.geometry.platform.iter_mut().zip(&mut design.geometry.base).enumerate() {
                    a.z += 0.010 * (1.7 * i as f64).sin();
                    b.z += 0.015 * (2.3 * i as f64).cos();
                }
                at_home(design)
            }
        }
    }
}

/// The reference machine with a range of poses, m and degrees.
fn reference([shift, turn]: [f64; 2]) -> Design {
    let geometry = Geometry::nominal();
    let home = geometry.home().unwrap_or(Pose { t: Vector3::new(0.0, 0.0, 0.4757), r: Matrix3::identity() });
    Design {
        targets: targets(1.2),
        geometry,
        home,
        lengths: [HOME_LENGTH; 6],
        half: [shift, turn.to_radians()],
        noise: [1e-6, 1e-4_f64.to_radians()],
        error: 0.5e-3,
    }
}

/// Six legs between two circles: radii of platform and base, half the angle between the points of a pair, height of home.
fn ring(radii: [f64; 2], pairs: [f64; 2], height: f64, half: [f64; 2], noise: [f64; 2], error: f64) -> Design {
    let on = |radius: f64, degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Vector3::new(radius * cosine, radius * sine, 0.0)
    };
    let point = |radius: f64, pair: f64, i: usize| {
        let side = if i.is_multiple_of(2) { -1.0 } else { 1.0 };
        on(radius, 120.0 * (i / 2) as f64 + side * pair)
    };
    at_home(Design {
        geometry: Geometry {
            platform: std::array::from_fn(|i| point(radii[0], pairs[0], i)),
            base: std::array::from_fn(|i| point(radii[1], pairs[1], i)),
            offset: [0.0; 6],
        },
        home: Pose { t: Vector3::new(0.0, 0.0, height), r: Matrix3::identity() },
        lengths: [0.0; 6],
        half: [half[0], half[1].to_radians()],
        noise: [noise[0], noise[1].to_radians()],
        error,
        targets: targets(radii[0]),
    })
}

/// With the lengths of its home.
fn at_home(design: Design) -> Design {
    Design { lengths: design.geometry.lengths(&design.home), ..design }
}

fn targets(size: f64) -> [Vector3<f64>; 4] {
    [[1.0, 0.1, 0.2], [-0.2, 0.9, -0.1], [-0.8, -0.5, 0.3], [0.3, -0.7, -0.3]].map(|p| Vector3::from(p) * size)
}

/// What is measured in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    Poses,
    /// Four targets of known places.
    Targets,
    /// The position of the platform alone.
    Positions,
}

/// A machine and what sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    pub design: Design,
    pub reading: Reading,
    /// The base in the frame of the tracker, and the target on the platform.
    pub frames: Option<[Pose; 2]>,
}

impl Stage {
    pub fn reference() -> Self {
        Self { design: Make::Reference.design(), reading: Reading::Poses, frames: None }
    }

    /// Frames of a tracker that stands somewhere.
    pub fn tracker<R: Rng + ?Sized>(size: f64, rng: &mut R) -> [Pose; 2] {
        let lean = |most: f64, rng: &mut R| Vector3::from_vec(direction(3, rng)) * rng.random_range(0.0..most);
        let yaw = Rotation3::new(Vector3::z() * angle(rng));
        let base = Pose {
            t: Vector3::from_vec(direction(3, rng)) * rng.random_range(2.0..5.0),
            r: (Rotation3::new(lean(0.4, rng)) * yaw).into_inner(),
        };
        let target = Pose { t: lean(size, rng), r: Rotation3::new(lean(0.2, rng)).into_inner() };
        [base, target]
    }

    /// The numbers that are read at a pose of the platform in the base frame, SI.
    pub fn seen(&self, pose: &Pose) -> Vec<f64> {
        let [base, target] = self.frames.unwrap_or([Pose { t: Vector3::zeros(), r: Matrix3::identity() }; 2]);
        let place = |p: &Vector3<f64>| base.t + base.r * (pose.t + pose.r * p);
        match self.reading {
            Reading::Poses => {
                let r = base.r * pose.r * target.r;
                Pose { t: place(&target.t), r }.coordinates().to_vec()
            }
            Reading::Targets => {
                self.design.targets.iter().flat_map(|p| place(p).iter().copied().collect::<Vec<_>>()).collect()
            }
            Reading::Positions => place(&Vector3::zeros()).iter().copied().collect(),
        }
    }

    /// The noise of each of these numbers.
    pub fn noise(&self) -> Vec<f64> {
        let [position, rotation] = self.design.noise;
        match self.reading {
            Reading::Poses => vec![position, position, position, rotation, rotation, rotation],
            Reading::Targets => vec![position; 12],
            Reading::Positions => vec![position; 3],
        }
    }

    /// The pose of a machine of this make at home.
    pub fn home_of(&self, machine: &Geometry) -> Option<Pose> {
        machine.reach(&self.design.lengths, self.design.home, |_| Disturbance::default())
    }
}
