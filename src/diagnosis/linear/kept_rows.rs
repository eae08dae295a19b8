//! The rows of a table that count, and the products of its columns over them.
//!
//! Every model of the same rows is a choice of columns, so that `Aᵀ A` and `Aᵀ r` are summed once, and a model, or one
//! more effect in it, costs no further pass over the rows: its normal equations, and the products of its columns with
//! all others, are pieces of these sums.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::linear::design_matrix::{Block, DesignMatrix};

/// Rows that are multiplied at once.
const AT_ONCE: usize = 512;
/// Columns of a panel of the symmetric product, of which only the panels on and above the diagonal are summed.
const PANEL: usize = 48;

/// A table without the samples that were left out.
#[derive(Debug)]
pub(crate) struct KeptRows {
    pub(crate) table: Arc<DesignMatrix>,
    /// The samples that were left out, in order.
    pub(crate) left_out: Vec<usize>,
    is_out: Vec<bool>,
    /// The residual of the table, zero where samples are left out.
    pub(crate) r: DVector<f64>,
    /// `Aᵀ A`.
    gram: DMatrix<f64>,
    /// `Aᵀ r`.
    moments: DVector<f64>,
}

/// The products of a block of columns with all columns of the table, and with the residual.
#[derive(Clone, Debug)]
pub(crate) struct BlockProducts {
    block: Block,
    /// `Xᵀ A` (columns of the block × columns of the table).
    pub(crate) with_all: DMatrix<f64>,
    /// `Xᵀ r`.
    pub(crate) with_residual: DVector<f64>,
}

impl KeptRows {
    pub(crate) fn new(table: Arc<DesignMatrix>, left_out: Vec<usize>) -> Self {
        let mut is_out = vec![false; table.samples()];
        let mut r = table.r.clone();
        for k in &left_out {
            is_out[*k] = true;
            let (first, n) = table.rows[*k];
            r.rows_mut(first, n).fill(0.0);
        }
        let gram = gram(&table, &is_out);
        let moments = &table.a_t * &r;
        Self { table, left_out, is_out, r, gram, moments }
    }

    /// True for a sample that was left out.
    pub(crate) fn is_out(&self, sample: usize) -> bool {
        self.is_out[sample]
    }

    /// First row and number of rows of each sample that is not left out.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.table.rows.iter().zip(&self.is_out).filter(|(_, out)| !**out).map(|(rows, _)| *rows)
    }

    /// The samples that are not left out.
    pub(crate) fn samples(&self) -> Vec<usize> {
        (0..self.is_out.len()).filter(|k| !self.is_out[*k]).collect()
    }

    /// Number of rows that count.
    pub(crate) fn count(&self) -> usize {
        self.table.r.len() - self.left_out.iter().map(|k| self.table.rows[*k].1).sum::<usize>()
    }

    /// Sets the columns of `by_row` to zero that belong to samples that were left out.
    pub(crate) fn clear(&self, by_row: &mut DMatrix<f64>) {
        for (first, n) in self.left_out.iter().map(|k| self.table.rows[*k]) {
            by_row.columns_mut(first, n).fill(0.0);
        }
    }

    /// The columns of a block (rows × columns), zero where samples are left out.
    pub(crate) fn columns(&self, block: &Block) -> DMatrix<f64> {
        let mut columns = self.table.columns(block);
        for (first, n) in self.left_out.iter().map(|k| self.table.rows[*k]) {
            columns.rows_mut(first, n).fill(0.0);
        }
        columns
    }

    /// `Xᵀ X` of columns that act on all rows.
    pub(crate) fn square(&self, columns: &std::ops::Range<usize>) -> DMatrix<f64> {
        let p = columns.len();
        self.gram.view((columns.start, columns.start), (p, p)).into_owned()
    }

    /// The products of a block: pieces of the sums where it acts on all rows, and one pass over its rows where not.
    pub(crate) fn products(&self, block: Block) -> BlockProducts {
        let (start, p) = (block.columns.start, block.columns.len());
        if block.first == 0 {
            let with_all = self.gram.rows(start, p).into_owned();
            return BlockProducts { with_all, with_residual: self.moments.rows(start, p).into_owned(), block };
        }
        let rows = self.r.len() - block.first;
        let mut x = self.table.a_t.view((start, block.first), (p, rows)).transpose();
        for (first, n) in self.left_out.iter().map(|k| self.table.rows[*k]).filter(|(first, _)| *first >= block.first) {
            x.rows_mut(first - block.first, n).fill(0.0);
        }
        let all = self.table.a_t.columns(block.first, rows) * &x;
        let with_residual = x.tr_mul(&self.r.rows(block.first, rows));
        BlockProducts { with_all: all.transpose(), with_residual, block }
    }
}

