//! Whether a measurement has what the effects of an extended model need.

use std::collections::BTreeMap;

use crate::effect::{AvailableData, EffectContext};
use crate::files::error::FileError;
use crate::files::machine::Machine;
use crate::files::table::text_table::Table;
use crate::measurement::Sample;
use crate::units::data_rows;

/// Warnings about rows in which an effect of the mechanism file does nothing, because they lack a condition of it.
///
/// # Errors
/// [`FileError::Header`] if all rows lack it: the model would be compared without the effect, and the effect identified
/// from nothing.
pub(super) fn lacking(table: &Table, machine: &Machine, samples: &[Sample]) -> Result<Vec<String>, FileError> {
    let context = EffectContext::new(machine.plain(), machine.environment());
    let mut found: BTreeMap<(String, String), Vec<usize>> = BTreeMap::new();
    for effect in machine.effects() {
        for sample in samples {
            let names = effect.lacking(&context, &AvailableData::of_state(&sample.conditions));
            if !names.is_empty() {
                found.entry((effect.label(), names.join(", "))).or_default().push(sample.row.0);
            }
        }
    }
    let mut warnings = Vec::with_capacity(found.len());
    for ((label, names), rows) in found {
        if rows.len() == samples.len() {
            let problem = format!(
                "the effect {label} of the mechanism file needs {names}, which no row has; add the column, or delete the \
                 effect"
            );
            return Err(FileError::Header { path: table.path.clone(), problem });
        }
        let rows = data_rows(&rows);
        warnings.push(format!("{rows}: the effect {label} does nothing there, for want of {names}; fill in the cells"));
    }
    Ok(warnings)
}
