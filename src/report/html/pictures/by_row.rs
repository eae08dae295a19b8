//! Errors row by row.

use super::scale::AxisUnit;
use super::{GROSS, ModelResiduals};
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
    let sizes = |of: fn(&SampleError) -> Option<f64>| models.iter().flat_map(|m| &m.errors.samples).filter_map(of);
    let panel = |title: &str, label: &str, of: fn(&SampleError) -> Option<f64>, unit: AxisUnit, sigma: Option<f64>| {
        let series = |(colour, model): (usize, &&ModelResiduals)| {
            let point = |s: &SampleError| Some([s.row.0 as f64, unit.per_si * of(s)?]);
            Series::new(&model.name, colour, Shape::Dots, model.errors.samples.iter().filter_map(point).collect())
        };
        let at = |sigma: f64| Rule { horizontal: true, at: unit.per_si * sigma, label: "stated noise".into() };
        let mut series: Vec<Series> = models.iter().enumerate().map(series).collect();
        if let Some(first) = series.first_mut().filter(|_| !gross.is_empty()) {
            let (far, near) = first.points.iter().partition(|p| gross.contains(&DataRow(p[0] as usize)));
            first.points = near;
            series.push(Series::new(GROSS, 3, Shape::Dots, far));
        }
        Panel {
            title: title.into(),
            x: Axis::linear("data row"),
            y: Axis::log(format!("{label} ({})", unit.name)),
            series,
            rules: sigma.map(at).into_iter().collect(),
            ..Panel::default()
        }
    };
    let (position, rotation) = (|s: &SampleError| s.position, |s: &SampleError| s.rotation);
    let stated = |k: usize, kind: RowKind| noise.map(|n| n[k] * components(kind).sqrt());
    let lengths = AxisUnit::of_lengths(sizes(position));
    let angles = AxisUnit::of_angles(sizes(rotation));
    let panels = [
        panel("Position", "position error", position, lengths, stated(0, RowKind::Position)),
        panel("Attitude", "angle error", rotation, angles, stated(1, RowKind::Rotation)),
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
