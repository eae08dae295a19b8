//! Files that are read wrongly, of random machines: what is wrong is named, or held by a tie, and sound files are not
//! called misread.
//!
//! Lengths, angles of cranks and heights of carriages come from the measured poses in closed form, by formulas of these tests;
//! every mistake is made by its own arithmetic.

use std::f64::consts::TAU;
use std::fmt::Write;

use paracal::diagnosis::Misread;
use paracal::nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::common::asked::Files;
use crate::common::hidden::cases::{Kind as Hidden, draw};
use crate::common::hidden::effects::CATALOGUE;
use crate::common::hidden::run::normal;

const ROWS: usize = 36;
type V = Vector3<f64>;
/// Joints of a true machine at a place and an attitude, mm or degrees.
type Inverse = Box<dyn Fn(&V, &Matrix3<f64>) -> Vec<f64>>;
/// The four numbers that are written for an attitude.
type Written = fn(&UnitQuaternion<f64>) -> [f64; 4];

/// A machine in mm and degrees: its file, and what it commands for a true pose.
struct Machine {
    file: String,
    /// Joints of the true machine at a pose, mm or degrees.
    joints: Inverse,
    home: f64,
    half: [f64; 2],
    noise: [f64; 2],
    unit: &'static str,
    targets: Vec<V>,
}

fn rx(a: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&V::x_axis(), a.to_radians()).into_inner()
}

fn ry(a: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&V::y_axis(), a.to_radians()).into_inner()
}

fn rz(a: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&V::z_axis(), a.to_radians()).into_inner()
}

fn at(radius: f64, degrees: f64, z: f64) -> V {
    V::new(radius * degrees.to_radians().cos(), radius * degrees.to_radians().sin(), z)
}

fn jitter(v: &V, sd: f64, rng: &mut ChaCha8Rng) -> V {
    v + V::new(normal(rng), normal(rng), normal(rng)) * sd
}

fn list(v: &V) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

fn tail(home: f64, half: [f64; 2], tolerance: f64, noise: [f64; 2]) -> String {
    format!(
        "\n[home]\nposition = [0, 0, {home}]\nrotation = [0, 0, 0]\n[workspace]\nposition = [{0}, {0}, {0}]\n\
         rotation = [{1}, {1}, {1}]\n[tolerance]\nanchor = {tolerance}\nlength = {tolerance}\n[noise]\nposition = {2}\n\
         rotation = {3}\n",
        half[0], half[1], noise[0], noise[1]
    )
}

fn targets(rng: &mut ChaCha8Rng, size: f64) -> Vec<V> {
    (0..4).map(|k| at(size, 90.0 * f64::from(k) + 20.0 * normal(rng), size * 0.4 * normal(rng))).collect()
}

fn target_text(targets: &[V]) -> String {
    targets
        .iter()
        .enumerate()
        .map(|(k, t)| format!("\n[[target]]\nname = \"p{}\"\nplatform = {}\n", k + 1, list(t)))
        .collect()
}

/// A hexapod without a symmetry, of random size.
fn hexapod(rng: &mut ChaCha8Rng) -> Machine {
    let size = 10_f64.powf(rng.random_range(2.0..3.0));
    let (lower, upper) = (rng.random_range(1.1..1.5), rng.random_range(0.7..0.9));
    let home = size * rng.random_range(0.8..1.4);
    let (base_gap, platform_gap) = (rng.random_range(10.0..25.0), rng.random_range(40.0..52.0));
    let tolerance = size * 5e-4;
    let mut file =
        "name = \"hexapod\"\ntype = \"six-hardpoint\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\n".to_owned();
    let (mut a, mut b, mut offset) = (Vec::new(), Vec::new(), Vec::new());
    for leg in 0..6 {
        let (corner, side) = (120.0 * f64::from(leg / 2), if leg % 2 == 0 { -1.0 } else { 1.0 });
        let mut odd = || 4.0 * normal(rng);
        let base = at(size * lower, corner + side * base_gap + odd(), size * 0.03 * odd() / 4.0);
        let platform = at(size * upper, corner + side * platform_gap + odd(), 0.0);
        let length = (platform + V::new(0.0, 0.0, home) - base).norm();
        let _ = write!(file, "[[leg]]\nplatform = {}\nbase = {}\nlength = {length}\n", list(&platform), list(&base));
        a.push(jitter(&platform, tolerance, rng));
        b.push(jitter(&base, tolerance, rng));
        offset.push(tolerance * normal(rng));
    }
    let half = [size * rng.random_range(0.03..0.12), rng.random_range(2.0..9.0)];
    let noise = [size * 1e-5, 6e-4];
    let targets = targets(rng, 0.8 * size);
    file += &(tail(home, half, tolerance, noise) + &target_text(&targets));
    let joints = move |t: &V, r: &Matrix3<f64>| (0..6).map(|i| (t + r * a[i] - b[i]).norm() - offset[i]).collect();
    Machine { file, joints: Box::new(joints), home, half, noise, unit: "mm", targets }
}

