//! Whether a measurement has what the effects of an extended model need.

use std::collections::BTreeMap;

use crate::effect::{AvailableData, EffectContext};
use crate::files::machine::Machine;
use crate::measurement::Sample;
use crate::units::data_rows;

/// Warnings about rows in which an effect of the mechanism file does nothing, because they lack a condition of it.
pub(super) fn lacking(machine: &Machine, samples: &[Sample]) -> Vec<String> {
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
    let said = |((label, names), rows): (&(String, String), &Vec<usize>)| match rows.len() == samples.len() {
        true => format!(
            "the effect {label} of the mechanism file does nothing: it needs {names}, which no row has; add the column, or \
             delete the effect"
        ),
        false => {
            let rows = data_rows(rows);
            format!("{rows}: the effect {label} does nothing there, for want of {names}; fill in the cells")
        }
    };
    found.iter().map(said).collect()
}
