//! Forward kinematics of six legs for many poses at a time: Newton's method with one pose in each lane of the machine's
//! vectors.
//!
//! The equations and the stopping rule are those of one pose at a time. Lanes that have arrived stand still, so that a result
//! does not depend on its neighbours. What one pose at a time does about difficult poses (halved steps, following the joints,
//! looking across a singularity) has no place in lanes: a pose that full steps do not lead to at once is left to that way.
//!
//! Steps are by elimination in one order for all lanes, that of full pivoting at the first seed: a mechanism moves in a part
//! of space in which this order stays good, and a lane in which a pivot gets small is left out.

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3};
use pulp::{Arch, Simd, WithSimd};

use super::six_hardpoint::LEGS;
use crate::pose::Pose;
use crate::solve::{LANES, Lanes, NewtonOptions, load, store, vectors};

/// Steps after which a lane is left out.
const STEPS: usize = 12;
/// A pivot below this part of the largest entry is small.
const SMALL_PIVOT: f64 = 1e-6;
/// Largest turn of a step, rad: as far as the series for the rotation goes.
const LONGEST_TURN: f64 = 1.0;

/// Lanes of a batch: twelve numbers of the pose, six lengths, the determinant of `J₁`, and how it ended.
const STATE: usize = 12;
const LENGTH: usize = STATE;
const DETERMINANT: usize = LENGTH + LEGS;
const ENDED: usize = DETERMINANT + 1;
const ROWS: usize = ENDED + 1;

/// How a lane ended, as a number.
const RUNNING: f64 = 0.0;
const ARRIVED: f64 = 1.0;
const LEFT_OUT: f64 = 2.0;

/// The points of six legs, and the order of elimination.
pub(super) struct SixLegsBatch {
    a: [Vector3<f64>; LEGS],
    b: [Vector3<f64>; LEGS],
    rows: [usize; LEGS],
    columns: [usize; LEGS],
    /// Sign of the permutations together.
    sign: f64,
}

impl SixLegsBatch {
    /// For legs with these points and with `jacobian` somewhere among the poses.
    pub(super) fn new(a: [Vector3<f64>; LEGS], b: [Vector3<f64>; LEGS], jacobian: &Matrix6<f64>) -> Self {
        let (rows, columns, sign) = pivots(jacobian);
        Self { a, b, rows, columns, sign }
    }

    /// The poses for these lengths from these seeds, each with the determinant of `J₁`; `None` for those that are left to
    /// another way.
    pub(super) fn solve(&self, lengths: &[[f64; LEGS]], seeds: &[Pose]) -> Vec<Option<(Pose, f64)>> {
        let mut found = Vec::with_capacity(seeds.len());
        for (lengths, seeds) in lengths.chunks(LANES).zip(seeds.chunks(LANES)) {
            let mut batch = [[0.0; LANES]; ROWS];
            for lane in 0..LANES {
                // Lanes without a pose repeat the last one.
                let k = lane.min(seeds.len() - 1);
                let pose = &seeds[k];
                let numbers = pose.position.iter().chain(pose.rotation.matrix().iter()).chain(&lengths[k]);
                batch.iter_mut().zip(numbers).for_each(|(row, value)| row[lane] = *value);
            }
            Arch::new().dispatch(Run { legs: self, batch: &mut batch });
            found.extend((0..seeds.len()).map(|lane| {
                let pose = Pose {
                    position: Vector3::from_fn(|k, _| batch[k][lane]),
                    rotation: Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| batch[3 + i + 3 * j][lane])),
                };
                (batch[ENDED][lane] == ARRIVED).then_some((pose, batch[DETERMINANT][lane]))
            }));
        }
        found
    }
}

/// Order of rows and of columns by full pivoting, and the sign of both permutations. Columns count by their largest entry,
/// because turns have another unit than shifts.
fn pivots(jacobian: &Matrix6<f64>) -> ([usize; LEGS], [usize; LEGS], f64) {
    let mut m = *jacobian;
    for mut column in m.column_iter_mut() {
        let largest = column.amax();
        column.unscale_mut(largest.max(f64::MIN_POSITIVE));
    }
    let (mut rows, mut columns, mut sign) = ([0, 1, 2, 3, 4, 5], [0, 1, 2, 3, 4, 5], 1.0);
    for k in 0..LEGS {
        let (mut best, mut largest) = ((k, k), -1.0);
        for i in k..LEGS {
            for j in k..LEGS {
                if m[(i, j)].abs() > largest {
                    (best, largest) = ((i, j), m[(i, j)].abs());
                }
            }
        }
        for (from, exchanged) in [(best.0, &mut rows), (best.1, &mut columns)] {
            if from != k {
                exchanged.swap(k, from);
                sign = -sign;
            }
        }
        m.swap_rows(k, best.0);
        m.swap_columns(k, best.1);
        for i in k + 1..LEGS {
            let factor = m[(i, k)] / m[(k, k)];
            for j in k..LEGS {
                m[(i, j)] -= factor * m[(k, j)];
            }
        }
    }
    (rows, columns, sign)
}

