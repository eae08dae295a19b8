//! Identified parameters.

use nalgebra::DMatrix;

use crate::identification::Estimate;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::units::Dimension;

/// More parameters than this make no readable matrix.
const MOST: usize = 60;

/// Deviations of lengths from the file with ± 2 σ, mm.
pub(in crate::report::html) fn deviations(parameters: &[Estimate]) -> Option<Figure> {
    let lengths: Vec<&Estimate> = parameters.iter().filter(|p| p.spec.dimension == Dimension::Length).collect();
    if lengths.is_empty() {
        return None;
    }
    let mm = |p: &Estimate| 1e3 * (p.value - p.start);
    let points: Vec<[f64; 2]> = lengths.iter().enumerate().map(|(k, p)| [k as f64, mm(p)]).collect();
    let end = |p: &&Estimate| {
        let half = 2e3 * p.sigma.unwrap_or(0.0);
        [mm(p) - half, mm(p) + half]
    };
    let ends = lengths.iter().map(end).collect();
    let mut series = vec![Series::new("deviation, ± 2 sigma", 0, Shape::ErrorBars { ends }, points)];
    let tolerance = |sign: f64| -> Vec<[f64; 2]> {
        let at = |(k, p): (usize, &&Estimate)| Some([k as f64, sign * 1e3 * p.spec.tolerance?]);
        lengths.iter().enumerate().filter_map(at).collect()
    };
    series.push(Series::new("tolerance, 1 sigma", 1, Shape::Dashed, tolerance(1.0)));
    series.push(Series::new("tolerance, 1 sigma", 1, Shape::Dashed, tolerance(-1.0)));
    let panel = Panel {
        x: Axis::named("parameter", lengths.iter().map(|p| p.spec.name.clone()).collect()),
        y: Axis::linear("deviation from the file (mm)"),
        series,
        ..Panel::default()
    };
    Some(Figure {
        title: "Deviations of the length parameters".into(),
        description:
            "Deviation of each length parameter from the mechanism file with its uncertainty, compared with its \
             tolerance."
                .into(),
        columns: 1,
        panels: vec![panel],
    })
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
