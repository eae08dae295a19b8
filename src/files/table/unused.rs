//! What stands in a measurement file and is not read: said, or refused where it must be a mistake.

use std::collections::HashSet;

use crate::conditions::TIME;
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::table::column::{Meaning, POSE_NAMES};
use crate::files::table::text_table::Table;
use crate::units::data_rows;

/// Refuses a 1σ of something that has no column.
pub(super) fn check_sigmas(table: &Table) -> Result<(), FileError> {
    let any = |wanted: &dyn Fn(&Meaning) -> bool| table.columns.iter().any(|c| wanted(&c.meaning));
    let points = any(&|m| matches!(m, Meaning::Reading(c) if c.kind == "targets" && !c.sigma));
    for (k, column) in table.columns.iter().enumerate() {
        let missing = match &column.meaning {
            // That of an axis holds for all targets.
            Meaning::Sigma(axis) => {
                let turned = *axis >= 3 && any(&|m| matches!(m, Meaning::Quaternion(_)));
                let measured = turned || points || any(&|m| *m == Meaning::Pose(*axis));
                (!measured).then(|| POSE_NAMES[*axis].to_owned())
            }
            Meaning::Reading(c) if c.sigma => {
                let same = |m: &Meaning| matches!(m, Meaning::Reading(r) if !r.sigma && (&r.kind, &r.quantity, r.axis) == (&c.kind, &c.quantity, c.axis));
                (!any(&same)).then(|| stem(&column.name))
            }
            Meaning::Covariate(name) => {
                let of = name.strip_prefix("sigma_");
                let is_of = |other: &str, of: &str| other == of || other.rsplit_once('_').is_some_and(|(o, _)| o == of);
                of.filter(|of| !table.columns.iter().any(|c| is_of(&c.name, of))).map(str::to_owned)
            }
            _ => None,
        };
        if let Some(missing) = missing {
            let problem = format!("has no column '{missing}_…' whose 1 sigma it is; add that one, or delete this");
            return Err(table.column_error(k, problem));
        }
    }
    Ok(())
}

/// The name of a column without its prefix `sigma_` and its last part.
fn stem(name: &str) -> String {
    let name = name.strip_prefix("sigma_").unwrap_or(name);
    name.rsplit_once('_').map_or(name, |(stem, _)| stem).to_owned()
}

/// The names of the columns that neither the model nor its calibration reads.
pub(super) fn not_used(table: &Table, machine: &Machine) -> Vec<String> {
    let kinds = machine.condition_kinds();
    let any = |wanted: &dyn Fn(&Meaning) -> bool| table.columns.iter().any(|c| wanted(&c.meaning));
    let joints = any(&|m| matches!(m, Meaning::Joint(_)));
    let timed = any(&|m| matches!(m, Meaning::Covariate(name) if name == TIME));
    let read_by_model = |name: &str| {
        machine.environment().sensors.iter().any(|s| s.covariate == name)
            || machine.effects().iter().any(|e| e.effect.covariates(&e.at).iter().any(|c| c == name))
    };
    let unused = |k: &usize| match &table.columns[*k].meaning {
        Meaning::Commanded(_) => joints,
        Meaning::Clock => timed,
        Meaning::Check => table.rows.iter().any(|(_, cells)| cells[*k].parse::<f64>().is_ok()),
        _ => table.columns[*k].foreign(kinds).is_some_and(|name| !read_by_model(name)),
    };
    (0..table.columns.len()).filter(unused).map(|k| table.columns[k].name.clone()).collect()
}

/// A warning if rows say the same as earlier ones to the last digit.
pub(super) fn copies(table: &Table) -> Option<String> {
    let of_row = |m: &Meaning| {
        let reading = matches!(m, Meaning::Reading(c) if !c.sigma);
        reading || matches!(m, Meaning::Joint(_) | Meaning::Commanded(_) | Meaning::Pose(_) | Meaning::Quaternion(_))
    };
    let columns: Vec<usize> = (0..table.columns.len()).filter(|k| of_row(&table.columns[*k].meaning)).collect();
    let mut seen = HashSet::new();
    let mut first = |(_, cells): &(u64, Vec<String>)| {
        seen.insert(columns.iter().map(|k| cells[*k].clone()).collect::<Vec<String>>())
    };
    let rows: Vec<usize> = (0..table.rows.len()).filter(|row| !first(&table.rows[*row])).collect();
    let (rows_are, they) =
        if rows.len() == 1 { ("row is a copy", "it counts") } else { ("rows are copies", "they count") };
    (!rows.is_empty()).then(|| {
        format!(
            "{} {rows_are} of earlier ones, with the same joints and readings to the last digit ({}); {they} as \
             independent measurements, so delete what was not measured twice",
            rows.len(),
            data_rows(&rows)
        )
    })
}
