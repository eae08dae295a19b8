//! Manufacturing tolerances as prior knowledge.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::identification::error::IdentifyError;
use crate::mechanism::{Body, Mechanism, ParameterSpec, characteristic_length, rigid_directions};
use crate::units::Dimension;

/// Where prior knowledge comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PriorPolicy {
    /// No prior while every singular value of the whitened, tolerance-scaled Jacobian is at least
    /// [`DECIDED`](crate::observability::DECIDED); below that the tolerance is the prior.
    #[default]
    Auto,
    /// The tolerance is the prior.
    Tolerance,
    /// No prior.
    None,
}

/// Knowledge about the parameters of the mechanism in addition to the data, as further rows `M (x - x₀)` of unit
/// variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// Start of each parameter of the mechanism.
    centre: Vec<f64>,
    /// `M` (rows × parameters).
    rows: DMatrix<f64>,
    /// Number of directions that are only held at their start, and for each parameter whether it takes part.
    held: Option<(usize, Vec<bool>)>,
}

/// How firmly unseen directions are held, as a part of the scale.
const HOLD: f64 = 1e-3;
/// What the tolerances say about rigid motions of all platform points or all base points, that is about where the
/// target sits and where the tracker stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameConvention {
    /// The data are in the base frame and the platform frame: points that move together are held by their
    /// tolerances like any others.
    #[default]
    Stated,
    /// The frames are those of the measurement; rigid motions may be a hundred tolerances large.
    Free,
}

/// Tolerances that a rigid motion may be large if the frames are free.
const WIDE: f64 = 100.0;
/// Rigid motions less likely than this under the tolerances show that the frames are not the stated ones.
const NOT_STATED: f64 = 1e-4;

/// Tolerances of the parameters that have one, and the rigid motions as orthonormal columns in these parameters over
/// their tolerances.
struct Rigid {
    known: Vec<usize>,
    scale: Vec<f64>,
    q: Option<DMatrix<f64>>,
}

impl Rigid {
    fn of(mechanism: &dyn Mechanism) -> Self {
        let specs = mechanism.parameters();
        let known: Vec<usize> = (0..specs.len()).filter(|k| specs[*k].tolerance.is_some()).collect();
        // Parameters without a tolerance are as good as free.
        let scale: Vec<f64> = specs.iter().map(|s| s.tolerance.unwrap_or(f64::INFINITY)).collect();
        let columns: Vec<DVector<f64>> = [Body::Platform, Body::Base]
            .into_iter()
            .flat_map(|body| rigid_directions(mechanism, body, &scale))
            .map(|d| DVector::from_iterator(known.len(), known.iter().map(|k| d[*k])))
            .filter(|d| d.norm() > 0.0)
            .collect();
        let usable = !columns.is_empty() && columns.len() <= known.len();
        let q = usable.then(|| DMatrix::from_columns(&columns).qr().q());
        Self { known, scale, q }
    }
}

/// True if the identified points moved together farther than their tolerances allow: the data are not in the frames
/// of the mechanism file, though perhaps near them.
pub fn frames_differ(mechanism: &dyn Mechanism, values: &[f64]) -> bool {
    let rigid = Rigid::of(mechanism);
    let Some(q) = &rigid.q else { return false };
    let start = mechanism.values();
    let shift = rigid.known.iter().map(|k| (values[*k] - start[*k]) / rigid.scale[*k]);
    let along = q.transpose() * DVector::from_iterator(rigid.known.len(), shift);
    ChiSquared::new(q.ncols() as f64).is_ok_and(|chi| chi.sf(along.norm_squared()) < NOT_STATED)
}

impl Prior {
    /// Each parameter lies about its start with its tolerance as 1σ: the rows are `D⁻¹` with `D` the tolerances, or
    /// `(I - (1 - 1/100) Q Qᵀ) D⁻¹` with `Q` the rigid motions if the frames are free.
    ///
    /// # Errors
    /// [`IdentifyError::NoTolerance`] if no parameter has one.
    pub fn from_tolerance(mechanism: &dyn Mechanism, convention: FrameConvention) -> Result<Self, IdentifyError> {
        let Rigid { known, scale, q } = Rigid::of(mechanism);
        if known.is_empty() {
            return Err(IdentifyError::NoTolerance);
        }
        let mut precision = DMatrix::identity(known.len(), known.len());
        if let (FrameConvention::Free, Some(q)) = (convention, q) {
            precision -= &q * q.transpose() * (1.0 - 1.0 / WIDE);
        }
        let mut rows = DMatrix::zeros(known.len(), scale.len());
        for (column, k) in known.iter().enumerate() {
            rows.set_column(*k, &(precision.column(column) / scale[*k]));
        }
        Ok(Self { centre: mechanism.values().to_vec(), rows, held: None })
    }

