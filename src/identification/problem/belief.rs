//! What the drawing says of the parameters, group by group: how wide its tolerances are, and what of it is convention.
//!
//! Eighteen directions of a mechanism with six legs are convention and not workmanship: where the target sits on the
//! platform, where the tracker stands, and where each joint counts from. The tolerances hold them until the data contradict;
//! then they are free. Groups are the points of the platform, the points of the base, the zeros of the joints, and the rest;
//! the directions of a convention lie within one group each.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::mechanism::{Body, Mechanism, ParameterRole, ParameterSpec, rigid_directions};

/// The groups, by what they are called.
pub const GROUPS: [&str; 4] = ["platform points", "base points", "joint zeros", "other parameters"];

/// The group of a parameter, among [`GROUPS`].
pub(crate) fn group_of(role: ParameterRole) -> usize {
    match role {
        _ if Body::Platform.coordinate(role).is_some() => 0,
        _ if Body::Base.coordinate(role).is_some() => 1,
        ParameterRole::JointOffset { .. } => 2,
        _ => 3,
    }
}

/// Which conventions are those of the measurement instead of the drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conventions {
    /// Where the target sits: rigid motions of all platform points.
    pub target: bool,
    /// Where the tracker stands: rigid motions of all base points.
    pub tracker: bool,
    /// Where the joints count from.
    pub zeros: bool,
}

impl Conventions {
    /// Those of the drawing.
    pub const STATED: Self = Self { target: false, tracker: false, zeros: false };

    /// By group.
    pub(crate) fn free(self) -> [bool; 4] {
        [self.target, self.tracker, self.zeros, false]
    }

    /// Where tracker and target are is not known.
    pub const FRAMES: Self = Self { target: true, tracker: true, zeros: false };

    /// Those that the identified values contradict: along them the points, or the zeros, are farther from `centre` than so many
    /// tolerances allow.
    pub fn contradicted(mechanism: &dyn Mechanism, centre: &[f64], values: &[f64], tolerances: f64) -> Self {
        let [target, tracker, zeros, _] = Group::all(mechanism).map(|group| {
            let Some((group, q)) = group.as_ref().and_then(|g| Some((g, g.convention.as_ref()?))) else { return false };
            let along = q.transpose() * group.shift(centre, values) / tolerances;
            ChiSquared::new(q.ncols() as f64).is_ok_and(|chi| chi.sf(along.norm_squared()) < NOT_STATED)
        });
        Self { target, tracker, zeros }
    }

    /// Those that are free in either.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            target: self.target || other.target,
            tracker: self.tracker || other.tracker,
            zeros: self.zeros || other.zeros,
        }
    }
}

/// Deviations along a convention less likely than this under the tolerances show that it is not the stated one.
const NOT_STATED: f64 = 1e-4;

/// How the tolerances are taken: which conventions are free, and how much wider than stated each group is.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    /// Conventions that are not those of the drawing.
    pub conventions: Conventions,
    /// True width over the stated one, by group.
    pub factors: [f64; 4],
    /// True if the places of targets on the platform are identified too, so that moving the platform's points and all targets
    /// together moves nothing that is measured: the platform is then where the drawing has it, by definition.
    pub platform_held: bool,
    /// Values about which free conventions are looked for, where a fit has found them; those of the drawing if absent.
    pub centre: Option<Vec<f64>>,
}

impl Belief {
    /// The tolerances as they are stated.
    pub fn stated(conventions: Conventions) -> Self {
        Self { conventions, factors: [1.0; 4], platform_held: false, centre: None }
    }

    /// How much narrower than its tolerances each convention is taken, by group.
    pub(crate) fn narrowness(&self) -> [f64; 4] {
        let mut along = self.conventions.free().map(|free| if free { 1.0 / FREE } else { 1.0 });
        if self.platform_held {
            along[0] = HELD;
        }
        along
    }
}

/// How many widths a convention may be away if it is free.
pub(crate) const FREE: f64 = 100.0;
/// And by how much narrower one is taken that nothing sees.
const HELD: f64 = 1e3;

