//! Names and outliers in turn, until both stay.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DVector;

use crate::diagnosis::answer::result::NoiseVaries;
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::DesignMatrix;
use crate::diagnosis::linear::hypotheses::{Hypotheses, Point};
use crate::diagnosis::linear::model::{Fitting, Hypothesis, Model, columns_of};
use crate::diagnosis::search::covariates::covariates;
use crate::diagnosis::search::noise;
use crate::diagnosis::search::outliers::{distances, outliers, suspicious};
use crate::diagnosis::search::stepwise::Stepwise;
use crate::effect::ActiveEffect;
use crate::measurement::DataRow;

/// Times that the columns are computed anew.
const ROUNDS: usize = 3;
/// Additions and re-judgements of outliers in one round.
const STEPS: usize = 8;
/// Degrees of freedom below which nothing is looked for.
const FEWEST: usize = 12;

/// The samples below `samples` that are not left out.
fn kept(samples: usize, left_out: &[usize]) -> Vec<usize> {
    (0..samples).filter(|k| !left_out.contains(k)).collect()
}

/// Runs the search on a subject.
pub(crate) struct Search<'a> {
    pub(crate) subject: &'a Hypotheses<'a>,
    /// True if the noise is as stated.
    pub(crate) known: bool,
}

/// Where the search ended.
#[derive(Debug)]
pub(crate) struct SearchState {
    /// The columns at the end, with the effects' share taken out of the residual; every sample is in it.
    pub(crate) full: DesignMatrix,
    /// The columns without the samples that were left out.
    pub(crate) table: DesignMatrix,
    pub(crate) names: Vec<Hypothesis>,
    pub(crate) left_out: Vec<usize>,
    pub(crate) fitting: Fitting,
    pub(crate) point: Point,
    /// Correlation from row to row that was found, if any.
    pub(crate) correlation: Option<f64>,
}

impl SearchState {
    /// σ of position rows and of rotation rows over the stated ones, if their ratio is not the stated one.
    pub(crate) fn ratio(&self, subject: &Hypotheses<'_>) -> Result<Option<[f64; 2]>, DiagnoseError> {
        Ok(noise::ratio(&self.model(subject, self.names.clone())?, &self.left_out))
    }

    /// What the noise was found to vary with, and the σ of each sample then.
    pub(crate) fn noise_varies(
        &self,
        subject: &Hypotheses<'_>,
    ) -> Result<Option<(NoiseVaries, Vec<f64>)>, DiagnoseError> {
        let model = self.model(subject, self.names.clone())?;
        let all = distances(&self.full, &model, &subject.groups, &self.left_out);
        Ok(noise::noise_varies(&all, &covariates(subject.data, &subject.environment.condition_kinds), &self.kept()))
    }

    /// σ of the rows of each joint over the stated one.
    pub(crate) fn spreads(&self, subject: &Hypotheses<'_>) -> Result<Vec<f64>, DiagnoseError> {
        let model = self.model(subject, self.names.clone())?;
        Ok(self.table.spreads_of(&model.residual, &self.left_out))
    }

    /// The samples that were not left out.
    pub(crate) fn kept(&self) -> Vec<usize> {
        kept(self.full.samples(), &self.left_out)
    }

    /// The model of the parameters and these names.
    pub(crate) fn model(&self, subject: &Hypotheses<'_>, names: Vec<Hypothesis>) -> Result<Model<'_>, DiagnoseError> {
        Model::fit(&self.table, &subject.groups, names, &self.fitting)
    }
}

impl Search<'_> {
    /// The search, and again where outliers or correlated rows ask for it.
    pub(crate) fn explore_with_care(&self) -> Result<SearchState, DiagnoseError> {
        let mut state = self.explore(true, 1.0)?;
        let samples = state.full.samples();
        if suspicious(&state.left_out, samples) {
            let untrimmed = self.explore(false, 1.0)?;
            if self.cost(&untrimmed, &state)? < self.cost(&state, &untrimmed)? {
                state = untrimmed;
            }
        }
        if 3 * state.left_out.len() > samples {
            return Err(DiagnoseError::NothingFits { outliers: state.left_out.len(), samples });
        }
        let model = state.model(self.subject, state.names.clone())?;
        if let Some(rho) = noise::correlation(&model, &state.left_out) {
            let trimmed = !state.left_out.is_empty();
            state = self.explore(trimmed, (1.0 + rho) / (1.0 - rho))?;
            state.correlation = Some(rho);
        }
        Ok(state)
    }

