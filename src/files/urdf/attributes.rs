//! Attributes of elements, as numbers; what is wrong with them is reported.

use super::findings::{Findings, did_you_mean};
use super::xml::Element;
use crate::files::finding::FindingKind as K;

/// Orientation as the file writes it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Turn {
    Rpy([f64; 3]),
    Quaternion([f64; 4]),
}

/// Position and orientation of an `<origin>`, or of any element with `xyz` and `rpy`; zero where it states none.
pub(super) fn origin(element: Option<&Element>, what: &str, findings: &mut Findings) -> Option<([f64; 3], Turn)> {
    let element = element?;
    known_attributes(element, &["xyz", "rpy", "quat_xyzw", "link"], &format!("{what} origin"), findings);
    let xyz = numbers(element, "xyz", &format!("{what} origin"), findings)?.unwrap_or([0.0; 3]);
    let rpy = numbers(element, "rpy", &format!("{what} origin"), findings)?;
    let turn = match (rpy, numbers(element, "quat_xyzw", &format!("{what} origin"), findings)?) {
        (None, Some(q)) => {
            if !(q.iter().map(|v| v * v).sum::<f64>() > 0.0) {
                let text = format!("{what} origin: quat_xyzw is zero; state a rotation");
                findings.add(K::BadNumber, what, element.line, text);
            }
            Turn::Quaternion(q)
        }
        (Some(_), Some(_)) => {
            let text = format!("{what} origin states both rpy and quat_xyzw; keep one of them");
            findings.add(K::BadNumber, what, element.line, text);
            return None;
        }
        (rpy, None) => Turn::Rpy(rpy.unwrap_or([0.0; 3])),
    };
    Some((xyz, turn))
}

/// Reports the attributes of an element that are none of `known`, and so state nothing.
pub(super) fn known_attributes(element: &Element, known: &[&str], what: &str, findings: &mut Findings) {
    let of_others = |name: &str| name.contains(':') || name == "xmlns";
    for (name, _) in element.attributes.iter().filter(|(n, _)| !known.contains(&n.as_str()) && !of_others(n)) {
        let hint = did_you_mean(name, known.iter().copied());
        let text = format!(
            "{what}: attribute '{}' of <{}> is not read{hint}; the attributes are {}",
            shown(name),
            element.name,
            known.iter().filter(|k| **k != "link").copied().collect::<Vec<_>>().join(", ")
        );
        let joint = what.split('\'').nth(1).unwrap_or_default();
        findings.add(K::UnknownAttribute, joint, element.line, text);
    }
}

/// The numbers of an attribute; `Some(None)` if it is absent, `None` if it is wrong, which is then reported.
pub(super) fn numbers<const N: usize>(
    element: &Element,
    attribute: &str,
    what: &str,
    findings: &mut Findings,
) -> Option<Option<[f64; N]>> {
    match element.attribute(attribute) {
        None => Some(None),
        Some(text) => {
            number_list(text, element.line, &format!("{what} {attribute}=\"{}\"", shown(text)), findings).map(Some)
        }
    }
}

/// Exactly `N` finite numbers; anything else is reported about `what`.
pub(super) fn number_list<const N: usize>(
    text: &str,
    line: usize,
    what: &str,
    findings: &mut Findings,
) -> Option<[f64; N]> {
    let element = what.split('\'').nth(1).unwrap_or_default();
    let values: Option<Vec<f64>> = text.split_whitespace().take(N + 1).map(|t| t.parse().ok()).collect();
    let Some(values) = values.and_then(|v| <[f64; N]>::try_from(v).ok()) else {
        let text = format!("{what} must be {N} numbers separated by spaces; correct it");
        findings.add(K::BadNumber, element, line, text);
        return None;
    };
    // Squares of such numbers are no numbers any more.
    if values.iter().any(|v| !(v.abs() < 1e100)) {
        let text = format!("{what} holds a number that is not finite; write the actual number");
        findings.add(K::NotFinite, element, line, text);
        return None;
    }
    Some(values)
}

/// At most a short piece of a text.
fn shown(text: &str) -> String {
    if text.chars().count() <= 80 { text.into() } else { text.chars().take(77).chain("...".chars()).collect() }
}

/// The limits of a slide; an end that is not stated is zero, as URDF has it.
pub(super) fn limits(limit: &Element, what: &str, findings: &mut Findings) -> Option<[f64; 2]> {
    let mut end = |key: &str| {
        let Some(text) = limit.attribute(key) else { return Some(0.0) };
        match text.trim().parse::<f64>() {
            // An endless slide is one without limits.
            Ok(v) if v.is_infinite() => None,
            _ => number_list::<1>(text, limit.line, &format!("{what} limit {key}"), findings).map(|[v]| v),
        }
    };
    let ends = (end("lower"), end("upper"));
    if limit.attribute("lower").is_none() && limit.attribute("upper").is_none() {
        return None;
    }
    Some([ends.0?, ends.1?])
}
