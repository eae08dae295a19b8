//! Figure 9: errors at each of 150 targets, after one calibration with chosen and one with random poses.

use super::calibrations::{Fit, Study, Truth};
use super::context::Purpose;
use super::exhibit::Listing;
use super::figure8::{chosen_set, one_draw};
use super::sets::{How, Place, Wanted, choose};
use super::{Comparison, Exhibit, ReproduceError, ReproductionContext, Spread, paper};
use crate::pose::Pose;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::simulation::TargetErrors;

/// Random sets of which the median is shown.
const RANDOM_SETS: u64 = 21;

pub(super) fn exhibit(context: &ReproductionContext<'_>) -> Result<Exhibit, ReproduceError> {
    let place = Place::of_section_5()?;
    let truth = paper::with_table_6(place.nominal())?;
    let targets = place.random(context.seed(Purpose::Targets, 0), paper::TARGETS.1);
    // All calibrations have the same noise, as in the paper.
    let calibrated = |poses: Vec<Pose>| -> Result<TargetErrors, ReproduceError> {
        let study = Study {
            place: &place,
            set: String::new(),
            poses,
            targets: &targets,
            at: "150 targets".into(),
            noise: paper::noise(),
            truth: Truth::Table6,
            fit: Fit::Paper,
            draws: 1,
            seed: 0,
        };
        Ok(study.run_once(truth.as_ref(), &mut one_draw(context, 0))?.errors)
    };
    let wanted = Wanted::over(context, How::Random, paper::POSES, RANDOM_SETS);
    let mut random = choose(context, &place, "figure 9", &wanted)?
        .iter()
        .map(|set| calibrated(set.poses()))
        .collect::<Result<Vec<TargetErrors>, ReproduceError>>()?;
    random.sort_by(|a, b| a.integrated().total_cmp(&b.integrated()));
    let typical = random.swap_remove(random.len() / 2);
    let errors = [("with O1", calibrated(chosen_set(context, &place)?)?), ("traditional", typical)];
    let comment = "Figure 9: errors at 150 targets after one calibration";
    let header = ["calibration", "target", "position_error_mm", "attitude_error_deg"];
    let mut listing = Listing::new("figure9", comment, &header);
    let mut comparisons = Vec::new();
    for (k, (name, e)) in errors.iter().enumerate() {
        for (target, (p, r)) in e.positions.iter().zip(&e.rotations).enumerate() {
            listing.row(&[name, &(target + 1).to_string()], &[1e3 * p, r.to_degrees()]);
        }
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let [_, position, _, attitude] = paper::TABLE_8[k];
        let one = |what: &str, unit, printed: f64, ours: f64| {
            let row =
                Comparison::ours(format!("{name}: mean {what} error of this one draw"), unit, Spread::exactly(ours));
            Comparison { paper: Some(printed), ..row }.because("one draw beside another: table8 has the distribution")
        };
        comparisons.push(one("position", "mm", position, 1e3 * mean(&e.positions)));
        comparisons.push(one("attitude", "deg", attitude, mean(&e.rotations).to_degrees()));
    }
    let better =
        |f: fn(&TargetErrors) -> &Vec<f64>| f(&errors[0].1).iter().zip(f(&errors[1].1)).filter(|(a, b)| a < b).count();
    let findings = vec![format!(
        "Under the same noise the calibration with O1 is the better at {} of 150 targets in position and at {} in attitude. The \
         random set shown is the median of {RANDOM_SETS} by its integrated error.",
        better(|e| &e.positions),
        better(|e| &e.rotations)
    )];
    let title = "Position and attitude errors at 150 targets, one calibration each";
    let figure = figure(&errors);
    Ok(Exhibit { name: "figure9", title, comparisons, findings, listings: vec![listing], figure, took: None })
}

fn figure(errors: &[(&'static str, TargetErrors)]) -> Figure {
    let panel = |title: &str, label: &str, of: fn(&TargetErrors) -> Vec<f64>| Panel {
        title: title.into(),
        x: Axis::linear("target"),
        y: Axis::linear(label),
        series: errors
            .iter()
            .enumerate()
            .map(|(k, (name, e))| {
                let points = of(e).iter().enumerate().map(|(t, v)| [t as f64 + 1.0, *v]).collect();
                Series::new(*name, k, Shape::LineWithDots, points)
            })
            .collect(),
        ..Panel::default()
    };
    Figure {
        title: "Figure 9: errors at 150 targets".into(),
        description:
            "Two panels, position and attitude: errors at each target after a calibration with O1 and after one with \
                      random poses; the former lie lower."
                .into(),
        columns: 1,
        panels: vec![
            panel("position", "position error (mm)", |e| e.positions.iter().map(|p| 1e3 * p).collect()),
            panel("attitude", "attitude error (deg)", |e| e.rotations.iter().map(|r| r.to_degrees()).collect()),
        ],
    }
}
