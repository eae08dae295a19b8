//! Lines through spots: their paths, and the pieces into which they are cut.

use super::camera::{between, distance};
use super::stage::{Spot, Stage};
use crate::report::chart::marks::tenth;

/// Longest pieces into which lines are cut, in radii of the scene.
const PIECE: f64 = 0.22;

/// Path data of a line through spots.
pub(super) fn path(spots: &[Spot], closed: bool) -> String {
    let mut d = String::new();
    for (i, spot) in spots.iter().enumerate() {
        d.push_str(if i == 0 { "M" } else { "L" });
        d.push_str(&format!("{} {}", tenth(spot.px[0]), tenth(spot.px[1])));
    }
    if spots.len() == 1 {
        d.push_str("h0");
    } else if closed {
        d.push('z');
    }
    d
}

/// The mean of some spots.
pub(super) fn middle(spots: &[Spot]) -> Option<Spot> {
    // The first and last one of a closed line are the same.
    let closed = spots.len() > 2 && spots.first() == spots.last();
    let spots = if closed { spots.get(1..)? } else { spots };
    let mean = |pick: &dyn Fn(&Spot) -> f64| spots.iter().map(pick).sum::<f64>() / spots.len() as f64;
    (!spots.is_empty()).then(|| Spot {
        at: std::array::from_fn(|i| mean(&|s| s.at[i])),
        px: std::array::from_fn(|i| mean(&|s| s.px[i])),
        depth: mean(&|s| s.depth),
    })
}

/// The lines of a closed polygon, interrupted where there is no spot. A polygon without gaps ends where it begins.
pub(super) fn runs(spots: &[Option<Spot>]) -> Vec<Vec<Spot>> {
    let whole: Option<Vec<Spot>> = spots.iter().copied().collect();
    if let Some(mut all) = whole {
        if all.len() > 2 {
            all.extend(all.first().copied());
        }
        return vec![all];
    }
    // Starting after a gap, no run is torn apart where the list ends.
    let gap = spots.iter().position(Option::is_none).unwrap_or(0);
    let turned: Vec<Option<Spot>> = spots.iter().cycle().skip(gap).take(spots.len()).copied().collect();
    turned.split(Option::is_none).filter(|r| !r.is_empty()).map(|r| r.iter().flatten().copied().collect()).collect()
}

/// Cuts a line into pieces that are short enough to be ordered by their depth; short edges share a piece.
pub(super) fn pieces(stage: &Stage, run: &[Spot]) -> Vec<Vec<Spot>> {
    let mut all: Vec<Vec<Spot>> = Vec::new();
    let mut piece: Vec<Spot> = run.first().copied().into_iter().collect();
    let mut length = 0.0;
    for edge in run.windows(2) {
        let (Some(a), Some(b)) = (edge.first(), edge.last()) else { continue };
        let whole = distance(a.at, b.at);
        let count = (whole / PIECE).ceil().clamp(1.0, 12.0) as usize;
        for i in 1..=count {
            if length + whole / count as f64 > 1.01 * PIECE && piece.len() > 1 {
                let last = piece.last().copied();
                all.push(std::mem::replace(&mut piece, last.into_iter().collect()));
                length = 0.0;
            }
            piece.push(stage.project(between(a.at, b.at, i as f64 / count as f64)));
            length += whole / count as f64;
        }
    }
    all.push(piece);
    all
}
