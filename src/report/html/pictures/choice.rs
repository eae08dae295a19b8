//! Predicted accuracy of chosen poses.

use super::maps::shown;
use super::scale::AxisUnit;
use crate::pose::{Pose, PoseConvention};
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};
use crate::selection::ChosenSet;

/// The index over the iterations of the selector, beside the certified bound.
pub(in crate::report::html) fn trace(r: &ChosenSet) -> Figure {
    let points = r.trace.iter().enumerate().map(|(k, v)| [k as f64, *v]).collect();
    let last = r.trace.len().saturating_sub(1) as f64;
    let bound = |at: f64| Rule { horizontal: true, at, label: "no set of these candidates is better".into() };
    let end = Series::new("the chosen set", 1, Shape::Dots, vec![[last, r.value]]);
    let panel = Panel {
        x: Axis::linear("iteration"),
        y: Axis::linear(r.index.clone()),
        series: vec![Series::new("best set so far", 0, Shape::Line, points), end],
        rules: r.bound.map(bound).into_iter().collect(),
        ..Panel::default()
    };
    Figure {
        title: format!("{} over the iterations", r.index),
        description: "Index of the best set after each iteration of the selector, with the certified bound as a line."
            .into(),
        columns: 1,
        panels: vec![panel],
    }
}

/// The poses, in the base frame, in four planes of the workspace.
pub(in crate::report::html) fn coverage(poses: &[Pose], given: usize, convention: &PoseConvention) -> Figure {
    let coordinates: Vec<[f64; 6]> = poses.iter().map(|p| shown(&convention.coordinates(p))).collect();
    let planes = [
        ("x (mm)", 0, "y (mm)", 1),
        ("x (mm)", 0, "z (mm)", 2),
        ("rx (°)", 3, "ry (°)", 4),
        ("rx (°)", 3, "rz (°)", 5),
    ];
    let panel = |(x, i, y, j): (&str, usize, &str, usize)| {
        let series = |name: &str, colour: usize, of: &[[f64; 6]]| {
            let (points, sizes) = stacked(of.iter().map(|q| [q[i], q[j]]));
            Series::new(name, colour, Shape::Bubbles { sizes, full: 0.5 * coordinates.len() as f64 }, points)
        };
        let mut series = vec![
            series("chosen; larger circles are several poses", 0, &coordinates[given..]),
            series("given", 1, &coordinates[..given]),
        ];
        series.retain(|s| !s.points.is_empty());
        Panel { x: Axis::linear(x), y: Axis::linear(y), series, ..Panel::default() }
    };
    Figure {
        title: "Where the poses lie, base frame".into(),
        description: "The chosen poses in four planes of the workspace.".into(),
        columns: 2,
        panels: planes.into_iter().map(panel).collect(),
    }
}

/// Places and how many points lie at each; corners of a workspace are shared by many poses.
fn stacked(points: impl Iterator<Item = [f64; 2]>) -> (Vec<[f64; 2]>, Vec<f64>) {
    let (mut places, mut counts): (Vec<[f64; 2]>, Vec<f64>) = (Vec::new(), Vec::new());
    for point in points {
        let same = |p: &[f64; 2]| (p[0] - point[0]).abs() < 1e-6 && (p[1] - point[1]).abs() < 1e-6;
        match places.iter().position(same) {
            Some(k) => counts[k] += 1.0,
            None => {
                places.push(point);
                counts.push(1.0);
            }
        }
    }
    (places, counts)
}

/// Predicted error of the calibrated pose and efficiency over the number of poses.
pub(in crate::report::html) fn how_many(table: &[ChosenSet], n: usize) -> Figure {
    let points = |of: &dyn Fn(&ChosenSet) -> Option<f64>| -> Vec<[f64; 2]> {
        table.iter().filter_map(|r| Some([r.poses.len() as f64, of(r)?])).collect()
    };
    let error = |r: &ChosenSet| r.forecast.as_ref().map(|f| f.error);
    let panel = |title: &str, label: &str, points: Vec<[f64; 2]>| Panel {
        title: title.into(),
        x: Axis::linear("number of poses"),
        y: Axis::linear(label),
        series: vec![Series::new("", 0, Shape::LineWithDots, points)],
        rules: vec![Rule { horizontal: false, at: n as f64, label: "chosen".into() }],
        ..Panel::default()
    };
    let errors = || table.iter().filter_map(error);
    let lengths = AxisUnit::of_lengths(errors().map(|e| e.position_rms));
    let angles = AxisUnit::of_angles(errors().map(|e| e.rotation_rms));
    let label = |unit: AxisUnit| format!("predicted RMS error ({})", unit.name);
    let panels = [
        panel("Position", &label(lengths), points(&|r| Some(lengths.per_si * error(r)?.position_rms))),
        panel("Attitude", &label(angles), points(&|r| Some(angles.per_si * error(r)?.rotation_rms))),
        panel("Efficiency", "certified efficiency (%)", points(&|r| Some(100.0 * r.efficiency?))),
    ];
    Figure {
        title: "How many poses".into(),
        description: "Predicted RMS error of the calibrated pose and certified efficiency over the number of poses."
            .into(),
        columns: 3,
        panels: panels.into_iter().filter(|p| !p.series[0].points.is_empty()).collect(),
    }
}
