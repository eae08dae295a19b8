//! Which column goes with which leg.

use nalgebra::DMatrix;

/// The assignment of columns to rows with the largest sum, by going through all of them; legs are few.
pub(crate) fn best_assignment(score: &DMatrix<f64>) -> Vec<usize> {
    fn go(score: &DMatrix<f64>, bound: &[f64], order: &mut Vec<usize>, sum: f64, best: &mut (f64, Vec<usize>)) {
        let row = order.len();
        if row == score.nrows() {
            if sum > best.0 {
                *best = (sum, order.clone());
            }
            return;
        }
        if sum + bound[row] <= best.0 {
            return;
        }
        for column in (0..score.ncols()).filter(|k| !order.contains(k)).collect::<Vec<_>>() {
            order.push(column);
            go(score, bound, order, sum + score[(row, column)], best);
            order.pop();
        }
    }
    let n = score.nrows();
    // What the rows from each on can add at most.
    let mut bound = vec![0.0; n + 1];
    for row in (0..n).rev() {
        bound[row] = bound[row + 1] + score.row(row).max();
    }
    let mut best = (f64::NEG_INFINITY, (0..n).collect());
    go(score, &bound, &mut Vec::new(), 0.0, &mut best);
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_sum_wins_over_the_largest_entries() {
        let score = DMatrix::from_row_slice(3, 3, &[9.0, 8.0, 0.0, 9.0, 1.0, 0.0, 5.0, 5.0, 5.0]);
        assert_eq!(best_assignment(&score), [1, 0, 2]);
    }
}
