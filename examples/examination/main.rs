//! An examination of the diagnosis: blind cases in, tables of rates with their 95 % intervals out.
//!
//! Something is hidden in each case by a generator that shares no equation with the library
//! (`tests/it/common/hidden`). The program sees two files and nothing else, and what it says is compared with the truth.
//!
//! Run with `cargo run --release --example examination`, which takes some minutes, or with
//! `-- --only null --trials 1000 --seed 7 --verbose`. `--limits` prints the detection limits of the generator,
//! `--grid` asks in all settings that differ from the reference in one respect, and in any (`--only` chooses them by words of
//! their names); `--noise-known` takes the stated noise at its word, `--keep FOLDER` leaves the files there. The same seed gives the same tables on any number of threads.

mod grid;
#[path = "../../tests/it/common/hidden/mod.rs"]
mod hidden;
mod marks;
mod rows;
mod said;
mod table;

use std::error::Error;
use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use hidden::cases::{Kind, draw};
use hidden::effects::{CATALOGUE, Scan};
use hidden::limits::Limits;
use hidden::run::{Run, Weather};
use rows::{PAPERS, Paper};
use said::Answer;

struct Options {
    trials: usize,
    seed: u64,
    only: Vec<String>,
    verbose: bool,
    limits: bool,
    grid: bool,
    noise_known: bool,
    keep: Option<PathBuf>,
}

impl Options {
    fn read(mut words: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            trials: 200,
            seed: 1,
            only: Vec::new(),
            verbose: false,
            limits: false,
            grid: false,
            noise_known: false,
            keep: None,
        };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "--trials" => options.trials = value()?.parse()?,
                "--seed" => options.seed = value()?.parse()?,
                "--only" => options.only.extend(value()?.split(',').map(str::to_owned)),
                "--verbose" => options.verbose = true,
                "--limits" => options.limits = true,
                "--grid" => options.grid = true,
                "--keep" => options.keep = Some(value()?.into()),
                "--noise-known" => options.noise_known = true,
                _ => {
                    let keys: Vec<&str> = PAPERS.iter().map(|p| p.key).collect();
                    let usage = "[--trials N] [--seed S] [--only ROW,…] [--verbose] [--limits] [--grid] [--noise-known] [--keep FOLDER]";
                    return Err(format!("'{word}' is unknown; {usage}; rows: {}", keys.join(" ")).into());
                }
            }
        }
        let is_known = |key: &String| options.grid || PAPERS.iter().any(|p| p.key == *key);
        if let Some(unknown) = options.only.iter().find(|key| !is_known(key)) {
            return Err(format!("there is no row '{unknown}'").into());
        }
        Ok(options)
    }

    fn wants(&self, paper: &Paper) -> bool {
        if self.only.is_empty() { !paper.extra } else { self.only.iter().any(|key| key == paper.key) }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::read(std::env::args().skip(1))?;
    if options.limits {
        return print_limits(options.seed);
    }
    let passing = tempfile::tempdir()?;
    let folder = options.keep.as_deref().unwrap_or(passing.path());
    if options.grid {
        return grid::examine(&options, folder);
    }
    for paper in PAPERS.iter().filter(|paper| options.wants(paper)) {
        let answers = examine(paper, &options, folder)?;
        report(paper, &answers, options.verbose);
    }
    Ok(())
}

/// Draws the cases of a paper and has them diagnosed, in parallel; answers are in the order of the cases.
fn examine(paper: &Paper, options: &Options, folder: &Path) -> Result<Vec<Answer>, Box<dyn Error>> {
    let answers: Option<Vec<Answer>> = (0..options.trials)
        .into_par_iter()
        .map(|number| {
            let case = draw(paper.kind, options.seed, number)?;
            Some(said::ask(case, &folder.join(format!("{}-{number}", paper.key)), options.noise_known))
        })
        .collect();
    answers.ok_or_else(|| format!("a case of '{}' could not be drawn", paper.key).into())
}

