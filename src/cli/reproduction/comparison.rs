//! A printed number among our draws.

use std::fmt;

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::simulation::RunningStats;

/// Whether a printed number is what the simulation gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Agreement {
    /// It lies in the central 95 % of single draws, which are within 5 % of their mean; or within 1 % of the mean.
    Reproduced,
    /// It lies in the central 95 % of single draws, which are wider than that.
    WithinOneDraw,
    /// It lies outside.
    NotReproduced,
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reproduced => "reproduced",
            Self::WithinOneDraw => "within its one draw",
            Self::NotReproduced => "not reproduced",
        })
    }
}

/// Mean of draws, and where 95 % of single draws lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard error of the mean.
    pub error: f64,
    /// Lower end of the central 95 % of single draws.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// With as many draws their own quantiles say where 95 % lie; with fewer Student's distribution does.
const MANY: usize = 200;
/// Draws within this part of their mean are narrow enough to be compared with.
const NARROW: f64 = 0.05;
/// A number this near to the mean is the mean.
const SAME: f64 = 0.01;

impl Spread {
    /// Of independent draws.
    pub fn of(draws: &[f64]) -> Self {
        let all = RunningStats::of(draws.iter().copied());
        let (mean, error) = (all.mean(), all.standard_error());
        if draws.len() >= MANY {
            return Self { mean, error, low: quantile(draws, 0.025), high: quantile(draws, 0.975) };
        }
        let n = draws.len() as f64;
        let half = student(n - 1.0) * all.sd() * (1.0 + 1.0 / n).sqrt();
        // What is never negative among the draws is taken to be so by its nature.
        let floor = if all.least() >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
        Self { mean, error, low: (mean - half).max(floor), high: mean + half }
    }

    /// Of draws that come in sets, each with something in common: the error of the mean is that over the sets.
    pub fn of_sets(sets: &[Vec<f64>]) -> Self {
        let means =
            RunningStats::of(sets.iter().filter(|s| !s.is_empty()).map(|s| RunningStats::of(s.iter().copied()).mean()));
        let all: Vec<f64> = sets.iter().flatten().copied().collect();
        Self { mean: means.mean(), error: means.standard_error(), ..Self::of(&all) }
    }

    /// A number without spread.
    pub fn exactly(value: f64) -> Self {
        Self { mean: value, error: 0.0, low: value, high: value }
    }

    /// 95 % confidence interval of the mean of a few independent draws.
    pub fn of_mean(draws: &[f64]) -> Self {
        let all = RunningStats::of(draws.iter().copied());
        let (mean, error) = (all.mean(), all.standard_error());
        let half = student(draws.len() as f64 - 1.0) * error;
        Self { mean, error, low: mean - half, high: mean + half }
    }
}

/// Half of the central 95 % of Student's distribution.
fn student(freedom: f64) -> f64 {
    // One degree of freedom is the least that it has.
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// Quantile of draws, interpolated; NaN without draws.
pub(super) fn quantile(draws: &[f64], part: f64) -> f64 {
    let mut sorted = draws.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = part * (sorted.len().max(1) - 1) as f64;
    let (below, share) = (place.floor() as usize, place.fract());
    match (sorted.get(below), sorted.get(below + 1)) {
        (Some(a), Some(b)) => a + share * (b - a),
        (Some(a), None) => *a,
        _ => f64::NAN,
    }
}

/// A quantity of the paper beside ours.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Quantity that is compared.
    pub quantity: String,
    /// Unit of the numbers; empty if there is none.
    pub unit: &'static str,
    /// Number that the paper prints, if any.
    pub paper: Option<f64>,
    /// Our result.
    pub ours: Spread,
    /// Whether they agree, if there is something to agree with.
    pub verdict: Option<Agreement>,
    /// A statement of the paper that is judged, where it is no number.
    pub claim: Option<&'static str>,
    /// Why they do not, or what else is to be known.
    pub why: String,
}

impl Comparison {
    /// A statement of the paper, with the number of ours that decides it.
    pub fn claim(quantity: impl Into<String>, claim: &'static str, ours: Spread, holds: bool) -> Self {
        let verdict = Some(if holds { Agreement::Reproduced } else { Agreement::NotReproduced });
        Self { claim: Some(claim), verdict, ..Self::ours(quantity, "", ours) }
    }

    /// Compares a printed number with draws of ours.
    pub fn new(quantity: impl Into<String>, unit: &'static str, paper: f64, ours: Spread) -> Self {
        let verdict = Some(judge(paper, &ours));
        Self { quantity: quantity.into(), unit, paper: Some(paper), ours, verdict, claim: None, why: String::new() }
    }

    /// A number of ours that the paper does not print.
    pub fn ours(quantity: impl Into<String>, unit: &'static str, ours: Spread) -> Self {
        Self { quantity: quantity.into(), unit, paper: None, ours, verdict: None, claim: None, why: String::new() }
    }

    /// This comparison without a verdict, for quantities that the paper does not state.
    #[must_use]
    pub fn not_judged(mut self) -> Self {
        self.verdict = None;
        self
    }

    /// With a remark.
    #[must_use]
    pub fn because(mut self, why: impl Into<String>) -> Self {
        self.why = why.into();
        self
    }

    /// With a remark if it is not reproduced.
    #[must_use]
    pub fn unless_reproduced(self, why: &str) -> Self {
        if self.verdict == Some(Agreement::NotReproduced) { self.because(why) } else { self }
    }
}

fn judge(paper: f64, ours: &Spread) -> Agreement {
    let size = ours.mean.abs();
    let inside = (ours.low..=ours.high).contains(&paper);
    let narrow = ours.high - ours.mean <= NARROW * size && ours.mean - ours.low <= NARROW * size;
    if (paper - ours.mean).abs() <= SAME * size || (inside && narrow) {
        Agreement::Reproduced
    } else if inside {
        Agreement::WithinOneDraw
    } else {
        Agreement::NotReproduced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_need_agreement_and_a_narrow_spread() {
        let spread = |half: f64| Spread { mean: 1.0, error: 0.0, low: 1.0 - half, high: 1.0 + half };
        assert_eq!(judge(1.03, &spread(0.04)), Agreement::Reproduced);
        assert_eq!(judge(1.03, &spread(0.5)), Agreement::WithinOneDraw);
        assert_eq!(judge(1.6, &spread(0.5)), Agreement::NotReproduced);
        assert_eq!(judge(1.009, &spread(0.001)), Agreement::Reproduced);
        assert_eq!(judge(1.011, &spread(0.001)), Agreement::NotReproduced);
    }

    #[test]
    fn few_draws_are_spread_by_student_and_many_by_their_quantiles() {
        // Five draws: t(4) at 97.5 % is 2.776 (tables).
        let five = Spread::of(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!((five.high - 3.0 - 2.776_445 * 2.5_f64.sqrt() * 1.2_f64.sqrt()).abs() < 1e-5);
        let many: Vec<f64> = (0..=1000).map(f64::from).collect();
        assert_eq!((Spread::of(&many).low, Spread::of(&many).high), (25.0, 975.0));
        let mean = Spread::of_mean(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!((mean.high - 3.0 - 2.776_445 * 0.5_f64.sqrt()).abs() < 1e-5);
    }
}
