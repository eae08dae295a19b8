//! Which columns of the Jacobian may travel in one lane.

use super::{Closure, Column, Outline};

/// The sparsity of a closure, and a colouring of its columns: columns of one colour share no row.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// Colour of each identified parameter, then of each joint.
    pub(super) colour: Vec<usize>,
    /// Rows of each of these columns.
    pub(super) rows: Vec<Vec<usize>>,
    /// Number of colours.
    pub(super) colours: usize,
}

impl Pattern {
    /// Greedy colouring in the order of the columns; `free` are the identified parameters.
    pub(super) fn of<C: Closure>(closure: &C, outline: &Outline, free: &[usize]) -> Self {
        let joints = 0..outline.joints.len();
        let columns = free.iter().map(|k| Column::Parameter(*k)).chain(joints.map(Column::Joint));
        let rows: Vec<Vec<usize>> =
            columns.map(|on| (0..outline.equations).filter(|row| closure.depends(*row, on)).collect()).collect();
        // Rows that a colour has taken.
        let mut taken: Vec<Vec<bool>> = Vec::new();
        let mut colour = Vec::with_capacity(rows.len());
        for of_column in &rows {
            let free_in = |used: &Vec<bool>| of_column.iter().all(|row| !used[*row]);
            let k = taken.iter().position(free_in).unwrap_or_else(|| {
                taken.push(vec![false; outline.equations]);
                taken.len() - 1
            });
            of_column.iter().for_each(|row| taken[k][*row] = true);
            colour.push(k);
        }
        Self { colour, rows, colours: taken.len() }
    }
}
