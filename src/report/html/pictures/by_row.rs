//! Errors row by row.

use super::{ARCSECONDS, MICROMETRES, Seen};
use crate::identification::PoseErrors;
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};

/// Position and attitude error of each row for some models, beside the length of a vector of three components with the
/// stated noise (m, rad of one component).
pub(in crate::report::html) fn by_row(models: &[&Seen], noise: Option<[f64; 2]>) -> Figure {
    let panel = |title: &str, label: &str, of: fn(&PoseErrors) -> Option<f64>, unit: f64, sigma: Option<f64>| {
        let series = |(colour, model): (usize, &&Seen)| {
            let points = model.errors.samples.iter().filter_map(|s| Some([s.row as f64, unit * of(s)?])).collect();
            Series::new(&model.name, colour, Shape::Dots, points)
        };
        let at =
            |sigma: f64| Rule { horizontal: true, at: unit * 3.0_f64.sqrt() * sigma, label: "stated noise".into() };
        Panel {
            title: title.into(),
            x: Axis::linear("data row"),
            y: Axis::log(label),
            series: models.iter().enumerate().map(series).collect(),
            rules: sigma.map(at).into_iter().collect(),
            ..Panel::default()
        }
    };
    let panels = [
        panel("Position", "position error (um)", |s| s.position, MICROMETRES, noise.map(|n| n[0])),
        panel("Attitude", "angle error (arcsec)", |s| s.rotation, ARCSECONDS, noise.map(|n| n[1])),
    ];
    let names: Vec<&str> = models.iter().map(|m| m.name.as_str()).collect();
    Figure {
        title: "Errors row by row".into(),
        description: format!(
            "Length of the error of each measured row on a logarithmic axis, for {}.",
            names.join(" and ")
        ),
        columns: 2,
        panels: panels.into_iter().filter(|p| p.series.iter().any(|s| !s.points.is_empty())).collect(),
    }
}
