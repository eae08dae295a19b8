//! Which index is best, and how sure that is.

use super::conditions::{INDICES, Outcome, means};
use super::exhibit::Listing;
use super::paper::{CONDITIONS, Condition};
use super::{Comparison, Spread};

/// Which index is best, and how sure that is.
pub(super) struct Ranking {
    /// Probability that O1 wins all four conditions on single draws, one a list.
    all_four: Vec<f64>,
    /// For each condition: ratios O5 over O1 by list, with the paper's estimator and weighted.
    ratios: Vec<[Vec<f64>; 2]>,
    pub(super) listing: Listing,
}

impl Ranking {
    pub(super) fn of(all: &[Outcome]) -> Self {
        let comment = "share of noise draws in which an index gives the smallest error; mean error over that of O1 with its \
                       95 % interval over lists, with the paper's estimator and with weighted rows";
        let header = [
            "condition",
            "index",
            "wins",
            "over_o1",
            "low",
            "high",
            "weighted_over_o1",
            "weighted_low",
            "weighted_high",
        ];
        let mut listing = Listing::new("table4-ranking", comment, &header);
        let lists = all[0].draws[0].len();
        let mut all_four = vec![1.0; lists];
        let mut ratios = Vec::new();
        for o in all {
            let wins: Vec<[f64; 5]> = (0..lists).map(|list| wins(o, list)).collect();
            for (p, w) in all_four.iter_mut().zip(&wins) {
                *p *= w[0];
            }
            let over = |cells: &[Vec<Vec<Option<f64>>>], k: usize| -> Vec<f64> {
                means(&cells[k]).iter().zip(means(&cells[0])).map(|(a, b)| a / b).collect()
            };
            for (k, index) in INDICES.iter().enumerate() {
                let won = wins.iter().map(|w| w[k]).sum::<f64>() / lists as f64;
                let (plain, weighted) = (Spread::of_mean(&over(&o.draws, k)), Spread::of_mean(&over(&o.weighted, k)));
                let numbers = [won, plain.mean, plain.low, plain.high, weighted.mean, weighted.low, weighted.high];
                listing.row(&[o.condition.name, index], &numbers);
            }
            ratios.push([over(&o.draws, 4), over(&o.weighted, 4)]);
        }
        Self { all_four, ratios, listing }
    }

    pub(super) fn comparison(&self) -> Comparison {
        let Spread { mean, error, low, high } = Spread::of_mean(&self.all_four);
        let probability = Spread { mean, error, low: low.max(0.0), high: high.min(1.0) };
        let claim = "the calibration based on O1 has the highest accuracy";
        Comparison::claim(
            "probability that O1 wins all four on single draws",
            claim,
            probability,
            probability.low > 0.5,
        )
        .because("the paper found it in one draw and took it for the rule")
    }

    pub(super) fn findings(&self) -> Vec<String> {
        let describe = |which: usize| -> String {
            let one = |(o, r): (&Condition, &[Vec<f64>; 2])| {
                let s = Spread::of_mean(&r[which]);
                let better = match () {
                    () if s.low > 1.0 => "O1 is better",
                    () if s.high < 1.0 => "O5 is better",
                    () => "not decided",
                };
                format!("{} {:.3} ({:.3} to {:.3}: {better})", o.name, s.mean, s.low, s.high)
            };
            CONDITIONS.iter().zip(&self.ratios).map(one).collect::<Vec<_>>().join(", ")
        };
        vec![
            format!("Mean error with O5 over that with O1, the paper's estimator: {}.", describe(0)),
            format!("The same with weighted rows: {}.", describe(1)),
        ]
    }
}

/// Share of draws that each index wins, for one list.
fn wins(o: &Outcome, list: usize) -> [f64; 5] {
    let mut won = [0.0; 5];
    let mut counted = 0.0_f64;
    for draw in 0..o.draws[0][list].len() {
        let errors: Option<Vec<f64>> = (0..5).map(|k| o.draws[k][list][draw]).collect();
        let Some(errors) = errors else { continue };
        counted += 1.0;
        if let Some(best) = (0..5).min_by(|a, b| errors[*a].total_cmp(&errors[*b])) {
            won[best] += 1.0;
        }
    }
    won.map(|w| w / counted.max(1.0))
}
