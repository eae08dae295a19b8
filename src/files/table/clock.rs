//! Times of the rows of a table: clocks, and whether they run forwards.

use crate::conditions::{Conditions, TIME};
use crate::files::error::FileError;
use crate::files::table::cells::is_missing;
use crate::files::table::text_table::Table;
use crate::files::table::time::{is_dateless, parse_time};
use crate::units::data_rows;

/// A clock without date that goes back by more than this, s, has passed midnight.
const BACK: f64 = 3600.0;
const DAY: f64 = 86_400.0;

/// Clock times of the rows so far.
#[derive(Default)]
pub(super) struct Clock {
    first: Option<First>,
    last: f64,
    days: f64,
}

/// The first time.
#[derive(Clone, Copy)]
struct First {
    time: f64,
    dateless: bool,
}

impl Clock {
    /// Seconds since the first row that has a time; `None` where the cell is empty.
    pub(super) fn since_first(&mut self, table: &Table, row: usize, column: usize) -> Result<Option<f64>, FileError> {
        let text = &table.rows[row].1[column];
        if is_missing(text) {
            return Ok(None);
        }
        let advice = "is not a time; write 2026-03-01T12:30:00 or 12:30:00";
        let mut time = parse_time(text).ok_or_else(|| table.cell_error(row, column, advice))?;
        let dateless = is_dateless(text);
        let first = *self.first.get_or_insert(First { time, dateless });
        if first.dateless != dateless {
            let advice = match dateless {
                true => "has no date, and times before it have one; write all with a date, or none",
                false => "has a date, and times before it have none; write all with a date, or none",
            };
            return Err(table.cell_error(row, column, advice));
        }
        if dateless {
            if row > 0 && time + self.days < self.last - BACK {
                self.days += DAY;
            }
            time += self.days;
        }
        self.last = time;
        Ok(Some(time - first.time))
    }
}

/// A warning where the time of a row is before that of the row that was measured before it.
pub(super) fn backwards(states: &[Conditions]) -> Option<String> {
    let mut last = f64::NEG_INFINITY;
    let mut rows = Vec::new();
    for (row, time) in states.iter().enumerate().filter_map(|(row, state)| Some((row, state.get(TIME)?))) {
        if time < last {
            rows.push(row);
        }
        last = time;
    }
    let at = || data_rows(&rows);
    (!rows.is_empty()).then(|| {
        format!(
            "time runs backwards at {}; rows count as measured in the order of the file, so sort them by time if they \
             were not",
            at()
        )
    })
}
