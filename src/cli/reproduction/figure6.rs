//! Figure 6: O1 during the search for 20 poses.

use super::exhibit::Listing;
use super::sets::{Chosen, How, Place, Wanted, choose};
use super::{Comparison, Exhibit, ReproduceError, ReproductionContext, Spread, paper};
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::simulation::RunningStats;

pub(super) fn exhibit(context: &ReproductionContext<'_>) -> Result<Exhibit, ReproduceError> {
    let place = Place::of_section_5()?;
    let searches = |how: How| {
        choose(context, &place, "figure 6", &Wanted::over(context, how, paper::POSES, context.settings.lists))
    };
    let (tabu, plain) = (searches(How::Tabu("o1"))?, searches(How::Detmax("o1"))?);
    let (value, to_best, to_end) = paper::SEARCH;
    let over = |chosen: &[Chosen], f: fn(&Chosen) -> f64| Spread::of(&chosen.iter().map(f).collect::<Vec<f64>>());
    let comparisons = vec![
        Comparison::new("O1 of the chosen set, tabu DETMAX", "", value, over(&tabu, |c| c.value))
            .not_judged()
            .because("judged in table1"),
        Comparison::new("iterations to the best, tabu DETMAX", "", to_best, over(&tabu, iterations_to_best)),
        Comparison::new("iterations to the end, DETMAX", "", to_end, over(&plain, |c| c.iterations as f64)),
    ];
    let comment = "Figure 6: O1 (mm, rad) after each iteration, for each list of candidates";
    let mut listing = Listing::new("figure6", comment, &["method", "list", "iteration", "o1"]);
    for (method, chosen) in [("tabu DETMAX", &tabu), ("DETMAX", &plain)] {
        for (list, c) in chosen.iter().enumerate() {
            for (k, v) in c.trace.iter().enumerate() {
                listing.row(&[method, &list.to_string(), &k.to_string()], &[*v]);
            }
        }
    }
    let gain = RunningStats::of(tabu.iter().zip(&plain).map(|(t, p)| 100.0 * (t.value / p.value - 1.0)));
    let findings = vec![format!(
        "The list lets the search leave the set at which DETMAX ends; the best set seen is {:.1} % better (mean over {} lists).",
        gain.mean(),
        gain.count()
    )];
    Ok(Exhibit {
        name: "figure6",
        title: "O1 during the search, tabu DETMAX and DETMAX",
        comparisons,
        findings,
        listings: vec![listing],
        figure: figure(&tabu[0], &plain[0]),
        took: None,
    })
}

/// Values within this part of the largest are the largest.
const SAME: f64 = 1e-9;

fn iterations_to_best(c: &Chosen) -> f64 {
    let best = c.trace.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    c.trace.iter().position(|v| *v >= best * (1.0 - SAME)).map_or(f64::NAN, |k| k as f64)
}

fn figure(tabu: &Chosen, plain: &Chosen) -> Figure {
    let points = |c: &Chosen| c.trace.iter().enumerate().map(|(k, v)| [k as f64, *v]).collect();
    let best = tabu.value;
    let panel = |title: &str, range: Option<(f64, f64)>| Panel {
        title: title.into(),
        x: Axis::linear("iteration"),
        y: Axis { range, ..Axis::linear("O1 (mm, rad)") },
        series: vec![
            Series::new("tabu DETMAX", 0, Shape::Line, points(tabu)),
            Series::new("DETMAX", 1, Shape::Line, points(plain)),
        ],
        ..Panel::default()
    };
    Figure {
        title: "Figure 6: the search for 20 poses".into(),
        description:
            "O1 after each iteration: both searches climb steeply for twenty iterations; DETMAX ends there, tabu \
                      DETMAX goes on slowly."
                .into(),
        columns: 2,
        panels: vec![
            panel("first list of candidates", None),
            panel("the same near the end", Some((0.97 * best, 1.005 * best))),
        ],
    }
}
