//! Parameters fitted to the closure at measured poses. No forward kinematics is needed, so that the mechanism need not reach
//! the poses beforehand: it is where an identification starts if it does not, and tells what a reading of a file leaves.
//!
//! At a measured pose `x` the closure `f(c, q, x)` leaves a residual, and `J₁⁻¹ f` is the motion by which the pose would have
//! to move; its columns are `J₁⁻¹ ∂f/∂c`. With `W` one over the noise, `B = W J₁⁻¹`, and `P = ∂f/∂c`, which has one entry in
//! a column where a parameter is that of a leg, the normal equations sum `Pᵀ (Bᵀ B) P`. More than six equations are turned
//! into the six that move the pose. The first look, which tries forty
//! readings of a file, sums entry by entry of `P`. The others, whose results are used, multiply the written-out columns
//! `B P`: a wrong reading leaves a fit so badly posed that the order of the sums changes its misfit in the second digit.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix6, Vector6};

use crate::conditions::Conditions;
use crate::identification::problem::prior::Prior;
use crate::measurement::Frames;
use crate::mechanism::{Linearization, Mechanism};
use crate::pose::Pose;

/// A row this many medians away counts for less.
const FAR: f64 = 4.0;

/// How closely a reading is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// At a few rows.
    First,
    /// At all rows.
    Second,
    /// At all rows, until the parameters are good enough to go on from.
    Start,
}

impl Look {
    /// Steps of the fit.
    fn steps(self) -> usize {
        match self {
            Self::First => 2,
            Self::Second => 5,
            Self::Start => 10,
        }
    }
}

/// A row of joints and the pose that was measured with them.
pub(crate) struct ClosureRow<'a> {
    pub(crate) joints: &'a [f64],
    /// Tracker's frame.
    pub(crate) pose: Pose,
    pub(crate) at: &'a Conditions,
}

/// What a fit leaves.
pub(crate) struct ClosureFitted {
    /// The parameters.
    pub(crate) values: Vec<f64>,
    /// Median length of the whitened misfit of a row.
    pub(crate) misfit: f64,
    /// What the prior says of the parameters: their deviations over its widths, squared and summed.
    pub(crate) penalty: f64,
    /// Length of the whitened misfit of each row; not finite where it has no number.
    pub(crate) lengths: Vec<f64>,
}

/// Fits of the parameters of a mechanism.
pub(crate) struct ClosureFit<'a> {
    mechanism: &'a dyn Mechanism,
    /// Precision of the prior.
    precision: DMatrix<f64>,
    /// Gradient of the prior at the values of the mechanism.
    gradient: DVector<f64>,
    /// One over the σ of positions and angles.
    weights: Vector6<f64>,
}

/// The rows at the present parameters.
#[derive(Default)]
struct Rows {
    /// `B f` of each row.
    residuals: Vec<Vector6<f64>>,
    /// `B` of each row.
    inverses: Vec<Matrix6<f64>>,
    /// Entries of `P` of each row that are not zero: equation, parameter, value.
    entries: Vec<(usize, usize, f64)>,
    /// Where the entries of each row end.
    ends: Vec<usize>,
}

impl Rows {
    fn clear(&mut self) {
        self.residuals.clear();
        self.inverses.clear();
        self.entries.clear();
        self.ends.clear();
    }

    /// The entries of `P` of each row.
    fn entries(&self) -> impl Iterator<Item = &[(usize, usize, f64)]> {
        let first = std::iter::once(0).chain(self.ends.iter().copied());
        first.zip(&self.ends).map(|(first, end)| &self.entries[first..*end])
    }

