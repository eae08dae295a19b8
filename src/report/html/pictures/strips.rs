//! Residuals of each leg over the recorded conditions.

use std::collections::BTreeMap;

use super::GROSS;
use super::scale::AxisUnit;
use crate::conditions::{ConditionKind, ConditionTable, Extent, Role, TIME, of_leg};
use crate::measurement::{DataRow, Dataset, Sample};
use crate::mechanism::JointSpec;
use crate::report::chart::{Axis, Figure, Panel, Rule, Series, Shape};
use crate::report::html::Subject;
use crate::units::Dimension;

/// Residuals in the joints under one model.
pub(in crate::report::html) struct Layer<'a> {
    /// What the model is called.
    pub(in crate::report::html) name: &'a str,
    /// Index into the palette.
    pub(in crate::report::html) colour: usize,
    /// Data row and residual of each joint, SI.
    pub(in crate::report::html) residuals: Vec<(DataRow, &'a [f64])>,
}

/// Something over which residuals are drawn.
struct Against {
    title: String,
    label: String,
    /// Of a sample at a leg, in the unit of the label.
    of: Get,
}

/// A recorded value of a sample at a leg.
type Get = Box<dyn Fn(&Sample, usize) -> Option<f64>>;

/// A figure with a strip for each leg, for the row or time, the joint, temperature, elevation and payload, as far as they
/// change, and for `further` covariates. `marked` are data rows that look like gross errors.
pub(in crate::report::html) fn strips(
    data: &Dataset,
    subject: &Subject<'_>,
    layers: &[Layer<'_>],
    marked: &[DataRow],
    further: &[&str],
) -> Vec<Figure> {
    let (joints, kinds) = (subject.mechanism.joints(), subject.condition_kinds);
    let samples: BTreeMap<DataRow, &Sample> = data.iter().map(|s| (s.row, s)).collect();
    let changes = |against: &Against| {
        let values = (0..joints.len()).flat_map(|leg| data.iter().filter_map(move |s| (against.of)(s, leg)));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        high - low > 1e-9 * low.abs().max(high.abs())
    };
    let named = |name: &&str| {
        let wanted = (*name).to_owned();
        let of: Get = Box::new(move |s, _| s.conditions.get(&wanted));
        Against { title: (*name).to_owned(), label: format!("{name} (SI)"), of }
    };
    // Those of a single leg are drawn at their own leg only, and so once more if a finding names one.
    let drawn = |kind: &ConditionKind| kind.role == Role::Clock || kind.pictured && kind.extent == Extent::Machine;
    let further = further.iter().filter(|name| !kinds.of(name).is_some_and(drawn));
    all(data, joints, kinds)
        .into_iter()
        .chain(further.map(named))
        .filter(changes)
        .map(|against| {
            let panel = |(leg, joint): (usize, &JointSpec)| {
                let (unit, per_si) = unit(joint.dimension, layers);
                let mut series = Vec::new();
                let mut gross = Vec::new();
                for layer in layers {
                    let mut points = Vec::new();
                    for (row, residual) in &layer.residuals {
                        let x = samples.get(row).and_then(|s| (against.of)(s, leg));
                        let (Some(x), Some(y)) = (x, residual.get(leg)) else { continue };
                        let to = if marked.contains(row) { &mut gross } else { &mut points };
                        to.push([x, per_si * y]);
                    }
                    series.push(Series { plain: true, ..Series::new(layer.name, layer.colour, Shape::Dots, points) });
                }
                if !marked.is_empty() {
                    series.push(Series::new(GROSS, 1, Shape::Dots, gross));
                }
                Panel {
                    title: joint.name.clone(),
                    x: Axis::linear(against.label.clone()),
                    y: Axis::linear(format!("residual ({unit})")),
                    series,
                    rules: vec![Rule { horizontal: true, at: 0.0, label: String::new() }],
                    ..Panel::default()
                }
            };
            let mut panels: Vec<Panel> = joints.iter().enumerate().map(panel).collect();
            if joints.iter().all(|j| j.dimension == joints[0].dimension) {
                compare(&mut panels);
            }
            Figure {
                title: format!("Leg by leg against {}", against.title),
                description: format!(
                    "Residual of each sample as a change of each joint, measured minus predicted, over {}.",
                    against.title
                ),
                columns: 3,
                panels,
            }
        })
        .collect()
}

/// Gives all panels the same axes, so that legs can be compared; gross errors widen their own panel only.
fn compare(panels: &mut [Panel]) {
    let shared = |k: usize| {
        let usual = panels.iter().flat_map(|p| &p.series).filter(|s| s.name != GROSS).flat_map(|s| &s.points);
        let finite = usual.map(|p| p[k]).filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        (low <= high).then_some((low, high))
    };
    let [x, y] = [0, 1].map(shared);
    for panel in panels {
        (panel.x.besides, panel.y.besides) = (x, y);
    }
}

/// Unit of residuals in joints of a dimension, and how many of it make one in SI.
fn unit(dimension: Dimension, layers: &[Layer<'_>]) -> (&'static str, f64) {
    let sizes = layers.iter().flat_map(|l| &l.residuals).flat_map(|(_, r)| r.iter().copied());
    let of = |unit: AxisUnit| (unit.name, unit.per_si);
    match dimension {
        Dimension::Length => of(AxisUnit::of_lengths(sizes)),
        Dimension::Angle => of(AxisUnit::of_angles(sizes)),
        other => (other.si(), 1.0),
    }
}

/// The axis of the run: the time if every sample has one, or else the data row; and the place of a sample on it.
pub(super) fn course(data: &Dataset) -> (String, fn(&Sample) -> Option<f64>) {
    let times = || data.iter().filter_map(|s| s.conditions.get(TIME));
    let (from, to) = times().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    if data.is_empty() || times().count() < data.len() {
        return ("data row".into(), |s| Some(s.row.0 as f64));
    }
    match to - from {
        span if span < 180.0 => ("time (s)".into(), |s| s.conditions.get(TIME)),
        span if span < 7200.0 => ("time (min)".into(), |s| s.conditions.get(TIME).map(|t| t / 60.0)),
        _ => ("time (h)".into(), |s| s.conditions.get(TIME).map(|t| t / 3600.0)),
    }
}

fn all(data: &Dataset, joints: &[JointSpec], kinds: &ConditionTable) -> Vec<Against> {
    let (label, at) = course(data);
    let title = if label == "data row" { "the data row" } else { "time" };
    let first = Against { title: title.into(), label, of: Box::new(move |s, _| at(s)) };
    let of_joint = joints.first().map_or(Dimension::None, |j| j.dimension);
    let (joint_unit, per_si) = of_joint.in_tables();
    let alike = joints.iter().all(|j| j.dimension == of_joint);
    let joint = Against {
        title: if of_joint == Dimension::Length { "the length of the leg" } else { "the joint" }.into(),
        label: if alike { format!("{} ({joint_unit})", of_joint.noun()) } else { "joint (SI)".into() },
        of: Box::new(move |s, leg| Some(if alike { per_si } else { 1.0 } * s.joints.get(leg)?)),
    };
    [first, joint].into_iter().chain(kinds.iter().filter(|kind| kind.pictured).map(condition)).collect()
}

/// A condition, at each leg where it has one of its own.
fn condition(kind: &ConditionKind) -> Against {
    let (name, all_legs, each_leg) = (kind.name.to_string(), kind.of_all_legs(), kind.extent == Extent::EachLeg);
    let unit = kind.unit();
    let value = move |s: &Sample, leg: usize| match each_leg {
        true => s.conditions.get(&of_leg(&name, leg)).or_else(|| s.conditions.get(&all_legs)),
        false => s.conditions.get(&name),
    };
    let label = match kind.dimension {
        Dimension::None => kind.label.to_string(),
        Dimension::Temperature => format!("{} (°C)", kind.label),
        _ => format!("{} ({})", kind.label, unit.name),
    };
    Against { title: kind.title.to_string(), label, of: Box::new(move |s, leg| value(s, leg).map(|v| unit.from_si(v))) }
}

/// Rows beyond this many robust σ of a leg look like gross errors.
const FAR: f64 = 8.0;

/// Rows of which a joint lies far from the others of its leg.
pub(in crate::report::html) fn gross(residuals: &[(DataRow, &[f64])]) -> Vec<DataRow> {
    let joints = residuals.first().map_or(0, |(_, r)| r.len());
    let mut rows = Vec::new();
    for joint in 0..joints {
        let mut sizes: Vec<f64> = residuals.iter().map(|(_, r)| r[joint].abs()).filter(|v| v.is_finite()).collect();
        sizes.sort_by(f64::total_cmp);
        // The median of the sizes of normal noise is 0.6745 sigma.
        let Some(sigma) = sizes.get(sizes.len() / 2).map(|m| m / 0.6745).filter(|s| *s > 0.0) else { continue };
        let far = residuals.iter().filter(|(_, r)| r[joint].abs() > FAR * sigma);
        rows.extend(far.map(|(row, _)| *row));
    }
    rows.sort_unstable();
    rows.dedup();
    rows
}

#[cfg(test)]
mod tests {
    use super::gross;
    use crate::measurement::DataRow;

    #[test]
    fn a_row_far_from_its_neighbours_is_marked() {
        let mut values: Vec<Vec<f64>> = (0..40).map(|k| vec![f64::from(k % 5 - 2), f64::from(k % 3 - 1)]).collect();
        values[7][1] = -30.0;
        let residuals: Vec<(DataRow, &[f64])> =
            values.iter().enumerate().map(|(k, v)| (DataRow(k + 100), v.as_slice())).collect();
        assert_eq!(gross(&residuals), [DataRow(107)]);
    }
}