/// The parameters of a group that have a tolerance.
pub(crate) struct Group {
    pub(crate) members: Vec<usize>,
    /// Their tolerances.
    pub(crate) widths: Vec<f64>,
    /// Directions that are convention: orthonormal columns in the members over their tolerances.
    pub(crate) convention: Option<DMatrix<f64>>,
}

impl Group {
    /// All groups, in the order of [`GROUPS`]; `None` for those without members.
    pub(crate) fn all(mechanism: &dyn Mechanism) -> [Option<Self>; 4] {
        Self::of(mechanism, &widths(mechanism, [1.0; 4]))
    }

    /// How far its members are from one set of parameters to another, over their widths.
    pub(crate) fn shift(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        let shift = self.members.iter().zip(&self.widths).map(|(k, w)| (to[*k] - from[*k]) / w);
        DVector::from_iterator(self.members.len(), shift)
    }

    /// `I + (factor - 1) Q Qᵀ`: multiplies what lies along its convention and leaves the rest.
    pub(crate) fn convention_times(&self, factor: f64) -> DMatrix<f64> {
        let n = self.members.len();
        let mut times = DMatrix::identity(n, n);
        if let Some(q) = &self.convention {
            times += q * q.transpose() * (factor - 1.0);
        }
        times
    }

    /// Its conventions as columns in all `n` parameters over their tolerances.
    pub(crate) fn directions(&self, n: usize) -> Option<DMatrix<f64>> {
        let q = self.convention.as_ref()?;
        let mut all = DMatrix::zeros(n, q.ncols());
        for (row, k) in self.members.iter().enumerate() {
            all.row_mut(*k).copy_from(&q.row(row));
        }
        Some(all)
    }

    /// All groups with other widths, infinite ones left out.
    pub(crate) fn of(mechanism: &dyn Mechanism, widths: &[f64]) -> [Option<Self>; 4] {
        std::array::from_fn(|group| {
            let specs = mechanism.parameters();
            let belongs = |k: &usize| widths[*k].is_finite() && group_of(specs[*k].role) == group;
            let members: Vec<usize> = (0..specs.len()).filter(belongs).collect();
            if members.is_empty() {
                return None;
            }
            let rigid = |body| {
                let only = |d: DVector<f64>| DVector::from_iterator(members.len(), members.iter().map(|k| d[*k]));
                let all = rigid_directions(mechanism, body, widths).into_iter().map(only);
                all.filter(|d| d.norm() > 0.0).collect::<Vec<_>>()
            };
            let columns = match group {
                0 => rigid(Body::Platform),
                1 => rigid(Body::Base),
                2 => (0..members.len())
                    .map(|k| DVector::from_fn(members.len(), |i, _| f64::from(u8::from(i == k))))
                    .collect(),
                _ => Vec::new(),
            };
            let usable = !columns.is_empty() && columns.len() <= members.len();
            let convention = usable.then(|| DMatrix::from_columns(&columns).qr().q());
            Some(Self { widths: members.iter().map(|k| widths[*k]).collect(), members, convention })
        })
    }
}

/// The tolerance of each parameter times the factor of its group; infinite without one, which is as good as free.
pub(crate) fn widths(mechanism: &dyn Mechanism, factors: [f64; 4]) -> Vec<f64> {
    let width = |s: &ParameterSpec| s.tolerance.map_or(f64::INFINITY, |t| t * factors[group_of(s.role)]);
    mechanism.parameters().iter().map(width).collect()
}

/// Covariance of the parameters before anything is measured, if all conventions are known; `None` if not all parameters have a
/// tolerance.
pub(crate) fn without_conventions(mechanism: &dyn Mechanism, factors: [f64; 4]) -> Option<DMatrix<f64>> {
    let widths = widths(mechanism, factors);
    if widths.iter().any(|w| w.is_infinite()) {
        return None;
    }
    let mut covariance = DMatrix::zeros(widths.len(), widths.len());
    for group in Group::of(mechanism, &widths).iter().flatten() {
        let held = group.convention_times(0.0);
        for (i, k) in group.members.iter().enumerate() {
            for (j, l) in group.members.iter().enumerate() {
                covariance[(*k, *l)] = held[(i, j)] * group.widths[i] * group.widths[j];
            }
        }
    }
    Some(covariance)
}
