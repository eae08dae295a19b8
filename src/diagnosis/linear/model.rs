//! A model: the nuisance columns and those of accepted effects, fitted; and any further column asked beside it.
//!
//! With `Z` the columns of the model and `P` the precision of the prior let `L Lᵀ = Zᵀ Z + P` and `Q = Z L⁻ᵀ`. The fit
//! leaves `r - Q t` with `t = Qᵀ r + L⁻¹ P (x - x₀)`. A further block of columns `X` is projected by
//! `S = Xᵀ X - (Qᵀ X)ᵀ (Qᵀ X)`, its gradient is `c = Xᵀ r - (Qᵀ X)ᵀ t`, and it would take `cᵀ S⁻¹ c` off the sum of
//! squares with the values `-S⁻¹ c`. No refit is needed for any question.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::DesignMatrix;
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::joint_functions::JointFunctions;
use crate::diagnosis::linear::score_test::ScoreTest;
use crate::diagnosis::linear::statistics::Noise;
use crate::effect::ScanPoint;
use crate::measurement::DataRow;

/// An effect at a place, as the search handles it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hypothesis {
    /// Which group of the subject.
    pub(crate) group: usize,
    /// Which place of the group.
    pub(crate) place: usize,
    /// Sample (position in the data) from which on it acts, if rows are scanned.
    pub(crate) from: Option<usize>,
}

impl Hypothesis {
    /// The place in the terms of the effect; `rows` are the data rows of the samples.
    pub(crate) fn at(&self, groups: &[EffectColumns], rows: &[DataRow]) -> ScanPoint {
        let mut at = groups[self.group].places[self.place].at.clone();
        at.row = self.from.map(|k| rows[k].0);
        at
    }
}

/// A fitted model.
#[derive(Debug)]
pub(crate) struct Model<'a> {
    pub(crate) table: &'a DesignMatrix,
    pub(crate) candidates: Vec<Hypothesis>,
    factor: Cholesky<f64, Dyn>,
    /// `Q` (rows × z).
    q: DMatrix<f64>,
    t: DVector<f64>,
    /// `Qᵀ A` for all columns of the table.
    w: DMatrix<f64>,
    /// The residual of the fit.
    pub(crate) residual: DVector<f64>,
    pub(crate) noise: Noise,
    inflation: f64,
}

/// How a model is fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitting {
    /// Rows that count, without samples that were left out.
    pub(crate) rows: usize,
    /// Estimated σ of the readings over the stated one, for the weight of the prior.
    pub(crate) scale: f64,
    /// How many rows say what one independent row would, for rows that repeat each other.
    pub(crate) inflation: f64,
    /// True if the noise is as stated.
    pub(crate) known: bool,
}

/// The columns of a candidate.
pub(crate) fn columns_of(table: &DesignMatrix, groups: &[EffectColumns], candidate: &Hypothesis) -> DMatrix<f64> {
    let place = &groups[candidate.group].places[candidate.place];
    let mut columns = table.a.columns(place.columns.start, place.columns.len()).into_owned();
    if let Some(from) = candidate.from {
        columns.rows_mut(0, table.rows[from].0).fill(0.0);
    }
    columns
}

/// The columns of candidates side by side.
fn columns_of_all(table: &DesignMatrix, groups: &[EffectColumns], candidates: &[Hypothesis]) -> DMatrix<f64> {
    let blocks: Vec<DMatrix<f64>> = candidates.iter().map(|c| columns_of(table, groups, c)).collect();
    let mut all = DMatrix::zeros(table.r.len(), blocks.iter().map(DMatrix::ncols).sum());
    let mut at = 0;
    for block in &blocks {
        all.columns_mut(at, block.ncols()).copy_from(block);
        at += block.ncols();
    }
    all
}

