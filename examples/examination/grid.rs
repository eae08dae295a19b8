//! The same questions over all that campaigns differ in.

use std::error::Error;
use std::path::Path;

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use crate::Options;
use crate::hidden::cases::{Case, Kind, ROWS, draw_in};
use crate::hidden::others::{self, Other};
use crate::hidden::setting::Setting;
use crate::marks;
use crate::said::{self, Answer, Said};
use crate::table::{self, Rate};

/// What is hidden in every setting, with a short word for the head of the table.
const HIDDEN: [(&str, Kind); 6] = [
    ("nothing", Kind::Null),
    ("one at 3", Kind::One(3.0)),
    ("one at 6", Kind::One(6.0)),
    ("one at 6, 5 % gross", Kind::OneWithOutliers(6.0)),
    ("two at 6", Kind::Two(6.0)),
    ("instrument at 6", Kind::Instrument(6.0)),
];

/// Other machines, of which nothing or one effect is asked.
const OTHERS: [(&str, Other); 2] = [("linear delta", Other::Delta), ("pose positioner", Other::Positioner)];

/// One line of the table.
#[derive(Clone, Copy)]
enum Line {
    Setting(Setting),
    /// Settings that differ in any respects.
    Any,
    Other(Other),
}

impl Line {
    fn asks(self, kind: Kind) -> bool {
        !matches!(self, Self::Other(_)) || matches!(kind, Kind::Null | Kind::One(_))
    }

    fn draw(self, kind: Kind, seed: u64, number: usize) -> Option<Case> {
        match self {
            Self::Setting(setting) => draw_in(&setting, kind, seed, number),
            Self::Any => {
                let setting = Setting::draw(&mut ChaCha8Rng::seed_from_u64(seed + 7 * number as u64));
                draw_in(&setting, kind, seed, number)
            }
            Self::Other(machine) => {
                let size = if let Kind::One(size) = kind { Some(size) } else { None };
                others::draw(machine, size, ROWS, seed, number)
            }
        }
    }
}

/// Every question in every setting, of other machines, and in settings that differ in any respects.
pub(crate) fn examine(options: &Options, folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut settings: Vec<(String, Line)> =
        Setting::each().into_iter().map(|setting| (setting.name(), Line::Setting(setting))).collect();
    settings.extend(OTHERS.map(|(name, machine)| (name.to_owned(), Line::Other(machine))));
    settings.push(("any of these together".into(), Line::Any));
    let asked = |name: &str| options.only.is_empty() || options.only.iter().any(|word| name.contains(word.as_str()));
    let mut head = vec![String::new()];
    head.extend(HIDDEN.iter().map(|(name, _)| (*name).to_owned()));
    let mut lines = Vec::new();
    for (name, asked_in) in settings.iter().filter(|(name, _)| asked(name)) {
        let mut line = vec![name.clone()];
        for (hidden, kind) in HIDDEN {
            if !asked_in.asks(kind) {
                line.push(String::new());
                continue;
            }
            let answers = answers(options, folder, name, *asked_in, kind)?;
            line.push(cell(kind, &answers));
            if options.verbose {
                for (number, answer) in answers.iter().enumerate().filter(|(_, a)| !is_right(kind, a)) {
                    let said = answer.said.as_ref().map_or_else(|e| format!("refused: {e}"), Said::text);
                    println!("{name}, {hidden} {number}: {}  ->  {said}", said::hidden_text(&answer.truth));
                }
            }
        }
        println!("{}", line.join("  |  "));
        lines.push(line);
    }
    println!("\nright or tied with the truth / plainly wrong / missed / all; of nothing: false alarms / all");
    table::print(&head, &lines);
    Ok(())
}

fn answers(
    options: &Options,
    folder: &Path,
    name: &str,
    line: Line,
    kind: Kind,
) -> Result<Vec<Answer>, Box<dyn Error>> {
    let answers: Option<Vec<Answer>> = (0..options.trials)
        .into_par_iter()
        .map(|number| {
            let case = line.draw(kind, options.seed, number)?;
            let name = format!("{}-{}-{number}", name.replace([',', ' '], "-"), marks::word(kind));
            Some(said::ask(case, &folder.join(name), options.noise_known))
        })
        .collect();
    answers.ok_or_else(|| "a case could not be drawn".into())
}

/// Nothing found where nothing is; every truth named or tied where something is.
fn is_right(kind: Kind, answer: &Answer) -> bool {
    let Ok(said) = &answer.said else { return false };
    match kind {
        Kind::Null => !is_alarm(said),
        _ => answer.truth.effects.iter().all(|effect| said.mentions(effect)),
    }
}

/// A name or a structure where nothing is; that the noise is not as stated is no alarm.
fn is_alarm(said: &Said) -> bool {
    !said.causes.is_empty() || said.reading.is_some() || said.unknown.as_ref().is_some_and(|u| u.covariate.is_some())
}

/// Names without the truth, of which none is tied with it, and nothing said to be unknown.
fn is_wrong(answer: &Answer) -> bool {
    let Ok(said) = &answer.said else { return false };
    let named = !said.causes.is_empty() && said.unknown.is_none();
    (named && answer.truth.effects.iter().all(|effect| !said.mentions(effect))) || said.reading.is_some()
}

fn is_missed(answer: &Answer) -> bool {
    answer.said.as_ref().is_ok_and(|said| said.causes.is_empty() && said.unknown.is_none() && said.reading.is_none())
}

fn cell(kind: Kind, answers: &[Answer]) -> String {
    let count = |of: &dyn Fn(&Answer) -> bool| Rate::of(answers.iter().map(of)).hits;
    match kind {
        Kind::Null => format!("{}/{}", answers.len() - count(&|a| is_right(kind, a)), answers.len()),
        _ => format!("{}/{}/{}/{}", count(&|a| is_right(kind, a)), count(&is_wrong), count(&is_missed), answers.len()),
    }
}
