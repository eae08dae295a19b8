//! Errors over the workspace.

use super::ModelResiduals;
use crate::identification::SampleError;
use crate::measurement::DataRow;
use crate::pose::PoseConvention;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::report::html::typeset::in_print;
use crate::units::{show_angle, show_length};

/// Coordinates that make a map: name, its place in the pose, unit.
const PLANES: [[(&str, usize); 2]; 3] = [[("x", 0), ("y", 1)], [("x", 0), ("z", 2)], [("rx", 3), ("ry", 4)]];

/// The error of each sample as a circle at its pose, in three planes of the workspace; a row of maps for each model.
pub(in crate::report::html) fn maps(
    models: &[&ModelResiduals],
    convention: &PoseConvention,
    gross: &[DataRow],
) -> Figure {
    let measured = models.first().is_some_and(|m| m.errors.samples.iter().any(|s| s.position.is_some()));
    let of = |s: &SampleError| if measured { s.position } else { s.rotation };
    let show: fn(f64) -> String = if measured { show_length } else { show_angle };
    let poses = |model: &ModelResiduals| -> Vec<[f64; 6]> {
        model.deviations.iter().map(|d| convention.coordinates(&d.pose)).map(|q| shown(&q)).collect()
    };
    let changes = |k: usize| models.iter().any(|m| poses(m).windows(2).any(|w| w[0][k] != w[1][k]));
    let planes: Vec<[(&str, usize); 2]> =
        PLANES.into_iter().filter(|plane| plane.iter().any(|(_, k)| changes(*k))).collect();
    // The maps of all models have the same axes.
    let everywhere: Vec<[f64; 6]> = models.iter().flat_map(|m| poses(m)).collect();
    let ends = |k: usize| {
        let values = everywhere.iter().map(|q| q[k]).filter(|v| v.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        (low <= high).then_some((low, high))
    };
    let axis = |(name, k): (&str, usize)| Axis {
        besides: ends(k),
        ..Axis::linear(format!("{name} ({})", if k < 3 { "mm" } else { "°" }))
    };
    let mut panels = Vec::new();
    for (colour, model) in models.iter().enumerate() {
        let sizes: Vec<f64> = model.errors.samples.iter().map(|s| of(s).unwrap_or(f64::NAN)).collect();
        // One gross row would shrink all others to points.
        let rows = model.errors.samples.iter().zip(&sizes);
        let usual = rows.filter(|(s, size)| size.is_finite() && !gross.contains(&s.row)).map(|(_, size)| *size);
        let largest = usual.fold(0.0, f64::max);
        let coordinates = poses(model);
        for plane in &planes {
            let points = coordinates.iter().map(|q| plane.map(|(_, k)| q[k])).collect();
            let shape = Shape::Bubbles { sizes: sizes.clone(), full: largest };
            panels.push(Panel {
                x: axis(plane[0]),
                y: axis(plane[1]),
                series: vec![Series::new(
                    format!(
                        "{}; the largest circle is {}{}",
                        model.name,
                        in_print(&show(largest)),
                        if gross.is_empty() { "" } else { " or a gross error" }
                    ),
                    colour,
                    shape,
                    points,
                )],
                ..Panel::default()
            });
        }
    }
    let what = if measured { "position" } else { "angle" };
    Figure {
        title: format!("Where in the workspace, base frame: {what} error by area of the circle"),
        description: format!(
            "Each sample at its pose in the base frame, in three planes of the workspace, as a circle whose area is its {what} error; a row of \
             maps for each model."
        ),
        columns: 3,
        panels,
    }
}

/// Coordinates of a pose in mm and degrees, without the rounding of what is zero.
pub(super) fn shown(q: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|k| {
        let value = if k < 3 { 1e3 * q[k] } else { q[k].to_degrees() };
        (value * 1e9).round() * 1e-9
    })
}
