//! Errors row by row.

use crate::identification::ModelErrors;
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};

/// A model's errors and what it is called.
pub(super) type Named<'a> = (&'a str, &'a ModelErrors);

/// Micrometres in a metre.
pub(super) const MICROMETRES: f64 = 1e6;
/// Arc seconds in a radian.
pub(super) const ARCSECONDS: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// Position and attitude error of each row for some models, with the stated noise of a vector length (m, rad).
pub(super) fn by_row(models: &[Named<'_>], noise: Option<(f64, f64)>) -> Figure {
    let panel = |title: &str,
                 label: &str,
                 of: fn(&crate::identification::PoseErrors) -> Option<f64>,
                 unit: f64,
                 rule: Option<f64>| {
        let series = |(colour, (name, errors)): (usize, &Named<'_>)| {
            let points = errors.samples.iter().filter_map(|s| Some([s.row as f64, unit * of(s)?])).collect();
            Series::new(*name, colour, Shape::Dots, points)
        };
        Panel {
            title: title.into(),
            x: Axis::linear("data row"),
            y: Axis::log(label),
            series: models.iter().enumerate().map(series).collect(),
            rules: rule
                .map(|at| Rule { horizontal: true, at: unit * at, label: "stated noise".into() })
                .into_iter()
                .collect(),
            ..Panel::default()
        }
    };
    let panels = vec![
        panel("Position", "position error (um)", |s| s.position, MICROMETRES, noise.map(|n| n.0)),
        panel("Attitude", "angle error (arcsec)", |s| s.rotation, ARCSECONDS, noise.map(|n| n.1)),
    ];
    let panels: Vec<Panel> =
        panels.into_iter().filter(|p: &Panel| p.series.iter().any(|s| !s.points.is_empty())).collect();
    let names: Vec<&str> = models.iter().map(|(name, _)| *name).collect();
    Figure {
        title: "Errors row by row".into(),
        description: format!(
            "Length of the error of each measured row on a logarithmic axis, for {}.",
            names.join(" and ")
        ),
        columns: 2,
        panels,
    }
}