    /// `Σ wₖ² Pᵀ Bᵀ B P` and `Σ wₖ² Pᵀ Bᵀ B f`, by the columns `wₖ B P`.
    fn written_out(&self, n: usize, weights: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let mut a = DMatrix::zeros(6 * weights.len(), n);
        let mut r = DVector::zeros(6 * weights.len());
        for ((k, weight), entries) in weights.iter().enumerate().zip(self.entries()) {
            // Rows without a number, and rows that are far from the others, must not lead the fit.
            if !(*weight > 0.0) {
                continue;
            }
            r.fixed_rows_mut::<6>(6 * k).copy_from(&(self.residuals[k] * *weight));
            for (equation, parameter, value) in entries {
                let mut to = a.fixed_view_mut::<6, 1>(6 * k, *parameter);
                to.axpy(*value, &self.inverses[k].column(*equation), 1.0);
            }
            if *weight < 1.0 {
                a.fixed_rows_mut::<6>(6 * k).scale_mut(*weight);
            }
        }
        (a.transpose() * &a, a.tr_mul(&r))
    }

    /// The same by the entries; of the matrix only the lower triangle is filled.
    fn summed(&self, n: usize, weights: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        // Symmetric: rows of the lower triangle are columns of the upper one.
        let mut upper = DMatrix::zeros(n, n);
        let mut moment = DVector::zeros(n);
        let mut product = vec![0.0; 6 * n];
        for ((k, weight), entries) in weights.iter().enumerate().zip(self.entries()) {
            if !(*weight > 0.0) {
                continue;
            }
            let inverse = self.inverses[k] * *weight;
            let square = inverse.tr_mul(&inverse);
            let along = inverse.tr_mul(&(self.residuals[k] * *weight));
            product.fill(0.0);
            for (equation, parameter, value) in entries {
                for i in 0..6 {
                    product[i * n + parameter] += square[(i, *equation)] * value;
                }
            }
            for (equation, parameter, value) in entries {
                let row = &product[equation * n..equation * n + parameter + 1];
                let to = &mut upper.as_mut_slice()[parameter * n..parameter * n + parameter + 1];
                to.iter_mut().zip(row).for_each(|(to, p)| *to += value * p);
                moment[*parameter] += value * along[*equation];
            }
        }
        (upper.transpose(), moment)
    }
}

impl<'a> ClosureFit<'a> {
    pub(crate) fn new(mechanism: &'a dyn Mechanism, prior: &Prior, weights: Vector6<f64>) -> Self {
        let (precision, gradient, _) = prior.quadratic(mechanism.values(), mechanism.parameters().len());
        Self { mechanism, precision, gradient, weights }
    }

