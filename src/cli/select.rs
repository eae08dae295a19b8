//! `paracal select`.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::files::{ListedPose, Machine, read_poses};
use crate::mechanism::Workspace;
use crate::observability::{Scaling, index};
use crate::pose::Pose;
use crate::report::{html, json, text};
use crate::selection::{
    Campaign, Candidates, ChosenSet, Forecaster, MOST_POSES, Objective, Requirement, SelectionError, SelectionTask,
    Sources, Step, how_many, select_among, smallest_number,
};
use anyhow::{Context, Result, anyhow, bail};

use crate::cli::common::{page_subject, settings};
use crate::cli::select_args::{Args, Order, ScalingChoice};
use crate::cli::select_list;
use crate::cli::ui::Ui;

const POSES: usize = 20;
/// Numbers of poses that a table shows.
const TABLE: std::ops::RangeInclusive<usize> = 7..=60;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let number = args.random_candidates()?;
    let listed = number.is_none().then(|| PathBuf::from(&args.candidates));
    let lists = [&listed, &args.given, &args.targets, &args.diagnosis.conditions];
    let inputs = std::iter::once(&args.mechanism).chain(lists.into_iter().flatten());
    let mut outputs = ui.outputs(inputs, args.output.iter().chain(&args.report))?;
    let requirement = args.requirement()?;
    if args.n == Some(0) {
        bail!("-n 0: select at least one pose");
    }
    let machine = ui.machine(&args.mechanism)?;
    outputs.protect(machine.inputs());
    let planned = args.diagnosis.campaign(&machine, ui)?;
    let workspace = machine.workspace.with_context(|| {
        format!(
            "{}: there is no [workspace] to choose poses from; state \
                                  one",
            args.mechanism.display()
        )
    })?;
    let job = Job { args, ui, machine: &machine, requirement };
    let (given, targets) = (job.poses(&args.given)?, job.poses(&args.targets)?);
    let sources = job.sources(number, &listed)?;
    let (campaign, forecaster) = job.campaign(&workspace, &targets)?;
    let start = std::time::Instant::now();
    let Choice { mut report, table } = job.choose(&campaign, forecaster.as_ref(), &sources, &given)?;
    let seconds = start.elapsed().as_secs_f64();
    if args.order == Order::Random {
        report.shuffle(given.len(), args.seed);
    }
    job.warn(&report);
    let rows = select_list::rows(&machine, &mut report, given.len(), args.resolution.as_deref())?;
    let limits = args.diagnosis.limits(&planned, &machine, &report.poses)?;
    let scaling = campaign.scaling;
    let selector = args.selector();
    if let Some(path) = &args.output {
        let comment = select_list::comment(&machine, &report, scaling.name(), selector.name(), args.seed);
        let list = select_list::table(&machine, &rows, planned.columns(), comment);
        outputs.add(path, list.to_text())?;
    }
    let shown = text::Selection {
        title: machine.mechanism.name(),
        report: &report,
        scaling,
        selector: selector.name(),
        given: given.len(),
        table: &table,
        requirement: requirement.as_ref(),
        limits: limits.as_ref(),
        file: args.output.as_deref().filter(|path| path.as_os_str() != "-").map(|path| path.display().to_string()),
    };
    if let Some(path) = &args.report {
        let read = machine.inputs().iter().chain(lists.into_iter().flatten());
        let subject = page_subject(ui, &machine, machine.mechanism.as_ref(), settings(Some(args.seed), read));
        outputs.add(path, html::selection(&shown, &subject).html())?;
    }
    ui.write(outputs)?;
    let (poses, joints): (Vec<_>, Vec<_>) = rows.iter().map(|row| (row.pose, row.joints.as_slice())).unzip();
    ui.result(&text::selection(&shown), &json::selection(&shown, &poses, &joints, seconds))?;
    Ok(ExitCode::SUCCESS)
}

/// One call, once its mechanism is read.
struct Job<'a> {
    args: &'a Args,
    ui: &'a Ui,
    machine: &'a Machine,
    requirement: Option<Requirement>,
}

/// What was chosen, and what other numbers of poses would give if that was asked.
struct Choice {
    report: ChosenSet,
    table: Vec<ChosenSet>,
}

impl<'a> Job<'a> {
    fn file(&self) -> String {
        self.args.mechanism.display().to_string()
    }

    /// A failure with the file that it is about.
    fn about(&self, cause: &SelectionError) -> anyhow::Error {
        match (cause, &self.args.given, &self.args.targets) {
            (SelectionError::Given { .. }, given, _) => {
                anyhow!("{}: {cause}", given.clone().unwrap_or_default().display())
            }
            (SelectionError::NoTarget(_), _, Some(targets)) => anyhow!("{}: {cause}", targets.display()),
            _ => anyhow!("{}: {cause}", self.file()),
        }
    }

    /// The poses of a list, or none.
    fn poses(&self, path: &Option<PathBuf>) -> Result<Vec<Pose>> {
        let Some(path) = path else { return Ok(Vec::new()) };
        Ok(read_poses(path, self.machine)?.into_iter().map(|l: ListedPose| l.pose).collect())
    }

    /// Where candidates come from.
    fn sources(&self, number: Option<usize>, listed: &Option<PathBuf>) -> Result<Sources> {
        let random = number.unwrap_or(0);
        let corners = self.args.selector().wants_corners() && !self.args.no_corners && listed.is_none();
        if random == 0 && listed.is_none() && !corners {
            bail!("--candidates 0: without corners there is nothing to choose from");
        }
        let listed = self.poses(listed).context("--candidates")?;
        Ok(Sources { random, corners_and_grid: corners, listed, seed: self.args.seed })
    }

