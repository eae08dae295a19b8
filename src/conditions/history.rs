//! What was recorded in the rows of a run, and how parts follow it that take their time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::standard::TIME;
use super::state::Conditions;
use super::table::ConditionTable;

/// The covariates of all rows of a run, in file order.
#[derive(Debug, Default)]
pub struct History {
    rows: Vec<Conditions>,
    /// What was asked for, so that it is computed once: by covariate and time constant.
    followed: Mutex<BTreeMap<(String, u64), Series>>,
}

/// The value in each row; `None` where it is not known.
type Series = Arc<[Option<f64>]>;

impl PartialEq for History {
    fn eq(&self, other: &Self) -> bool {
        self.rows == other.rows
    }
}

impl History {
    /// The covariates of these states.
    pub(super) fn of(states: &[Conditions]) -> Self {
        let row = |state: &Conditions| Conditions { covariates: state.covariates.clone(), ..Conditions::unknown() };
        Self { rows: states.iter().map(row).collect(), followed: Mutex::default() }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// A covariate at a row as a part has it that follows with a first-order lag of `lag` s, `lag dy/dt = x - y`, from
    /// equilibrium at the first row: exact for a record that is linear between its rows. Rows without the covariate or
    /// without a time are not known and do not count; a row beyond the run is none.
    pub fn followed(&self, row: usize, covariate: &str, lag: f64, kinds: &ConditionTable) -> Option<f64> {
        let key = (covariate.to_owned(), lag.to_bits());
        let mut known = self.followed.lock().unwrap_or_else(PoisonError::into_inner);
        let series = known.entry(key).or_insert_with(|| self.series(covariate, lag, kinds));
        series.get(row).copied().flatten()
    }

    fn series(&self, covariate: &str, lag: f64, kinds: &ConditionTable) -> Series {
        let record =
            |(row, state): (usize, &Conditions)| Some((state.get(TIME)?, row, kinds.value(covariate, state, &[])?));
        let mut record: Vec<(f64, usize, f64)> = self.rows.iter().enumerate().filter_map(record).collect();
        record.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut all = vec![None; self.rows.len()];
        let mut before: Option<(f64, f64, f64)> = None;
        for (time, row, value) in record {
            let followed = match before {
                Some((t, x, y)) => step(time - t, [x, value], y, lag),
                None => value,
            };
            all[row] = Some(followed);
            before = Some((time, value, followed));
        }
        all.into()
    }
}

/// What `y` becomes while the record goes from `x[0]` to `x[1]` in `dt`.
fn step(dt: f64, x: [f64; 2], y: f64, lag: f64) -> f64 {
    if !(dt > 0.0) {
        return y;
    }
    // A ramp is followed `lag` behind; the start dies away.
    let behind = (x[1] - x[0]) / dt * lag;
    x[1] - behind + (y - x[0] + behind) * (-dt / lag).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(record: &[(f64, f64)]) -> History {
        let state = |(time, value): &(f64, f64)| {
            let mut state = Conditions::unknown();
            state.covariates.extend([(TIME.to_owned(), *time), ("temp_base".to_owned(), *value)]);
            state
        };
        History::of(&record.iter().map(state).collect::<Vec<_>>())
    }

    #[test]
    fn a_ramp_is_followed_as_the_closed_form_says_on_any_rows() {
        let kinds = ConditionTable::standard();
        let lag = 1800.0;
        let ramp = |t: f64| 20.0 + t / 3600.0;
        for times in [vec![0.0, 7200.0], vec![0.0, 100.0, 2000.0, 2000.0, 7200.0]] {
            let record: Vec<(f64, f64)> = times.iter().map(|t| (*t, ramp(*t))).collect();
            let history = history(&record);
            for (row, t) in times.iter().enumerate() {
                let wanted = ramp(*t) - lag / 3600.0 * (1.0 - (-t / lag).exp());
                let found = history.followed(row, "temp_base", lag, &kinds).unwrap();
                assert!((found - wanted).abs() < 1e-12, "{row}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn rows_count_in_the_order_of_time_and_gaps_are_bridged() {
        let kinds = ConditionTable::standard();
        let ordered = history(&[(0.0, 20.0), (600.0, 23.0), (900.0, 21.0)]);
        let shuffled = history(&[(900.0, 21.0), (0.0, 20.0), (600.0, 23.0)]);
        for (row, other) in [(0, 1), (1, 2), (2, 0)] {
            let of = |h: &History, row| h.followed(row, "temp_base", 1000.0, &kinds);
            assert_eq!(of(&ordered, row), of(&shuffled, other));
        }
        let mut gap = ordered;
        gap.rows[1].covariates.remove("temp_base");
        gap.followed = Mutex::default();
        assert_eq!(gap.followed(1, "temp_base", 1000.0, &kinds), None);
        assert!(gap.followed(2, "temp_base", 1000.0, &kinds).is_some_and(|v| v > 20.0 && v < 21.0));
        assert_eq!(gap.followed(3, "temp_base", 1000.0, &kinds), None);
    }
}
