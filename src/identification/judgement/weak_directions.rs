//! Directions that the data do not determine, described in words.
//!
//! The whitened Jacobian of the data, with each column multiplied by the tolerance of its parameter and the
//! measurement's own parameters projected out, has one singular value for each direction of the parameters:
//! the tolerance along it over the σ that the data alone give. Ten means that the data know the direction to a
//! tenth of the tolerance ([`DECIDED`]); one that they know no more than the workshop.

use nalgebra::{DMatrix, DVector};

use crate::identification::error::IdentifyError;
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::task::{Task, Weights};
use crate::mechanism::{Body, Mechanism, ParameterRole, rigid_directions};
use crate::observability::{DECIDED, Spectrum};
use crate::solve::linearized;
use crate::units::Dimension;

/// Singular values and directions of the data alone.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DataSpectrum {
    /// Singular values in descending order, one for each parameter of the mechanism.
    pub values: Vec<f64>,
    /// Directions as columns, in parameters divided by their tolerance.
    pub directions: DMatrix<f64>,
    /// Tolerance of each parameter, SI; 1e-3 stands in where none is stated.
    pub scale: Vec<f64>,
    /// True if every parameter has a tolerance.
    pub scaled_by_tolerance: bool,
}

/// Rows that see a direction by less than this part of the strongest do not see it.
const UNSEEN: f64 = 1e-9;

/// A direction of the parameters that the data do not decide.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WeakDirection {
    /// Tolerance along the direction over the σ from the data alone; 0 if the data say nothing.
    pub sigma: f64,
    /// Description in words.
    pub text: String,
}

impl DataSpectrum {
    /// At the values of the mechanism, for σ of the readings times `noise_scale`.
    ///
    /// # Errors
    /// [`IdentifyError`] if the rows have no value there.
    pub fn at_start(task: &Task<'_>, noise_scale: f64) -> Result<Self, IdentifyError> {
        let task = Task { weights: Weights::Noise, ..*task };
        let mut problem = CalibrationProblem::new(&task, None, noise_scale)?;
        let start = problem.start();
        let (_, j) = linearized(&mut problem, &start)?;
        Ok(Self::of(task.mechanism, &j))
    }

    /// Of a whitened Jacobian of finite numbers whose first columns belong to the mechanism and whose others are
    /// projected out.
    pub fn of(mechanism: &dyn Mechanism, jacobian: &DMatrix<f64>) -> Self {
        let specs = mechanism.parameters();
        let n = specs.len();
        let scale: Vec<f64> = specs.iter().map(|s| s.tolerance.unwrap_or(1e-3)).collect();
        let mut part = jacobian.columns(0, n).into_owned();
        let own = jacobian.ncols() - n;
        if own > 0 {
            let mut columns = jacobian.columns(n, own).into_owned();
            columns.column_iter_mut().for_each(|mut c| c.unscale_mut(c.amax().max(f64::MIN_POSITIVE)));
            let q = columns.qr().q();
            part -= &q * (q.transpose() * &part);
        }
        for (k, s) in scale.iter().enumerate() {
            part.column_mut(k).scale_mut(*s);
        }
        let Spectrum { values, directions, .. } = Spectrum::of(&part, 0, true);
        Self { values, directions, scaled_by_tolerance: specs.iter().all(|s| s.tolerance.is_some()), scale }
    }

    /// Directions (columns, in parameters over their scale) of which the rows say nothing; `None` if there are
    /// none.
    pub fn unseen(&self) -> Option<DMatrix<f64>> {
        let largest = self.values.iter().copied().fold(0.0, f64::max);
        let columns: Vec<DVector<f64>> = (0..self.values.len())
            .filter(|k| self.values[*k] < UNSEEN * largest)
            .map(|k| self.directions.column(k).into_owned())
            .collect();
        (!columns.is_empty()).then(|| DMatrix::from_columns(&columns))
    }

    /// The smallest singular value.
    pub fn smallest(&self) -> f64 {
        self.values.iter().copied().fold(f64::INFINITY, f64::min)
    }
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
    let names: Vec<String> =
        largest.iter().take(4).map(|(part, name)| format!("{name} ({:.0} %)", 100.0 * part)).collect();
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
