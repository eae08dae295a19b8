//! Directions that the data do not determine, described in words.

use nalgebra::{DMatrix, DVector};

use crate::identification::problem::spectrum::{DataSpectrum, UNSEEN};
use crate::mechanism::{Body, Mechanism, ParameterRole, rigid_directions};
use crate::observability::DECIDED;
use crate::units::Dimension;

/// A direction of the parameters that the data do not decide.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WeakDirection {
    /// Tolerance along the direction over the σ from the data alone; 0 if the data say nothing.
    pub sigma: f64,
    /// Description in words.
    pub text: String,
}

/// The directions that the data do not decide, weakest first, in words.
///
/// Without tolerances only directions of which the data say nothing are listed.
pub fn weak_directions(mechanism: &dyn Mechanism, spectrum: &DataSpectrum) -> Vec<WeakDirection> {
    let largest = spectrum.values.iter().copied().fold(0.0, f64::max);
    let limit = if spectrum.scaled_by_tolerance { DECIDED } else { UNSEEN * largest };
    let patterns = patterns(mechanism, &spectrum.scale);
    let mut weak: Vec<usize> = (0..spectrum.values.len()).filter(|k| spectrum.values[*k] < limit).collect();
    weak.sort_by(|a, b| spectrum.values[*a].total_cmp(&spectrum.values[*b]));
    let say = |k: usize| WeakDirection {
        sigma: spectrum.values[k],
        text: describe(mechanism, &patterns, &spectrum.directions.column(k).into_owned()),
    };
    weak.into_iter().map(say).collect()
}

/// A family of directions with a physical name.
struct Pattern {
    name: String,
    /// Orthonormal columns, in parameters divided by their tolerance.
    basis: DMatrix<f64>,
    family: Family,
}

/// Which sentence a pattern belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    /// A motion of all points of a body; named only if it is nearly the whole direction.
    Rigid,
    /// The ends of a leg move along it, and its length follows.
    Slide,
    /// Both ends of a leg shift by the same amount.
    Together,
}

/// A direction belongs to a pattern if this part of its length squared does.
const MOSTLY: f64 = 0.5;
/// A rigid motion is named alone from this part on.
const NEARLY_WHOLE: f64 = 0.8;
/// Legs with less than this part of the pattern are not listed.
const WORTH_NAMING: f64 = 0.15;

fn describe(mechanism: &dyn Mechanism, patterns: &[Pattern], direction: &DVector<f64>) -> String {
    let share = |p: &Pattern| (p.basis.transpose() * direction).norm_squared();
    let mut shares: Vec<(f64, &Pattern)> = patterns.iter().map(|p| (share(p), p)).collect();
    shares.sort_by(|a, b| b.0.total_cmp(&a.0));
    if let Some((part, pattern)) = shares.iter().find(|(part, p)| p.family == Family::Rigid && *part > NEARLY_WHOLE) {
        return format!("{} ({:.0} %)", pattern.name, 100.0 * part);
    }
    for (family, sentence) in [
        (Family::Slide, "points slide along their leg, and its length follows"),
        (Family::Together, "both points of a leg shift together"),
    ] {
        let members = || shares.iter().filter(|(_, p)| p.family == family);
        let together: f64 = members().map(|(part, _)| part).sum();
        let legs: Vec<String> = members()
            .filter(|(part, _)| *part > WORTH_NAMING * together)
            .map(|(part, p)| format!("{} ({:.0} %)", p.name, 100.0 * part))
            .collect();
        if together > MOSTLY {
            return format!("{sentence}: {}", legs.join(", "));
        }
    }
    let mut largest: Vec<(f64, &str)> =
        direction.iter().zip(mechanism.parameters()).map(|(v, s)| (v * v, s.name.as_str())).collect();
    largest.sort_by(|a, b| b.0.total_cmp(&a.0));
    let names: Vec<String> = largest
        .iter()
        .take(4)
        .filter(|(part, _)| *part >= 0.005)
        .map(|(part, name)| format!("{name} ({:.0} %)", 100.0 * part))
        .collect();
    format!("a combination of {}", names.join(", "))
}

fn patterns(mechanism: &dyn Mechanism, scale: &[f64]) -> Vec<Pattern> {
    let specs = mechanism.parameters();
    let (c, home) = (mechanism.values(), mechanism.home());
    let mut found = Vec::new();
    for (body, label, effect) in
        [(Body::Platform, "platform", "an attitude offset"), (Body::Base, "base", "a rotation of the tracker")]
    {
        let rigid = rigid_directions(mechanism, body, scale);
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let turn = format!("all {label} points rotate together about {name}, {effect}");
            let shift = format!("all {label} points shift together along {name}");
            found.extend(pattern(turn, Family::Rigid, &rigid[axis + 3..=axis + 3]));
            found.extend(pattern(shift, Family::Rigid, &rigid[axis..=axis]));
        }
        found.extend(pattern(format!("all {label} points rotate together, {effect}"), Family::Rigid, &rigid[3..]));
    }
    let platform = Body::Platform.points(mechanism, c);
    let base = Body::Base.points(mechanism, c);
    for (leg, a) in &platform {
        let Some((_, b)) = base.iter().find(|(l, _)| l == leg) else { continue };
        let along = (home.place(a) - b).normalize();
        let along_platform = home.rotation.inverse() * along;
        let mut slide = vec![DVector::zeros(specs.len()); 3];
        let mut together = vec![DVector::zeros(specs.len()); 3];
        for (k, spec) in specs.iter().enumerate() {
            match spec.role {
                ParameterRole::PlatformPoint { leg: l, axis } if l == *leg => {
                    slide[0][k] = along_platform[axis.index()] / scale[k];
                    for (base_axis, column) in together.iter_mut().enumerate() {
                        column[k] = home.rotation[(base_axis, axis.index())] / scale[k];
                    }
                }
                ParameterRole::BasePoint { leg: l, axis } if l == *leg => {
                    slide[1][k] = along[axis.index()] / scale[k];
                    together[axis.index()][k] = 1.0 / scale[k];
                }
                // An angle does not follow a slide.
                ParameterRole::JointOffset { leg: l } if l == *leg && spec.dimension == Dimension::Length => {
                    slide[2][k] = 1.0 / scale[k];
                }
                _ => {}
            }
        }
        let name = format!("A{0} and B{0}", leg + 1);
        found.extend(pattern(name.clone(), Family::Slide, &slide));
        found.extend(pattern(name, Family::Together, &together));
    }
    found
}

fn pattern(name: String, family: Family, columns: &[DVector<f64>]) -> Option<Pattern> {
    let columns: Vec<DVector<f64>> = columns.iter().filter(|c| c.norm() > 0.0).cloned().collect();
    if columns.is_empty() {
        return None;
    }
    Some(Pattern { name, family, basis: DMatrix::from_columns(&columns).qr().q() })
}
