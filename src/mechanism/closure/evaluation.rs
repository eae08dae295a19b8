//! Values and derivatives of a closure by dual numbers, eight derivatives in one pass.

use nalgebra::{DMatrix, DVector, Matrix3, SVector, Vector3};
use num_dual::{Derivative, DualSVec64};

use super::pattern::Pattern;
use super::{Closure, State};
use crate::conditions::Conditions;
use crate::pose::Pose;

/// Derivatives that travel in one pass.
const LANES: usize = 8;

type Dual = DualSVec64<LANES>;

/// Where a closure is evaluated.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) pose: &'a Pose,
    pub(super) joints: &'a [f64],
    /// All parameters, fixed ones included.
    pub(super) parameters: &'a [f64],
    pub(super) passive: &'a [f64],
    pub(super) at: &'a Conditions,
}

/// Raw derivatives of a closure, passive coordinates not yet eliminated.
#[derive(Clone, Debug)]
pub(super) struct Derivatives {
    pub(super) residual: DVector<f64>,
    /// Along small motions.
    pub(super) motion: DMatrix<f64>,
    /// Along identified parameters, then joints.
    pub(super) columns: DMatrix<f64>,
    pub(super) passive: DMatrix<f64>,
}

/// What a lane carries.
#[derive(Clone, Copy, PartialEq)]
enum Direction {
    Motion(usize),
    Passive(usize),
    Colour(usize),
}

/// Which derivatives are wanted.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Wanted {
    /// Along the motion of the platform.
    Motion,
    /// Along the passive coordinates.
    Passive,
    /// All.
    All,
}

fn dual(value: f64, lane: Option<usize>) -> Dual {
    let mut x = Dual::from_re(value);
    if let Some(lane) = lane {
        x = x.derivative(lane);
    }
    x
}

/// The residual and its derivatives; matrices that are not wanted have no columns.
pub(super) fn derivatives<C: Closure>(
    closure: &C,
    pattern: &Pattern,
    free: &[usize],
    equations: usize,
    place: &Place<'_>,
    wanted: Wanted,
) -> Derivatives {
    let p = place.passive.len();
    let motions = (wanted != Wanted::Passive).then_some(0..6).into_iter().flatten().map(Direction::Motion);
    let passives = (wanted != Wanted::Motion || p > 0).then_some(0..p).into_iter().flatten().map(Direction::Passive);
    let colours = (wanted == Wanted::All).then_some(0..pattern.colours).into_iter().flatten().map(Direction::Colour);
    let directions: Vec<Direction> = motions.chain(passives).chain(colours).collect();
    let mut out = Derivatives {
        residual: DVector::zeros(equations),
        motion: DMatrix::zeros(equations, if wanted == Wanted::Passive { 0 } else { 6 }),
        columns: DMatrix::zeros(equations, if wanted == Wanted::All { pattern.colour.len() } else { 0 }),
        passive: DMatrix::zeros(equations, p),
    };
    let mut work = Work::new(place, equations);
    for lanes in directions.chunks(LANES) {
        work.seed(place, pattern, free, lanes);
        work.run(closure, place.at);
        work.collect(pattern, lanes, &mut out);
    }
    for (to, value) in out.residual.iter_mut().zip(&work.out) {
        *to = value.re;
    }
    out
}

/// Dual numbers of one pass.
struct Work {
    position: Vector3<Dual>,
    rotation: Matrix3<Dual>,
    joints: Vec<Dual>,
    parameters: Vec<Dual>,
    passive: Vec<Dual>,
    out: Vec<Dual>,
}

impl Work {
    fn new(place: &Place<'_>, equations: usize) -> Self {
        let constant = |values: &[f64]| values.iter().map(|v| Dual::from_re(*v)).collect();
        Self {
            position: place.pose.position.map(Dual::from_re),
            rotation: place.pose.rotation.matrix().map(Dual::from_re),
            joints: constant(place.joints),
            parameters: constant(place.parameters),
            passive: constant(place.passive),
            out: vec![Dual::from_re(0.0); equations],
        }
    }

    fn seed(&mut self, place: &Place<'_>, pattern: &Pattern, free: &[usize], lanes: &[Direction]) {
        let lane = |wanted: Direction| lanes.iter().position(|d| *d == wanted);
        for k in 0..3 {
            self.position[k] = dual(place.pose.position[k], lane(Direction::Motion(k)));
        }
        let r = place.pose.rotation.matrix();
        let turns: [Option<usize>; 3] = std::array::from_fn(|k| lane(Direction::Motion(3 + k)));
        for column in 0..3 {
            let v = r.column(column);
            // d(R e) = ω × (R e)
            let moved = [Vector3::new(0.0, -v[2], v[1]), Vector3::new(v[2], 0.0, -v[0]), Vector3::new(-v[1], v[0], 0.0)];
            for row in 0..3 {
                let mut eps = SVector::<f64, LANES>::zeros();
                for (k, lane) in turns.iter().enumerate() {
                    if let Some(lane) = lane {
                        eps[*lane] = moved[k][row];
                    }
                }
                let turning = turns.iter().any(Option::is_some);
                let eps = if turning { Derivative::some(eps) } else { Derivative::none() };
                self.rotation[(row, column)] = Dual::new(v[row], eps);
            }
        }
        for (k, value) in place.passive.iter().enumerate() {
            self.passive[k] = dual(*value, lane(Direction::Passive(k)));
        }
        let colours: Vec<Option<usize>> = (0..pattern.colours).map(|k| lane(Direction::Colour(k))).collect();
        for (column, p) in free.iter().enumerate() {
            self.parameters[*p] = dual(place.parameters[*p], colours[pattern.colour[column]]);
        }
        for (k, value) in place.joints.iter().enumerate() {
            self.joints[k] = dual(*value, colours[pattern.colour[free.len() + k]]);
        }
    }

    fn run<C: Closure>(&mut self, closure: &C, at: &Conditions) {
        let state = State {
            position: self.position,
            rotation: self.rotation,
            joints: &self.joints,
            parameters: &self.parameters,
            passive: &self.passive,
            conditions: at,
        };
        closure.residual(&state, &mut self.out);
    }

    fn collect(&self, pattern: &Pattern, lanes: &[Direction], out: &mut Derivatives) {
        let eps = |row: usize, lane: usize| -> f64 {
            self.out[row].eps.clone().unwrap_generic(nalgebra::Const::<LANES>, nalgebra::U1)[lane]
        };
        for (lane, direction) in lanes.iter().enumerate() {
            match direction {
                Direction::Motion(k) => (0..self.out.len()).for_each(|row| out.motion[(row, *k)] = eps(row, lane)),
                Direction::Passive(k) => (0..self.out.len()).for_each(|row| out.passive[(row, *k)] = eps(row, lane)),
                Direction::Colour(colour) => {
                    for (column, of_column) in pattern.rows.iter().enumerate().filter(|(c, _)| pattern.colour[*c] == *colour) {
                        of_column.iter().for_each(|row| out.columns[(*row, column)] = eps(*row, lane));
                    }
                }
            }
        }
    }
}