    /// What an explanation costs: its misfit, its parameters, and six mean shifts for every discarded pose, with the noise
    /// that the better of the two leaves.
    fn cost(&self, one: &SearchState, other: &SearchState) -> Result<f64, DiagnoseError> {
        let of = |e: &SearchState| -> Result<(f64, f64, f64), DiagnoseError> {
            let model = e.model(self.subject, e.names.clone())?;
            let shifts: usize = e.left_out.iter().map(|k| e.full.rows[*k].1).sum();
            let values: usize = e.names.iter().map(|n| self.subject.groups[n.group].parameters.len()).sum();
            Ok((model.noise.rss, model.noise.variance(), (shifts + values) as f64))
        };
        let ((rss, variance, paid), (_, others, _)) = (of(one)?, of(other)?);
        Ok(rss / variance.min(others) + paid * (one.full.r.len() as f64).ln())
    }

    fn explore(&self, trim: bool, inflation: f64) -> Result<SearchState, DiagnoseError> {
        let subject = self.subject;
        let start = Point { values: subject.mechanism.values().to_vec(), effects: Vec::new(), scale: 1.0 };
        let mut names: Vec<Hypothesis> = Vec::new();
        let mut left_out = if trim { self.gross(&start)? } else { Vec::new() };
        let mut point = subject.fit(&start, &kept(subject.data.len(), &left_out))?;
        let mut last: Option<SearchState> = None;
        for round in 0..ROUNDS {
            let mut full = match (subject.table(&point), last.take()) {
                (Ok(table), _) => table,
                // Effects that lead nowhere keep the columns that they were found with.
                (Err(DiagnoseError::Identify(_) | DiagnoseError::Geometry(_)), Some(before)) => return Ok(before),
                (Err(error), _) => return Err(error),
            };
            for (name, effect) in names.iter().zip(&point.effects) {
                let columns = columns_of(&full, &subject.groups, name);
                full.r -= columns * DVector::from_column_slice(&effect.values);
            }
            let mut fitting = Fitting { rows: full.r.len(), scale: point.scale, inflation, known: self.known };
            let before = (names.clone(), left_out.clone());
            let mut table = full.clone();
            for step in 0..STEPS {
                if trim {
                    (left_out, fitting.scale) = outliers(&full, &subject.groups, &names, &fitting, &left_out)?;
                } else if !self.known {
                    let model = Model::fit(&full, &subject.groups, names.clone(), &fitting)?;
                    fitting.scale = model.noise.variance().sqrt();
                }
                table = full.without(&left_out);
                fitting.rows = full.count(&left_out);
                let search = Stepwise { table: &table, groups: &subject.groups, fitting };
                let mut model = search.model(names.clone())?;
                self.check_freedom(&model, fitting.rows)?;
                if step == 0 && round > 0 && !names.is_empty() {
                    // With the columns of the new point a name may no longer stand.
                    names = search.polished(names)?;
                    model = search.model(names.clone())?;
                }
                match search.step(&model)? {
                    Some(next) if next != names => names = next,
                    _ => break,
                }
            }
            point.scale = fitting.scale;
            let settled = before == (names.clone(), left_out.clone());
            let effects = self.effects(&Model::fit(&table, &subject.groups, names.clone(), &fitting)?);
            let state = SearchState {
                full,
                table,
                names: names.clone(),
                left_out: left_out.clone(),
                fitting,
                point: Point { effects: effects.clone(), ..point.clone() },
                correlation: None,
            };
            if settled || round + 1 == ROUNDS {
                return Ok(state);
            }
            point = match subject.fit(&Point { effects, ..point.clone() }, &state.kept()) {
                Ok(point) => point,
                Err(DiagnoseError::Identify(_) | DiagnoseError::Geometry(_)) => return Ok(state),
                Err(error) => return Err(error),
            };
            last = Some(state);
        }
        // The last round returns.
        Err(DiagnoseError::Singular)
    }

    /// Samples that are far from all others already beside the parameters of the drawing, fitted in one linear step: an error
    /// of millimetres would lead the first fit away.
    fn gross(&self, start: &Point) -> Result<Vec<usize>, DiagnoseError> {
        let full = self.subject.table(start)?;
        let fitting = Fitting { rows: full.r.len(), scale: 1.0, inflation: 1.0, known: false };
        let (left_out, _) = outliers(&full, &self.subject.groups, &[], &fitting, &[])?;
        // Where many are far, the step itself was too long.
        Ok(if 3 * left_out.len() > full.samples() { Vec::new() } else { left_out })
    }

    fn check_freedom(&self, model: &Model<'_>, rows: usize) -> Result<(), DiagnoseError> {
        let free = model.noise.dof;
        if free < FEWEST as f64 {
            let samples = self.subject.data.len();
            return Err(DiagnoseError::TooFewRows { samples, rows, free: free.max(0.0), needed: FEWEST });
        }
        Ok(())
    }

    /// The names of a model with their values.
    fn effects(&self, model: &Model<'_>) -> Vec<ActiveEffect> {
        let step = model.step();
        let rows: Vec<DataRow> = self.subject.data.iter().map(|s| s.row).collect();
        let mut at = model.table.nuisance;
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
