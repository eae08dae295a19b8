//! The data seen through the columns of everything that is asked.
//!
//! At one point of the parameters the whitened residual `r = W(ŷ - y)` and all its columns are computed once: those of
//! the parameters of the mechanism and of the measurement (the *nuisance*, which every question is asked beside),
//! one for each parameter of each effect, and one for a unit displacement of each joint and of each coordinate. Everything else is
//! linear algebra on this table.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::linear::spreads::Spreads;
use crate::diagnosis::linear::unit_motion::Place;
use crate::measurement::RowKind;

/// Columns of the table that act from one row on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    /// The columns.
    pub(crate) columns: Range<usize>,
    /// The first row on which they act.
    pub(crate) first: usize,
}

/// Residual and columns.
#[derive(Clone, Debug)]
pub(crate) struct DesignMatrix {
    /// Whitened columns, transposed ((nuisance + effects + joints) × rows), so that a sample is one piece of memory.
    pub(crate) a_t: DMatrix<f64>,
    /// Whitened residual.
    pub(crate) r: DVector<f64>,
    /// First row and number of rows of each sample.
    pub(crate) rows: Vec<(usize, usize)>,
    /// What each row measures.
    pub(crate) kinds: Vec<RowKind>,
    /// Number of nuisance columns.
    pub(crate) nuisance: usize,
    /// Columns of unit joint displacements.
    pub(crate) joints: Range<usize>,
    /// Columns of unit displacements of what is seen of the platform, along its six coordinates; empty where they are the
    /// joints.
    pub(crate) coordinates: Range<usize>,
    /// Precision of the prior on the nuisance, in units of the stated noise.
    pub(crate) precision: DMatrix<f64>,
    /// Its gradient at the point.
    pub(crate) gradient: DVector<f64>,
    /// Its value at the point.
    pub(crate) penalty: f64,
    /// Own parameters of the measurement at the point.
    pub(crate) own: Vec<f64>,
    /// Whitened rows back to SI, by sample.
    pub(crate) unwhiten: Vec<DMatrix<f64>>,
}

impl DesignMatrix {
    /// Divides each row by the spread of the joint that moves it most, of its kind, and of its sample.
    pub(crate) fn weigh(&mut self, spreads: &Spreads) {
        if spreads.are_as_stated() {
            return;
        }
        for (k, (first, n)) in self.rows.clone().into_iter().enumerate() {
            for i in 0..n {
                let spread = spreads.of_row(k, || self.joint_of(first + i), self.kinds[first + i]);
                self.a_t.column_mut(first + i).unscale_mut(spread);
                self.r[first + i] /= spread;
                self.unwhiten[k].column_mut(i).scale_mut(spread);
            }
        }
    }

    /// The joint that moves a row most.
    fn joint_of(&self, row: usize) -> usize {
        let size = |k: &usize| self.a_t[(self.joints.start + k, row)].abs();
        (0..self.joints.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0)
    }

    /// Root mean square of a residual over the rows that each joint moves, in units of the present spread. Joints that move
    /// no row, or whose rows are fitted to rounding, have the median of the others. `kept` are rows of samples.
    pub(crate) fn spreads_of(&self, residual: &DVector<f64>, kept: impl Iterator<Item = (usize, usize)>) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.joints.len()];
        for (first, n) in kept {
            for row in first..first + n {
                let sum = &mut sums[self.joint_of(row)];
                *sum = (sum.0 + residual[row] * residual[row], sum.1 + 1.0);
            }
        }
        let roots: Vec<f64> = sums.iter().map(|(s, n)| if *n > 0.0 { (s / n).sqrt() } else { 0.0 }).collect();
        let mut seen: Vec<f64> = roots.iter().copied().filter(|r| *r > 0.0).collect();
        seen.sort_by(f64::total_cmp);
        let median = seen.get(seen.len() / 2).copied().unwrap_or(1.0);
        roots.into_iter().map(|r| if r > 1e-9 * median { r } else { median }).collect()
    }

    /// The sum of the columns of a block times `values` (rows).
    pub(crate) fn combined(&self, block: &Block, values: &[f64]) -> DVector<f64> {
        let mut sum = DVector::zeros(self.r.len());
        let rows = self.r.len() - block.first;
        let part = self.a_t.view((block.columns.start, block.first), (block.columns.len(), rows));
        sum.rows_mut(block.first, rows).gemv_tr(1.0, &part, &DVector::from_column_slice(values), 0.0);
        sum
    }

    /// The columns of a block (rows × columns).
    pub(crate) fn columns(&self, block: &Block) -> DMatrix<f64> {
        let mut columns = self.a_t.rows(block.columns.start, block.columns.len()).transpose();
        columns.rows_mut(0, block.first).fill(0.0);
        columns
    }

    /// Everywhere that a nameless error may act.
    pub(crate) fn places(&self) -> impl Iterator<Item = Place> {
        (0..self.joints.len()).map(Place::Joint).chain((0..self.coordinates.len()).map(Place::Coordinate))
    }

    /// The coordinates of the platform as it is seen; in pose space they are the joints.
    pub(crate) fn whole_frame(&self) -> Vec<Place> {
        match self.coordinates.len() {
            0 => (0..self.joints.len()).map(Place::Joint).collect(),
            n => (0..n).map(Place::Coordinate).collect(),
        }
    }

    /// The column of a unit displacement at a place.
    pub(crate) fn column_of(&self, place: Place) -> usize {
        match place {
            Place::Joint(k) => self.joints.start + k,
            Place::Coordinate(k) => self.coordinates.start + k,
        }
    }

    /// Number of samples.
    pub(crate) fn samples(&self) -> usize {
        self.rows.len()
    }
}
