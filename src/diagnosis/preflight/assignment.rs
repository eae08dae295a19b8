//! Which column goes with which leg.

use nalgebra::DMatrix;

/// Correlation of pairs of numbers; 0 where one of the two does not change.
pub(crate) fn correlation(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let n = pairs.clone().count() as f64;
    let (ma, mb) = pairs.clone().fold((0.0, 0.0), |(x, y), (a, b)| (x + a / n, y + b / n));
    let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in pairs {
        aa += (a - ma).powi(2);
        ab += (a - ma) * (b - mb);
        bb += (b - mb).powi(2);
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

/// The assignment of columns to rows with the largest sum, by going through all of them; legs are few.
pub(crate) fn best_assignment(score: &DMatrix<f64>) -> Vec<usize> {
    fn go(score: &DMatrix<f64>, order: &mut Vec<usize>, sum: f64, best: &mut (f64, Vec<usize>)) {
        let n = score.nrows();
        if order.len() == n {
            if sum > best.0 {
                *best = (sum, order.clone());
            }
            return;
        }
        // No row can add more than one.
        if sum + (n - order.len()) as f64 <= best.0 {
            return;
        }
        for column in (0..n).filter(|k| !order.contains(k)).collect::<Vec<_>>() {
            let row = order.len();
            order.push(column);
            go(score, order, sum + score[(row, column)], best);
            order.pop();
        }
    }
    let mut best = (f64::NEG_INFINITY, (0..score.nrows()).collect());
    go(score, &mut Vec::new(), 0.0, &mut best);
    best.1
}
