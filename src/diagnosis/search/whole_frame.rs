//! Is it the whole frame that moves, rather than one leg or one coordinate? A frame that moves in a direction of its own looks
//! like the leg that moves the platform most like it.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::score_test::ScoreTest;
use crate::diagnosis::linear::unit_motion::Place;
use crate::diagnosis::search::unnamed::{FEW, Finding, worth};

/// Where a finding acts, and the steps of its functions there: at its place, or, if it explains enough more, in all
/// coordinates at once, of which the one is named where it is largest in units of the noise.
pub(super) fn where_it_acts(model: &Model, found: &Finding<'_>, functions: &DMatrix<f64>) -> (Place, Vec<f64>) {
    let table = model.table();
    let places = table.whole_frame();
    let w = functions.ncols();
    let mut columns = DMatrix::zeros(table.r.len(), places.len() * w);
    for (sample, (first, n)) in table.rows.iter().enumerate().filter(|(k, _)| !model.kept.is_out(*k)) {
        for row in *first..first + n {
            for at in 0..places.len() * w {
                let unit = table.a_t[(table.column_of(places[at / w]), row)];
                columns[(row, at)] = functions[(sample, at % w)] * unit;
            }
        }
    }
    let square = columns.tr_mul(&columns);
    let moment = columns.tr_mul(&model.residual);
    let projected = model.projected(columns);
    let asked = ScoreTest::of(&square, &projected.tr_mul(&projected), &moment, model.inflation());
    let (gain, rank) = asked.gain();
    if rank > found.rank && worth_of_frame(model, found, (gain, rank)) > found.worth {
        let values = asked.values();
        let size = |k: usize| (0..w).map(|f| values[k * w + f].powi(2) * square[(k * w + f, k * w + f)]).sum::<f64>();
        if let Some(k) = (0..places.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))) {
            return (places[k], values[k * w..(k + 1) * w].to_vec());
        }
    }
    let steps = model.samples_at(found.place).ask(functions, w).first().map(ScoreTest::values);
    (found.place, steps.unwrap_or_default())
}

/// The value of its covariate at which the whole frame jumps, if that explains more than the jump at one place.
pub(super) fn jump_of_frame(model: &Model, found: &Finding<'_>) -> Option<f64> {
    let values = &found.covariate.values;
    let mut order = model.kept.samples();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let worths = gains_from(model, &order).into_iter().map(|gain| worth_of_frame(model, found, gain)).enumerate();
    let is_place = |at: usize| at >= FEW && at + FEW <= order.len() && values[order[at]] != values[order[at - 1]];
    let (at, worth) = worths.filter(|(at, _)| is_place(*at)).max_by(|a, b| a.1.total_cmp(&b.1))?;
    (worth > found.worth).then(|| 0.5 * (values[order[at - 1]] + values[order[at]]))
}

/// What it is worth to move the whole frame: what a finding costs beside its columns, that costs too.
fn worth_of_frame(model: &Model, found: &Finding<'_>, (gain, rank): (f64, usize)) -> f64 {
    let beside = (worth(model, found.gain, found.rank as f64) - found.worth).max(0.0);
    worth(model, gain, rank as f64) - beside
}

/// What a step of the whole frame gains from each place of an order to its end, and in how many directions.
fn gains_from(model: &Model, order: &[usize]) -> Vec<(f64, usize)> {
    let table = model.table();
    let columns: Vec<usize> = table.whole_frame().into_iter().map(|place| table.column_of(place)).collect();
    let p = columns.len();
    let mut square = DMatrix::zeros(p, p);
    let mut moment = DVector::zeros(p);
    let mut w: Option<DMatrix<f64>> = None;
    let mut gains = Vec::with_capacity(order.len());
    for (first, n) in order.iter().rev().map(|k| table.rows[*k]) {
        let x = DMatrix::from_fn(n, p, |row, k| table.a_t[(columns[k], first + row)]);
        let q_t = model.leverage(first, n);
        let w = w.get_or_insert_with(|| DMatrix::zeros(q_t.nrows(), p));
        w.gemm(1.0, &q_t, &x, 1.0);
        square.gemm_tr(1.0, &x, &x, 1.0);
        moment.gemv_tr(1.0, &x, &model.residual.rows(first, n), 1.0);
        gains.push(ScoreTest::of(&square, &(&square - w.tr_mul(w)), &moment, model.inflation()).gain());
    }
    gains.reverse();
    gains
}