/// `Xᵀ Y` of two lists of blocks. Of two blocks the one that begins later knows their product.
pub(crate) fn between(left: &[BlockProducts], right: &[BlockProducts]) -> DMatrix<f64> {
    let size = |list: &[BlockProducts]| list.iter().map(|x| x.block.columns.len()).sum();
    let mut all = DMatrix::zeros(size(left), size(right));
    let mut row = 0;
    for x in left {
        let mut column = 0;
        let p = x.block.columns.len();
        for y in right {
            let q = y.block.columns.len();
            let mut part = all.view_mut((row, column), (p, q));
            if x.block.first >= y.block.first {
                part.copy_from(&x.with_all.columns(y.block.columns.start, q));
            } else {
                part.tr_copy_from(&y.with_all.columns(x.block.columns.start, p));
            }
            column += q;
        }
        row += p;
    }
    all
}

/// `Aᵀ A` over the samples that are not out, some rows at a time.
fn gram(table: &DesignMatrix, is_out: &[bool]) -> DMatrix<f64> {
    let columns = table.a_t.nrows();
    let mut gram = DMatrix::zeros(columns, columns);
    let mut part = DMatrix::zeros(columns, AT_ONCE);
    let mut filled = 0;
    let mut add = |part: &DMatrix<f64>, filled: usize| {
        let some = part.columns(0, filled);
        let across = some.transpose();
        for first in (0..columns).step_by(PANEL) {
            let width = PANEL.min(columns - first);
            let above = first + width;
            gram.view_mut((0, first), (above, width)).gemm(
                1.0,
                &some.rows(0, above),
                &across.columns(first, width),
                1.0,
            );
        }
    };
    for (first, n) in table.rows.iter().zip(is_out).filter(|(_, out)| !**out).map(|(rows, _)| *rows) {
        for row in first..first + n {
            part.column_mut(filled).copy_from(&table.a_t.column(row));
            filled += 1;
            if filled == AT_ONCE {
                add(&part, filled);
                filled = 0;
            }
        }
    }
    add(&part, filled);
    gram.fill_lower_triangle_with_upper_triangle();
    gram
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::RowKind;

    fn table(samples: usize) -> DesignMatrix {
        let (rows, columns) = (3 * samples, 100);
        DesignMatrix {
            a_t: DMatrix::from_fn(columns, rows, |i, k| ((7 * i + 13 * k + i * k) % 29) as f64 - 14.0),
            r: DVector::from_fn(rows, |k, _| (k % 5) as f64 - 2.0),
            rows: (0..samples).map(|k| (3 * k, 3)).collect(),
            kinds: vec![RowKind::Position; rows],
            nuisance: 10,
            joints: 94..100,
            coordinates: 0..0,
            precision: DMatrix::zeros(10, 10),
            gradient: DVector::zeros(10),
            penalty: 0.0,
            own: Vec::new(),
            unwhiten: vec![DMatrix::identity(3, 3); samples],
        }
    }

    /// Whole numbers: every order of summation gives the same, so that the products must be exact.
    #[test]
    fn products_are_those_of_the_written_out_columns() {
        let table = Arc::new(table(400));
        let left_out = vec![3, 170, 399];
        let kept = KeptRows::new(Arc::clone(&table), left_out.clone());
        let blocks = [(0..10, 0), (20..26, 0), (40..46, 600), (50..51, 30)];
        let blocks = blocks.map(|(columns, first)| Block { columns, first });
        let written: Vec<DMatrix<f64>> = blocks
            .iter()
            .map(|b| {
                let mut x = table.columns(b);
                left_out.iter().for_each(|k| x.rows_mut(3 * k, 3).fill(0.0));
                x
            })
            .collect();
        let products = blocks.clone().map(|b| kept.products(b));
        for (k, x) in written.iter().enumerate() {
            assert_eq!(products[k].with_residual, x.tr_mul(&table.r));
            for (m, y) in written.iter().enumerate() {
                assert_eq!(between(&products[k..=k], &products[m..=m]), x.tr_mul(y), "{k} {m}");
            }
        }
        assert_eq!(kept.square(&(20..26)), written[1].tr_mul(&written[1]));
        assert_eq!(kept.count(), 1200 - 9);
    }
}
