//! Time constants: do the parts whose temperatures were found to act follow their sensors at once, or later?
//!
//! A search over all effects with all lags would be many times as long, and most machines are measured faster than they
//! warm up. So the question is put beside the names that were found, if any of them is slow: would one of them with a lag,
//! or a part that follows late in place of all slow names, explain more? Only then the search is made again, with lags in the scan of every
//! effect that may have one, and its answer is taken only if a lag stands in it. What was tried is counted in its price.

use std::sync::Arc;

use crate::conditions::TIME;
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::{Hypotheses, Point};
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::kept_rows::KeptRows;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::search::iteration::{Search, SearchState};
use crate::effect::{AvailableData, Catalogue, Effect};

/// Time constants to begin with, s.
const COARSE: [f64; 4] = [600.0, 1800.0, 5400.0, 14_400.0];
/// Factors around the best of them, and again: a large effect shows its time constant to a few parts in a hundred, and what
/// is left of it otherwise looks like another effect.
const FINE: [&[f64]; 2] =
    [&[0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4, 1.6], &[0.925, 0.95, 0.975, 1.0, 1.025, 1.05, 1.075]];
/// Half the change of BIC, nats, by which a lag must explain more than none.
const WORTH: f64 = 6.0;
/// Searches with lags.
const ROUNDS: usize = 3;
/// A time constant that changes by less than this part has settled.
const SETTLED: f64 = 0.013;

/// The time constants that data can show: those within the time of the run. Empty without times.
pub(crate) fn coarse(subject: &Hypotheses<'_>) -> Vec<f64> {
    let available = AvailableData::of(subject.data);
    if !(available.run && available.has(TIME)) {
        return Vec::new();
    }
    let times = subject.data.iter().filter_map(|s| s.conditions.get(TIME));
    let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    COARSE.into_iter().filter(|lag| *lag < last - first).collect()
}

/// A search with lags and its hypotheses, if it finds one. `unknown` is true if something was left that no name explains.
pub(crate) fn with_lags<'a>(
    search: &Search<'_, 'a>,
    state: &SearchState,
    unknown: bool,
    catalogue: &Catalogue,
) -> Result<Option<(Hypotheses<'a>, SearchState)>, DiagnoseError> {
    let subject = search.subject;
    let coarse = coarse(subject);
    if coarse.is_empty() {
        return Ok(None);
    }
    let mut lags = coarse.clone();
    match favoured(subject, state, &coarse)? {
        Some(best) => lags.push(refined(subject, state, (&best.effect, best.lag))?),
        None if unknown => {}
        None => return Ok(None),
    }
    let mut answer = None;
    for _ in 0..ROUNDS {
        lags.sort_by(f64::total_cmp);
        lags.dedup();
        let asked = subject.with_lags(catalogue, &lags);
        let found = Search { subject: &asked, known: search.known, left_out: search.left_out.clone() }.reweighted()?;
        let Some((effect, lag)) = lag_of(&asked, &found) else { break };
        let finer = refined(&asked, &found, (effect, lag))?;
        // Of a lag that is off, a second name takes the rest.
        if stands(&asked, &found) {
            answer = Some((asked, found));
            if (finer / lag - 1.0).abs() < SETTLED {
                break;
            }
        }
        lags.clone_from(&coarse);
        lags.push(finer);
    }
    Ok(answer)
}

/// The first name with a lag.
fn lag_of<'s>(subject: &'s Hypotheses<'_>, state: &SearchState) -> Option<(&'s str, f64)> {
    let lag = |name: &Hypothesis| Some((subject.groups[name.group].effect.name(), subject.place(name).at.lag?));
    state.names().iter().find_map(lag)
}

/// True if every name that acts with a lag explains that much more than it would at once.
fn stands(subject: &Hypotheses<'_>, state: &SearchState) -> bool {
    let names = state.names();
    let lagged = (0..names.len()).filter(|k| subject.place(&names[*k]).at.lag.is_some());
    let cost = |names: Vec<Hypothesis>| state.with_names(subject, names).map(|model| cost(&model, &state.model, 0.0));
    let at_once = |k: usize| {
        let mut others = names.to_vec();
        others[k] = subject.at_lag(&names[k], None)?;
        cost(others).ok()
    };
    let own = cost(names.to_vec()).unwrap_or(f64::INFINITY);
    lagged.filter_map(at_once).all(|other| other - own > WORTH)
}

/// Half of misfit and price of a model, nats, with the noise that the better of two leaves.
fn cost(model: &Model, best: &Model, extra: f64) -> f64 {
    let variance = model.noise.variance().min(best.noise.variance());
    let price = model.candidates_columns() as f64 + extra;
    0.5 * (model.noise.objective / variance + price * (model.table().r.len() as f64).ln())
}

/// The names of a search with columns at further lags, at the point where it ended.
struct Asked<'a> {
    subject: Hypotheses<'a>,
    names: Vec<Hypothesis>,
    rows: Arc<KeptRows>,
}

