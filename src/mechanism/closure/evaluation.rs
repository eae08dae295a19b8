//! Values and derivatives of a closure by dual numbers, eight derivatives in one pass.

use std::cell::Cell;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::lanes::{LANES, Lanes};
use super::pattern::Pattern;
use super::{Closure, State};
use crate::conditions::Conditions;
use crate::pose::Pose;

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
    /// `columns` of all rows, kept where passive coordinates were eliminated from the others.
    pub(super) unreduced: Option<DMatrix<f64>>,
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

/// Which direction travels where: motions first, then passive coordinates, then colours, eight to a pass.
struct Plan {
    motions: usize,
    passives: usize,
    colours: usize,
}

impl Plan {
    fn passes(&self) -> usize {
        (self.motions + self.passives + self.colours).div_ceil(LANES)
    }

    /// The part of `first..first + count` that travels in a pass: lane of its first member, and the members.
    fn part(first: usize, count: usize, pass: usize) -> (usize, std::ops::Range<usize>) {
        let (from, to) = (pass * LANES, (pass + 1) * LANES);
        let start = from.clamp(first, first + count);
        let end = to.clamp(first, first + count);
        (start.saturating_sub(from), start - first..end - first)
    }

    fn motion_part(&self, pass: usize) -> (usize, std::ops::Range<usize>) {
        Self::part(0, self.motions, pass)
    }

    fn passive_part(&self, pass: usize) -> (usize, std::ops::Range<usize>) {
        Self::part(self.motions, self.passives, pass)
    }

    fn colour_part(&self, pass: usize) -> (usize, std::ops::Range<usize>) {
        Self::part(self.motions + self.passives, self.colours, pass)
    }
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
    let plan = Plan {
        motions: if wanted == Wanted::Passive { 0 } else { 6 },
        passives: place.passive.len(),
        colours: if wanted == Wanted::All { pattern.colours } else { 0 },
    };
    let columns = if wanted == Wanted::All { pattern.colour.len() } else { 0 };
    let mut out = Derivatives {
        residual: DVector::zeros(equations),
        motion: DMatrix::zeros(equations, plan.motions),
        columns: DMatrix::zeros(equations, columns),
        passive: DMatrix::zeros(equations, plan.passives),
        unreduced: None,
    };
    let mut work = Work::new(place, equations);
    for pass in 0..plan.passes() {
        work.seed(place, pattern, free, &plan, pass, 1.0);
        work.run(closure, place.at);
        work.collect(pattern, &plan, pass, &mut out);
        if pass + 1 < plan.passes() {
            work.seed(place, pattern, free, &plan, pass, 0.0);
        }
    }
    for (to, value) in out.residual.iter_mut().zip(&work.out) {
        *to = value.re;
    }
    out
}

/// Dual numbers of one evaluation.
struct Work {
    position: Vector3<Lanes>,
    rotation: Matrix3<Lanes>,
    /// Joints, then parameters, then passive coordinates.
    variables: Vec<Lanes>,
    joints: usize,
    parameters: usize,
    out: Vec<Lanes>,
}

thread_local! {
    /// Variables and rows of the evaluation before: their memory is used again.
    static BEFORE: Cell<(Vec<Lanes>, Vec<Lanes>)> = const { Cell::new((Vec::new(), Vec::new())) };
}

impl Drop for Work {
    fn drop(&mut self) {
        BEFORE.set((std::mem::take(&mut self.variables), std::mem::take(&mut self.out)));
    }
}

impl Work {
    fn new(place: &Place<'_>, equations: usize) -> Self {
        let (mut variables, mut out) = BEFORE.take();
        variables.clear();
        for part in [place.joints, place.parameters, place.passive] {
            variables.extend(part.iter().map(|v| Lanes::constant(*v)));
        }
        out.clear();
        out.resize(equations, Lanes::constant(0.0));
        Self {
            position: place.pose.position.map(Lanes::constant),
            rotation: place.pose.rotation.matrix().map(Lanes::constant),
            variables,
            joints: place.joints.len(),
            parameters: place.parameters.len(),
            out,
        }
    }

    /// Sets the derivatives of the variables of a pass, or with `on = 0` takes them away.
    fn seed(&mut self, place: &Place<'_>, pattern: &Pattern, free: &[usize], plan: &Plan, pass: usize, on: f64) {
        let (lane, motions) = plan.motion_part(pass);
        for (k, lane) in motions.zip(lane..) {
            if k < 3 {
                self.position[k].eps[lane] = on;
                continue;
            }
            // d(R e) = ω × (R e)
            let (x, y) = ((k - 3 + 1) % 3, (k - 3 + 2) % 3);
            let r = place.pose.rotation.matrix();
            for column in 0..3 {
                self.rotation[(x, column)].eps[lane] = -on * r[(y, column)];
                self.rotation[(y, column)].eps[lane] = on * r[(x, column)];
            }
        }
        let (lane, passives) = plan.passive_part(pass);
        let first = self.joints + self.parameters;
        passives.zip(lane..).for_each(|(k, lane)| self.variables[first + k].eps[lane] = on);
        let (lane, colours) = plan.colour_part(pass);
        if colours.is_empty() {
            return;
        }
        let places = free.iter().map(|p| self.joints + p).chain(0..self.joints);
        for (variable, colour) in places.zip(&pattern.colour) {
            if colours.contains(colour) {
                self.variables[variable].eps[lane + colour - colours.start] = on;
            }
        }
    }

    fn run<C: Closure>(&mut self, closure: &C, at: &Conditions) {
        let (joints, rest) = self.variables.split_at(self.joints);
        let (parameters, passive) = rest.split_at(self.parameters);
        let state =
            State { position: self.position, rotation: self.rotation, joints, parameters, passive, conditions: at };
        pulp::Arch::new().dispatch(Pass { closure, state: &state, out: &mut self.out });
    }

    fn collect(&self, pattern: &Pattern, plan: &Plan, pass: usize, out: &mut Derivatives) {
        let (lane, motions) = plan.motion_part(pass);
        for (k, lane) in motions.zip(lane..) {
            out.motion.column_mut(k).iter_mut().zip(&self.out).for_each(|(to, row)| *to = row.eps[lane]);
        }
        let (lane, passives) = plan.passive_part(pass);
        for (k, lane) in passives.zip(lane..) {
            out.passive.column_mut(k).iter_mut().zip(&self.out).for_each(|(to, row)| *to = row.eps[lane]);
        }
        let (lane, colours) = plan.colour_part(pass);
        if colours.is_empty() {
            return;
        }
        for (column, colour) in pattern.colour.iter().enumerate() {
            if colours.contains(colour) {
                let lane = lane + colour - colours.start;
                for row in pattern.rows(column) {
                    out.columns[(*row, column)] = self.out[*row].eps[lane];
                }
            }
        }
    }
}

/// One evaluation, compiled for each set of vector instructions.
struct Pass<'a, C> {
    closure: &'a C,
    state: &'a State<'a, Lanes>,
    out: &'a mut [Lanes],
}

impl<C: Closure> pulp::WithSimd for Pass<'_, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.closure.residual(self.state, self.out);
    }
}
