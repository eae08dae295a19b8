//! Options of `select`.

use std::path::PathBuf;

use crate::observability::INDICES;
use crate::selection::{Exchange, PoseSelector, Requirement, SELECTORS, TabuDetmax, selector};
use crate::units::{Dimension, parse_quantity};
use anyhow::{Result, bail};
use clap::ValueEnum;
use clap::builder::RangedU64ValueParser;

use crate::cli::campaign_limits::DiagnosisArgs;

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

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ScalingChoice {
    /// Rows divided by the noise, columns multiplied by the tolerance.
    Whitened,
    /// Millimetres and radians.
    Paper,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub(crate) enum Order {
    /// Shuffled, by the seed.
    Random,
    /// As the selector gives them.
    Given,
}

/// Arguments of `select`.
#[derive(clap::Args)]
#[command(after_help = "Example: paracal select mechanisms/table5.toml -n 20 -o poses.csv")]
pub(crate) struct Args {
    /// Mechanism file with a [workspace].
    pub(crate) mechanism: PathBuf,
    /// Table to write: the poses, with the joints to command; without it the choice is only shown.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Order of the new poses in the list. A search leaves them sorted, and then a drift looks like a coordinate.
    #[arg(long, value_enum, default_value = "random")]
    pub(crate) order: Order,
    /// Round the joints to command to multiples of this, such as 1um or 0.1arcsec; the poses of the list are where
    /// they lead to.
    #[arg(long, value_name = "STEP")]
    pub(crate) resolution: Option<String>,
    /// HTML page to write: the poses, how the search converged, the predicted accuracy.
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Total number of poses, given ones included.
    #[arg(short, value_name = "N", conflicts_with = "require", value_parser = up_to(MOST_SELECTED))]
    pub(crate) n: Option<usize>,
    /// Index to optimise: o1 to o5, or the predicted error of the calibrated pose.
    #[arg(long, default_value = "o1", value_parser = clap::builder::PossibleValuesParser::new(INDICES))]
    pub(crate) index: String,
    /// How to choose the poses.
    #[arg(long, default_value = "exchange", value_parser = clap::builder::PossibleValuesParser::new(SELECTORS))]
    pub(crate) selector: String,
    /// Number of random poses to choose from, or a list of the poses that can be measured.
    #[arg(long, value_name = "N|FILE", default_value = "2000")]
    pub(crate) candidates: String,
    /// Leave out the corners and the grid of the workspace (exchange).
    #[arg(long)]
    pub(crate) no_corners: bool,
    /// Do not move poses off random candidates (exchange); those of a list are never moved.
    #[arg(long)]
    pub(crate) no_polish: bool,
    /// Units of the index; whitened where noise and tolerance are stated, else paper.
    #[arg(long, value_enum)]
    pub(crate) scaling: Option<ScalingChoice>,
    /// Poses that will be measured anyway; they are kept, and count.
    #[arg(long, value_name = "FILE")]
    pub(crate) given: Option<PathBuf>,
    /// Poses at which errors of the calibrated model matter; the whole workspace if absent.
    #[arg(long, value_name = "FILE")]
    pub(crate) targets: Option<PathBuf>,
    /// Also show 7 to 60 poses, to see where measuring more stops paying off.
    #[arg(long)]
    pub(crate) table: bool,
    /// Choose the smallest number of poses whose calibration is predicted to be this accurate (RMS).
    #[arg(long, value_name = "LENGTH,ANGLE")]
    pub(crate) require: Option<String>,
    #[command(flatten)]
    pub(crate) diagnosis: DiagnosisArgs,
    /// Length of the tabu list (tabu-detmax).
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = up_to(MOST_ITERATIONS))]
    pub(crate) tabu: usize,
    /// Iterations (tabu-detmax).
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = up_to(MOST_ITERATIONS))]
    pub(crate) iterations: usize,
    /// Random seed.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

impl Args {
    /// The number of random candidates; `None` if a list is named.
    pub(crate) fn random_candidates(&self) -> Result<Option<usize>> {
        let text = &self.candidates;
        if text.is_empty() || !text.bytes().all(|b| b.is_ascii_digit()) {
            return Ok(None);
        }
        match text.parse() {
            Ok(number) if number <= MOST_CANDIDATES => Ok(Some(number)),
            _ => bail!("--candidates {text}: at most {MOST_CANDIDATES} random poses can be drawn"),
        }
    }

    /// The accuracy that is asked for.
    pub(crate) fn requirement(&self) -> Result<Option<Requirement>> {
        self.require.as_deref().map(requirement).transpose()
    }

    /// Whether poses may move off the candidates. A list says which poses can be measured, and no other may be.
    fn polishes(&self) -> bool {
        !self.no_polish && self.candidates.parse::<usize>().is_ok()
    }

    /// The selector that is asked for.
    pub(crate) fn selector(&self) -> Box<dyn PoseSelector> {
        match self.selector.as_str() {
            "tabu-detmax" => Box::new(TabuDetmax { length: self.tabu, iterations: self.iterations }),
            "exchange" => Box::new(Exchange { polish: self.polishes(), ..Exchange::default() }),
            // The names were checked when the arguments were read.
            name => selector(name).unwrap_or_else(|| Box::new(Exchange::default())),
        }
    }

    /// For many numbers of poses: an exchange with fewer starts, any other selector as it is.
    pub(crate) fn quicker(&self) -> Box<dyn PoseSelector> {
        match self.selector.as_str() {
            "exchange" => Box::new(Exchange { starts: 3, rounds: 0, polish: self.polishes() }),
            _ => self.selector(),
        }
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
            bail!("--require {text}: state at most one length and one angle");
        }
    }
    Ok(wanted)
}
