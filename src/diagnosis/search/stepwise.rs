//! The search for names: score tests of the whole catalogue beside the present model, one step at a time.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::kept_rows::KeptRows;
use crate::diagnosis::linear::model::{Fitting, Model};
use crate::diagnosis::linear::score_test::ScoreTest;
use crate::diagnosis::linear::statistics::log_mean;
use crate::diagnosis::search::pairs::pairs;
use crate::solve::{Triangle, svd};

/// Family-wise level of the catalogue.
pub(crate) const LEVEL: f64 = 0.004;
/// Separability at which two names are told apart.
pub const TOLD_APART: f64 = 10.0;
/// Rivals within this many nats are ties: a factor of 20.
pub(crate) const TIED: f64 = 2.995_732_273_553_991;
/// Evidence, nats, that a further name needs.
pub(crate) const SECOND: f64 = 3.0;
/// Most names in one answer.
const MOST: usize = 4;
/// Rounds of removing and swapping after each addition.
const ROUNDS: usize = 6;

/// How an effect does beside a model.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    /// The effect at its best place.
    pub(crate) candidate: Hypothesis,
    /// Gain at the best place.
    pub(crate) gain: f64,
    /// Directions of it that the data see.
    pub(crate) rank: usize,
    /// Probability by chance, places counted.
    pub(crate) p_value: f64,
    /// Evidence, averaged over the places.
    pub(crate) evidence: f64,
    /// Number of places.
    pub(crate) places: usize,
}

/// Tests every effect of the catalogue beside a model. Effects that the data do not see have rank 0.
pub(crate) fn scores(model: &Model, groups: &[EffectColumns]) -> Vec<Score> {
    (0..groups.len()).map(|g| score(model, groups, g)).collect()
}

/// Tests one effect beside a model.
pub(crate) fn score(model: &Model, groups: &[EffectColumns], group: usize) -> Score {
    let scales: Vec<f64> = groups[group].parameters.iter().map(|p| p.scale).collect();
    let all = model.ask_everywhere(groups, group);
    let nothing = Hypothesis { group, place: 0, from: None };
    let mut best =
        Score { candidate: nothing, gain: 0.0, rank: 0, p_value: 1.0, evidence: f64::NEG_INFINITY, places: 0 };
    let mut evidences = Vec::with_capacity(all.len());
    let mut places = 0;
    // Of places with as many directions the one with the largest gain is the least probable.
    let mut largest: Vec<(f64, usize, Hypothesis)> = Vec::new();
    for (candidate, asked) in all {
        let (gain, rank) = asked.gain();
        if rank == 0 {
            continue;
        }
        places += 1;
        evidences.push(evidence(&asked, (gain, rank), &groups[group], &scales, model));
        match largest.iter_mut().find(|(_, of, _)| *of == rank) {
            Some(found) if gain > found.0 => *found = (gain, rank, candidate),
            Some(_) => {}
            None => largest.push((gain, rank, candidate)),
        }
    }
    let mut least = 2.0;
    for (gain, rank, candidate) in largest {
        let p = model.noise.p_value(gain, rank);
        if p < least || (p == least && gain > best.gain) {
            least = p;
            best = Score { candidate, gain, rank, p_value: p, ..best };
        }
    }
    best.places = places;
    best.evidence = log_mean(&evidences);
    best.p_value = if places == 0 { 1.0 } else { (least * places as f64).min(1.0) };
    best
}

/// The evidence of an effect at one place: of all its parameters, or shared between these and the directions along which it
/// often acts alone.
fn evidence(asked: &ScoreTest, gain: (f64, usize), effect: &EffectColumns, scales: &[f64], model: &Model) -> f64 {
    let of_all = asked.evidence(gain, scales, &model.noise);
    let along = |direction: &Vec<f64>| {
        let one = asked.along(direction);
        let gain = one.gain();
        // Directions count from the parameter that they begin with.
        let scale = direction.iter().zip(scales).find(|(d, _)| **d != 0.0).map_or(1.0, |(_, scale)| *scale);
        (gain.1 > 0).then(|| one.evidence(gain, &[scale], &model.noise))
    };
    let all: Vec<f64> = std::iter::once(of_all).chain(effect.alone.iter().filter_map(along)).collect();
    log_mean(&all)
}

/// What the search needs beside the rows.
pub(crate) struct Stepwise<'a> {
    pub(crate) kept: &'a Arc<KeptRows>,
    pub(crate) groups: &'a [EffectColumns],
    pub(crate) fitting: Fitting,
}

