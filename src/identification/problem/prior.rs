//! Manufacturing tolerances as prior knowledge.

use crate::identification::error::IdentifyError;
use crate::identification::problem::belief::{Belief, Conventions, Group, widths};
use crate::mechanism::{Mechanism, ParameterSpec, characteristic_length};
use crate::units::Dimension;
use nalgebra::{DMatrix, DVector};

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

impl Prior {
    /// The most probable values of the parameters before anything is measured.
    pub(crate) fn centre(&self) -> &[f64] {
        &self.centre
    }

    /// Each parameter lies about its start with its tolerance, times the factor of its group, as 1σ: the rows are `D⁻¹` with
    /// `D` these widths, or `(I - (1 - a) Q Qᵀ) D⁻¹` with `Q` the conventions, along which `a` is a hundredth if they are free.
    ///
    /// # Errors
    /// [`IdentifyError::NoTolerance`] if no parameter has one.
    pub fn from_tolerance(mechanism: &dyn Mechanism, belief: &Belief) -> Result<Self, IdentifyError> {
        let groups = Group::of(mechanism, &widths(mechanism, belief.factors));
        let rows = rows(&groups, mechanism.parameters().len(), belief.narrowness());
        if rows.nrows() == 0 {
            return Err(IdentifyError::NoTolerance);
        }
        let start = mechanism.values();
        let mut centre = start.to_vec();
        if let Some(found) = &belief.centre {
            for (group, free) in groups.iter().zip(belief.conventions.free()) {
                let Some((group, q)) = group.as_ref().filter(|_| free).and_then(|g| Some((g, g.convention.as_ref()?)))
                else {
                    continue;
                };
                let along = q * (q.transpose() * group.shift(start, found));
                for ((k, w), moved) in group.members.iter().zip(&group.widths).zip(along.iter()) {
                    centre[*k] += w * moved;
                }
            }
        }
        Ok(Self { centre, rows, held: None })
    }

    /// A prior for a search through causes: each parameter lies within `factor` tolerances of its start, and
    /// `conventions` are as good as free. Parameters without a tolerance get a width that only keeps them finite: a hundredth of
    /// the size of the mechanism for lengths, a hundredth of a radian for angles, a tenth of their value otherwise.
    pub fn wide(mechanism: &dyn Mechanism, factor: f64, conventions: Conventions) -> Self {
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
        let groups = Group::of(mechanism, &widths);
        let rows = rows(&groups, widths.len(), Belief::stated(conventions).narrowness());
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

/// A row for each member of the groups, in all `parameters`; along the convention of a group they are multiplied by its
/// `narrowness`.
fn rows(groups: &[Option<Group>; 4], parameters: usize, narrowness: [f64; 4]) -> DMatrix<f64> {
    let count = groups.iter().flatten().map(|g| g.members.len()).sum();
    let mut rows = DMatrix::zeros(count, parameters);
    let mut first = 0;
    for (group, along) in groups.iter().zip(narrowness) {
        let Some(group) = group else { continue };
        let n = group.members.len();
        let precision = group.convention_times(along);
        for (column, (k, width)) in group.members.iter().zip(&group.widths).enumerate() {
            rows.view_mut((first, *k), (n, 1)).copy_from(&(precision.column(column) / *width));
        }
        first += n;
    }
    rows
}
