//! An audit of the word "trusted": machines with known errors in, rates with their 95 % intervals out.
//!
//! Each trial draws a machine, how it differs from its drawing, a frame, a way of measuring and a campaign, by a
//! generator that shares no equation with the library. The library calibrates it, and what it states of the error over
//! the workspace is compared with the error at a hundred further exact poses. A result is right if position and
//! rotation are both within 1.5 times of what is stated. Where few directions dominate an error, chance alone exceeds
//! that now and then: how often it should is computed for each trial from its covariance, and printed beside the rate
//! that was found.
//!
//! A refusal counts as one of good data if the model that comes with it is right and leaves less than half of the error
//! of the drawing or, where there is no result at all, if the same data calibrate to such a result from the true
//! machine; and if the model held nothing false.
//!
//! Run with `cargo run --release --example audit -- --trials 200`, or with `--only singular,zeros --seed 7 --verbose`;
//! `--number N` repeats one trial, and `--kind linear-delta` draws machines of that kind alone. The same seed gives the
//! same table on any number of threads.

mod answer;
mod chance;
mod dice;
mod effects;
mod machines;
mod made;
mod readings;
mod rigid;
mod situations;
#[path = "../examination/table.rs"]
mod table;
mod trial;

use std::error::Error;
use std::time::Instant;

use rayon::prelude::*;

use answer::{Answer, Mark, ask};
use chance::median;
use situations::{SITUATIONS, Situation};
use table::Rate;

struct Options {
    trials: usize,
    seed: u64,
    only: Vec<String>,
    number: Option<usize>,
    kind: Option<String>,
    verbose: bool,
}

impl Options {
    fn read(mut words: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let mut options = Self { trials: 200, seed: 1, only: Vec::new(), number: None, kind: None, verbose: false };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "--trials" => options.trials = value()?.parse()?,
                "--seed" => options.seed = value()?.parse()?,
                "--only" => options.only.extend(value()?.split(',').map(str::to_owned)),
                "--number" => options.number = Some(value()?.parse()?),
                "--kind" => options.kind = Some(value()?),
                "--verbose" => options.verbose = true,
                _ => {
                    let keys: Vec<&str> = SITUATIONS.iter().map(|s| s.key).collect();
                    let usage = "[--trials N] [--seed S] [--only SITUATION,…] [--number N] [--kind KIND] [--verbose]";
                    return Err(format!("'{word}' is unknown; {usage}; situations: {}", keys.join(" ")).into());
                }
            }
        }
        if let Some(kind) = options.kind.as_ref().filter(|kind| !machines::KINDS.contains(&kind.as_str())) {
            return Err(format!("there is no kind '{kind}'; kinds: {}", machines::KINDS.join(" ")).into());
        }
        if let Some(unknown) = options.only.iter().find(|key| SITUATIONS.iter().all(|s| s.key != **key)) {
            return Err(format!("there is no situation '{unknown}'").into());
        }
        Ok(options)
    }

    fn wants(&self, situation: &Situation) -> bool {
        self.only.is_empty() || self.only.iter().any(|key| key == situation.key)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::read(std::env::args().skip(1))?;
    let mut lines = Vec::new();
    for situation in SITUATIONS.iter().filter(|situation| options.wants(situation)) {
        let numbers = options.number.map_or(0..options.trials, |number| number..number + 1);
        let started = Instant::now();
        let answers: Option<Vec<(usize, Answer)>> = numbers
            .into_par_iter()
            .map(|number| Some((number, ask(situation, options.kind.as_deref(), options.seed, number)?)))
            .collect();
        let answers = answers.ok_or_else(|| format!("a trial of '{}' could not be drawn", situation.key))?;
        lines.push(report(situation, &answers, started.elapsed().as_secs_f64()));
        if options.verbose || options.number.is_some() {
            details(&answers, options.number.is_some());
        }
    }
    println!();
    table::print(&HEAD.map(str::to_owned), &lines);
    Ok(())
}

/// Columns of the summary.
const HEAD: [&str; 9] =
    ["", "right", "wrong", "by chance", "improbable", "good refused", "bad refused", "position", "rotation"];

/// Prints what became of the trials of a situation, and returns its line of the summary.
fn report(situation: &Situation, answers: &[(usize, Answer)], seconds: f64) -> Vec<String> {
    println!("\n{} ({}): {} trials, {seconds:.0} s", situation.title, situation.key, answers.len());
    let marked = |mark: Mark| Rate::of(answers.iter().map(|(_, a)| a.mark == mark));
    let trusted: Vec<&Answer> =
        answers.iter().map(|(_, a)| a).filter(|a| matches!(a.mark, Mark::TrustedRight | Mark::TrustedWrong)).collect();
    let by_chance = trusted.iter().filter_map(|a| a.chance).map(|c| c.wrong).fold(0.0, |sum, wrong| sum + wrong);
    let by_chance = format!("{:.1} %", 100.0 * by_chance / answers.len().max(1) as f64);
    let improbable = Rate::of(answers.iter().map(|(_, a)| a.chance.is_some_and(|c| c.probability < IMPROBABLE)));
    let largest = answers.iter().map(|(_, a)| a.disagreement).fold(0.0, f64::max);
    println!("    generator and library    {largest:.0e} of the size apart, at most, for the true values");
    let mut line = vec![situation.key.to_owned()];
    for (name, mark) in MARKS {
        println!("    {name:<24} {}", marked(mark).text());
        line.push(marked(mark).short());
        if mark == Mark::TrustedWrong {
            println!("      expected by chance     {by_chance:>7}");
            println!("      less likely than {IMPROBABLE}  {}", improbable.text());
            line.extend([by_chance.clone(), improbable.short()]);
        }
    }
    let from_truth = answers.iter().filter(|(_, a)| a.mark == Mark::RefusedBad && a.good_from_truth).count();
    if from_truth > 0 {
        println!("      good from the truth    {from_truth}");
    }
    for (k, name) in ["position", "rotation"].iter().enumerate() {
        let seen = || trusted.iter().filter(move |a| a.seen[k]);
        let found = median(&mut seen().filter_map(|a| Some(a.ratios?[k])).collect::<Vec<_>>());
        let expected = median(&mut seen().filter_map(|a| Some(a.chance?.medians[k])).collect::<Vec<_>>());
        println!("    true over stated error of {name}, median {found:.3}, by chance {expected:.3}");
        line.push(format!("{found:.2}"));
    }
    line
}

/// Errors less likely than this under what is stated are not chance.
const IMPROBABLE: f64 = 1e-3;

const MARKS: [(&str, Mark); 4] = [
    ("trusted and right", Mark::TrustedRight),
    ("trusted and wrong", Mark::TrustedWrong),
    ("refused, good data", Mark::RefusedGood),
    ("refused, bad", Mark::RefusedBad),
];

/// The trials that went wrong or are improbable, or all.
fn details(answers: &[(usize, Answer)], all: bool) {
    let improbable = |a: &Answer| a.chance.is_some_and(|c| c.probability < IMPROBABLE);
    let told = |a: &Answer| all || a.mark != Mark::TrustedRight || improbable(a);
    for (number, answer) in answers.iter().filter(|(_, a)| told(a)) {
        let truth = if answer.good_from_truth { " (good from the truth)" } else { "" };
        let chance =
            answer.chance.map_or(String::new(), |c| format!(", by chance {:.3}, p {:.1e}", c.wrong, c.probability));
        println!("    {number:>4} {:?}{truth}{chance}: {}\n         {}", answer.mark, answer.text, answer.said);
    }
}
