//! Errors row by row.

use super::{ARCSECONDS, GROSS, MICROMETRES, ModelResiduals};
use crate::identification::SampleError;
use crate::measurement::{DataRow, RowKind};
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};

/// Position and attitude error of each row for some models, beside the length that the stated noise (m, rad of one component)
/// gives; rows that look like gross errors are marked.
pub(in crate::report::html) fn by_row(
    models: &[&ModelResiduals],
    noise: Option<[f64; 2]>,
    gross: &[DataRow],
) -> Figure {
    // The length of a vector of as many components as were measured.
    let components = |kind: RowKind| {
        let first = models.first().and_then(|m| m.deviations.first());
        first.map_or(3, |d| d.readings.iter().filter(|(of, _)| *of == kind).count().min(3)) as f64
    };
    let panel = |title: &str, label: &str, of: fn(&SampleError) -> Option<f64>, unit: f64, sigma: Option<f64>| {
        let series = |(colour, model): (usize, &&ModelResiduals)| {
            let points = model.errors.samples.iter().filter_map(|s| Some([s.row.0 as f64, unit * of(s)?])).collect();
            Series::new(&model.name, colour, Shape::Dots, points)
        };
        let at = |sigma: f64| Rule { horizontal: true, at: unit * sigma, label: "stated noise".into() };
        let mut series: Vec<Series> = models.iter().enumerate().map(series).collect();
        if let Some(first) = series.first_mut().filter(|_| !gross.is_empty()) {
            let (far, near) = first.points.iter().partition(|p| gross.contains(&DataRow(p[0] as usize)));
            first.points = near;
            series.push(Series::new(GROSS, 3, Shape::Dots, far));
        }
        Panel {
            title: title.into(),
            x: Axis::linear("data row"),
            y: Axis::log(label),
            series,
            rules: sigma.map(at).into_iter().collect(),
            ..Panel::default()
        }
    };
    let panels = [
        panel(
            "Position",
            "position error (um)",
            |s| s.position,
            MICROMETRES,
            noise.map(|n| n[0] * components(RowKind::Position).sqrt()),
        ),
        panel(
            "Attitude",
            "angle error (arcsec)",
            |s| s.rotation,
            ARCSECONDS,
            noise.map(|n| n[1] * components(RowKind::Rotation).sqrt()),
        ),
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
