//! A result in the frames of the measurement.

use nalgebra::DMatrix;

use crate::identification::error::IdentifyError;
use crate::identification::estimators::identification::{Estimate, Identification};
use crate::identification::judgement::plausibility::{Plausibility, plausibility};
use crate::measurement::Frames;
use crate::mechanism::{Body, Mechanism, Workspace};

/// What was identified, in the frames of the measurement.
pub(crate) struct Carried {
    pub(crate) mechanism: Box<dyn Mechanism>,
    pub(crate) parameters: Vec<Estimate>,
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) plausibility: Plausibility,
}

/// Carries what was identified into the frames of the measurement. A mechanism that is mounted in them keeps the
/// parameters of its drawing; others carry them there.
pub(crate) fn carried(
    mechanism: &dyn Mechanism,
    found: &Identification,
    frames: &Frames,
) -> Result<Carried, IdentifyError> {
    let fitted = mechanism.with_values(&found.mechanism_values(), mechanism.home())?;
    let mounted = fitted.mounted(&frames.base, &frames.target).filter(|_| !frames.is_identity());
    let by = if mounted.is_some() { Frames::default() } else { *frames };
    let (parameters, covariance) = carry(mechanism, found, &by);
    let values: Vec<f64> = parameters[..found.mechanism_parameters].iter().map(|p| p.value).collect();
    let plausibility = plausibility(mechanism, &values);
    let (mechanism, plausibility) = match mounted {
        Some(mounted) => (mounted, plausibility.seen_from(frames)),
        None => (mechanism.with_values(&values, frames.measured(&mechanism.home()))?, plausibility),
    };
    Ok(Carried { mechanism, parameters, covariance, plausibility })
}

/// Parameters and covariance in the frames of the measurement: `b' = B b`, `a' = A⁻¹ a`.
fn carry(mechanism: &dyn Mechanism, found: &Identification, frames: &Frames) -> (Vec<Estimate>, DMatrix<f64>) {
    let n = found.mechanism_parameters;
    let mut parameters = found.parameters.clone();
    let mut covariance = found.mechanism_covariance();
    if frames.is_identity() {
        return (parameters, covariance);
    }
    let specs = mechanism.parameters();
    let values = found.mechanism_values();
    let mut map = DMatrix::identity(n, n);
    for (body, motion) in [(Body::Base, frames.base), (Body::Platform, frames.target.inverse())] {
        let moved = body.moved(mechanism, &values, &motion);
        let member = |k: usize| body.coordinate(specs[k].role);
        for k in 0..n {
            let Some((leg, axis)) = member(k) else { continue };
            parameters[k].value = moved[k];
            for j in 0..n {
                if let Some((_, from)) = member(j).filter(|(l, _)| *l == leg) {
                    map[(k, j)] = motion.rotation[(axis, from)];
                }
            }
        }
    }
    covariance = &map * covariance * map.transpose();
    let known: Vec<bool> = found.parameters.iter().map(|p| p.sigma.is_some()).collect();
    for (k, p) in parameters.iter_mut().take(n).enumerate() {
        // A coordinate is known if all those of its point that it is turned from are.
        let all_known = (0..n).all(|j| map[(k, j)].abs() < 1e-12 || known[j]);
        p.sigma = all_known.then(|| covariance[(k, k)].max(0.0).sqrt());
    }
    (parameters, covariance)
}

/// The box with the same centre and the same spread along the axes of the tracker.
pub fn carried_workspace(workspace: &Workspace, frames: &Frames) -> Workspace {
    if frames.is_identity() {
        return *workspace;
    }
    let turn = frames.base.rotation;
    let mut half = [0.0; 6];
    for first in [0, 3] {
        for k in 0..3 {
            let parts = (0..3).map(|j| (turn[(k, j)] * workspace.half[first + j]).powi(2));
            half[first + k] = parts.sum::<f64>().sqrt();
        }
    }
    let centre = workspace.convention.pose(&workspace.centre);
    Workspace { centre: workspace.convention.coordinates(&frames.measured(&centre)), half, ..*workspace }
}
