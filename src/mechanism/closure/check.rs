//! Checks of a closure and its outline before anything is solved.

use super::evaluation::{Place, Wanted, derivatives};
use super::pattern::Pattern;
use super::{Closure, Outline};
use crate::conditions::Conditions;
use crate::mechanism::GeometryError;

/// Refuses an outline that contradicts itself.
pub(super) fn check_outline(outline: &Outline, all: &[f64], free: &[usize]) -> Result<(), GeometryError> {
    let wrong = |problem: String| Err(GeometryError::Outline(problem));
    let (m, p) = (outline.equations, outline.passive.len());
    if m < 6 + p {
        return wrong(format!(
            "{m} closure equations cannot hold a platform with {p} passive coordinates; state at least {} (structural rows count)",
            6 + p
        ));
    }
    if free.is_empty() || outline.joints.is_empty() {
        return wrong("there is no parameter to identify, or no joint".into());
    }
    if outline.home_joints.len() != outline.joints.len() {
        return wrong(format!(
            "{} joints and {} joint coordinates near home",
            outline.joints.len(),
            outline.home_joints.len()
        ));
    }
    for (k, spec) in outline.parameters.iter().enumerate() {
        if outline.parameters[..k].iter().any(|s| s.name == spec.name) {
            return wrong(format!("two parameters are called {}", spec.name));
        }
        if !all[k].is_finite() {
            return wrong(format!("{} is {}; every value of a mechanism must be a number", spec.name, all[k]));
        }
    }
    let numbers = outline.home_joints.iter().chain(&outline.passive);
    if !outline.home.is_finite() || numbers.clone().any(|v| !v.is_finite()) {
        return wrong("home contains a number that is not finite".into());
    }
    Ok(())
}

/// Refuses a row that depends on a column although it says it does not: its derivatives would be wrong. `free` are the
/// identified parameters.
pub(super) fn check_dependence<C: Closure>(
    closure: &C,
    outline: &Outline,
    all: &[f64],
    free: &[usize],
    pattern: &Pattern,
) -> Result<(), GeometryError> {
    let dense = Pattern::dense(pattern.colour.len(), outline.equations);
    let place = Place {
        pose: &outline.home,
        joints: &outline.home_joints,
        parameters: all,
        passive: &outline.passive,
        at: &Conditions::unknown(),
    };
    let d = derivatives(closure, &dense, free, outline.equations, &place, Wanted::All);
    for column in 0..pattern.colour.len() {
        let rows = pattern.rows(column);
        let name = match column.checked_sub(free.len()) {
            None => &outline.parameters[free[column]].name,
            Some(joint) => &outline.joints[joint].name,
        };
        let hidden = |row: &usize| !rows.contains(row) && d.columns[(*row, column)] != 0.0;
        if let Some(row) = (0..outline.equations).find(hidden) {
            let value = d.columns[(row, column)];
            return Err(GeometryError::HiddenDependence { row: row + 1, column: name.clone(), value });
        }
    }
    Ok(())
}