    /// The campaign in the scaling that was asked for, or that is possible, and what predicts its error.
    fn campaign(&self, workspace: &Workspace, targets: &[Pose]) -> Result<(Campaign<'a>, Option<Forecaster<'a>>)> {
        let (mechanism, noise) = (self.machine.mechanism.as_ref(), self.machine.noise.as_ref());
        let whitened = Campaign::new(mechanism, workspace, noise, Scaling::Whitened);
        let (scaling, why_not) = match (self.args.scaling, &whitened) {
            (Some(ScalingChoice::Paper), _) => (Scaling::Paper, None),
            (Some(ScalingChoice::Whitened), _) | (None, Ok(_)) => (Scaling::Whitened, None),
            (None, Err(cause)) => (Scaling::Paper, Some(cause.clone())),
        };
        if self.args.index == "pose-error" && scaling == Scaling::Paper {
            bail!(
                "{}: --index pose-error is stated in units of the noise; it needs --scaling whitened with [noise] and [tolerance]",
                self.file()
            );
        }
        let about = |cause| self.about(&cause);
        let forecaster =
            whitened.clone().ok().map(|campaign| Forecaster::new(campaign, targets)).transpose().map_err(about)?;
        let campaign = match scaling {
            Scaling::Whitened => whitened,
            Scaling::Paper => Campaign::new(mechanism, workspace, noise, scaling),
        };
        let campaign = campaign.map_err(about)?;
        if forecaster.is_none() && (self.requirement.is_some() || !targets.is_empty()) {
            bail!(
                "{}: the error of the calibrated pose is predicted from [noise] and [tolerance]; state both",
                self.file()
            );
        }
        if let Some(cause) = why_not {
            self.ui.warn(&format!("{}; the index is taken in mm and rad (--scaling paper)", short(&cause)));
        }
        Ok((campaign, forecaster))
    }

    /// Collects candidates and chooses among them.
    fn choose(
        &self,
        campaign: &Campaign<'_>,
        forecaster: Option<&Forecaster<'_>>,
        sources: &Sources,
        given: &[Pose],
    ) -> Result<Choice> {
        let about = |cause| self.about(&cause);
        let bar = self.ui.steps("collecting candidates");
        let candidates = Candidates::collect(campaign, sources).map_err(about)?;
        if sources.listed.is_empty() && candidates.tried > 2 * candidates.len() {
            self.ui.warn(&format!("only {} of the {} poses tried can be measured", candidates.len(), candidates.tried));
        }
        let named = index(&self.args.index);
        let aim = match (named.as_deref(), forecaster) {
            (Some(index), _) => Objective::Index(index),
            (None, Some(forecaster)) => Objective::PoseError(forecaster),
            // Whitened rows were asked for, and with them there is a forecast.
            (None, None) => return Err(about(SelectionError::NoNoise)),
        };
        let watch = |step: Step| bar.set(step.done, step.total);
        let plan = SelectionTask { campaign, forecaster, aim, given, seed: self.args.seed, watch: &watch };
        let (selector, quick) = (self.args.selector(), self.args.quicker());
        let n = match (&self.requirement, self.args.n) {
            (Some(wanted), _) => {
                bar.say("looking for the number of poses");
                smallest_number(&plan, quick.as_ref(), &candidates, wanted).map_err(about)?
            }
            (None, n) => n.unwrap_or(POSES.max(given.len() + 1)),
        };
        bar.say(&format!("choosing {n} poses from {}", candidates.len()));
        let mut report = select_among(&plan, selector.as_ref(), &candidates, n, true).map_err(about)?;
        // Another index than the error itself may end elsewhere than the search for the number did.
        if self.requirement.is_some_and(|wanted| !wanted.met_by(&report)) {
            report = select_among(&plan, quick.as_ref(), &candidates, n, true).map_err(about)?;
        }
        if !(report.value > 0.0 && report.value.is_finite()) {
            bail!(
                "{}: {} is {} for the best set of {n} poses: they leave parameters undetermined; ask for more poses, \
                 or offer other candidates",
                self.file(),
                report.index,
                report.value
            );
        }
        let table = if self.args.table {
            bar.say("comparing numbers of poses");
            how_many(&plan, quick.as_ref(), &candidates, TABLE, true).map_err(about)?
        } else {
            Vec::new()
        };
        bar.finish();
        Ok(Choice { report, table })
    }

    /// Says what the user should know of a choice.
    fn warn(&self, report: &ChosenSet) {
        let n = report.poses.len();
        if n > MOST_POSES {
            self.ui.warn(&format!("{n} poses take long to measure; --table shows where more of them stop paying off"));
        }
        let repeated = report.repeated();
        if repeated > 0 {
            let poses = if repeated == 1 { "1 pose is" } else { &format!("{repeated} poses are") };
            self.ui.warn(&format!(
                "{poses} in the list more than once: measuring there again is worth more than another candidate; \
                 offer more candidates if that is not meant"
            ));
        }
        if report.invisible > 0 {
            self.ui.warn(&format!(
                "no candidate determines {} of the {} parameter directions; the index is taken over the others",
                report.invisible,
                self.machine.mechanism.parameters().len()
            ));
        }
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