fn report(paper: &Paper, answers: &[Answer], verbose: bool) {
    let all: Vec<&Answer> = answers.iter().collect();
    let seconds = answers.iter().map(|a| a.seconds).sum::<f64>() / answers.len() as f64;
    println!("\n{} ({}): {} cases, {seconds:.2} s each", paper.title, paper.key, answers.len());
    let failed = answers.iter().filter(|a| a.said.is_err()).count();
    if failed > 0 {
        println!("    {failed} were refused");
    }
    for (name, rate) in marks::marks(paper.kind, &all) {
        println!("    {name:<31} {}", rate.text());
    }
    let ratios: Vec<f64> = answers.iter().filter_map(|a| a.said.as_ref().ok()?.after_over_floor).collect();
    if !ratios.is_empty() {
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        println!("    {:<31} {mean:5.3}", "held-out after over floor, mean");
    }
    by_kind(paper.kind, answers);
    if verbose {
        for (number, answer) in answers.iter().enumerate().filter(|(_, answer)| marks::wrong(paper.kind, answer)) {
            let said = answer.said.as_ref().map_or_else(|e| format!("refused: {e}"), said::Said::text);
            println!("    {number:>4}  {}  ->  {said}", said::hidden_text(&answer.truth));
        }
    }
}

/// The same marks for each effect, stranger or mistake.
fn by_kind(kind: Kind, answers: &[Answer]) {
    type Marks = fn(&[&Answer]) -> Vec<marks::Mark>;
    let (label, marks): (fn(&Answer) -> String, Marks) = match kind {
        Kind::One(_) | Kind::OneWithOutliers(_) | Kind::WarmUp(_) => (|a| a.truth.effects.concat(), marks::one),
        Kind::Outside(_) => (|a| a.truth.detail.clone(), marks::outside),
        Kind::Misread => (
            |a| {
                let reading = a.truth.reading.clone().unwrap_or_default();
                if reading == "leg-order" { reading } else { format!("{reading} {}", a.truth.detail) }
            },
            marks::misread,
        ),
        _ => return,
    };
    let mut labels: Vec<String> = Vec::new();
    for found in answers.iter().map(label) {
        if !labels.contains(&found) {
            labels.push(found);
        }
    }
    let head = std::iter::once(String::new()).chain(marks(&[]).into_iter().map(|(name, _)| short(&name)));
    let lines = labels.iter().map(|wanted| {
        let of: Vec<&Answer> = answers.iter().filter(|a| label(a) == *wanted).collect();
        let cells = marks(&of).into_iter().map(|(_, rate)| rate.short());
        std::iter::once(wanted.clone()).chain(cells).collect()
    });
    table::print(&head.collect::<Vec<_>>(), &lines.collect::<Vec<_>>());
}

/// The head of a narrow column: the first word, or two where one says little.
fn short(name: &str) -> String {
    let words: Vec<&str> = name.split([' ', ',']).filter(|w| !w.is_empty()).collect();
    let take = if matches!(words.first(), Some(&("right" | "called" | "more"))) { words.len().min(3) } else { 1 };
    words[words.len().min(take) - 1].to_owned()
}

/// Limits of the first parameter alone, the mean of ten runs.
fn print_limits(seed: u64) -> Result<(), Box<dyn Error>> {
    let runs: Vec<Run> = (0..10)
        .map(|k| Run::draw(hidden::cases::ROWS, Weather::Reference, &mut ChaCha8Rng::seed_from_u64(seed + k)))
        .collect();
    let limits: Option<Vec<Limits<'_>>> = runs.iter().map(Limits::of).collect();
    let limits = limits.ok_or("no pose at the commanded lengths")?;
    for known in &CATALOGUE {
        let leg = matches!(known.scan, Scan::Leg | Scan::LegAndRow).then_some(0);
        let row = matches!(known.scan, Scan::Row | Scan::LegAndRow).then_some(hidden::cases::ROWS / 2);
        let mut sum = 0.0;
        for run in &limits {
            let information = run.information(known, leg, row).ok_or("no pose at the commanded lengths")?;
            sum += known.scale[0] * run.at_limit(known) / information[(0, 0)].sqrt();
        }
        println!("{:<26} {:.3e}", known.name, sum / limits.len() as f64);
    }
    Ok(())
}
