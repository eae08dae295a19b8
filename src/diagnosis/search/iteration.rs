//! Names, outliers and weights in turn, until all stay.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnosis::answer::result::NoiseVaries;
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::{Hypotheses, Point};
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::kept_rows::KeptRows;
use crate::diagnosis::linear::model::{Fitting, Model};
use crate::diagnosis::linear::spreads::Spreads;
use crate::diagnosis::search::agreement::left_out_by;
use crate::diagnosis::search::covariates::covariates;
use crate::diagnosis::search::noise;
use crate::diagnosis::search::outliers::{outliers, suspicious};
use crate::diagnosis::search::stepwise::Stepwise;
use crate::effect::ActiveEffect;
use crate::measurement::DataRow;

/// Times that the columns are computed anew.
const ROUNDS: usize = 3;
/// Additions and re-judgements of outliers in one round.
const STEPS: usize = 8;
/// Degrees of freedom below which nothing is looked for.
const FEWEST: usize = 12;

/// Runs the search on a subject.
pub(crate) struct Search<'s, 'a> {
    pub(crate) subject: &'s Hypotheses<'a>,
    /// True if the noise is as stated.
    pub(crate) known: bool,
    /// The samples that are left out, if that is decided already.
    pub(crate) left_out: Option<Vec<usize>>,
}

/// Where the search ended.
#[derive(Debug)]
pub(crate) struct SearchState {
    /// The fitted model of the parameters and the names. The residual of its table is without the effects' share.
    pub(crate) model: Model,
    pub(crate) fitting: Fitting,
    pub(crate) point: Point,
    /// The weights with which the rows were fitted.
    pub(crate) spreads: Spreads,
    /// Correlation from row to row that was found, if any.
    pub(crate) correlation: Option<f64>,
    /// What the noise was found to vary with.
    pub(crate) noise_varies: Option<NoiseVaries>,
}

impl SearchState {
    /// The names that were found.
    pub(crate) fn names(&self) -> &[Hypothesis] {
        &self.model.candidates
    }

    /// The rows that were not left out.
    pub(crate) fn kept(&self) -> &Arc<KeptRows> {
        &self.model.kept
    }

    /// The same where each row counts as one.
    pub(crate) fn with_independent_rows(
        &self,
        subject: &Hypotheses<'_>,
        names: Vec<Hypothesis>,
    ) -> Result<Model, DiagnoseError> {
        Model::fit(self.kept(), &subject.groups, names, &Fitting { inflation: 1.0, ..self.fitting })
    }

    /// The model of the parameters and other names, of the same rows.
    pub(crate) fn with_names(&self, subject: &Hypotheses<'_>, names: Vec<Hypothesis>) -> Result<Model, DiagnoseError> {
        Model::fit(self.kept(), &subject.groups, names, &self.fitting)
    }
}

/// Whether samples may be left out, and what rows that repeat each other count for.
#[derive(Clone, Copy)]
struct Care {
    trim: bool,
    inflation: f64,
}

impl Search<'_, '_> {
    /// The search with the rows weighted by their noise, again where outliers or correlated rows ask for it.
    pub(crate) fn with_spreads(&self, spreads: &Spreads) -> Result<SearchState, DiagnoseError> {
        let mut care = Care { trim: self.left_out.is_none(), inflation: 1.0 };
        let mut state = self.explore(spreads, care)?;
        let samples = state.model.table().samples();
        let known = covariates(self.subject.data, &self.subject.environment.condition_kinds);
        if care.trim && left_out_by(&state.kept().left_out, &known).is_some() {
            // Gross errors do not choose a condition.
            care.trim = false;
            state = self.explore(spreads, care)?;
        } else if care.trim && suspicious(&state.kept().left_out, samples) {
            let untrimmed = self.explore(spreads, Care { trim: false, ..care })?;
            if self.cost(&untrimmed, &state) < self.cost(&state, &untrimmed) {
                state = untrimmed;
            }
        }
        let outliers = state.kept().left_out.len();
        if 3 * outliers > samples {
            return Err(DiagnoseError::NothingFits { outliers, samples });
        }
        if let Some(rho) = noise::correlation(&state.model) {
            care = Care { trim: care.trim && outliers > 0, inflation: (1.0 + rho) / (1.0 - rho) };
            state = self.explore(spreads, care)?;
            state.correlation = Some(rho);
        }
        Ok(state)
    }

    /// What an explanation costs: its misfit, its parameters, and six mean shifts for every discarded pose, with the noise
    /// that the better of the two leaves.
    fn cost(&self, one: &SearchState, other: &SearchState) -> f64 {
        let table = one.model.table();
        let shifts: usize = one.kept().left_out.iter().map(|k| table.rows[*k].1).sum();
        let values: usize = one.names().iter().map(|n| self.subject.groups[n.group].parameters.len()).sum();
        let variance = one.model.noise.variance().min(other.model.noise.variance());
        one.model.noise.rss / variance + (shifts + values) as f64 * (table.r.len() as f64).ln()
    }