impl Stepwise<'_> {
    pub(crate) fn model(&self, candidates: Vec<Hypothesis>) -> Result<Model, DiagnoseError> {
        Model::fit(self.kept, self.groups, candidates, &self.fitting)
    }

    /// The best name beside a model: of those that are detected the one with the most evidence.
    fn best(&self, model: &Model) -> Option<Score> {
        if model.is_rounding() {
            return None;
        }
        let scores = scores(model, self.groups);
        let tests = scores.iter().filter(|s| s.rank > 0).count().max(1);
        // Beside a large effect, what is not linear in it looks like a small one.
        let worth = if model.candidates.is_empty() { 0.0 } else { SECOND };
        // Two time constants of one part only trace a third.
        let twice = |s: &Score| model.candidates.iter().any(|name| another_lag(self.groups, name, &s.candidate));
        let significant = |s: &Score| s.p_value < LEVEL / tests as f64 && s.evidence > worth;
        let detected = scores.into_iter().filter(|s| significant(s) && !twice(s));
        detected.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// The names of a model and one more, if one is detected, and then names removed and exchanged while that helps. `None`
    /// if nothing is detected.
    pub(crate) fn step(&self, model: &Model) -> Result<Option<Vec<Hypothesis>>, DiagnoseError> {
        if model.candidates.len() >= MOST {
            return Ok(None);
        }
        let Some(found) = self.best(model) else { return Ok(None) };
        let mut next = model.candidates.clone();
        next.push(found.candidate);
        if next.len() > 1 {
            next = self.polished(next)?;
        }
        Ok(Some(next))
    }

    /// The names with two in the place of one, where these are detected and have more evidence. `None` if no name is taken
    /// apart so.
    pub(crate) fn taken_apart(&self, model: &Model) -> Result<Option<Vec<Hypothesis>>, DiagnoseError> {
        let names = &model.candidates;
        if names.len() >= MOST || model.is_rounding() {
            return Ok(None);
        }
        for (k, name) in names.iter().enumerate() {
            let mut others = names.clone();
            others.remove(k);
            let beside = scores(&self.model(others.clone())?, self.groups);
            let found = pairs(self.groups, name, &others, &beside, |names| self.model(names))?;
            let better = found.into_iter().filter(|p| p.detected && p.evidence > beside[name.group].evidence);
            if let Some(best) = better.max_by(|a, b| a.evidence.total_cmp(&b.evidence)) {
                others.extend(best.names);
                return Ok(Some(self.polished(others)?));
            }
        }
        Ok(None)
    }

    /// Every name against all others in its place, and against none.
    pub(crate) fn polished(&self, mut names: Vec<Hypothesis>) -> Result<Vec<Hypothesis>, DiagnoseError> {
        for _ in 0..ROUNDS {
            let mut changed = false;
            let mut k = 0;
            while k < names.len() {
                let mut others = names.clone();
                let removed = others.remove(k);
                let model = self.model(others)?;
                match self.best(&model) {
                    // Places of the same name are chosen by their gain.
                    Some(found) if found.candidate == removed => k += 1,
                    Some(found) if names.contains(&found.candidate) => k += 1,
                    Some(found) => {
                        names[k] = found.candidate;
                        changed = true;
                        k += 1;
                    }
                    None => {
                        names.remove(k);
                        changed = true;
                    }
                }
            }
            if !changed {
                break;
            }
        }
        Ok(names)
    }
}

/// True if one of two effects is a special case of the other.
pub(crate) fn related(groups: &[EffectColumns], one: &Hypothesis, other: &Hypothesis) -> bool {
    let (a, b) = (&groups[one.group].effect, &groups[other.group].effect);
    a.special_case_of().contains(&b.name()) || b.special_case_of().contains(&a.name())
}

/// True if two hypotheses are one effect at one place with different lags.
fn another_lag(groups: &[EffectColumns], one: &Hypothesis, other: &Hypothesis) -> bool {
    let at = |name: &Hypothesis| &groups[name.group].places[name.place].at;
    let (a, b) = (at(one), at(other));
    one.group == other.group && a.leg == b.leg && a.covariate == b.covariate && a.lag != b.lag
}

/// True if two effects differ by the size of the machine alone.
pub(crate) fn twins(groups: &[EffectColumns], one: &Hypothesis, other: &Hypothesis) -> bool {
    let (a, b) = (&groups[one.group].effect, &groups[other.group].effect);
    a.twins().contains(&b.name()) || b.twins().contains(&a.name())
}

/// The part of a named effect, squared and in units of the noise (`variance` of a row), that a rival, of one effect or of
/// several together, cannot imitate beside the model `without`.
pub(crate) fn separability(
    without: &Model,
    groups: &[EffectColumns],
    named: &[Hypothesis],
    values: &[f64],
    rival: &[Hypothesis],
    variance: f64,
) -> f64 {
    let of = |names: &[Hypothesis]| {
        let columns: Vec<_> = names.iter().map(|n| without.kept.columns(&n.block(groups, without.table()))).collect();
        let all: Vec<_> = columns.iter().flat_map(|block| block.column_iter()).collect();
        DMatrix::from_columns(&all)
    };
    let shape = &of(named) * DVector::from_column_slice(values);
    let x = without.projected(of(rival));
    let p = x.ncols();
    let shape = without.projected(DMatrix::from_column_slice(shape.len(), 1, shape.as_slice()));
    // What the shape has outside of `X` is the last entry.
    let rows = Triangle::of(&x, &shape.column(0).into_owned());
    let r = rows.upper();
    let svd = svd(r.view((0, 0), (p, p)).into_owned(), true, false);
    let largest = svd.singular_values.max();
    let mut left = r.view((0, p), (p, 1)).column(0).into_owned();
    for (u, _) in
        svd.u.iter().flat_map(|u| u.column_iter()).zip(svd.singular_values.iter()).filter(|(_, s)| **s > 1e-6 * largest)
    {
        let along = u.dot(&left);
        left.axpy(-along, &u, 1.0);
    }
    (left.norm_squared() + r[(p, p)].powi(2)) / variance
}
