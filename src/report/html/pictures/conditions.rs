//! What was recorded beside the readings, over the run.

use std::collections::BTreeSet;

use super::strips::course;
use crate::conditions::{ConditionTable, Extent, TIME, of_leg};
use crate::measurement::{Dataset, Sample};
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::units::{Dimension, Unit};

/// More pictures than this are no overview.
const MOST: usize = 12;

/// Each condition that changes over the time or the row, those of the legs in one picture.
pub(in crate::report::html) fn conditions(data: &Dataset, kinds: &ConditionTable) -> Option<Figure> {
    let names: BTreeSet<&String> = data.iter().flat_map(|s| s.conditions.covariates.keys()).collect();
    let (axis, at) = course(data);
    let mut panels: Vec<Panel> = Vec::new();
    let mut done: BTreeSet<String> = BTreeSet::new();
    for name in names.into_iter().filter(|name| *name != TIME) {
        let kind = kinds.of(name);
        let unit = kind.map_or_else(|| Unit::si(Dimension::None), |k| k.unit());
        let each_leg = kind.filter(|k| k.extent == Extent::EachLeg);
        let members: Vec<(String, String)> = match each_leg {
            Some(kind) if *name != kind.of_all_legs() => {
                (0..legs(data)).map(|leg| (format!("leg {}", leg + 1), of_leg(&kind.name, leg))).collect()
            }
            _ => vec![(String::new(), name.clone())],
        };
        if !done.insert(members[0].1.clone()) {
            continue;
        }
        let series = |(colour, (label, name)): (usize, &(String, String))| {
            let value = |s: &Sample| Some([at(s)?, unit.from_si(s.conditions.get(name)?)]);
            Series {
                plain: true,
                ..Series::new(label.clone(), colour, Shape::Dots, data.iter().filter_map(value).collect())
            }
        };
        let series: Vec<Series> = members.iter().enumerate().map(series).collect();
        let title = match each_leg {
            Some(kind) if members.len() > 1 => format!("{} of the legs", kind.label),
            _ => name.clone(),
        };
        let label = kind.map_or_else(|| name.clone(), |k| labelled(&k.label, k.dimension, unit));
        let panel = Panel { title, x: Axis::linear(axis.clone()), y: Axis::linear(label), series, ..Panel::default() };
        panels.extend(changes(&panel).then_some(panel));
    }
    panels.truncate(MOST);
    (!panels.is_empty()).then(|| Figure {
        title: "What was recorded during the run".into(),
        description: "Each recorded condition that changes, over the time or the data row.".into(),
        columns: 3,
        panels,
    })
}

fn legs(data: &Dataset) -> usize {
    data.iter().map(|s| s.joints.len()).max().unwrap_or(0)
}

fn labelled(label: &str, dimension: Dimension, unit: Unit) -> String {
    match dimension {
        Dimension::None => label.to_owned(),
        Dimension::Temperature => format!("{label} (°C)"),
        _ => format!("{label} ({})", unit.name),
    }
}

fn changes(panel: &Panel) -> bool {
    let values = panel.series.iter().flat_map(|s| &s.points).map(|p| p[1]);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    high - low > 1e-9 * low.abs().max(high.abs())
}
