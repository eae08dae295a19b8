//! Figure 7: O1 of random sets.

use rand::seq::index::sample;

use super::context::Purpose;
use super::exhibit::Listing;
use super::sets::{How, Place, Wanted, choose, indices_of_random_sets};
use super::{Comparison, Exhibit, ReproduceError, ReproductionContext, Spread, paper};
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};
use crate::simulation::{RunningStats, stream};

/// Bars of the histogram.
const BARS: usize = 30;

pub(super) fn exhibit(context: &ReproductionContext<'_>) -> Result<Exhibit, ReproduceError> {
    let place = Place::of_section_5()?;
    let lists: Vec<u64> = (0..context.settings.lists).collect();
    let values = context.units(
        "random sets of figure 7",
        &lists,
        |list| format!("{}: O1 of {} random sets of list {list}", place.name, paper::RANDOM_SETS),
        |list| {
            let seed = context.seed(Purpose::RandomSets, *list);
            let draw = |set: u64| sample(&mut stream(seed, set), context.settings.candidates, paper::POSES).into_vec();
            indices_of_random_sets(context, &place, *list, paper::RANDOM_SETS, draw)
        },
    )?;
    let summaries: Vec<RunningStats> = values.iter().map(|v| RunningStats::of(v.iter().copied())).collect();
    let over = |f: fn(&RunningStats) -> f64| Spread::of(&summaries.iter().map(f).collect::<Vec<f64>>());
    let (mean, largest) = paper::RANDOM_O1;
    let comparisons = vec![
        Comparison::new("mean O1 of 1000 random sets of 20 poses", "", mean, over(RunningStats::mean)),
        Comparison::new("largest O1 of 1000 random sets", "", largest, over(RunningStats::largest)),
    ];
    let comment = "Figure 7: O1 (mm, rad) of random sets of 20 poses, for each list of candidates";
    let mut listing = Listing::new("figure7", comment, &["list", "set", "o1"]);
    for (list, of_list) in values.iter().enumerate() {
        for (set, v) in of_list.iter().enumerate() {
            listing.row(&[&list.to_string(), &set.to_string()], &[*v]);
        }
    }
    let first = &summaries[0];
    let searched = Wanted::over(context, How::Tabu("o1"), paper::POSES, context.settings.lists);
    let searched = RunningStats::of(choose(context, &place, "figure 7", &searched)?.iter().map(|c| c.value));
    let random = over(RunningStats::mean).mean;
    let findings = vec![format!(
        "The best of a thousand random sets has {:.2} times the mean; sets chosen by tabu DETMAX from the same candidates \
         have {:.2} times. Drawing more sets does not replace choosing.",
        over(RunningStats::largest).mean / random,
        searched.mean() / random
    )];
    Ok(Exhibit {
        name: "figure7",
        title: "O1 of 1000 random sets of 20 poses",
        comparisons,
        findings,
        listings: vec![listing],
        figure: figure(&values[0], first),
        took: None,
    })
}

fn figure(values: &[f64], summary: &RunningStats) -> Figure {
    let (low, high) = (summary.least(), summary.largest());
    let width = (high - low) / BARS as f64;
    let bars = super::figure5::histogram(values, low, width, BARS);
    let panel = Panel {
        x: Axis::linear("O1 (mm, rad), first list of candidates"),
        y: Axis::linear("sets"),
        series: vec![Series::new("", 0, Shape::Bars { width }, bars)],
        rules: vec![
            Rule { horizontal: false, at: paper::RANDOM_O1.0, label: "paper, mean".into() },
            Rule { horizontal: false, at: paper::RANDOM_O1.1, label: "paper, largest".into() },
        ],
        ..Panel::default()
    };
    Figure {
        title: "Figure 7: O1 of random sets".into(),
        description: format!("Histogram of O1 of 1000 random sets: mean {:.5}, largest {high:.5}.", summary.mean()),
        columns: 1,
        panels: vec![panel],
    }
}