/// Six cranks: `|p − r (cos θ u + sin θ v)| = rod` is `A cos θ + B sin θ = C`.
fn cranks(rng: &mut ChaCha8Rng) -> Machine {
    let mut file =
        "name = \"cranks\"\ntype = \"rotary-stewart\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\n".to_owned();
    let (home, tolerance) = (195.9, 0.2);
    let mut legs = Vec::new();
    for leg in 0..6 {
        let (corner, side) = (120.0 * f64::from(leg / 2), if leg % 2 == 0 { -1.0 } else { 1.0 });
        let base = at(170.0, corner + side * (22.0 + normal(rng)), 0.0);
        let platform = at(130.0, corner + side * (48.0 + normal(rng)), 0.0);
        let radial = at(1.0, corner, 0.0);
        let zero = V::z().cross(&radial) * side;
        let axis = radial * -side;
        // The rod that holds the crank near zero at home.
        let rod = (platform + V::new(0.0, 0.0, home) - base - zero * 60.0).norm();
        let _ = write!(
            file,
            "[[leg]]\nplatform = {}\nbase = {}\nlength = {rod}\ncrank = 60.0\naxis = {}\nzero = {}\n",
            list(&platform),
            list(&base),
            list(&axis),
            list(&zero)
        );
        let (platform, base) = (jitter(&platform, tolerance, rng), jitter(&base, tolerance, rng));
        legs.push((platform, base, rod + tolerance * normal(rng), zero, axis.cross(&zero)));
    }
    let (half, noise) = ([15.0, 6.0], [0.004, 0.001]);
    let targets = targets(rng, 120.0);
    file += &(tail(home, half, tolerance, noise) + &target_text(&targets));
    let joints = move |t: &V, r: &Matrix3<f64>| {
        let angle = |(a, b, rod, u, v): &(V, V, f64, V, V)| {
            let p = t + r * a - b;
            let (x, y) = (p.dot(u), p.dot(v));
            let c = (p.norm_squared() + 60.0 * 60.0 - rod * rod) / 120.0;
            let (about, off) = (y.atan2(x), (c / x.hypot(y)).acos());
            // Of the two the one near zero, on which the drawing is.
            let both = [about + off, about - off].map(|w| w - TAU * (w / TAU).round());
            if both[0].abs() < both[1].abs() { both[0].to_degrees() } else { both[1].to_degrees() }
        };
        legs.iter().map(angle).collect()
    };
    Machine { file, joints: Box::new(joints), home, half, noise, unit: "deg", targets }
}

/// Joints and poses as they are written down: mm and degrees, angles of `Rz Ry Rx`.
struct Table {
    joints: Vec<Vec<f64>>,
    poses: Vec<(V, Matrix3<f64>)>,
    /// How the attitude is written.
    angles: fn(&Matrix3<f64>) -> [f64; 3],
    quaternion: Option<Written>,
    file: String,
    unit: &'static str,
}

fn zyx(r: &Matrix3<f64>) -> [f64; 3] {
    [r[(2, 1)].atan2(r[(2, 2)]), (-r[(2, 0)]).asin(), r[(1, 0)].atan2(r[(0, 0)])].map(f64::to_degrees)
}

