//! `paracal reproduce`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use crate::cli::reproduction::Journal;
use crate::cli::reproduction::{EXHIBITS, Exhibit, Progress, ReproductionContext, Settings, page, reproduce};
use crate::files::Outputs;
use anyhow::{Context, Result};
use clap::builder::PossibleValuesParser;
use serde_json::{Value, json};

use crate::cli::ui::Ui;

/// All exhibits.
const ALL: &str = "all";
/// The page of all exhibits.
const PAGE: &str = "paper.html";

/// Arguments of `reproduce`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal reproduce table1 --out paper\n\
                        An interrupted run resumes where it stopped if it is started again with the same options.")]
pub(crate) struct Args {
    /// Table or figure of Yu, Wu, Wang 2023.
    #[arg(value_name = "EXHIBIT", value_parser = PossibleValuesParser::new(EXHIBITS.into_iter().chain([ALL])))]
    exhibit: String,
    /// Folder for tables (CSV), figures (SVG) and texts; created if missing.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// HTML page to write: what was requested, with verdicts, tables and charts; `all` also writes paper.html.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Noise draws for each set of poses.
    #[arg(long, value_name = "N", default_value_t = Settings::default().draws)]
    draws: u64,
    /// Candidate poses per list.
    #[arg(long, value_name = "N", default_value_t = Settings::default().candidates)]
    candidates: usize,
    /// Lists of candidates, each with its own sets.
    #[arg(long, value_name = "N", default_value_t = Settings::default().lists)]
    lists: u64,
    /// Random seed.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<ExitCode> {
    let start = Instant::now();
    let settings = Settings { draws: args.draws, candidates: args.candidates, lists: args.lists, seed: args.seed };
    let bar = ui.steps("");
    let watch = |p: Progress<'_>| bar.work(p.what, p.done, p.total);
    settings.check()?;
    let names: Vec<&str> = EXHIBITS.into_iter().filter(|name| args.exhibit == ALL || args.exhibit == *name).collect();
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("{}: the folder cannot be created; name another with --out", args.out.display()))?;
    pages(args, "", &mut Vec::new())?;
    // Another exhibit or other settings keep a journal of their own.
    let Settings { draws, candidates, lists, seed } = settings;
    let name = format!("unfinished-{}-{draws}-{candidates}-{lists}-{seed}.journal", args.exhibit);
    let journal = Journal::open(args.out.join(name))?;
    if !journal.is_empty() {
        ui.warn(&format!("resuming an interrupted run with {} finished units of work", journal.len()));
    }
    let context = ReproductionContext::new(settings, &journal, &watch)?;
    let mut exhibits = Vec::new();
    let mut files = Vec::new();
    for name in names {
        let exhibit = reproduce(name, &context)?;
        files.extend(write(&args.out, &exhibit, &settings)?);
        exhibits.push(exhibit);
    }
    pages(args, &page(&exhibits, &settings), &mut files)?.write()?;
    journal.remove()?;
    bar.finish();
    let seconds = start.elapsed().as_secs_f64();
    ui.result(&text(args, &exhibits, &settings, seconds), &object(&exhibits, &settings, &files, seconds))?;
    Ok(ExitCode::SUCCESS)
}

/// The pages to write with this text, after the files that are there.
fn pages(args: &Args, text: &str, files: &mut Vec<PathBuf>) -> Result<Outputs> {
    let beside = (args.exhibit == ALL).then(|| args.out.join(PAGE));
    let mut outputs = Outputs::default();
    for path in beside.into_iter().chain(args.report.clone()) {
        outputs.add(&path, text)?;
        files.push(path);
    }
    Ok(outputs)
}

/// Writes the files of an exhibit, all or none; their names.
fn write(out: &Path, exhibit: &Exhibit, settings: &Settings) -> Result<Vec<PathBuf>> {
    let mut outputs = Outputs::default();
    let mut files = Vec::new();
    let mut add = |name: String, text: String| -> Result<()> {
        let path = out.join(name);
        outputs.add(&path, text)?;
        files.push(path);
        Ok(())
    };
    for listing in &exhibit.listings {
        let mut table = listing.table.clone();
        table.comments.push(settings.text());
        add(format!("{}.csv", listing.stem), table.to_text())?;
    }
    add(format!("{}.svg", exhibit.name), exhibit.figure.svg())?;
    add(format!("{}.txt", exhibit.name), exhibit.text(settings))?;
    outputs.write()?;
    Ok(files)
}

fn text(args: &Args, exhibits: &[Exhibit], settings: &Settings, seconds: f64) -> String {
    let took = exhibits.iter().filter_map(|e| e.took.as_ref()).map(|t| format!("{t}\n")).collect::<String>();
    let out = args.out.display();
    match exhibits {
        [one] => format!("{}\n{took}written to {out} in {seconds:.1} s", one.text(settings)),
        all => {
            let lines: String = all.iter().map(|e| format!("{:<9} {}\n", e.name, e.summary())).collect();
            format!("{lines}\n{took}written to {out} in {seconds:.1} s; open {}", args.out.join(PAGE).display())
        }
    }
}

fn object(exhibits: &[Exhibit], settings: &Settings, files: &[PathBuf], seconds: f64) -> Value {
    let Settings { draws, candidates, lists, seed } = settings;
    json!({
        "settings": { "draws": draws, "candidates": candidates, "lists": lists, "seed": seed },
        "exhibits": exhibits.iter().map(Exhibit::json).collect::<Vec<Value>>(),
        "files": files.iter().map(|f| f.display().to_string()).collect::<Vec<String>>(),
        "seconds": seconds,
    })
}
