//! Detection limits: how large an effect must be to be seen.
//!
//! Currie's limit: the size with which the test of the effect, at the level of the whole catalogue and with all places of
//! its scan counted, comes out with a probability of 95 %. It follows from the columns alone, before anything is measured.

use crate::diagnosis::answer::result::NotFound;
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::linear::score_test::ABSORBED;
use crate::diagnosis::linear::statistics::detection_limit;
use crate::diagnosis::search::stepwise::LEVEL;

/// `λ` that an effect must reach beside a model, with `tests` effects in the catalogue and so many places of its own.
pub(crate) fn lambda(model: &Model, rank: usize, tests: usize, places: usize) -> f64 {
    let p = rank.max(1);
    detection_limit(p, LEVEL / (tests * places.max(1)) as f64, model.noise.dof - p as f64)
}

/// The limit of the first parameter of an effect alone; `None` if the data do not see it. Where places are tried out, that
/// of the place in the middle of their order by size.
pub(crate) fn limit(model: &Model, groups: &[EffectColumns], group: usize, tests: usize) -> Option<NotFound> {
    let asked = model.ask_everywhere(groups, group);
    let places = asked.len();
    let mut seen: Vec<(f64, usize)> = asked
        .iter()
        .filter_map(|(_, a)| {
            let (_, rank) = a.gain();
            (rank > 0 && a.s[(0, 0)] > ABSORBED * a.raw[0]).then(|| (a.s[(0, 0)], rank))
        })
        .collect();
    if seen.is_empty() {
        return None;
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (s, rank) = seen[seen.len() / 2];
    let lambda = lambda(model, rank, tests, places);
    let parameter = &groups[group].parameters[0];
    Some(NotFound {
        effect: groups[group].effect.name().into(),
        parameter: parameter.name.clone(),
        limit: (lambda * model.noise.variance() / s).sqrt(),
        dimension: parameter.dimension,
    })
}