struct Run<'a> {
    legs: &'a SixLegsBatch,
    batch: &'a mut [Lanes; ROWS],
}

impl WithSimd for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for vector in 0..vectors::<S>() {
            newton(simd, self.legs, self.batch, vector);
        }
    }
}

/// Brings the poses of one vector to their lengths.
#[inline(always)]
fn newton<S: Simd>(simd: S, legs: &SixLegsBatch, batch: &mut [Lanes; ROWS], vector: usize) {
    let tolerance = simd.splat_f64s(NewtonOptions::default().step_tolerance);
    let mut pose = [simd.splat_f64s(0.0); STATE];
    for (value, row) in pose.iter_mut().zip(batch.iter()) {
        *value = load::<S>(row, vector);
    }
    let mut before = simd.splat_f64s(f64::INFINITY);
    let mut ended = simd.splat_f64s(RUNNING);
    let mut determinant = simd.splat_f64s(0.0);
    for _ in 0..STEPS {
        let (mut m, cost) = equations(simd, legs, &pose, batch, vector);
        let (delta, product, good) = eliminate(simd, legs, &mut m);
        let moved = step(simd, &pose, &delta);
        let mut longest = simd.abs_f64s(delta[0]);
        for d in &delta[1..] {
            longest = simd.select_f64s(simd.less_than_f64s(longest, simd.abs_f64s(*d)), simd.abs_f64s(*d), longest);
        }
        let running = simd.less_than_f64s(ended, simd.splat_f64s(0.5));
        // Comparisons with what is no number are false.
        let arrived = simd.and_m64s(simd.less_than_f64s(longest, tolerance), good);
        let useful = simd.and_m64s(simd.less_than_f64s(cost, before), good);
        let useful = simd.and_m64s(useful, simd.less_than_f64s(longest, simd.splat_f64s(LONGEST_TURN)));
        let moves = simd.or_m64s(arrived, useful);
        for (value, moved) in pose.iter_mut().zip(moved) {
            *value = simd.select_f64s(simd.and_m64s(running, moves), moved, *value);
        }
        determinant = simd.select_f64s(running, product, determinant);
        let next = simd.select_f64s(useful, simd.splat_f64s(RUNNING), simd.splat_f64s(LEFT_OUT));
        let next = simd.select_f64s(arrived, simd.splat_f64s(ARRIVED), next);
        ended = simd.select_f64s(running, next, ended);
        before = cost;
        if simd.reduce_min_f64s(ended) > RUNNING {
            break;
        }
    }
    for (value, row) in pose.iter().zip(batch.iter_mut()) {
        store::<S>(row, vector, *value);
    }
    store::<S>(&mut batch[DETERMINANT], vector, determinant);
    store::<S>(&mut batch[ENDED], vector, ended);
}

/// Rows of `[J₁ -f]` in the order of elimination, and `|f|²`.
#[inline(always)]
fn equations<S: Simd>(
    simd: S,
    legs: &SixLegsBatch,
    pose: &[S::f64s; STATE],
    batch: &[Lanes; ROWS],
    vector: usize,
) -> ([[S::f64s; LEGS + 1]; LEGS], S::f64s) {
    let zero = simd.splat_f64s(0.0);
    let mut m = [[zero; LEGS + 1]; LEGS];
    let mut cost = zero;
    for (row, leg) in m.iter_mut().zip(legs.rows) {
        let (a, b) = (&legs.a[leg], &legs.b[leg]);
        let (mut arm, mut l) = ([zero; 3], [zero; 3]);
        for k in 0..3 {
            let mut sum = simd.mul_f64s(pose[3 + k], simd.splat_f64s(a.x));
            sum = simd.mul_add_e_f64s(pose[6 + k], simd.splat_f64s(a.y), sum);
            sum = simd.mul_add_e_f64s(pose[9 + k], simd.splat_f64s(a.z), sum);
            arm[k] = sum;
            l[k] = simd.sub_f64s(simd.add_f64s(pose[k], sum), simd.splat_f64s(b[k]));
        }
        let mut square = simd.mul_f64s(l[0], l[0]);
        square = simd.mul_add_e_f64s(l[1], l[1], square);
        square = simd.mul_add_e_f64s(l[2], l[2], square);
        let length = simd.sqrt_f64s(square);
        let inverse = simd.div_f64s(simd.splat_f64s(1.0), length);
        let mut j = [zero; LEGS];
        for k in 0..3 {
            j[k] = simd.mul_f64s(l[k], inverse);
        }
        for k in 0..3 {
            let (p, q) = ((k + 1) % 3, (k + 2) % 3);
            j[3 + k] = simd.sub_f64s(simd.mul_f64s(arm[p], j[q]), simd.mul_f64s(arm[q], j[p]));
        }
        let residual = simd.sub_f64s(load::<S>(&batch[LENGTH + leg], vector), length);
        cost = simd.mul_add_e_f64s(residual, residual, cost);
        for (value, column) in row.iter_mut().zip(legs.columns) {
            *value = j[column];
        }
        row[LEGS] = residual;
    }
    (m, cost)
}

