//! `paracal settle`.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::conditions::{ConditionKind, Role};
use crate::diagnosis::{MeasurementPlan, Verdict, diagnose, settle};
use crate::files::{CsvTable, Machine, number};
use crate::report::{json, text};
use crate::units::{Dimension, Unit};
use anyhow::{Result, anyhow};

use crate::cli::case::CaseArgs;
use crate::cli::common::verdict;
use crate::cli::ui::Ui;
use crate::files::{JointsAndPose, joints_and_poses};

/// Arguments of `settle`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal settle mechanisms/table5.toml warm-up.csv -o extra.csv")]
pub(crate) struct Args {
    #[command(flatten)]
    case: CaseArgs,
    /// Table to write: the best plan, with joints to command, poses, and the conditions to wait for.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let (case, mut outputs) = args.case.read(&[args.output.as_ref()], ui)?;
    let (machine, question) = (&case.machine, case.question());
    let progress = ui.progress("looking for measurements that break the tie".into());
    let found = diagnose(&question).map_err(|error| case.about(error))?;
    let plans = settle(&question, &found).map_err(|error| case.about(error))?;
    progress.finish_and_clear();
    found.warnings.iter().for_each(|w| ui.warn(w));
    if let Some(misread) = &found.misread {
        ui.warn(&format!("the data were misread ({}): {}", misread.reading, misread.detail));
    }
    if let (Some(path), Some(best)) = (&args.output, plans.first().filter(|p| !p.samples.is_empty())) {
        outputs.add(path, plan_table(machine, best)?.to_text())?;
        ui.write(outputs)?;
    } else if let Some(path) = &args.output {
        ui.warn(&format!("{} is not written: there is no tie to settle", path.display()));
    }
    ui.result(&text::settlement(&found, &plans, machine.mechanism.name()), &json::settlement(&found, &plans))?;
    Ok(verdict(!matches!(found.verdict, Verdict::Misread | Verdict::Undecided)))
}

/// Joints, the poses that they lead to, and the conditions of a plan.
fn plan_table(machine: &Machine, plan: &MeasurementPlan) -> Result<CsvTable> {
    let mechanism = machine.mechanism.as_ref();
    let mut rows = Vec::with_capacity(plan.samples.len());
    for sample in &plan.samples {
        let pose = mechanism
            .forward(mechanism.values(), &sample.joints, &sample.conditions, &mechanism.home())
            .map_err(|cause| anyhow!("{cause}"))?;
        let pose = machine.convention.coordinates(&pose);
        rows.push(JointsAndPose { id: None, joints: sample.joints.clone(), pose });
    }
    let mut table = joints_and_poses(machine, plan.what.clone(), &rows);
    let names = plan.samples.first().map(|s| s.conditions.covariates.keys().cloned().collect::<Vec<_>>());
    for name in names.unwrap_or_default() {
        let kind = machine.condition_kinds().of(&name);
        // When the plan is carried out is not for the plan to say.
        if kind.is_some_and(|kind| kind.role == Role::Clock) {
            continue;
        }
        table.header.push(kind.map_or_else(|| name.clone(), |kind| kind.column(&name)));
        let unit = kind.map_or_else(|| Unit::si(Dimension::None), ConditionKind::unit);
        for (row, sample) in table.rows.iter_mut().zip(&plan.samples) {
            let value = sample.conditions.get(&name);
            row.push(value.map_or_else(String::new, |v| number(unit.from_si(v))));
        }
    }
    Ok(table)
}
