//! How the columns of the joints should have been read: their order, signs, unit and zeros.

use crate::diagnosis::preflight::unit_factors::UnitFactor;
use crate::mechanism::{Mechanism, ParameterRole};
use crate::units::{Dimension, show_angle, show_length};

/// What the joints are by what stands in the columns: joint `i` is `zero + sign · unit · column[order]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointColumns {
    /// The column of each joint.
    pub(crate) order: Vec<usize>,
    /// True for joints that count the other way.
    pub(crate) reversed: Vec<bool>,
    pub(crate) unit: Option<UnitFactor>,
    /// What is added to each, SI: by twice home, a joint that counts the other way stays at home where it is there.
    pub(crate) zero: Vec<f64>,
    /// True if joints count from elsewhere than the drawing, by more than a convention would explain.
    pub(crate) counted_from_elsewhere: bool,
}

impl JointColumns {
    /// As they are stated.
    pub(crate) fn stated(joints: usize) -> Self {
        Self {
            order: (0..joints).collect(),
            reversed: vec![false; joints],
            unit: None,
            zero: vec![0.0; joints],
            counted_from_elsewhere: false,
        }
    }

    /// Joints in another order.
    pub(crate) fn in_order(order: Vec<usize>) -> Self {
        Self { zero: vec![0.0; order.len()], reversed: vec![false; order.len()], order, ..Self::stated(0) }
    }

    /// Some joints count the other way, about these coordinates.
    pub(crate) fn with_signs(reversed: Vec<bool>, about: &[f64]) -> Self {
        let zero = reversed.iter().zip(about).map(|(r, h)| if *r { 2.0 * h } else { 0.0 }).collect();
        Self { zero, reversed, ..Self::stated(about.len()) }
    }

    pub(crate) fn is_in_order(&self) -> bool {
        self.order.iter().enumerate().all(|(i, k)| i == *k)
    }

    /// True if nothing is read otherwise.
    pub(crate) fn is_as_stated(&self) -> bool {
        self.names().is_empty()
    }

    /// The joints by what stands in the columns.
    pub(crate) fn joints(&self, columns: &[f64]) -> Vec<f64> {
        let unit = self.unit.as_ref().map_or(1.0, |u| u.factor);
        let joint = |i: usize| {
            let sign = if self.reversed[i] { -1.0 } else { 1.0 };
            self.zero[i] + sign * unit * columns[self.order[i]]
        };
        (0..self.order.len()).map(joint).collect()
    }

    /// Names in the format.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        if !self.is_in_order() {
            names.push("leg-order");
        }
        if self.reversed.contains(&true) {
            names.push("leg-sign");
        }
        if self.unit.is_some() {
            names.push("joint-unit");
        }
        if self.counted_from_elsewhere {
            names.push("joint-zero");
        }
        names
    }

    /// What is wrong, in words, in the order of the names.
    pub(crate) fn details(&self, mechanism: &dyn Mechanism) -> Vec<String> {
        let lengths = mechanism.joints().iter().all(|j| j.dimension == Dimension::Length);
        let count = self.order.len();
        let mut details = Vec::new();
        if !self.is_in_order() {
            let columns: Vec<usize> = self.order.iter().map(|k| k + 1).collect();
            details.push(format!("legs 1 to {count} are in the columns of legs {}", listed(&columns)));
        }
        let reversed: Vec<usize> = (0..count).filter(|i| self.reversed[*i]).map(|i| i + 1).collect();
        let counts = if lengths { "extension" } else { "travel" };
        match reversed[..] {
            [] => {}
            [one] => details.push(format!("leg {one} counts its {counts} in the opposite direction")),
            _ if reversed.len() == count => {
                details.push(format!("the legs count their {counts} in the opposite direction"));
            }
            _ => details.push(format!("legs {} count their {counts} in the opposite direction", listed(&reversed))),
        }
        if let Some(unit) = &self.unit {
            let what = if lengths { "leg lengths" } else { "joints" };
            details.push(format!("the {what} seem to be in a different unit: {}", unit.text()));
        }
        if self.counted_from_elsewhere {
            details.push(self.zeros(mechanism));
        }
        details
    }

    /// Where the joints count from.
    fn zeros(&self, mechanism: &dyn Mechanism) -> String {
        let lengths = mechanism.joints().iter().all(|j| j.dimension == Dimension::Length);
        let shown = |v: f64| if lengths { show_length(v) } else { show_angle(v) };
        let what = if lengths { "length" } else { "angle" };
        let first = self.zero[0];
        let same = self.zero.iter().all(|z| (z - first).abs() <= 1e-3 * first.abs());
        let values: Vec<String> = self.zero.iter().map(|z| shown(*z)).collect();
        let values = if same { values[0].clone() } else { values.join(", ") };
        let has_offset = mechanism.parameters().iter().any(|p| matches!(p.role, ParameterRole::JointOffset { .. }));
        let remedy = match has_offset {
            true => format!("; state `{what}_offset` = {values} in the mechanism file"),
            false => String::new(),
        };
        format!(
            "the joints count from elsewhere than the drawing, as if from home: true {what} = stated {what} + {values}{remedy}"
        )
    }
}

fn listed(numbers: &[usize]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