impl<'a> Model<'a> {
    /// Fits the nuisance and these effects.
    pub(crate) fn fit(
        table: &'a DesignMatrix,
        groups: &[EffectColumns],
        candidates: Vec<Hypothesis>,
        fitting: &Fitting,
    ) -> Result<Self, DiagnoseError> {
        let effects = columns_of_all(table, groups, &candidates);
        let z_count = table.nuisance + effects.ncols();
        let mut z = DMatrix::zeros(table.r.len(), z_count);
        z.columns_mut(0, table.nuisance).copy_from(&table.a.columns(0, table.nuisance));
        z.columns_mut(table.nuisance, effects.ncols()).copy_from(&effects);
        let mut normal = z.transpose() * &z;
        let weight = fitting.scale * fitting.scale;
        let mut corner = normal.view_mut((0, 0), (table.nuisance, table.nuisance));
        corner += &table.precision * weight;
        // Columns that vanish, or that repeat others, are held where they are.
        let largest = normal.diagonal().map(|v| if v > 0.0 { v } else { 1.0 });
        for k in 0..z_count {
            normal[(k, k)] += RIDGE * largest[k];
        }
        let factor = Cholesky::new(normal).ok_or(DiagnoseError::Singular)?;
        let l = factor.l();
        let mut q = z.transpose();
        if !l.solve_lower_triangular_mut(&mut q) {
            return Err(DiagnoseError::Singular);
        }
        let q = q.transpose();
        let mut gradient = DVector::zeros(z_count);
        gradient.rows_mut(0, table.nuisance).copy_from(&(&table.gradient * weight));
        if !l.solve_lower_triangular_mut(&mut gradient) {
            return Err(DiagnoseError::Singular);
        }
        let t = q.tr_mul(&table.r) + gradient;
        let residual = &table.r - &q * &t;
        let w = q.transpose() * &table.a;
        let dof = (fitting.rows as f64 - q.norm_squared()) / fitting.inflation;
        let rss = residual.norm_squared() / fitting.inflation;
        let whole = (table.r.norm_squared() + table.penalty * weight - t.norm_squared()) / fitting.inflation;
        let noise = Noise { rss, objective: whole.max(rss), dof, known: fitting.known };
        Ok(Self { table, candidates, factor, q, t, w, residual, noise, inflation: fitting.inflation })
    }

    /// True if what is left is that of rounded numbers and no noise: data from a simulation without any.
    pub(crate) fn is_rounding(&self) -> bool {
        self.noise.rss <= ROUNDING * ROUNDING * self.table.r.len() as f64
    }

    /// Further columns of the table, by their numbers.
    fn ask(&self, columns: std::ops::Range<usize>) -> ScoreTest {
        let x = self.table.a.columns(columns.start, columns.len());
        let w = self.w.columns(columns.start, columns.len());
        let square = x.tr_mul(&x);
        ScoreTest::of(&square, &(&square - w.tr_mul(&w)), &x.tr_mul(&self.residual), self.inflation)
    }

    /// The columns of these candidates together.
    pub(crate) fn ask_all(&self, groups: &[EffectColumns], candidates: &[Hypothesis]) -> ScoreTest {
        let x = columns_of_all(self.table, groups, candidates);
        let w = self.q.transpose() * &x;
        let square = x.transpose() * &x;
        ScoreTest::of(&square, &(&square - w.tr_mul(&w)), &x.tr_mul(&self.residual), self.inflation)
    }

    /// An effect at every place of its scan.
    pub(crate) fn ask_everywhere(&self, groups: &[EffectColumns], group: usize) -> Vec<(Hypothesis, ScoreTest)> {
        let mut all = Vec::new();
        for (place, p) in groups[group].places.iter().enumerate() {
            if !p.scans_rows {
                all.push((Hypothesis { group, place, from: None }, self.ask(p.columns.clone())));
                continue;
            }
            // A step before the first row is an offset, and one at the last row an outlier.
            let last = self.table.samples().saturating_sub(1);
            let steps = self.ask_from_each_row(p.columns.clone()).into_iter().enumerate().take(last).skip(1);
            all.extend(steps.map(|(from, asked)| (Hypothesis { group, place, from: Some(from) }, asked)));
        }
        all
    }