/// Angles of `Ry Rx Rz`, under the columns of their axes.
fn yxz(r: &Matrix3<f64>) -> [f64; 3] {
    [(-r[(1, 2)]).asin(), r[(0, 2)].atan2(r[(2, 2)]), r[(1, 0)].atan2(r[(1, 1)])].map(f64::to_degrees)
}

/// Angles of `Rz Rx Rz`, from left to right.
fn zxz(r: &Matrix3<f64>) -> [f64; 3] {
    [r[(0, 2)].atan2(-r[(1, 2)]), r[(2, 2)].acos(), r[(2, 0)].atan2(r[(2, 1)])].map(f64::to_degrees)
}

fn rotation_vector(r: &Matrix3<f64>) -> [f64; 3] {
    let w = UnitQuaternion::from_matrix(r).scaled_axis();
    [w.x, w.y, w.z].map(f64::to_degrees)
}

impl Table {
    fn of(machine: &Machine, rng: &mut ChaCha8Rng) -> Self {
        let [shift, turn] = machine.half;
        let (mut joints, mut poses) = (Vec::new(), Vec::new());
        for _ in 0..ROWS {
            let u: [f64; 6] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
            let t = V::new(shift * u[0], shift * u[1], machine.home + shift * u[2]);
            let r = rz(turn * u[5]) * ry(turn * u[4]) * rx(turn * u[3]);
            joints.push((machine.joints)(&t, &r));
            let [p, w] = machine.noise;
            let small = V::new(normal(rng), normal(rng), normal(rng)) * w.to_radians();
            poses.push((jitter(&t, p, rng), Rotation3::new(small).into_inner() * r));
        }
        Self { joints, poses, angles: zyx, quaternion: None, file: machine.file.clone(), unit: machine.unit }
    }

    /// As a tracker sees it that stands and looks anyhow, at a target that sits somewhere on the platform.
    fn seen(&mut self, size: f64, target: bool, rng: &mut ChaCha8Rng) {
        let turn = |rng: &mut ChaCha8Rng, by: f64| Rotation3::new(V::new(normal(rng), normal(rng), normal(rng)) * by);
        let (base, at) = (turn(rng, 0.6).into_inner(), V::new(3.0, -2.0, 0.5) * size);
        let (on, place) = (turn(rng, 0.3).into_inner(), V::new(0.1, -0.05, 0.2) * size);
        for (t, r) in &mut self.poses {
            let (place, on) = if target { (place, on) } else { (V::zeros(), Matrix3::identity()) };
            (*t, *r) = (base * (*t + *r * place) + at, base * *r * on);
        }
    }

    fn lines(&self, head: &str, cells: impl Fn(usize) -> Vec<f64>) -> String {
        let n = self.joints[0].len();
        let mut text: String = (1..=n).map(|i| format!("leg{i}_{},", self.unit)).collect::<String>() + head + "\n";
        for (k, joints) in self.joints.iter().enumerate() {
            let row: Vec<String> = joints.iter().chain(&cells(k)).map(|v| format!("{v:.9}")).collect();
            text += &(row.join(",") + "\n");
        }
        text
    }

    fn as_poses(&self, change: &dyn Fn([f64; 6]) -> [f64; 6]) -> String {
        if let Some(write) = self.quaternion {
            return self.lines("x_mm,y_mm,z_mm,qw,qx,qy,qz", |k| {
                let (t, r) = &self.poses[k];
                [vec![t.x, t.y, t.z], write(&UnitQuaternion::from_matrix(r)).to_vec()].concat()
            });
        }
        self.lines("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg", |k| {
            let (t, r) = &self.poses[k];
            let [a, b, c] = (self.angles)(r);
            change([t.x, t.y, t.z, a, b, c]).to_vec()
        })
    }

    fn as_points(&self, targets: &[V], change: &dyn Fn([f64; 6]) -> [f64; 6]) -> String {
        let head: Vec<String> =
            (1..=targets.len()).flat_map(|k| ["x", "y", "z"].map(|a| format!("p{k}{a}_mm"))).collect();
        self.lines(&head.join(","), |k| {
            let (t, r) = &self.poses[k];
            let one = |p: &V| {
                let v = t + r * p;
                change([v.x, v.y, v.z, 0.0, 0.0, 0.0])[..3].to_vec()
            };
            targets.iter().flat_map(one).collect()
        })
    }

