//! Kinematics against numbers that others published.

use crate::common::machine;
use paracal::conditions::Conditions;
use paracal::files::Machine;
use paracal::identification::{Identifier, LevenbergMarquardt, PriorPolicy, Task};
use paracal::measurement::Noise;
use paracal::mechanism::{Leg, Mechanism, SixHardpoint};
use paracal::nalgebra::Vector3;
use paracal::pose::{PoseConvention, RotationOrder};
use paracal::simulation::{as_dataset, simulate};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// Legs whose `moving` points belong to the platform; lengths are those at home, the pivot at the origin.
fn hexapod(
    moving: &[[f64; 3]; 6],
    standing: &[[f64; 3]; 6],
    pivot: Vector3<f64>,
    convention: &PoseConvention,
) -> SixHardpoint {
    let leg = |(m, s): (&[f64; 3], &[f64; 3])| {
        let (platform, base) = (Vector3::from(*m), Vector3::from(*s) - pivot);
        let length = (platform - pivot - base).norm();
        Leg { platform, base, length, length_offset: 0.0, stroke: None }
    };
    let legs: Vec<Leg> = moving.iter().zip(standing).map(leg).collect();
    SixHardpoint::new("hexapod", &legs, Some(convention.pose(&[0.0; 6])), None).unwrap()
}

fn length_changes(m: &SixHardpoint, convention: &PoseConvention, q: &[f64; 6]) -> Vec<f64> {
    let at = Conditions::unknown();
    let lengths = |q: &[f64; 6]| m.inverse(m.values(), &convention.pose(q), &at).unwrap();
    lengths(q).iter().zip(lengths(&[0.0; 6])).map(|(a, b)| a - b).collect()
}

/// ts_mthexapod (Rubin Observatory), tests/test_simple_hexapod.py: checked there against the controller's model.
#[test]
fn the_camera_hexapod_moves_its_struts_as_published() {
    let pivot = Vector3::new(0.0, 0.0, -2.7584);
    let convention = PoseConvention { order: RotationOrder::Xyz, pivot };
    let moving = [
        [0.20944, 0.66426, -0.555],
        [-0.20944, 0.66426, -0.555],
        [-0.67999, -0.15075, -0.555],
        [-0.47055, -0.51351, -0.555],
        [0.47055, -0.51351, -0.555],
        [0.67999, -0.15075, -0.555],
    ];
    let standing = [
        [0.47055, 0.51351, -0.125],
        [-0.47055, 0.51351, -0.125],
        [-0.67999, 0.15075, -0.125],
        [-0.20944, -0.66426, -0.125],
        [0.20944, -0.66426, -0.125],
        [0.67999, 0.15075, -0.125],
    ];
    let m = hexapod(&moving, &standing, pivot, &convention);
    let published = [0.15205, 0.07204, -0.04667, 0.13381, 0.02959, -0.07292];
    let found = length_changes(&m, &convention, &[-0.0603, 0.1045, -0.0109, -0.0355, -0.0205, -0.0004]);
    for (f, p) in found.iter().zip(published) {
        assert!((f - p).abs() <= 0.5e-5 + 1e-9, "{f:.6} against {p}");
    }
}

/// The same source: a translation of a zigzag hexapod, printed to 0.01 µm (one value lies on the edge of rounding).
#[test]
fn a_zigzag_hexapod_translates_as_published() {
    let ring = |radius: f64, z: f64, degrees: [f64; 6]| {
        degrees.map(|d| [radius * d.to_radians().cos(), radius * d.to_radians().sin(), z])
    };
    let moving = ring(1.2, 0.0, [10.0, 130.0, 130.0, 250.0, 250.0, 10.0]);
    let standing = ring(2.3, 0.81, [70.0, 70.0, 190.0, 190.0, 310.0, 310.0]);
    let convention = PoseConvention { order: RotationOrder::Xyz, pivot: Vector3::zeros() };
    let m = hexapod(&moving, &standing, Vector3::zeros(), &convention);
    let found = length_changes(&m, &convention, &[500e-6, -3020e-6, 2500e-6, 0.0, 0.0, 0.0]);
    let published = [1895.25, 443.86, -2443.52, 515.74, -2268.74, -3776.62];
    for (f, p) in found.iter().zip(published) {
        assert!((1e6 * f - p).abs() <= 0.0051, "{:.4} against {p}", 1e6 * f);
    }
}

#[test]
fn the_bundled_telescope_hexapods_have_home_at_zero_and_reach_their_limits() {
    for name in ["rubin-camera-hexapod", "rubin-m2-hexapod"] {
        let m: Machine = machine(name);
        assert!(m.convention.coordinates(&m.mechanism.home()).iter().all(|v| v.abs() < 1e-15), "{name}");
        let at = Conditions::unknown();
        for pose in m.workspace.unwrap().corners() {
            let joints = m.mechanism.inverse(m.mechanism.values(), &pose, &at).unwrap();
            let back = m.mechanism.forward(m.mechanism.values(), &joints, &at, &m.mechanism.home()).unwrap();
            assert!(pose.motion_to(&back).amax() < 1e-12, "{name}");
        }
    }
}

/// Nategh and Agheli 2009, true parameters of the machine: x, y, z of the platform and of the base, and the length.
const NATEGH_AGHELI_TRUE: [[f64; 7]; 6] = [
    [96.661, 81.7602, 1.0684, 305.2599, 115.0695, 2.621, 604.4299],
    [22.2476, 125.2511, -0.553, -55.2814, 322.9819, 4.2181, 607.2473],
    [-122.4519, 36.6453, 4.3547, -244.7954, 208.0087, 3.9365, 600.4441],
    [-120.6859, -34.4565, -4.9014, -252.5755, -211.8783, -3.0128, 605.9031],
    [24.7769, -125.0489, -4.8473, -53.9678, -320.6115, 4.3181, 604.5251],
    [91.3462, -80.9866, 0.2515, 302.4266, -109.4351, 3.3812, 600.0616],
];

#[test]
fn the_parameters_of_nategh_and_agheli_come_back_from_exact_data() {
    let m = machine("nategh-agheli");
    let nominal = m.mechanism.as_ref();
    let order = |l: &[f64; 7]| [l[0], l[1], l[2], l[6], l[3], l[4], l[5]].map(|v| 1e-3 * v);
    let values: Vec<f64> = NATEGH_AGHELI_TRUE.iter().flat_map(order).collect();
    let truth = nominal.with_values(&values, nominal.home()).unwrap();
    let space = m.workspace.unwrap();
    let poses: Vec<_> =
        space.corners().into_iter().step_by(2).chain(space.corners().into_iter().skip(1).step_by(4)).collect();
    let exact = Noise { position: 0.0, rotation: 0.0, joint: 0.0, known: true };
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let run = simulate(nominal, truth.as_ref(), &poses, &space.convention, &exact, &mut rng).unwrap();
    let data = as_dataset(&run, &space.convention, &m.noise.unwrap());
    let task = Task { prior: PriorPolicy::None, ..Task::new(nominal, &data) };
    let found = LevenbergMarquardt::default().identify(&task).unwrap();
    for (p, t) in found.parameters.iter().zip(&values) {
        assert!((p.value - t).abs() <= 1e-12, "{}: {:.15} against {t}", p.spec.name, p.value);
    }
}