impl<'a> Asked<'a> {
    /// Beside those of the names all effects that may lag have columns, or `only` one of them.
    fn new(
        subject: &Hypotheses<'a>,
        state: &SearchState,
        lags: &[f64],
        only: Option<&str>,
    ) -> Result<Option<Self>, DiagnoseError> {
        let of_names = |name: &str| state.point.effects.iter().any(|e| e.effect.name() == name);
        let is_asked = |effect: &&Arc<dyn Effect>| {
            of_names(effect.name()) || (effect.may_lag() && only.is_none_or(|only| only == effect.name()))
        };
        let effects: Catalogue = subject.groups.iter().map(|g| &g.effect).filter(is_asked).cloned().collect();
        let mut all: Vec<f64> =
            state.point.effects.iter().filter_map(|e| e.at.lag).chain(lags.iter().copied()).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        let asked = subject.with_lags(&effects, &all);
        let place = |name: &Hypothesis| {
            let effect = &subject.groups[name.group].effect;
            asked.find(effect.name(), &subject.place(name).at, name.from)
        };
        let Some(names) = state.names().iter().map(place).collect::<Option<Vec<_>>>() else { return Ok(None) };
        let point: &Point = &state.point;
        let mut table = asked.table(point, &state.spreads)?;
        for (name, effect) in names.iter().zip(&point.effects) {
            table.r -= table.combined(&name.block(&asked.groups, &table), &effect.values);
        }
        let rows = Arc::new(KeptRows::new(Arc::new(table), state.kept().left_out.clone()));
        Ok(Some(Self { subject: asked, names, rows }))
    }

    fn fit(&self, state: &SearchState, names: Vec<Hypothesis>) -> Result<Model, DiagnoseError> {
        Model::fit(&self.rows, &self.subject.groups, names, &state.fitting)
    }

    fn may_lag(&self, name: &Hypothesis) -> bool {
        self.subject.groups[name.group].effect.may_lag()
    }

    /// Every place of every effect that may lag, with these lags.
    fn late(&self, lags: &[f64]) -> Vec<(f64, Hypothesis)> {
        let groups = self.subject.groups.iter().enumerate().filter(|(_, group)| group.effect.may_lag());
        let places = groups.flat_map(|(g, group)| group.places.iter().enumerate().map(move |(p, site)| (g, p, site)));
        let late = places.filter_map(|(group, place, site)| {
            let lag = site.at.lag.filter(|lag| lags.contains(lag))?;
            Some((lag, Hypothesis { group, place, from: None }))
        });
        late.collect()
    }
}

/// True for an effect that a part which follows late looks like: of temperature or of time.
fn is_slow(subject: &Hypotheses<'_>, name: &Hypothesis) -> bool {
    let effect = &subject.groups[name.group].effect;
    effect.may_lag() || effect.describes_one_run()
}

/// What explains more with a lag than the names do at once, if anything does.
fn favoured(subject: &Hypotheses<'_>, state: &SearchState, lags: &[f64]) -> Result<Option<Best>, DiagnoseError> {
    Ok(best_of(subject, state, lags, None)?.filter(|best| best.gained > WORTH))
}

/// The best lag of finer and finer grids around one, of an effect.
fn refined(subject: &Hypotheses<'_>, state: &SearchState, (effect, lag): (&str, f64)) -> Result<f64, DiagnoseError> {
    let mut best = lag;
    for factors in FINE {
        let lags: Vec<f64> = factors.iter().map(|factor| factor * best).collect();
        best = best_of(subject, state, &lags, Some(effect))?.map_or(best, |found| found.lag);
    }
    Ok(best)
}

/// An effect with a lag, and the nats by which it is better than the names as they are.
struct Best {
    effect: String,
    lag: f64,
    gained: f64,
}

/// The lag that explains most for its price: of one name beside the others, or of one effect in place of all slow names, as
/// a part that is late looks like several that are not.
fn best_of(
    subject: &Hypotheses<'_>,
    state: &SearchState,
    lags: &[f64],
    only: Option<&str>,
) -> Result<Option<Best>, DiagnoseError> {
    if !state.names().iter().any(|name| is_slow(subject, name)) {
        return Ok(None);
    }
    let Some(asked) = Asked::new(subject, state, lags, only)? else { return Ok(None) };
    let now = asked.fit(state, asked.names.clone())?;
    let mut models = Vec::new();
    let quick: Vec<Hypothesis> = asked.names.iter().filter(|n| !is_slow(&asked.subject, n)).cloned().collect();
    for (lag, late) in asked.late(lags) {
        let alone = quick.iter().cloned().chain([late.clone()]).collect();
        models.push((lag, late.group, asked.fit(state, alone)?));
    }
    for (k, name) in asked.names.iter().enumerate().filter(|(_, name)| asked.may_lag(name)) {
        for lag in lags {
            let Some(late) = asked.subject.at_lag(name, Some(*lag)) else { continue };
            let mut beside = asked.names.clone();
            beside[k] = late;
            models.push((*lag, name.group, asked.fit(state, beside)?));
        }
    }
    let variance = |model: &Model| model.noise.variance();
    let Some(least) = models.iter().map(|(_, _, m)| m).min_by(|a, b| variance(a).total_cmp(&variance(b))) else {
        return Ok(None);
    };
    let own = cost(&now, least, 0.0);
    let best = |(lag, group, model): &(f64, usize, Model)| Best {
        effect: asked.subject.groups[*group].effect.name().to_owned(),
        lag: *lag,
        // The time constant is a parameter more.
        gained: own - cost(model, least, 1.0),
    };
    Ok(models.iter().map(best).max_by(|a, b| a.gained.total_cmp(&b.gained)))
}