    fn as_positions(&self, change: &dyn Fn([f64; 6]) -> [f64; 6]) -> String {
        self.lines("x_mm,y_mm,z_mm", |k| {
            let t = &self.poses[k].0;
            change([t.x, t.y, t.z, 0.0, 0.0, 0.0])[..3].to_vec()
        })
    }
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Pose,
    Targets,
    Positions,
}

type Change = fn([f64; 6]) -> [f64; 6];
const AS_IT_IS: Change = |q| q;

/// Mistakes: the name of the reading, what is done to the table, and what is done to the numbers of a row.
type Mistake = (&'static str, fn(&mut Table, &mut ChaCha8Rng), Change);

fn nothing(_: &mut Table, _: &mut ChaCha8Rng) {}

fn exchange_corner(table: &mut Table, rng: &mut ChaCha8Rng) {
    let first = 2 * rng.random_range(0..table.joints[0].len() / 2);
    table.joints.iter_mut().for_each(|j| j.swap(first, first + 1));
}

fn shuffle(table: &mut Table, rng: &mut ChaCha8Rng) {
    let n = table.joints[0].len();
    let (a, by) = (rng.random_range(0..n), rng.random_range(1..n));
    let b = (a + by) % n;
    table.joints.iter_mut().for_each(|j| j.swap(a, b));
}

fn mean_of(table: &Table) -> f64 {
    table.joints.iter().flatten().sum::<f64>() / (6.0 * ROWS as f64)
}

fn backwards(table: &mut Table, rng: &mut ChaCha8Rng) {
    let about = if table.unit == "deg" { 0.0 } else { mean_of(table) };
    let one = rng.random_range(0..6_usize);
    let more = [rng.random_bool(0.5), rng.random_bool(0.5)];
    for j in table.joints.iter_mut() {
        for (k, v) in j.iter_mut().enumerate() {
            if k == one || (k == (one + 2) % 6 && more[0]) || (k == (one + 3) % 6 && more[1]) {
                *v = 2.0 * about - *v;
            }
        }
    }
}

fn from_home(table: &mut Table, _: &mut ChaCha8Rng) {
    let by = if table.unit == "deg" { -90.0 } else { mean_of(table) };
    table.joints.iter_mut().flatten().for_each(|v| *v -= by);
}

fn joints_by_1000(table: &mut Table, _: &mut ChaCha8Rng) {
    let by = if table.unit == "deg" { 1_f64.to_radians() } else { 1e-3 };
    table.joints.iter_mut().flatten().for_each(|v| *v *= by);
}

fn late(table: &mut Table, _: &mut ChaCha8Rng) {
    table.joints.remove(0);
    table.poses.pop();
}

fn transposed(table: &mut Table, _: &mut ChaCha8Rng) {
    table.poses.iter_mut().for_each(|(_, r)| *r = r.transpose());
}

fn in_platform_axes(table: &mut Table, _: &mut ChaCha8Rng) {
    table.poses.iter_mut().for_each(|(t, r)| *t = r.transpose() * *t);
}

fn inverted(table: &mut Table, _: &mut ChaCha8Rng) {
    table.poses.iter_mut().for_each(|(t, r)| (*t, *r) = (-(r.transpose() * *t), r.transpose()));
}

fn file_in_metres(table: &mut Table, _: &mut ChaCha8Rng) {
    table.file = table.file.replace("length_unit = \"mm\"", "length_unit = \"m\"");
}

const JOINTS: [Mistake; 5] = [
    ("leg-order", exchange_corner, AS_IT_IS),
    ("leg-order", shuffle, AS_IT_IS),
    ("leg-sign", backwards, AS_IT_IS),
    ("joint-zero", from_home, AS_IT_IS),
    ("joint-unit", joints_by_1000, AS_IT_IS),
];
const POINTS: [Mistake; 5] = [
    ("axis-sign", nothing, |[x, y, z, a, b, c]| [x, -y, z, a, b, c]),
    ("axes-swapped", nothing, |[x, y, z, a, b, c]| [y, x, z, a, b, c]),
    ("length-unit", nothing, |[x, y, z, a, b, c]| [0.1 * x, 0.1 * y, 0.1 * z, a, b, c]),
    ("row-shift", late, AS_IT_IS),
    ("file-unit", file_in_metres, AS_IT_IS),
];
const POSES: [Mistake; 12] = [
    ("axis-sign", nothing, |[x, y, z, a, b, c]| [x, y, z, a, -b, c]),
    ("axes-swapped", nothing, |[x, y, z, a, b, c]| [x, y, z, c, b, a]),
    ("handedness", nothing, |[x, y, z, a, b, c]| [x, -y, z, -a, b, -c]),
    ("euler-order", |t, _| t.angles = yxz, AS_IT_IS),
    ("euler-order", |t, _| t.angles = zxz, AS_IT_IS),
    ("euler-order", |t, _| t.angles = rotation_vector, AS_IT_IS),
    ("quaternion-order", |t, _| t.quaternion = Some(|q| [q.i, q.j, q.k, q.w]), AS_IT_IS),
    ("inverse-pose", transposed, AS_IT_IS),
    ("inverse-pose", inverted, AS_IT_IS),
    ("platform-axes", in_platform_axes, AS_IT_IS),
    ("angle-unit", nothing, |[x, y, z, a, b, c]| [x, y, z, a / 0.9, b / 0.9, c / 0.9]),
    ("angle-unit", nothing, |[x, y, z, a, b, c]| [x, y, z, 60.0 * a, 60.0 * b, 60.0 * c]),
];

/// What was said of a file, by its names.
fn found(machine: &Machine, kind: Kind, tracker: bool, mistake: &Mistake, rng: &mut ChaCha8Rng) -> Option<Misread> {
    let mut table = Table::of(machine, rng);
    if tracker {
        table.seen(machine.home, kind == Kind::Pose, rng);
    }
    mistake.1(&mut table, rng);
    let data = match kind {
        Kind::Pose => table.as_poses(&mistake.2),
        Kind::Targets => table.as_points(&machine.targets, &mistake.2),
        Kind::Positions => table.as_positions(&mistake.2),
    };
    let files = Files::new(&table.file, &data);
    paracal::diagnosis::diagnose(&files.question()).ok()?.misread
}

/// How often the truth was named, was held by a tie, or something else was named, of all.
#[derive(Default)]
struct Marks {
    right: usize,
    held: usize,
    wrong: usize,
    silent: usize,
    notes: String,
}

impl Marks {
    fn mark(&mut self, truth: &str, found: Option<&Misread>, what: &str) {
        match found {
            None => {
                self.silent += 1;
                let _ = writeln!(self.notes, "{what}: {truth} was not seen");
            }
            Some(m) if m.reading == truth => self.right += 1,
            Some(m) if m.alternatives.iter().any(|a| a.reading == truth) => self.held += 1,
            Some(m) => {
                self.wrong += 1;
                let _ = writeln!(self.notes, "{what}: {truth} was called {} ({})", m.reading, m.detail);
            }
        }
    }
}

/// Machines of one make with each of these mistakes.
fn examine(
    make: fn(&mut ChaCha8Rng) -> Machine,
    kind: Kind,
    tracker: bool,
    mistakes: &[Mistake],
    trials: u64,
) -> Marks {
    let mut marks = Marks::default();
    for seed in 0..trials {
        for (k, mistake) in mistakes.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(1000 * seed + k as u64);
            let machine = make(&mut rng);
            let said = found(&machine, kind, tracker, mistake, &mut rng);
            marks.mark(mistake.0, said.as_ref(), &format!("{kind:?} tracker {tracker} seed {seed} form {k}"));
        }
    }
    println!(
        "{kind:?} tracker {tracker}: right {} held {} wrong {} silent {}\n{}",
        marks.right, marks.held, marks.wrong, marks.silent, marks.notes
    );
    marks
}

