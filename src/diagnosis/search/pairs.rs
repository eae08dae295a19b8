//! Two names in the place of one that has several parameters: a rigid motion takes growth of all legs and of one leg more,
//! and a search that adds one name at a time finds the motion first.

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::search::stepwise::{LEVEL, SECOND, Score, scores};

/// So many single names, those with the most evidence, are tried as the first of two.
const FIRSTS: usize = 3;

/// Two names together.
pub(crate) struct Pair {
    pub(crate) names: [Hypothesis; 2],
    /// Evidence of both, less what a second name must bring.
    pub(crate) evidence: f64,
    /// True if the second is detected beside the first, the whole catalogue counted.
    pub(crate) detected: bool,
}

/// The pairs that may stand in the place of `name`, whose place is judged by `beside`, the catalogue beside the `others`.
/// `fit` gives the model of some names.
pub(crate) fn pairs(
    groups: &[EffectColumns],
    name: &Hypothesis,
    others: &[Hypothesis],
    beside: &[Score],
    fit: impl Fn(Vec<Hypothesis>) -> Result<Model, DiagnoseError>,
) -> Result<Vec<Pair>, DiagnoseError> {
    let mut found: Vec<Pair> = Vec::new();
    if beside[name.group].rank < 2 {
        return Ok(found);
    }
    let other = |s: &&Score| s.rank > 0 && s.candidate.group != name.group && !others.contains(&s.candidate);
    let mut firsts: Vec<&Score> = beside.iter().filter(other).filter(|s| s.evidence > SECOND).collect();
    firsts.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    for first in firsts.into_iter().take(FIRSTS) {
        let mut names = others.to_vec();
        names.push(first.candidate.clone());
        let all = scores(&fit(names)?, groups);
        let tests = all.iter().filter(|s| s.rank > 0).count().max(1);
        let of_another = all.iter().filter(other).filter(|s| s.candidate.group != first.candidate.group);
        let Some(second) = of_another.max_by(|a, b| a.evidence.total_cmp(&b.evidence)) else { continue };
        let names = [first.candidate.clone(), second.candidate.clone()];
        let again = |pair: &Pair| names.iter().all(|n| pair.names.contains(n));
        if second.evidence > SECOND && !found.iter().any(again) {
            let evidence = first.evidence + second.evidence - SECOND;
            found.push(Pair { names, evidence, detected: second.p_value < LEVEL / tests as f64 });
        }
    }
    Ok(found)
}
