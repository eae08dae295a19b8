//! `paracal select`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use clap::builder::RangedU64ValueParser;
use paracal::files::{ListedPose, Machine, Outputs, read_poses};
use paracal::observability::{INDICES, Scaling, index};
use paracal::pose::Pose;
use paracal::report::{html, json, text};
use paracal::selection::{
    Aim, Campaign, Candidates, Exchange, Forecaster, MOST_POSES, Plan, PoseSelector, Report, Requirement, SELECTORS,
    SelectionError, Sources, TabuDetmax, how_many, select_among, selector, smallest_number,
};
use paracal::units::{Dimension, parse_quantity};

use crate::campaign_limits::DiagnosisArgs;
use crate::common::{JointsAndPose, Ui, joints_and_poses, page_subject, settings};

#[derive(Clone, Copy, ValueEnum)]
enum ScalingChoice {
    /// Rows over the noise, columns times the tolerance.
    Whitened,
    /// Millimetres and radians.
    Paper,
}

/// Arguments of `select`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal select mechanisms/table5.toml -n 20 -o poses.csv")]
pub(crate) struct Args {
    /// Mechanism file with a [workspace].
    mechanism: PathBuf,
    /// List of poses to write, with the joints to command.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Page to write: the poses, how the choice came about, what it promises (HTML).
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Number of poses in all, given ones included.
    #[arg(short, value_name = "N", conflicts_with = "require", value_parser = up_to(MOST_SELECTED))]
    n: Option<usize>,
    /// What is optimised: o1 to o5, or the predicted error of the calibrated pose.
    #[arg(long, default_value = "o1", value_parser = clap::builder::PossibleValuesParser::new(INDICES))]
    index: String,
    /// How poses are chosen.
    #[arg(long, default_value = "exchange", value_parser = clap::builder::PossibleValuesParser::new(SELECTORS))]
    selector: String,
    /// Number of random poses to choose from, or a list of the poses that can be measured.
    #[arg(long, value_name = "N|FILE", default_value = "2000")]
    candidates: String,
    /// Leave out the corners and the grid of the workspace (exchange).
    #[arg(long)]
    no_corners: bool,
    /// Do not move poses off random candidates (exchange); those of a list are never moved.
    #[arg(long)]
    no_polish: bool,
    /// Units of the index; whitened where noise and tolerance are stated, else paper.
    #[arg(long, value_enum)]
    scaling: Option<ScalingChoice>,
    /// Poses that are measured anyway; they are kept and count.
    #[arg(long, value_name = "FILE")]
    given: Option<PathBuf>,
    /// Poses at which errors of the calibrated model matter; the whole workspace if absent.
    #[arg(long, value_name = "FILE")]
    targets: Option<PathBuf>,
    /// Also show 7 to 60 poses, to see where measuring more stops paying.
    #[arg(long)]
    table: bool,
    /// Choose the smallest number of poses whose calibration is predicted to be this accurate (RMS).
    #[arg(long, value_name = "LENGTH,ANGLE")]
    require: Option<String>,
    #[command(flatten)]
    diagnosis: DiagnosisArgs,
    /// Length of the tabu list (tabu-detmax).
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = up_to(MOST_ITERATIONS))]
    tabu: usize,
    /// Iterations (tabu-detmax).
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = up_to(MOST_ITERATIONS))]
    iterations: usize,
    /// Seed of everything random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

const POSES: usize = 20;
/// Poses to choose: several times the longest campaigns; the time grows with their square.
const MOST_SELECTED: u64 = 1000;
/// Candidates: half a gigabyte.
const MOST_CANDIDATES: usize = 1_000_000;
/// Iterations: some minutes.
const MOST_ITERATIONS: u64 = 1_000_000;

/// Whole numbers that can be worked off.
fn up_to(most: u64) -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(0..=most)
}