/// Trials of each mistake; more where figures are measured.
fn trials() -> u64 {
    std::env::var("PARACAL_TRIALS").ok().and_then(|v| v.parse().ok()).unwrap_or(1)
}

#[test]
fn mistakes_in_joints_and_poses_are_named_in_the_base_frame() {
    for make in [hexapod, cranks] {
        let marks = examine(make, Kind::Pose, false, &[&JOINTS[..], &POINTS, &POSES].concat(), trials());
        assert!(marks.wrong == 0 && marks.silent == 0, "{}", marks.notes);
    }
}

#[test]
fn targets_and_positions_show_their_own_mistakes() {
    let marks = examine(hexapod, Kind::Targets, false, &[&JOINTS[..], &POINTS].concat(), trials());
    assert!(marks.wrong == 0 && marks.silent == 0, "{}", marks.notes);
    let marks = examine(hexapod, Kind::Positions, false, &[&JOINTS[..3], &POINTS[..2]].concat(), trials());
    assert!(marks.wrong == 0 && marks.silent == 0, "{}", marks.notes);
}

#[test]
fn mistakes_are_told_apart_in_a_frame_that_is_found() {
    let marks = examine(hexapod, Kind::Pose, true, &[&JOINTS[..4], &POSES[..2]].concat(), trials());
    assert!(marks.wrong == 0 && marks.silent == 0, "{}", marks.notes);
    let marks = examine(hexapod, Kind::Targets, true, &JOINTS[..4], trials());
    assert!(marks.wrong == 0 && marks.silent == 0, "{}", marks.notes);
}