/// Solves the system; the solution, the determinant of `J₁`, and where no pivot is small.
#[inline(always)]
fn eliminate<S: Simd>(
    simd: S,
    legs: &SixLegsBatch,
    m: &mut [[S::f64s; LEGS + 1]; LEGS],
) -> ([S::f64s; LEGS], S::f64s, S::m64s) {
    let zero = simd.splat_f64s(0.0);
    let mut product = simd.splat_f64s(legs.sign);
    let mut inverses = [zero; LEGS];
    let mut good = simd.less_than_f64s(zero, simd.splat_f64s(1.0));
    for k in 0..LEGS {
        let pivot = m[k][k];
        good = simd.and_m64s(good, simd.less_than_f64s(simd.splat_f64s(SMALL_PIVOT), simd.abs_f64s(pivot)));
        product = simd.mul_f64s(product, pivot);
        inverses[k] = simd.div_f64s(simd.splat_f64s(1.0), pivot);
        let above = m[k];
        for row in &mut m[k + 1..] {
            let factor = simd.mul_f64s(row[k], inverses[k]);
            for (value, above) in row[k + 1..].iter_mut().zip(&above[k + 1..]) {
                *value = simd.negate_mul_add_e_f64s(factor, *above, *value);
            }
        }
    }
    let mut solution = [zero; LEGS];
    for k in (0..LEGS).rev() {
        let mut sum = m[k][LEGS];
        for j in k + 1..LEGS {
            sum = simd.negate_mul_add_e_f64s(m[k][j], solution[legs.columns[j]], sum);
        }
        solution[legs.columns[k]] = simd.mul_f64s(sum, inverses[k]);
    }
    (solution, product, good)
}

/// The pose after a motion `(δt, δω)`; the turn by the series of sine and cosine.
#[inline(always)]
fn step<S: Simd>(simd: S, pose: &[S::f64s; STATE], delta: &[S::f64s; LEGS]) -> [S::f64s; STATE] {
    let one = simd.splat_f64s(1.0);
    let w = [delta[3], delta[4], delta[5]];
    let mut square = simd.mul_f64s(w[0], w[0]);
    square = simd.mul_add_e_f64s(w[1], w[1], square);
    square = simd.mul_add_e_f64s(w[2], w[2], square);
    // sin θ/θ and (1 - cos θ)/θ² from their last terms; the angle is at most √3.
    let (mut sine, mut cosine) = (one, one);
    for k in (1..=11).rev() {
        let n = 2.0 * f64::from(k);
        let by_sine = simd.splat_f64s(1.0 / (n * (n + 1.0)));
        let by_cosine = simd.splat_f64s(1.0 / ((n + 1.0) * (n + 2.0)));
        sine = simd.negate_mul_add_e_f64s(simd.mul_f64s(square, by_sine), sine, one);
        cosine = simd.negate_mul_add_e_f64s(simd.mul_f64s(square, by_cosine), cosine, one);
    }
    let cosine = simd.mul_f64s(cosine, simd.splat_f64s(0.5));
    let mut moved = *pose;
    for k in 0..3 {
        moved[k] = simd.add_f64s(pose[k], delta[k]);
    }
    for column in 0..3 {
        let v = [pose[3 + 3 * column], pose[4 + 3 * column], pose[5 + 3 * column]];
        let first = cross(simd, &w, &v);
        let second = cross(simd, &w, &first);
        for k in 0..3 {
            let turned = simd.mul_add_e_f64s(sine, first[k], v[k]);
            moved[3 + 3 * column + k] = simd.mul_add_e_f64s(cosine, second[k], turned);
        }
    }
    moved
}

#[inline(always)]
fn cross<S: Simd>(simd: S, a: &[S::f64s; 3], b: &[S::f64s; 3]) -> [S::f64s; 3] {
    let mut out = [simd.splat_f64s(0.0); 3];
    for (k, out) in out.iter_mut().enumerate() {
        let (p, q) = ((k + 1) % 3, (k + 2) % 3);
        *out = simd.sub_f64s(simd.mul_f64s(a[p], b[q]), simd.mul_f64s(a[q], b[p]));
    }
    out
}