/// Numbers of poses that a table shows.
const TABLE: std::ops::RangeInclusive<usize> = 7..=60;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let number = random_candidates(&args.candidates)?;
    let listed = number.is_none().then(|| PathBuf::from(&args.candidates));
    let lists = [&listed, &args.given, &args.targets, &args.diagnosis.conditions];
    let inputs = std::iter::once(&args.mechanism).chain(lists.into_iter().flatten());
    let mut outputs = Outputs::beside_inputs(inputs);
    outputs.check(&args.output)?;
    if let Some(path) = &args.report {
        outputs.check(path)?;
    }
    let requirement = args.require.as_deref().map(requirement).transpose()?;
    if args.n == Some(0) {
        bail!("-n 0: select at least one pose");
    }
    let machine = ui.machine(&args.mechanism)?;
    outputs.protect(machine.inputs());
    let to_diagnose = args.diagnosis.campaign(&machine, ui)?;
    let mechanism = machine.mechanism.as_ref();
    let file = || args.mechanism.display().to_string();
    let workspace =
        machine.workspace.with_context(|| format!("{}: state [workspace]: poses are chosen from it", file()))?;
    let poses = |path: &Option<PathBuf>| -> Result<Vec<Pose>> {
        let Some(path) = path else { return Ok(Vec::new()) };
        Ok(read_poses(path, &machine)?.into_iter().map(|l: ListedPose| l.pose).collect())
    };
    let (given, targets) = (poses(&args.given)?, poses(&args.targets)?);
    let chosen = chosen_selector(args);
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
        ui.warn(&format!("only {} of {} poses tried can be measured", candidates.len(), candidates.tried));
    }
    let named = index(&args.index);
    let aim = match (named.as_deref(), &forecaster) {
        (Some(index), _) => Aim::Index(index),
        (None, Some(forecaster)) => Aim::PoseError(forecaster),
        // Whitened rows were asked for above, and with them there is a forecast.
        (None, None) => return Err(about(SelectionError::NoNoise)),
    };
    let watch = |step: paracal::selection::Step| bar.set(step.done, step.total);
    let plan = Plan {
        campaign: &campaign,
        forecaster: forecaster.as_ref(),
        aim,
        given: &given,
        seed: args.seed,
        watch: &watch,
    };
    let quick = quicker(args);
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
            "{}: {} is {} for the best set of {n} poses: they leave parameters undetermined; ask for more poses, or offer others",
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
        ui.warn(&format!("{n} poses take long to measure; --table shows where more of them stop paying"));
    }
    if report.invisible > 0 {
        ui.warn(&format!(
            "no candidate sees {} of the {} parameter directions; the index is taken over the others",
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
        let subject = page_subject(&machine, mechanism, settings(Some(args.seed), read));
        outputs.add(path, html::selection(&shown, &subject).html())?;
    }
    outputs.write()?;
    let coordinates: Vec<[f64; 6]> = report.poses.iter().map(|p| machine.convention.coordinates(p)).collect();
    ui.result(&text::selection(&shown), &json::selection(&shown, &coordinates, seconds));
    Ok(ExitCode::SUCCESS)
}

/// The number of random candidates; `None` if the text is the name of a list.
fn random_candidates(text: &str) -> Result<Option<usize>> {
    if text.is_empty() || !text.bytes().all(|b| b.is_ascii_digit()) {
        return Ok(None);
    }
    match text.parse() {
        Ok(number) if number <= MOST_CANDIDATES => Ok(Some(number)),
        _ => bail!("--candidates {text}: at most {MOST_CANDIDATES} random poses can be drawn"),
    }
}

/// The first half of a refusal: what is missing.
fn short(cause: &SelectionError) -> String {
    match cause {
        SelectionError::NoNoise => "[noise] is not stated".into(),
        SelectionError::NoTolerance { .. } => "[tolerance] is not stated".into(),
        other => other.to_string(),
    }
}

/// Whether poses may move off the candidates. A list says which poses can be measured, and no other may be.
fn polishes(args: &Args) -> bool {
    !args.no_polish && args.candidates.parse::<usize>().is_ok()
}

fn chosen_selector(args: &Args) -> Box<dyn PoseSelector> {
    match args.selector.as_str() {
        "tabu-detmax" => Box::new(TabuDetmax { length: args.tabu, iterations: args.iterations }),
        "exchange" => Box::new(Exchange { polish: polishes(args), ..Exchange::default() }),
        // The names were checked when the arguments were read.
        name => selector(name).unwrap_or_else(|| Box::new(Exchange::default())),
    }
}

/// For many numbers of poses: an exchange with fewer starts, any other selector as it is.
fn quicker(args: &Args) -> Box<dyn PoseSelector> {
    match args.selector.as_str() {
        "exchange" => Box::new(Exchange { starts: 3, rounds: 0, polish: polishes(args) }),
        _ => chosen_selector(args),
    }
}

/// `2um,0.5arcsec`, in any order, one of them or both.
fn requirement(text: &str) -> Result<Requirement> {
    let mut wanted = Requirement::default();
    for part in text.split(',').map(str::trim) {
        let (place, value) = match parse_quantity(part, Dimension::Length) {
            Ok(value) => (&mut wanted.position, value),
            Err(_) => match parse_quantity(part, Dimension::Angle) {
                Ok(value) => (&mut wanted.rotation, value),
                Err(_) => {
                    bail!("--require {text}: '{part}' is neither a length such as 2um nor an angle such as 0.5arcsec")
                }
            },
        };
        if !(value > 0.0) {
            bail!("--require {text}: '{part}' must be positive");
        }
        if place.replace(value).is_some() {
            bail!("--require {text}: state one length and one angle");
        }
    }
    Ok(wanted)
}

/// The joints to command for each pose.
fn commands(machine: &Machine, report: &Report, given: usize) -> Result<Vec<JointsAndPose>> {
    let mechanism = machine.mechanism.as_ref();
    let row = |(k, pose): (usize, &Pose)| {
        let joints = mechanism.inverse(mechanism.values(), pose, &paracal::conditions::Conditions::unknown())?;
        let label = if k < given { format!("given{}", k + 1) } else { format!("new{}", k + 1 - given) };
        let id = (given > 0).then_some(label);
        Ok(JointsAndPose { id, joints, pose: machine.convention.coordinates(pose) })
    };
    report.poses.iter().enumerate().map(row).collect()
}