    /// A prior for a search through causes: each parameter lies within `factor` tolerances of its start, and rigid motions
    /// are as good as free. Parameters without a tolerance get a width that only keeps them finite: a hundredth of
    /// the size of the mechanism for lengths, a hundredth of a radian for angles, a tenth of their value otherwise.
    pub fn wide(mechanism: &dyn Mechanism, factor: f64) -> Self {
        let size = characteristic_length(mechanism);
        let specs = mechanism.parameters();
        let width = |spec: &ParameterSpec, value: f64| {
            spec.tolerance.map_or_else(
                || match spec.dimension {
                    Dimension::Length => 1e-2 * size,
                    Dimension::Angle => 1e-2,
                    _ => 0.1 * value.abs().max(1e-3),
                },
                |t| factor * t,
            )
        };
        let widths: Vec<f64> = specs.iter().zip(mechanism.values()).map(|(s, v)| width(s, *v)).collect();
        let mut rows = DMatrix::identity(widths.len(), widths.len());
        let columns: Vec<DVector<f64>> = [Body::Platform, Body::Base]
            .into_iter()
            .flat_map(|body| rigid_directions(mechanism, body, &widths))
            .filter(|d| d.norm() > 0.0)
            .collect();
        if !columns.is_empty() && columns.len() <= widths.len() {
            let q = DMatrix::from_columns(&columns).qr().q();
            rows -= &q * q.transpose() * (1.0 - 1.0 / WIDE);
        }
        for (k, w) in widths.iter().enumerate() {
            rows.column_mut(k).unscale_mut(*w);
        }
        Self { centre: mechanism.values().to_vec(), rows, held: None }
    }

    /// This prior for a mechanism with `count` further parameters, about which nothing is known.
    #[must_use]
    pub fn for_more_parameters(&self, count: usize) -> Self {
        let rows = self.rows.clone().resize_horizontally(count, 0.0);
        let mut centre = self.centre.clone();
        centre.resize(count, 0.0);
        Self { centre, rows, ..self.clone() }
    }

    /// `Mᵀ M`, `Mᵀ M (x - x₀)` and `|M (x - x₀)|²` at parameters `x`, for so many unknowns of which these are the first.
    pub fn quadratic(&self, x: &[f64], unknowns: usize) -> (DMatrix<f64>, DVector<f64>, f64) {
        let n = self.rows.ncols();
        let mut precision = DMatrix::zeros(unknowns, unknowns);
        precision.view_mut((0, 0), (n, n)).copy_from(&self.rows.tr_mul(&self.rows));
        let mut shift = DVector::zeros(unknowns);
        for (k, (x, c)) in x.iter().zip(&self.centre).enumerate() {
            shift[k] = x - c;
        }
        let gradient = &precision * &shift;
        let penalty = shift.dot(&gradient);
        (precision, gradient, penalty)
    }

    /// Holds directions (columns, in parameters over `scale`) at the values of a mechanism. This brings no knowledge
    /// in: no row sees these directions, and they are reported as undetermined.
    pub fn holding(mechanism: &dyn Mechanism, scale: &[f64], directions: &DMatrix<f64>) -> Self {
        let mut rows = directions.transpose();
        for (k, s) in scale.iter().enumerate() {
            rows.column_mut(k).unscale_mut(s * HOLD);
        }
        let takes_part = directions.row_iter().map(|r| r.norm() > 1e-6).collect();
        Self { centre: mechanism.values().to_vec(), rows, held: Some((directions.ncols(), takes_part)) }
    }

    /// True if it brings knowledge in; false if it only holds what no row sees.
    pub fn informs(&self) -> bool {
        self.held.is_none()
    }

    /// Number of directions that are only held, and whether each parameter takes part in them.
    pub fn held(&self) -> Option<(usize, &[bool])> {
        self.held.as_ref().map(|(count, takes_part)| (*count, takes_part.as_slice()))
    }

    /// Number of its rows.
    pub fn rows(&self) -> usize {
        self.rows.nrows()
    }

    /// Writes its rows at `x` from row `first` on.
    pub fn write(&self, x: &DVector<f64>, first: usize, residual: &mut DVector<f64>, jacobian: &mut DMatrix<f64>) {
        let (m, n) = self.rows.shape();
        let shift = DVector::from_iterator(n, x.iter().zip(&self.centre).map(|(x, c)| x - c));
        residual.rows_mut(first, m).copy_from(&(&self.rows * shift));
        jacobian.rows_mut(first, m).fill(0.0);
        jacobian.view_mut((first, 0), (m, n)).copy_from(&self.rows);
    }
}