    /// A block of columns that acts from each sample on, in order: the sums over the samples from there to the end.
    fn ask_from_each_row(&self, columns: std::ops::Range<usize>) -> Vec<ScoreTest> {
        let p = columns.len();
        let x = self.table.a.columns(columns.start, p);
        let mut w = DMatrix::zeros(self.q.ncols(), p);
        let mut square = DMatrix::zeros(p, p);
        let mut c = DVector::zeros(p);
        let mut all = Vec::with_capacity(self.table.samples());
        for (first, n) in self.table.rows.iter().rev() {
            let part = x.rows(*first, *n);
            w.gemm_tr(1.0, &self.q.rows(*first, *n), &part, 1.0);
            square.gemm_tr(1.0, &part, &part, 1.0);
            c.gemv_tr(1.0, &part, &self.residual.rows(*first, *n), 1.0);
            let s: DMatrix<f64> = &square - w.tr_mul(&w);
            all.push(ScoreTest::of(&square, &s, &c, self.inflation));
        }
        all.reverse();
        all
    }

    /// The part of the columns of a candidate that the model cannot imitate.
    pub(crate) fn projected(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        x - &self.q * self.q.tr_mul(x)
    }

    /// Steps of the nuisance and of the accepted effects from the point of the table.
    pub(crate) fn step(&self) -> DVector<f64> {
        let mut step = -self.t.clone();
        // The factor has a positive diagonal.
        self.factor.l().tr_solve_lower_triangular_mut(&mut step);
        step
    }

    /// Covariance of the parameters of the accepted effects, for unit noise.
    pub(crate) fn effect_covariance(&self) -> DMatrix<f64> {
        let first = self.table.nuisance;
        let count = self.q.ncols() - first;
        self.factor.inverse().view((first, first), (count, count)).into_owned()
    }

    /// `Q` of the rows of a sample.
    pub(crate) fn leverage_rows(&self, first: usize, n: usize) -> DMatrix<f64> {
        self.q.rows(first, n).into_owned()
    }

    /// Residual and `Q` of the rows of a sample that was left out, from the table that still has it.
    pub(crate) fn predicted(
        &self,
        full: &DesignMatrix,
        groups: &[EffectColumns],
        first: usize,
        n: usize,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let mut z = DMatrix::zeros(n, self.q.ncols());
        z.columns_mut(0, full.nuisance).copy_from(&full.a.view((first, 0), (n, full.nuisance)));
        let mut at = full.nuisance;
        for candidate in &self.candidates {
            let place = &groups[candidate.group].places[candidate.place];
            let p = place.columns.len();
            let acts = candidate.from.is_none_or(|from| first >= full.rows[from].0);
            if acts {
                z.columns_mut(at, p).copy_from(&full.a.view((first, place.columns.start), (n, p)));
            }
            at += p;
        }
        let mut q = z.transpose();
        self.factor.l().solve_lower_triangular_mut(&mut q);
        let q = q.transpose();
        let residual = full.r.rows(first, n) - &q * &self.t;
        (residual, q)
    }

    /// `Qᵀ` times functions of the sample times the unit displacement of a joint: one column for each function.
    pub(crate) fn joint_functions(&self, joint: usize, functions: &DMatrix<f64>) -> JointFunctions {
        let one = self.joint_samples(joint);
        JointFunctions { w: &one.w * functions, functions: functions.clone(), ..one }
    }

    /// The same for the functions that are one on a single sample each.
    pub(crate) fn joint_samples(&self, joint: usize) -> JointFunctions {
        let column = self.table.joints.start + joint;
        let samples = self.table.samples();
        let mut per_sample = DMatrix::zeros(self.q.ncols(), samples);
        let mut square = DVector::zeros(samples);
        let mut along = DVector::zeros(samples);
        for (k, (first, n)) in self.table.rows.iter().enumerate() {
            let v = self.table.a.view((*first, column), (*n, 1));
            let mut to = per_sample.column_mut(k);
            to.gemv_tr(1.0, &self.q.rows(*first, *n), &v.column(0), 0.0);
            square[k] = v.norm_squared();
            along[k] = v.column(0).dot(&self.residual.rows(*first, *n));
        }
        JointFunctions { w: per_sample, square, along, functions: DMatrix::zeros(0, 0), inflation: self.inflation }
    }
}

/// Part of the stated noise (or of a micrometre without one) that is rounding.
const ROUNDING: f64 = 1e-5;
/// Relative ridge on the normal equations: rounding.
const RIDGE: f64 = 1e-13;