    /// Parameters that fit rows best, with their misfit; `None` if most rows have no number.
    pub(crate) fn fit(&self, read: &[ClosureRow<'_>], frames: &Frames, look: Look) -> Option<ClosureFitted> {
        let steps = look.steps();
        let nominal = self.mechanism.values();
        let n = nominal.len();
        let mut c = nominal.to_vec();
        let mut work = Linearization::sized_for(self.mechanism);
        let mut rows = Rows::default();
        for step in 0..=steps {
            self.linearize(read, frames, &c, step < steps, &mut work, &mut rows);
            let lengths: Vec<f64> = rows.residuals.iter().map(Vector6::norm).collect();
            let usual = median(&lengths)?;
            if step == steps {
                // An exact file leaves rounding; far below the noise there is nothing to compare.
                let shift = DVector::from_fn(n, |k, _| c[k] - nominal[k]);
                let penalty = shift.dot(&(&self.precision * &shift));
                return Some(ClosureFitted { values: c, misfit: usual.max(1e-3), penalty, lengths });
            }
            let weight = |length: &f64| if length.is_finite() { (FAR * usual / length).min(1.0) } else { 0.0 };
            let weights: Vec<f64> = lengths.iter().map(weight).collect();
            let (mut normal, moment) = match look {
                Look::First => rows.summed(n, &weights),
                Look::Second | Look::Start => rows.written_out(n, &weights),
            };
            normal += &self.precision;
            for k in 0..n {
                normal[(k, k)] *= 1.0 + 1e-12;
            }
            let shift = DVector::from_fn(n, |k, _| c[k] - nominal[k]);
            let gradient = &self.gradient + &self.precision * shift;
            let delta = Cholesky::new(normal)?.solve(&(moment + gradient));
            c.iter_mut().zip(delta.iter()).for_each(|(c, d)| *c -= d);
        }
        None
    }

    /// The rows at parameters `c`, with or without their columns.
    fn linearize(
        &self,
        read: &[ClosureRow<'_>],
        frames: &Frames,
        c: &[f64],
        columns: bool,
        work: &mut Linearization,
        rows: &mut Rows,
    ) {
        rows.clear();
        for row in read {
            self.mechanism.linearize(c, row.joints, &frames.platform(&row.pose), row.at, work);
            if work.residual.len() > 6 {
                six_of(work);
            }
            // The motion by which the measured pose would have to move, and its columns.
            let inverse = work.motion.fixed_view::<6, 6>(0, 0).into_owned().try_inverse();
            let mut inverse = inverse.map_or_else(|| Matrix6::repeat(f64::NAN), |m| -m);
            for (mut row, w) in inverse.row_iter_mut().zip(self.weights.iter()) {
                row *= *w;
            }
            rows.residuals.push(inverse * work.residual.fixed_rows::<6>(0));
            if !columns {
                continue;
            }
            rows.inverses.push(inverse);
            for (parameter, column) in work.parameters.column_iter().enumerate() {
                let entries = column.iter().enumerate().filter(|(_, v)| **v != 0.0);
                rows.entries.extend(entries.map(|(equation, value)| (equation, parameter, *value)));
            }
            rows.ends.push(rows.entries.len());
        }
    }
}

/// Of more than six equations the six combinations that move the pose, `Qᵀ f` with `J₁ = Q R`, in the place of the first.
fn six_of(work: &mut Linearization) {
    let qr = work.motion.clone().qr();
    work.motion.rows_mut(0, 6).copy_from(&qr.r());
    let q = qr.q();
    let residual = q.tr_mul(&work.residual);
    work.residual.rows_mut(0, 6).copy_from(&residual);
    let parameters = q.tr_mul(&work.parameters);
    work.parameters.rows_mut(0, 6).copy_from(&parameters);
    work.parameters.rows_mut(6, work.motion.nrows() - 6).fill(0.0);
}

/// The median of what is finite, if that is most of it.
fn median(values: &[f64]) -> Option<f64> {
    let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    (2 * finite.len() > values.len()).then(|| finite[finite.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the written-out columns, with a row that does not count and a parameter in two equations.
    #[test]
    fn the_sums_are_those_of_the_written_out_columns() {
        let n = 5;
        let mut rows = Rows::default();
        let weights = [1.0, 0.5, 0.0];
        let (mut normal, mut moment) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (k, weight) in weights.iter().enumerate() {
            let inverse = Matrix6::from_fn(|i, j| ((3 * i + 5 * j + i * j + k) % 7) as f64 - 3.0);
            let residual = Vector6::from_fn(|i, _| i as f64 - 2.5);
            let mut p = DMatrix::zeros(6, n);
            for (equation, parameter, value) in [(0, 0, 2.0), (3, 1, -1.0), (1, 2, 0.5), (5, 2, 4.0), (2, 4, 3.0)] {
                p[(equation, parameter)] = value;
                rows.entries.push((equation, parameter, value));
            }
            rows.ends.push(rows.entries.len());
            rows.inverses.push(inverse);
            rows.residuals.push(residual);
            let a = DMatrix::from_iterator(6, 6, inverse.iter().copied()) * p * *weight;
            normal += a.tr_mul(&a);
            moment += a.tr_mul(&DVector::from_iterator(6, residual.iter().map(|v| v * weight)));
        }
        for (found, of_residual) in [rows.summed(n, &weights), rows.written_out(n, &weights)] {
            assert!((found.lower_triangle() - normal.lower_triangle()).amax() < 1e-12 * normal.amax());
            assert!((of_residual - &moment).amax() < 1e-12 * moment.amax());
        }
    }
}
