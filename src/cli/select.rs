//! `paracal select`.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::files::{ListedPose, Machine, Outputs, read_poses};
use crate::observability::{Scaling, index};
use crate::pose::Pose;
use crate::report::{html, json, text};
use crate::selection::{
    Campaign, Candidates, ChosenSet, Forecaster, MOST_POSES, Objective, SelectionError, SelectionTask, Sources,
    how_many, select_among, smallest_number,
};
use anyhow::{Context, Result, anyhow, bail};

use crate::cli::common::{JointsAndPose, Ui, joints_and_poses, page_subject, settings};
use crate::cli::select_args::{Args, ScalingChoice};

const POSES: usize = 20;
/// Numbers of poses that a table shows.
const TABLE: std::ops::RangeInclusive<usize> = 7..=60;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let number = args.random_candidates()?;
    let listed = number.is_none().then(|| PathBuf::from(&args.candidates));
    let lists = [&listed, &args.given, &args.targets, &args.diagnosis.conditions];
    let inputs = std::iter::once(&args.mechanism).chain(lists.into_iter().flatten());
    let mut outputs = Outputs::beside_inputs(inputs);
    outputs.check(&args.output)?;
    if let Some(path) = &args.report {
        outputs.check(path)?;
    }
    let requirement = args.requirement()?;
    if args.n == Some(0) {
        bail!("-n 0: select at least one pose");
    }
    let machine = ui.machine(&args.mechanism)?;
    outputs.protect(machine.inputs());
    let to_diagnose = args.diagnosis.campaign(&machine, ui)?;
    let mechanism = machine.mechanism.as_ref();
    let file = || args.mechanism.display().to_string();
    let workspace = machine.workspace.with_context(|| {
        format!(
            "{}: there is no [workspace] to choose poses from; state \
                                                   one",
            file()
        )
    })?;
    let poses = |path: &Option<PathBuf>| -> Result<Vec<Pose>> {
        let Some(path) = path else { return Ok(Vec::new()) };
        Ok(read_poses(path, &machine)?.into_iter().map(|l: ListedPose| l.pose).collect())
    };
    let (given, targets) = (poses(&args.given)?, poses(&args.targets)?);
    let chosen = args.selector();
    let random = number.unwrap_or(0);
    let corners = chosen.wants_corners() && !args.no_corners && listed.is_none();
    if random == 0 && listed.is_none() && !corners {
        bail!("--candidates 0: without corners there is nothing to choose from");
    }
    let sources =
        Sources { random, corners_and_grid: corners, listed: poses(&listed).context("--candidates")?, seed: args.seed };

    let noise = machine.noise.as_ref();
    let whitened = Campaign::new(mechanism, &workspace, noise, Scaling::Whitened);
    let (scaling, why_not) = match (args.scaling, &whitened) {
        (Some(ScalingChoice::Paper), _) => (Scaling::Paper, None),
        (Some(ScalingChoice::Whitened), _) | (None, Ok(_)) => (Scaling::Whitened, None),
        (None, Err(cause)) => (Scaling::Paper, Some(cause.clone())),
    };
    if args.index == "pose-error" && scaling == Scaling::Paper {
        bail!(
            "{}: --index pose-error is stated in units of the noise; it needs --scaling whitened with [noise] and [tolerance]",
            file()
        );
    }
    let about = |cause: SelectionError| match cause {
        SelectionError::Given { .. } => anyhow!("{}: {cause}", args.given.clone().unwrap_or_default().display()),
        SelectionError::NoTarget(_) if args.targets.is_some() => {
            anyhow!("{}: {cause}", args.targets.clone().unwrap_or_default().display())
        }
        _ => anyhow!("{}: {cause}", file()),
    };
    let forecaster =
        whitened.clone().ok().map(|campaign| Forecaster::new(campaign, &targets)).transpose().map_err(about)?;
    let campaign = match scaling {
        Scaling::Whitened => whitened.map_err(about)?,
        Scaling::Paper => Campaign::new(mechanism, &workspace, noise, scaling).map_err(about)?,
    };
    if forecaster.is_none() && (requirement.is_some() || !targets.is_empty()) {
        bail!("{}: the error of the calibrated pose is predicted from [noise] and [tolerance]; state both", file());
    }
    if let Some(cause) = why_not {
        ui.warn(&format!("{}; the index is taken in mm and rad (--scaling paper)", short(&cause)));
    }

    let start = std::time::Instant::now();
    let bar = ui.steps("collecting candidates");
    let candidates = Candidates::collect(&campaign, &sources).map_err(about)?;
    if listed.is_none() && candidates.tried > 2 * candidates.len() {
        ui.warn(&format!("only {} of the {} poses tried can be measured", candidates.len(), candidates.tried));
    }
    let named = index(&args.index);
    let aim = match (named.as_deref(), &forecaster) {
        (Some(index), _) => Objective::Index(index),
        (None, Some(forecaster)) => Objective::PoseError(forecaster),
        // Whitened rows were asked for above, and with them there is a forecast.
        (None, None) => return Err(about(SelectionError::NoNoise)),
    };
    let watch = |step: crate::selection::Step| bar.set(step.done, step.total);
    let plan = SelectionTask {
        campaign: &campaign,
        forecaster: forecaster.as_ref(),
        aim,
        given: &given,
        seed: args.seed,
        watch: &watch,
    };
    let quick = args.quicker();
    let n = match (&requirement, args.n) {
        (Some(wanted), _) => {
            bar.say("looking for the number of poses");
            smallest_number(&plan, quick.as_ref(), &candidates, wanted).map_err(about)?
        }
        (None, n) => n.unwrap_or(POSES.max(given.len() + 1)),
    };
    bar.say(&format!("choosing {n} poses from {}", candidates.len()));
    let mut report = select_among(&plan, chosen.as_ref(), &candidates, n, true).map_err(about)?;
    // Another index than the error itself may end elsewhere than the search for the number did.
    if requirement.is_some_and(|wanted| !wanted.met_by(&report)) {
        report = select_among(&plan, quick.as_ref(), &candidates, n, true).map_err(about)?;
    }
    if !(report.value > 0.0 && report.value.is_finite()) {
        bail!(
            "{}: {} is {} for the best set of {n} poses: they leave parameters undetermined; ask for more poses, or \
             offer other candidates",
            file(),
            report.index,
            report.value
        );
    }
    let table = if args.table {
        bar.say("comparing numbers of poses");
        how_many(&plan, quick.as_ref(), &candidates, TABLE, true).map_err(about)?
    } else {
        Vec::new()
    };
    bar.finish();
    let seconds = start.elapsed().as_secs_f64();
    if n > MOST_POSES {
        ui.warn(&format!("{n} poses take long to measure; --table shows where more of them stop paying off"));
    }
    if report.invisible > 0 {
        ui.warn(&format!(
            "no candidate determines {} of the {} parameter directions; the index is taken over the others",
            report.invisible,
            mechanism.parameters().len()
        ));
    }
    let rows = commands(&machine, &report, given.len())?;
    let limits = to_diagnose.map(|c| args.diagnosis.limits(&c, &machine, &report.poses)).transpose()?;
    let comment = format!(
        "{} poses for {}: {} = {:e} ({} scaling), {}, seed {}",
        report.poses.len(),
        mechanism.name(),
        report.index,
        report.value,
        scaling.name(),
        chosen.name(),
        args.seed
    );
    outputs.add(&args.output, joints_and_poses(&machine, comment, &rows).to_text())?;
    let shown = text::Selection {
        title: mechanism.name(),
        report: &report,
        scaling,
        selector: chosen.name(),
        given: given.len(),
        table: &table,
        requirement: requirement.as_ref(),
        limits: limits.as_ref(),
        file: &args.output.display().to_string(),
    };
    if let Some(path) = &args.report {
        let read = machine.inputs().iter().chain(lists.into_iter().flatten());
        let subject = page_subject(ui, &machine, mechanism, settings(Some(args.seed), read));
        outputs.add(path, html::selection(&shown, &subject).html())?;
    }
    outputs.write()?;
    let coordinates: Vec<[f64; 6]> = report.poses.iter().map(|p| machine.convention.coordinates(p)).collect();
    ui.result(&text::selection(&shown), &json::selection(&shown, &coordinates, seconds));
    Ok(ExitCode::SUCCESS)
}

/// The first half of a refusal: what is missing.
fn short(cause: &SelectionError) -> String {
    match cause {
        SelectionError::NoNoise => "[noise] is not stated".into(),
        SelectionError::NoTolerance { .. } => "[tolerance] is not stated".into(),
        other => other.to_string(),
    }
}

/// The joints to command for each pose.
fn commands(machine: &Machine, report: &ChosenSet, given: usize) -> Result<Vec<JointsAndPose>> {
    let mechanism = machine.mechanism.as_ref();
    let row = |(k, pose): (usize, &Pose)| {
        let joints = mechanism.inverse(mechanism.values(), pose, &crate::conditions::Conditions::unknown())?;
        let label = if k < given { format!("given{}", k + 1) } else { format!("new{}", k + 1 - given) };
        let id = (given > 0).then_some(label);
        Ok(JointsAndPose { id, joints, pose: machine.convention.coordinates(pose) })
    };
    report.poses.iter().enumerate().map(row).collect()
}
