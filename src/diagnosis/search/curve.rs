//! What a nameless error looks like: its size, and its course over the covariate.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use crate::diagnosis::answer::result::{Unknown, UnknownTest};
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::unit_motion::Place;
use crate::diagnosis::search::unnamed::{Finding, legendre};

/// A finding as an answer, with its probability. The size is half the range of its course, or the height of a jump.
pub(crate) fn unknown(model: &Model, found: &Finding<'_>, p_value: f64) -> Unknown {
    let course = course(model, found);
    let (low, high) =
        course.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [_, v]| (low.min(*v), high.max(*v)));
    let height = if found.test == UnknownTest::Jump { high - low } else { 0.5 * (high - low) };
    let (leg, coordinate) = match found.place {
        Place::Joint(k) => (Some(k), None),
        Place::Coordinate(k) => (None, Some(k)),
    };
    Unknown {
        covariate: Some(found.covariate.name.clone()),
        leg,
        coordinate,
        period: found.period,
        from: found.from,
        size: Some(height),
        course,
        ..Unknown::by(found.test, p_value)
    }
}

/// The value of the covariate and what acts there, by sample and in the order of the covariate.
fn course(model: &Model, found: &Finding<'_>) -> Vec<[f64; 2]> {
    let values = &found.covariate.values;
    let scaled = found.covariate.scaled();
    let degree = found.rank.max(1);
    let functions: Vec<Vec<f64>> = match found.test {
        UnknownTest::Jump => {
            let from = found.from.unwrap_or(f64::NAN);
            values.iter().map(|v| vec![if *v > from { 1.0 } else { 0.0 }]).collect()
        }
        UnknownTest::Wave => {
            let turn = found.period.map_or(f64::NAN, |period| 2.0 * PI / period);
            values.iter().map(|v| vec![(turn * v).sin(), (turn * v).cos()]).collect()
        }
        _ => scaled.iter().map(|x| legendre(*x)[..degree.min(4)].to_vec()).collect(),
    };
    let width = functions.first().map_or(0, Vec::len);
    if width == 0 {
        return Vec::new();
    }
    let matrix = DMatrix::from_fn(functions.len(), width, |i, k| functions[i][k]);
    // A score is the step that takes the residual away; the residual is the model less the reading.
    let steps = model.samples_at(found.place).ask(&matrix, width).first().map(|asked| asked.values());
    let steps = steps.unwrap_or_default();
    let mut course: Vec<[f64; 2]> = values
        .iter()
        .zip(&functions)
        .map(|(value, f)| [*value, f.iter().zip(&steps).map(|(f, s)| f * s).sum()])
        .collect();
    course.sort_by(|a, b| a[0].total_cmp(&b[0]));
    course
}
