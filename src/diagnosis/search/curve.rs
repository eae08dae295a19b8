//! What a nameless error looks like: its size, and its course over the covariate.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::answer::unknown::{Unknown, UnknownTest};
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::unit_motion::Place;
use crate::diagnosis::search::covariates::{Covariate, DEGREE};
use crate::diagnosis::search::unnamed::{Finding, legendre};
use crate::diagnosis::search::whole_frame::{jump_of_frame, where_it_acts};

/// A finding as an answer, with its probability. The size is half the range of its course, or the height of a jump.
pub(crate) fn unknown(model: &Model, found: &Finding<'_>, p_value: f64) -> Unknown {
    let from = match found.test {
        UnknownTest::Jump => jump_of_frame(model, found).or(found.from),
        _ => found.from,
    };
    let shape = Shape { test: found.test, from, period: found.period, degree: found.rank.max(1) };
    let functions = shape.of(found.covariate);
    let (place, steps) = where_it_acts(model, found, &functions);
    let course = course(found.covariate, &functions, &steps);
    let (low, high) =
        course.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [_, v]| (low.min(*v), high.max(*v)));
    let height = if found.test == UnknownTest::Jump { high - low } else { 0.5 * (high - low) };
    let (leg, coordinate) = match place {
        Place::Joint(k) => (Some(k), None),
        Place::Coordinate(k) => (None, Some(k)),
    };
    Unknown {
        covariate: Some(found.covariate.name.clone()),
        leg,
        coordinate,
        period: found.period,
        from,
        size: Some(height),
        course,
        ..Unknown::by(found.test, p_value)
    }
}

/// The value of the covariate and what acts there, by sample and in the order of the covariate. A step is what takes the
/// residual away, which is the model less the reading.
fn course(covariate: &Covariate, functions: &DMatrix<f64>, steps: &[f64]) -> Vec<[f64; 2]> {
    if steps.len() != functions.ncols() {
        return Vec::new();
    }
    let acting = functions * DVector::from_column_slice(steps);
    let mut course: Vec<[f64; 2]> = covariate.values.iter().zip(acting.iter()).map(|(v, a)| [*v, *a]).collect();
    course.sort_by(|a, b| a[0].total_cmp(&b[0]));
    course
}

/// How a nameless error depends on a covariate.
pub(crate) struct Shape {
    pub(crate) test: UnknownTest,
    /// The value at a jump.
    pub(crate) from: Option<f64>,
    pub(crate) period: Option<f64>,
    /// Of a polynomial.
    pub(crate) degree: usize,
}

impl Shape {
    /// Its functions of each sample (samples × functions): one for a jump, sine and cosine of a wave, polynomials.
    pub(crate) fn of(&self, covariate: &Covariate) -> DMatrix<f64> {
        let values = &covariate.values;
        match (self.test, self.from, self.period) {
            (UnknownTest::Jump, Some(from), _) => {
                DMatrix::from_fn(values.len(), 1, |i, _| if values[i] > from { 1.0 } else { 0.0 })
            }
            (UnknownTest::Wave, _, Some(period)) => DMatrix::from_fn(values.len(), 2, |i, k| {
                let (sine, cosine) = (2.0 * PI * values[i] / period).sin_cos();
                [sine, cosine][k]
            }),
            _ => {
                let scaled = covariate.scaled();
                DMatrix::from_fn(values.len(), self.degree.min(DEGREE), |i, k| legendre(scaled[i])[k])
            }
        }
    }
}
