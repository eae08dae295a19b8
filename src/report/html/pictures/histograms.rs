//! Residuals compared with the noise.

use std::f64::consts::{PI, SQRT_2};

use super::ModelResiduals;
use super::scale::AxisUnit;
use crate::measurement::{DataRow, RowKind};
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};

/// Fewest and most bins.
const BINS: [usize; 2] = [9, 31];
/// Points of the curve of the noise.
const CURVE: usize = 61;

/// Components of the residual of each model, beside the curve of the stated noise (σ of a component, m and rad).
pub(in crate::report::html) fn histograms(
    models: &[&ModelResiduals],
    noise: Option<[f64; 2]>,
    gross: &[DataRow],
) -> Figure {
    let mut panels = Vec::new();
    for (colour, model) in models.iter().enumerate() {
        let usual = || model.deviations.iter().filter(|d| !gross.contains(&d.row)).flat_map(|d| &d.readings);
        let of = |kind: RowKind| usual().filter(move |(of, v)| *of == kind && v.is_finite()).map(|(_, v)| *v);
        let kinds = [
            (RowKind::Position, "position component", AxisUnit::of_lengths(of(RowKind::Position))),
            (RowKind::Rotation, "angle component", AxisUnit::of_angles(of(RowKind::Rotation))),
        ];
        for (k, (kind, label, unit)) in kinds.into_iter().enumerate() {
            let values: Vec<f64> = of(kind).map(|v| unit.per_si * v).collect();
            if !values.is_empty() {
                let label = format!("{label} ({})", unit.name);
                panels.push(panel(&model.name, colour, &label, &values, noise.map(|n| unit.per_si * n[k])));
            }
        }
    }
    Figure {
        title: "Residuals against the noise".into(),
        description:
            "Histograms of the components of measured minus predicted for each model, with the curve expected from \
             the stated noise alone, unless it is too narrow to be seen; rows with gross errors are left out."
                .into(),
        columns: 2,
        panels,
    }
}

fn panel(name: &str, colour: usize, label: &str, values: &[f64], sigma: Option<f64>) -> Panel {
    let largest = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let half = largest.max(sigma.map_or(0.0, |s| 3.0 * s)).max(f64::MIN_POSITIVE);
    let bins = ((2.0 * (values.len() as f64).sqrt()) as usize).clamp(BINS[0], BINS[1]) | 1;
    let width = 2.0 * half / bins as f64;
    let mut counts = vec![0.0; bins];
    for v in values {
        let bin = (((v + half) / width) as usize).min(bins - 1);
        counts[bin] += 1.0;
    }
    let middle = |k: usize| -half + (k as f64 + 0.5) * width;
    let points = counts.iter().enumerate().map(|(k, n)| [middle(k), *n]).collect();
    let mut series = vec![Series::new(name, colour, Shape::Bars { width }, points)];
    // A curve narrower than a bin would only be a spike.
    if let Some(sigma) = sigma.filter(|s| *s > 0.5 * width) {
        let full = values.len() as f64 * width / (sigma * (2.0 * PI).sqrt());
        let at = |k: usize| -half + 2.0 * half * k as f64 / (CURVE - 1) as f64;
        let curve = (0..CURVE).map(|k| [at(k), full * (-(at(k) / (SQRT_2 * sigma)).powi(2)).exp()]).collect();
        series.push(Series::new("stated noise alone", 6, Shape::Line, curve));
    }
    Panel { x: Axis::linear(label), y: Axis::linear("readings"), series, ..Panel::default() }
}
