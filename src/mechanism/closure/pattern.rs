//! Which columns of the Jacobian may travel in one lane.

use super::{Closure, Column, Outline};

/// The sparsity of a closure, and a colouring of its columns: columns of one colour share no row.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// Colour of each identified parameter, then of each joint.
    pub(super) colour: Vec<usize>,
    /// Number of colours.
    pub(super) colours: usize,
    /// Rows of all columns one after the other.
    rows: Vec<usize>,
    /// Where the rows of each column end.
    ends: Vec<usize>,
}

impl Pattern {
    /// Greedy colouring in the order of the columns; `free` are the identified parameters.
    pub(super) fn of<C: Closure>(closure: &C, outline: &Outline, free: &[usize]) -> Self {
        let joints = 0..outline.joints.len();
        let columns = free.iter().map(|k| Column::Parameter(*k)).chain(joints.map(Column::Joint));
        let mut found = Self { colour: Vec::new(), colours: 0, rows: Vec::new(), ends: Vec::new() };
        // Rows that a colour has taken.
        let mut taken: Vec<Vec<bool>> = Vec::new();
        for on in columns {
            let rows: Vec<usize> = (0..outline.equations).filter(|row| closure.depends(*row, on)).collect();
            let free_in = |used: &Vec<bool>| rows.iter().all(|row| !used[*row]);
            let colour = taken.iter().position(free_in).unwrap_or_else(|| {
                taken.push(vec![false; outline.equations]);
                taken.len() - 1
            });
            rows.iter().for_each(|row| taken[colour][*row] = true);
            found.colour.push(colour);
            found.rows.extend(rows);
            found.ends.push(found.rows.len());
        }
        found.colours = taken.len();
        found
    }

    /// Every column in a lane of its own, with all rows.
    pub(super) fn dense(columns: usize, equations: usize) -> Self {
        Self {
            colour: (0..columns).collect(),
            colours: columns,
            rows: (0..columns).flat_map(|_| 0..equations).collect(),
            ends: (1..=columns).map(|k| k * equations).collect(),
        }
    }

    /// Rows of a column.
    #[inline]
    pub(super) fn rows(&self, column: usize) -> &[usize] {
        let start = if column == 0 { 0 } else { self.ends[column - 1] };
        &self.rows[start..self.ends[column]]
    }
}