#[test]
fn two_mistakes_at_once_are_named_together() {
    const PAIRS: [Mistake; 3] = [
        ("axis-sign+leg-order", exchange_corner, |[x, y, z, a, b, c]| [x, y, z, a, -b, c]),
        ("angle-unit+length-unit", nothing, |[x, y, z, a, b, c]| {
            [1e-3 * x, 1e-3 * y, 1e-3 * z, a.to_radians(), b.to_radians(), c.to_radians()]
        }),
        (
            "euler-order+leg-sign",
            |t, rng| {
                t.angles = yxz;
                backwards(t, rng);
            },
            AS_IT_IS,
        ),
    ];
    let marks = examine(hexapod, Kind::Pose, false, &PAIRS, trials());
    assert!(marks.wrong == 0 && marks.silent == 0, "{}", marks.notes);
}

#[test]
fn sound_files_are_not_called_misread() {
    const SOUND: [Mistake; 2] = [
        ("", nothing, AS_IT_IS),
        // A common zero is a convention.
        ("", |t, _| t.joints.iter_mut().flatten().for_each(|v| *v += 3.0), AS_IT_IS),
    ];
    for make in [hexapod, cranks] {
        for (kind, tracker) in
            [Kind::Pose, Kind::Targets, Kind::Positions].into_iter().flat_map(|k| [(k, false), (k, true)])
        {
            let marks = examine(make, kind, tracker, &SOUND, trials());
            assert_eq!(marks.silent as u64, 2 * trials(), "{kind:?} {tracker}");
        }
    }
}

/// What is large is not misread: effects at thirty times their limit, and tolerances that are a hundred times too small.
#[test]
fn strong_effects_and_contradicted_tolerances_are_no_misreading() {
    let mut called = String::new();
    let mut check = |what: &str, mechanism: &str, data: &str| {
        if let Ok(d) = paracal::diagnosis::diagnose(&Files::new(mechanism, data).question())
            && let Some(m) = d.misread
        {
            let _ = writeln!(called, "{what} was called {} ({})", m.reading, m.detail);
        }
    };
    for number in (0..CATALOGUE.len()).step_by(if trials() > 1 { 1 } else { 4 }) {
        let case = draw(Hidden::One(30.0), 77, number).unwrap();
        check(&format!("{:?}", case.truth.effects), &case.mechanism, &case.data);
    }
    for number in 0..2 {
        let case = draw(Hidden::Null, 78, number).unwrap();
        let narrow =
            case.mechanism.replace("anchor = 0.5", "anchor = 0.005").replace("length = 0.5\n", "length = 0.005\n");
        assert_ne!(narrow, case.mechanism);
        check("a narrow tolerance", &narrow, &case.data);
    }
    assert!(called.is_empty(), "{called}");
}