    /// Names and outliers in turn: in each round the columns are computed at a new point, until nothing changes.
    fn explore(&self, spreads: &Spreads, care: Care) -> Result<SearchState, DiagnoseError> {
        let subject = self.subject;
        let start = Point { values: subject.mechanism.values().to_vec(), effects: Vec::new(), scale: 1.0 };
        let decided = || self.left_out.clone().unwrap_or_default();
        let mut left_out = if care.trim { self.gross(&start, spreads)? } else { decided() };
        let kept: Vec<usize> = (0..subject.data.len()).filter(|k| left_out.binary_search(k).is_err()).collect();
        let mut point = subject.fit(&start, &kept)?;
        let mut names: Vec<Hypothesis> = Vec::new();
        let mut last: Option<SearchState> = None;
        for round in 1..=ROUNDS {
            let mut table = match (subject.table(&point, spreads), last.take()) {
                (Ok(table), _) => table,
                // Effects that lead nowhere keep the columns that they were found with.
                (Err(DiagnoseError::Identify(_) | DiagnoseError::Geometry(_)), Some(before)) => return Ok(before),
                (Err(error), _) => return Err(error),
            };
            for (name, effect) in names.iter().zip(&point.effects) {
                table.r -= table.combined(&name.block(&subject.groups, &table), &effect.values);
            }
            let before = (names.clone(), left_out.clone());
            let rows = Arc::new(KeptRows::new(Arc::new(table), left_out));
            let (model, fitting) = self.names(rows, names, point.scale, care)?;
            (names, left_out) = (model.candidates.clone(), model.kept.left_out.clone());
            let effects = self.effects(&model);
            point.scale = fitting.scale;
            let here = Point { effects, ..point };
            let state = SearchState {
                model,
                fitting,
                point: here.clone(),
                spreads: spreads.clone(),
                correlation: None,
                noise_varies: None,
            };
            if before == (names.clone(), left_out.clone()) || round == ROUNDS {
                return Ok(state);
            }
            point = match subject.fit(&here, &state.kept().samples()) {
                Ok(point) => point,
                Err(DiagnoseError::Identify(_) | DiagnoseError::Geometry(_)) => return Ok(state),
                Err(error) => return Err(error),
            };
            last = Some(state);
        }
        // The last round returns.
        Err(DiagnoseError::Singular)
    }

    /// Names added, exchanged and removed on the columns of one point, with gross errors judged anew after each step.
    fn names(
        &self,
        mut kept: Arc<KeptRows>,
        mut names: Vec<Hypothesis>,
        scale: f64,
        care: Care,
    ) -> Result<(Model, Fitting), DiagnoseError> {
        let groups = &self.subject.groups;
        let mut fitting = Fitting { scale, inflation: care.inflation, known: self.known };
        let mut polish = !names.is_empty();
        let mut whole = true;
        let mut steps = 0;
        loop {
            if care.trim {
                (kept, fitting.scale) = outliers(kept, groups, &names, &fitting)?;
            } else if !self.known {
                fitting.scale = Model::fit(&kept, groups, names.clone(), &fitting)?.noise.variance().sqrt();
            }
            let search = Stepwise { kept: &kept, groups, fitting };
            let mut model = search.model(names.clone())?;
            self.check_freedom(&model)?;
            if std::mem::take(&mut polish) {
                // With the columns of the new point a name may no longer stand.
                let polished = search.polished(names)?;
                if polished != model.candidates {
                    model = search.model(polished)?;
                }
            }
            steps += 1;
            names = match search.step(&model)? {
                Some(next) if next != model.candidates => next,
                _ => match if whole { search.taken_apart(&model)? } else { None } {
                    Some(next) if next != model.candidates => {
                        whole = false;
                        next
                    }
                    _ => return Ok((model, fitting)),
                },
            };
            if steps == STEPS {
                return Ok((search.model(names)?, fitting));
            }
        }
    }

    /// Samples that are far from all others already beside the parameters of the drawing, fitted in one linear step: an error
    /// of millimetres would lead the first fit away.
    fn gross(&self, start: &Point, spreads: &Spreads) -> Result<Vec<usize>, DiagnoseError> {
        let table = Arc::new(self.subject.table_of_parameters(start, spreads)?);
        let samples = table.samples();
        let fitting = Fitting { scale: 1.0, inflation: 1.0, known: false };
        let (kept, _) = outliers(Arc::new(KeptRows::new(table, Vec::new())), &self.subject.groups, &[], &fitting)?;
        // Where many are far, the step itself was too long.
        Ok(if 3 * kept.left_out.len() > samples { Vec::new() } else { kept.left_out.clone() })
    }

    fn check_freedom(&self, model: &Model) -> Result<(), DiagnoseError> {
        let free = model.noise.dof;
        if free < FEWEST as f64 {
            let (samples, rows) = (self.subject.data.len(), model.kept.count());
            return Err(DiagnoseError::TooFewRows { samples, rows, free: free.max(0.0), needed: FEWEST });
        }
        Ok(())
    }

    /// The names of a model with their values.
    fn effects(&self, model: &Model) -> Vec<ActiveEffect> {
        let step = model.step();
        let rows: Vec<DataRow> = self.subject.data.iter().map(|s| s.row).collect();
        let mut at = model.table().nuisance;
        let mut effects = Vec::with_capacity(model.candidates.len());
        for name in &model.candidates {
            let group = &self.subject.groups[name.group];
            let p = group.parameters.len();
            effects.push(ActiveEffect {
                effect: Arc::clone(&group.effect),
                at: name.at(&self.subject.groups, &rows),
                values: step.rows(at, p).iter().copied().collect(),
                range: BTreeMap::new(),
            });
            at += p;
        }
        effects
    }
}
