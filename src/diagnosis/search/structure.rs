//! Rows that were left out, judged again beside a nameless error: what does not fit a model that lacks something is no gross
//! error of the instrument.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::diagnosis::answer::unknown::{Unknown, UnknownTest};
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::DesignMatrix;
use crate::diagnosis::linear::hypotheses::{EffectColumns, Hypotheses, ScanSite};
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::kept_rows::KeptRows;
use crate::diagnosis::linear::unit_motion::{Place, UnitMotion};
use crate::diagnosis::search::covariates::{Covariate, covariates, with_coordinates};
use crate::diagnosis::search::curve::Shape;
use crate::diagnosis::search::iteration::SearchState;
use crate::diagnosis::search::outliers::outliers;
use crate::effect::ScanPoint;

/// Degree of the polynomial at each place.
const DEGREE: usize = 2;
/// Parts of the rows that its columns may be.
const MOST: usize = 4;

/// The samples that are gross errors also beside a nameless error, if these are fewer than were left out. It may act at all
/// places of its kind, of which the finding names the one where it is seen best.
pub(crate) fn still_gross(
    subject: &Hypotheses<'_>,
    state: &SearchState,
    unknown: &Unknown,
) -> Result<Option<Vec<usize>>, DiagnoseError> {
    let kept = state.kept();
    if kept.left_out.is_empty() {
        return Ok(None);
    }
    let known = covariates(subject.data, &subject.environment.condition_kinds);
    let everything = with_coordinates(&known, subject);
    let named = |c: &&Covariate| Some(&c.name) == unknown.covariate.as_ref();
    let Some(covariate) = everything.iter().find(named) else { return Ok(None) };
    let table = &kept.table;
    let shape = Shape { test: unknown.test, from: unknown.from, period: unknown.period, degree: DEGREE };
    let functions = shape.of(covariate);
    let joints: Vec<Place> = (0..table.joints.len()).map(Place::Joint).collect();
    let places = match (unknown.leg, unknown.coordinate) {
        _ if unknown.test == UnknownTest::Misfit => return Ok(None),
        (Some(_), _) if subject.is_pose_space() => joints,
        (Some(leg), _) => vec![Place::Joint(leg)],
        (None, Some(_)) => (0..table.coordinates.len()).map(Place::Coordinate).collect(),
        (None, None) => return Ok(None),
    };
    if MOST * places.len() * functions.ncols() > kept.count() {
        return Ok(None);
    }
    let (table, group) = with_columns(table, &functions, &places);
    let groups: Vec<EffectColumns> = subject.groups.iter().cloned().chain([group]).collect();
    let nameless = Hypothesis { group: subject.groups.len(), place: 0, from: None };
    let names: Vec<Hypothesis> = state.names().iter().cloned().chain([nameless]).collect();
    let start = Arc::new(KeptRows::new(Arc::new(table), kept.left_out.clone()));
    let (judged, _) = outliers(start, &groups, &names, &state.fitting)?;
    Ok((judged.left_out.len() < kept.left_out.len()).then(|| judged.left_out.clone()))
}

/// A table with columns for each function at each place, and these columns as those of an effect.
fn with_columns(table: &DesignMatrix, functions: &DMatrix<f64>, places: &[Place]) -> (DesignMatrix, EffectColumns) {
    let (first, rows) = table.a_t.shape();
    let columns = first..first + places.len() * functions.ncols();
    let mut a_t = DMatrix::zeros(columns.end, rows);
    a_t.rows_mut(0, first).copy_from(&table.a_t);
    for (k, (begin, n)) in table.rows.iter().enumerate() {
        for row in *begin..begin + n {
            let pairs = places
                .iter()
                .flat_map(|place| functions.row(k).iter().copied().map(move |f| (*place, f)).collect::<Vec<_>>());
            for (at, (place, f)) in columns.clone().zip(pairs) {
                a_t[(at, row)] = f * table.a_t[(table.column_of(place), row)];
            }
        }
    }
    let site = ScanSite { at: ScanPoint::none(), columns, scans_rows: false };
    let effect = Arc::new(UnitMotion::Coordinates);
    let group = EffectColumns { effect, parameters: Vec::new(), alone: Vec::new(), places: vec![site] };
    (DesignMatrix { a_t, ..table.clone() }, group)
}
