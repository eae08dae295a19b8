//! Identified parameters.

use nalgebra::DMatrix;

use super::scale::AxisUnit;
use crate::identification::Estimate;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::units::{Dimension, show_length};

/// More parameters than this make no readable matrix.
const MOST: usize = 60;

/// The axis ends at this many of the largest σ, or of the largest tolerance.
const SIGMAS: f64 = 10.0;
const TOLERANCES: f64 = 5.0;
/// Deviations up to this, m, are not shown in millimetres.
const LEAST: f64 = 5e-5;

/// Deviations of lengths from the file with ± 2 σ, and the names of those that lie beyond the picture.
pub(in crate::report::html) fn deviations(parameters: &[Estimate]) -> Option<(Figure, Vec<String>)> {
    let lengths: Vec<&Estimate> = parameters.iter().filter(|p| p.spec.dimension == Dimension::Length).collect();
    if lengths.is_empty() {
        return None;
    }
    let of = |p: &Estimate| p.value - p.start;
    let half = |p: &Estimate| 2.0 * p.sigma.unwrap_or(0.0);
    let largest = |v: fn(&Estimate) -> Option<f64>| lengths.iter().filter_map(|p| v(p)).fold(0.0, f64::max);
    let limit = (SIGMAS * largest(|p| p.sigma)).max(TOLERANCES * largest(|p| p.spec.tolerance));
    let needed = lengths.iter().map(|p| of(p).abs() + half(p)).fold(0.0, f64::max);
    // Drawings are in millimetres.
    let shown = if limit > 0.0 { needed.min(limit) } else { needed };
    let unit = if shown > LEAST { AxisUnit::MILLIMETRES } else { AxisUnit::of_lengths([shown]) };
    let beyond = |p: &&&Estimate| limit > 0.0 && of(p).abs() > limit;
    let beyond = lengths.iter().filter(beyond).map(|p| format!("{} ({})", p.spec.name, show_length(of(p)))).collect();
    let at = |k: usize, v: f64| [k as f64, unit.per_si * v];
    let points: Vec<[f64; 2]> = lengths.iter().enumerate().map(|(k, p)| at(k, of(p))).collect();
    let ends = lengths.iter().map(|p| [-1.0, 1.0].map(|side| unit.per_si * (of(p) + side * half(p)))).collect();
    let mut series = vec![Series::new("deviation, ± 2 σ", 0, Shape::ErrorBars { ends }, points)];
    for sign in [1.0, -1.0] {
        let tolerance = |(k, p): (usize, &&Estimate)| Some(at(k, sign * p.spec.tolerance?));
        let points = lengths.iter().enumerate().filter_map(tolerance).collect();
        series.push(Series::new("tolerance, 1 σ", 1, Shape::Dashed, points));
    }
    let mut y = Axis::linear(format!("deviation ({})", unit.name));
    // Ticks beyond the data may reach farther than the data do.
    y.range = (limit > 0.0 && 1.5 * needed > limit).then_some((-unit.per_si * limit, unit.per_si * limit));
    let x = Axis::named("parameter", lengths.iter().map(|p| p.spec.name.clone()).collect());
    let figure = Figure {
        title: "Deviations of the length parameters".into(),
        description:
            "Deviation of each length parameter from the mechanism file with its uncertainty, compared with its \
             tolerance."
                .into(),
        columns: 1,
        panels: vec![Panel { x, y, series, ..Panel::default() }],
    };
    Some((figure, beyond))
}

/// Correlations of the identified parameters as a matrix of tinted cells.
pub(in crate::report::html) fn correlation(parameters: &[Estimate], correlation: &DMatrix<f64>) -> Option<Figure> {
    let n = parameters.len();
    if !(2..=MOST).contains(&n) {
        return None;
    }
    let names: Vec<String> = parameters.iter().map(|p| p.spec.name.clone()).collect();
    // The upper half says nothing new, and the diagonal nothing.
    let (mut points, mut values) = (Vec::new(), Vec::new());
    for i in 0..n {
        for j in 0..i {
            points.push([j as f64, (n - 1 - i) as f64]);
            values.push(correlation[(i, j)]);
        }
    }
    let of = |wanted: fn(f64) -> bool| -> (Vec<[f64; 2]>, Vec<f64>) {
        points.iter().zip(&values).filter(|(_, v)| wanted(**v)).map(|(p, v)| (*p, *v)).unzip()
    };
    let series = |name: &str, colour: usize, (points, values): (Vec<[f64; 2]>, Vec<f64>)| {
        let values = values.into_iter().map(f64::abs).collect();
        Series::new(name, colour, Shape::Cells { values }, points)
    };
    let reversed = names.iter().rev().cloned().collect();
    let panel = Panel {
        x: Axis::named("", names),
        y: Axis::named("", reversed),
        series: vec![
            series("positive correlation (full tint: 1)", 0, of(|v| v > 0.0)),
            series("negative correlation (full tint: -1)", 1, of(|v| v < 0.0)),
        ],
        ..Panel::default()
    };
    Some(Figure {
        title: "Correlations of the identified parameters".into(),
        description:
            "Correlation of each pair of identified parameters, tinted by its size; pairs in full tint can only be \
             determined jointly."
                .into(),
        columns: 1,
        panels: vec![panel],
    })
}
