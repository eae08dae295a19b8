//! The data seen through the columns of everything that is asked.
//!
//! At one point of the parameters the whitened residual `r = W(ŷ - y)` and all its columns are computed once: those of
//! the parameters of the mechanism and of the measurement (the *nuisance*, which every question is asked beside),
//! one for each parameter of each effect, and one for a unit displacement of each joint. Everything else is
//! linear algebra on this table.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::measurement::RowKind;

/// Residual and columns.
#[derive(Clone, Debug)]
pub(crate) struct DesignMatrix {
    /// Whitened columns (rows × (nuisance + effects + joints)).
    pub(crate) a: DMatrix<f64>,
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
    pub(crate) fn spread(&mut self, of_joints: &[f64], of_kinds: Option<[f64; 2]>, of_samples: &[f64]) {
        if of_joints.is_empty() && of_kinds.is_none() && of_samples.is_empty() {
            return;
        }
        for (k, (first, n)) in self.rows.clone().into_iter().enumerate() {
            let of_sample = of_samples.get(k).copied().unwrap_or(1.0);
            for i in 0..n {
                let of_joint = if of_joints.is_empty() { 1.0 } else { of_joints[self.joint_of(first + i)] };
                let of_kind = of_kinds.map_or(1.0, |k| k[usize::from(self.kinds[first + i] == RowKind::Rotation)]);
                let spread = of_sample * of_joint * of_kind;
                self.a.row_mut(first + i).unscale_mut(spread);
                self.r[first + i] /= spread;
                self.unwhiten[k].column_mut(i).scale_mut(spread);
            }
        }
    }

    /// The joint that moves a row most.
    fn joint_of(&self, row: usize) -> usize {
        let size = |k: &usize| self.a[(row, self.joints.start + k)].abs();
        (0..self.joints.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0)
    }

    /// Root mean square of a residual over the rows that each joint moves, in units of the present spread. Joints that move
    /// no row, or whose rows are fitted to rounding, have the median of the others.
    pub(crate) fn spreads_of(&self, residual: &DVector<f64>, left_out: &[usize]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.joints.len()];
        for (first, n) in self.kept_rows(left_out) {
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

    /// The same with the rows of these samples set to zero.
    pub(crate) fn without(&self, left_out: &[usize]) -> Self {
        let mut table = self.clone();
        for (first, n) in left_out.iter().map(|k| self.rows[*k]) {
            table.a.rows_mut(first, n).fill(0.0);
            table.r.rows_mut(first, n).fill(0.0);
        }
        table
    }

    /// First row and number of rows of each sample that is not left out.
    pub(crate) fn kept_rows<'t>(&'t self, left_out: &'t [usize]) -> impl Iterator<Item = (usize, usize)> + 't {
        self.rows.iter().enumerate().filter(|(k, _)| !left_out.contains(k)).map(|(_, rows)| *rows)
    }

    /// Number of rows of the samples that are not left out.
    pub(crate) fn count(&self, left_out: &[usize]) -> usize {
        self.r.len() - left_out.iter().map(|k| self.rows[*k].1).sum::<usize>()
    }

    /// Number of samples.
    pub(crate) fn samples(&self) -> usize {
        self.rows.len()
    }
}
