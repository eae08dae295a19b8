//! Evidence for the causes of a diagnosis.

use super::scale::AxisUnit;
use crate::diagnosis::{Cause, Diagnosis};
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};

/// Added-variable plot of each named cause.
pub(in crate::report::html) fn added_variable(causes: &[Cause]) -> Figure {
    let panel = |c: &Cause| {
        let points = c.added_variable.points.clone();
        let (low, high) = points.iter().fold((0.0_f64, 0.0_f64), |(a, b), p| (a.min(p[0]), b.max(p[0])));
        let leg = c.leg.map_or_else(String::new, |leg| format!(", leg {}", leg + 1));
        Panel {
            title: format!("{}{leg}", c.effect),
            x: Axis::linear("part of the cause that nothing else imitates (σ)"),
            y: Axis::linear("residual without the cause (σ)"),
            series: vec![
                Series::new("a reading", 0, Shape::Dots, points),
                Series::new("what the cause predicts", 1, Shape::Line, vec![[low, low], [high, high]]),
            ],
            ..Panel::default()
        }
    };
    Figure {
        title: "Added-variable plots".into(),
        description: "For each named cause, the residual of each reading in the model without the cause, plotted against the part of \
                      the cause that neither parameters nor other causes imitate, both in units of the noise; a true cause follows \
                      the line."
            .into(),
        columns: causes.len().min(2),
        panels: causes.iter().map(panel).collect(),
    }
}

/// Held-out errors without and with the causes.
pub(in crate::report::html) fn gain(d: &Diagnosis) -> Figure {
    let g = &d.gain;
    let lengths = AxisUnit::of_lengths([g.position_before, g.position_after].into_iter().flatten());
    let angles = AxisUnit::of_angles([g.rotation_before, g.rotation_after].into_iter().flatten());
    let panel =
        |title: &str, label: &str, before: Option<f64>, after: Option<f64>, floor: Option<f64>, unit: AxisUnit| {
            let bars = [before, after].into_iter().enumerate();
            let points = bars.filter_map(|(k, v)| Some([k as f64, unit.per_si * v?])).collect();
            Panel {
                title: title.into(),
                x: Axis::named("", vec!["parameters alone".into(), "with the causes".into()]),
                y: Axis::linear(format!("{label} ({})", unit.name)),
                series: vec![Series::new("", 0, Shape::Bars { width: 0.5 }, points)],
                rules: floor
                    .map(|at| Rule { horizontal: true, at: unit.per_si * at, label: "stated noise".into() })
                    .into_iter()
                    .collect(),
                ..Panel::default()
            }
        };
    let panels = [
        panel("Position", "RMS", g.position_before, g.position_after, g.noise_floor_position, lengths),
        panel("Attitude", "RMS", g.rotation_before, g.rotation_after, g.noise_floor_rotation, angles),
    ];
    Figure {
        title: "Error on held-out rows".into(),
        description:
            "RMS position and angle error on held-out rows, with the kinematic parameters alone and with the causes, \
             compared with the stated noise."
                .into(),
        columns: 2,
        panels: panels.into_iter().filter(|p| !p.series[0].points.is_empty()).collect(),
    }
}

/// Values of the causes over their usual sizes.
pub(in crate::report::html) fn sizes(d: &Diagnosis) -> Figure {
    let all: Vec<(String, f64, f64)> = d
        .causes
        .iter()
        .flat_map(|c| {
            let leg = c.leg.map_or_else(String::new, |leg| format!(" leg {}", leg + 1));
            let name = move |p: &str| format!("{}{leg} {p}", c.effect);
            c.parameters.iter().map(move |p| (name(&p.name), p.value / p.scale, 2.0 * p.sigma.unwrap_or(0.0) / p.scale))
        })
        .collect();
    let points = all.iter().enumerate().map(|(k, (_, v, _))| [k as f64, *v]).collect();
    let ends = all.iter().map(|(_, v, half)| [v - half, v + half]).collect();
    let panel = Panel {
        x: Axis::named("parameter", all.iter().map(|(name, ..)| name.clone()).collect()),
        y: Axis::linear("value relative to its usual size, ± 2 σ"),
        series: vec![Series::new("", 0, Shape::ErrorBars { ends }, points)],
        rules: vec![Rule { horizontal: true, at: 0.0, label: String::new() }],
        ..Panel::default()
    };
    Figure {
        title: "Sizes of the causes".into(),
        description: "Each value of the named causes relative to the usual size of its effect, with its \
                      uncertainty."
            .into(),
        columns: 1,
        panels: vec![panel],
    }
}
