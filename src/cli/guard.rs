//! What guards the machine from commands that it cannot follow, or that were not meant.

use std::fmt::{Display, Formatter};

use rayon::prelude::*;

use crate::effect::Compensated;
use crate::files::{CsvTable, Machine};
use crate::mechanism::is_reached;
use crate::units::{data_rows, show_angle, show_length};

/// Poses beyond the workspace by this part of a half-range are inside: the home of a calibrated mechanism, about which the
/// workspace lies, is not quite that of the drawing.
const MARGIN: f64 = 0.05;
/// Strokes that are named one by one.
const SHOWN: usize = 5;
const COORDINATES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// What is to say of the command for a pose, the gravest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Check {
    Ok,
    OutsideWorkspace,
    OutsideStroke,
    NotReached,
}

impl Display for Check {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Ok => "ok",
            Self::OutsideWorkspace => "outside-workspace",
            Self::OutsideStroke => "outside-stroke",
            Self::NotReached => "not-reached",
        })
    }
}

/// The checks of all commands.
pub(crate) struct Guard {
    /// The gravest finding of each row.
    pub(crate) checks: Vec<Check>,
    /// Warnings about the workspace, and about poses that are not reached.
    pub(crate) warnings: Vec<String>,
    /// Warnings about strokes, one for each joint and row.
    pub(crate) strokes: Vec<String>,
}

impl Guard {
    pub(crate) fn of(machine: &Machine, rows: &[Compensated]) -> Self {
        let mut guard = Self { checks: vec![Check::Ok; rows.len()], warnings: Vec::new(), strokes: Vec::new() };
        guard.workspace(machine, rows);
        guard.strokes(machine, rows);
        guard.reach(machine, rows);
        guard
    }

    /// True if every command may be sent.
    pub(crate) fn is_clear(&self) -> bool {
        self.checks.iter().all(|check| *check == Check::Ok)
    }

    /// The column of the table.
    pub(crate) fn column(&self) -> CsvTable {
        let rows = self.checks.iter().map(|check| vec![check.to_string()]).collect();
        CsvTable { comments: Vec::new(), header: vec!["check".into()], rows }
    }

    /// The first warnings about strokes, and how many more there are.
    pub(crate) fn shown_strokes(&self, noun: &str) -> Vec<String> {
        let more = self.strokes.len().saturating_sub(SHOWN);
        let rest = (more > 0).then(|| format!("{more} more {noun} are outside their stroke"));
        self.strokes.iter().take(SHOWN).cloned().chain(rest).collect()
    }

    fn mark(&mut self, row: usize, check: Check) {
        self.checks[row] = self.checks[row].max(check);
    }

    fn workspace(&mut self, machine: &Machine, rows: &[Compensated]) {
        let Some(workspace) = machine.workspace.as_ref().filter(|_| !machine.is_seen_from_elsewhere()) else { return };
        let mut outside = Vec::new();
        let mut most = [0.0_f64; 6];
        for (row, found) in rows.iter().enumerate() {
            let excess = workspace.excess(&found.taken);
            if (0..6).any(|k| excess[k] > MARGIN * workspace.half[k]) {
                outside.push(row);
                self.mark(row, Check::OutsideWorkspace);
                most = std::array::from_fn(|k| most[k].max(excess[k]));
            }
        }
        if outside.is_empty() {
            return;
        }
        let shown = |k: usize| if k < 3 { show_length(most[k]) } else { show_angle(most[k]) };
        let beyond = (0..6).filter(|k| most[*k] > MARGIN * workspace.half[*k]);
        let beyond: Vec<String> = beyond.map(|k| format!("{} in {}", shown(k), COORDINATES[k])).collect();
        let rows = data_rows(&outside);
        self.warnings.push(format!(
            "{rows}: outside the [workspace] and its margin of {:.0} %, by up to {} beyond the half-range",
            1e2 * MARGIN,
            beyond.join(", ")
        ));
    }

    fn strokes(&mut self, machine: &Machine, rows: &[Compensated]) {
        for (row, found) in rows.iter().enumerate() {
            for (spec, value) in machine.plain().joints().iter().zip(&found.joints) {
                if let Some([from, to]) = spec.stroke.filter(|[from, to]| value < from || value > to) {
                    let (unit, per_si) = spec.dimension.in_tables();
                    self.strokes.push(format!(
                        "data row {row}: {} would be {:.3} {unit}, outside its stroke {:.3} to {:.3} {unit}",
                        spec.name,
                        per_si * value,
                        per_si * from,
                        per_si * to
                    ));
                    self.mark(row, Check::OutsideStroke);
                }
            }
        }
    }

    fn reach(&mut self, machine: &Machine, rows: &[Compensated]) {
        let mechanism = machine.plain();
        let reached: Vec<bool> = rows.par_iter().map(|found| is_reached(mechanism, &found.taken)).collect();
        let lost: Vec<usize> = (0..rows.len()).filter(|row| !reached[*row]).collect();
        lost.iter().for_each(|row| self.mark(*row, Check::NotReached));
        if !lost.is_empty() {
            self.warnings.push(format!(
                "{}: not reached; on the straight way from home there is a singularity, and beyond it these joints hold the \
                 platform in another pose than the one that is asked for",
                data_rows(&lost)
            ));
        }
    }
}
