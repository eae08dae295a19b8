//! A model: the nuisance columns and those of accepted effects, fitted; and any further column asked beside it.
//!
//! With `Z` the columns of the model and `P` the precision of the prior let `L Lᵀ = Zᵀ Z + P` and `Q = Z L⁻ᵀ`. The fit
//! leaves `r - Q t` with `t = Qᵀ r + L⁻¹ P (x - x₀)`. A further block of columns `X` is projected by
//! `S = Xᵀ X - (Qᵀ X)ᵀ (Qᵀ X)`, its gradient is `c = Xᵀ (r - Q t)`, and it would take `cᵀ S⁻¹ c` off the sum of
//! squares with the values `-S⁻¹ c`. No refit is needed for any question.
//!
//! `Qᵀ X = L⁻¹ Zᵀ X` is a piece of the products that [`KeptRows`] holds, so that only questions to single samples pass
//! over the rows. The prior bounds the condition of `Zᵀ Z + P`, and a ridge of the size of rounding holds what it does
//! not know; columns of which less than `1e-8` of the length squared is left beside the model count as not seen.

use std::iter::once;
use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::{Block, DesignMatrix};
use crate::diagnosis::linear::hypotheses::EffectColumns;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::kept_rows::{BlockProducts, KeptRows, between};
use crate::diagnosis::linear::normal_equations::{inverse_factor, residual};
use crate::diagnosis::linear::place_functions::PlaceSamples;
use crate::diagnosis::linear::score_test::ScoreTest;
use crate::diagnosis::linear::statistics::Noise;
use crate::diagnosis::linear::unit_motion::Place;

/// How a model is fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitting {
    /// Estimated σ of the readings over the stated one, for the weight of the prior.
    pub(crate) scale: f64,
    /// How many rows say what one independent row would, for rows that repeat each other.
    pub(crate) inflation: f64,
    /// True if the noise is as stated.
    pub(crate) known: bool,
}

/// A fitted model.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) kept: Arc<KeptRows>,
    pub(crate) candidates: Vec<Hypothesis>,
    /// The columns `Z`: the nuisance, and a block for each candidate.
    blocks: Vec<Block>,
    products: Vec<BlockProducts>,
    /// `L⁻¹`.
    inverse: DMatrix<f64>,
    t: DVector<f64>,
    /// The residual of the fit; zero where samples are left out.
    pub(crate) residual: DVector<f64>,
    pub(crate) noise: Noise,
    pub(crate) inflation: f64,
    q_t: OnceLock<DMatrix<f64>>,
    w: OnceLock<DMatrix<f64>>,
    gradient: OnceLock<DVector<f64>>,
}

impl Model {
    /// Fits the nuisance and these effects.
    pub(crate) fn fit(
        kept: &Arc<KeptRows>,
        groups: &[EffectColumns],
        candidates: Vec<Hypothesis>,
        fitting: &Fitting,
    ) -> Result<Self, DiagnoseError> {
        let table = &kept.table;
        let nuisance = Block { columns: 0..table.nuisance, first: 0 };
        let blocks: Vec<Block> = once(nuisance).chain(candidates.iter().map(|c| c.block(groups, table))).collect();
        let products: Vec<BlockProducts> = blocks.iter().map(|b| kept.products(b.clone())).collect();
        let square = between(&products, &products);
        let weight = fitting.scale * fitting.scale;
        let inverse = inverse_factor(square.clone(), &(&table.precision * weight))?;
        let mut moment = DVector::zeros(square.nrows());
        let mut at = 0;
        for part in &products {
            moment.rows_mut(at, part.with_residual.len()).copy_from(&part.with_residual);
            at += part.with_residual.len();
        }
        let mut corner = moment.rows_mut(0, table.nuisance);
        corner += &table.gradient * weight;
        let t = &inverse * moment;
        let residual = residual(kept, &blocks, &inverse.tr_mul(&t));
        let rss = residual.norm_squared() / fitting.inflation;
        let whole = (kept.r.norm_squared() + table.penalty * weight - t.norm_squared()) / fitting.inflation;
        let noise = Noise { rss, objective: whole.max(rss), dof: 0.0, known: fitting.known };
        let mut model = Self {
            kept: Arc::clone(kept),
            candidates,
            blocks,
            products,
            inverse,
            t,
            residual,
            noise,
            inflation: fitting.inflation,
            q_t: OnceLock::new(),
            w: OnceLock::new(),
            gradient: OnceLock::new(),
        };
        model.noise.dof = (kept.count() as f64 - model.leverage_of_all(&square)) / fitting.inflation;
        Ok(model)
    }

    /// The length squared of `Q`. `L⁻¹ ZᵀZ L⁻ᵀ` has it as its trace, but where directions are held by little more than
    /// rounding its entries are rounding over rounding, and the rows themselves are asked.
    fn leverage_of_all(&self, square: &DMatrix<f64>) -> f64 {
        let inflated = |k: usize| square[(k, k)] * self.inverse.column(k).norm_squared();
        if (0..square.nrows()).all(|k| inflated(k) < SOUND) {
            return (&self.inverse * square).dot(&self.inverse);
        }
        self.q_t().norm_squared()
    }

    /// How many rows say what one independent row would.
    pub(crate) fn inflation(&self) -> f64 {
        self.inflation
    }

    /// Number of columns of the accepted effects.
    pub(crate) fn candidates_columns(&self) -> usize {
        self.inverse.nrows() - self.table().nuisance
    }

    pub(crate) fn table(&self) -> &DesignMatrix {
        &self.kept.table
    }

    /// `Qᵀ` (z × rows), zero where samples are left out.
    fn q_t(&self) -> &DMatrix<f64> {
        self.q_t.get_or_init(|| {
            let a_t = &self.table().a_t;
            let mut q_t = DMatrix::zeros(self.inverse.nrows(), a_t.ncols());
            let mut at = 0;
            for block in &self.blocks {
                let (p, rows) = (block.columns.len(), a_t.ncols() - block.first);
                let columns = a_t.view((block.columns.start, block.first), (p, rows));
                q_t.columns_mut(block.first, rows).gemm(1.0, &self.inverse.columns(at, p), &columns, 1.0);
                at += p;
            }
            self.kept.clear(&mut q_t);
            q_t
        })
    }

    /// `Qᵀ A` for all columns of the table.
    fn w(&self) -> &DMatrix<f64> {
        self.w.get_or_init(|| {
            let mut all = DMatrix::zeros(self.inverse.nrows(), self.table().a_t.nrows());
            let mut at = 0;
            for part in &self.products {
                all.rows_mut(at, part.with_all.nrows()).copy_from(&part.with_all);
                at += part.with_all.nrows();
            }
            &self.inverse * all
        })
    }

    /// The products of all columns of the table with the residual.
    fn gradient(&self) -> &DVector<f64> {
        self.gradient.get_or_init(|| &self.table().a_t * &self.residual)
    }

    /// True if what is left is that of rounded numbers and no noise: data from a simulation without any.
    pub(crate) fn is_rounding(&self) -> bool {
        self.noise.rss <= ROUNDING * ROUNDING * self.residual.len() as f64
    }

    /// Further columns of the table, by their numbers.
    fn ask(&self, columns: std::ops::Range<usize>) -> ScoreTest {
        let w = self.w().columns(columns.start, columns.len());
        let square = self.kept.square(&columns);
        let c = self.gradient().rows(columns.start, columns.len()).into_owned();
        ScoreTest::of(&square, &(&square - w.tr_mul(&w)), &c, self.inflation)
    }

    /// The columns of these candidates together.
    pub(crate) fn ask_all(&self, groups: &[EffectColumns], candidates: &[Hypothesis]) -> ScoreTest {
        let blocks: Vec<Block> = candidates.iter().map(|c| c.block(groups, self.table())).collect();
        let products: Vec<BlockProducts> = blocks.iter().map(|b| self.kept.products(b.clone())).collect();
        let w = &self.inverse * between(&self.products, &products);
        let square = between(&products, &products);
        let mut c = DVector::zeros(square.nrows());
        let mut at = 0;
        for block in &blocks {
            let (p, rows) = (block.columns.len(), self.residual.len() - block.first);
            let columns = self.table().a_t.view((block.columns.start, block.first), (p, rows));
            c.rows_mut(at, p).gemv(1.0, &columns, &self.residual.rows(block.first, rows), 0.0);
            at += p;
        }
        ScoreTest::of(&square, &(&square - w.tr_mul(&w)), &c, self.inflation)
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
            let last = self.table().samples().saturating_sub(1);
            let steps = self.ask_from_each_row(p.columns.clone()).into_iter().enumerate().take(last).skip(1);
            all.extend(steps.map(|(from, asked)| (Hypothesis { group, place, from: Some(from) }, asked)));
        }
        all
    }

    /// A block of columns that acts from each sample on, in order: the sums over the samples from there to the end.
    fn ask_from_each_row(&self, columns: std::ops::Range<usize>) -> Vec<ScoreTest> {
        let p = columns.len();
        let (table, q_t) = (self.table(), self.q_t());
        let x = table.a_t.rows(columns.start, p);
        let mut w = DMatrix::zeros(q_t.nrows(), p);
        let mut square = DMatrix::zeros(p, p);
        let mut c = DVector::zeros(p);
        let mut all = Vec::with_capacity(table.samples());
        for (k, (first, n)) in table.rows.iter().enumerate().rev() {
            if !self.kept.is_out(k) {
                for row in *first..first + n {
                    let column = x.column(row);
                    for (i, v) in column.iter().enumerate() {
                        w.column_mut(i).axpy(*v, &q_t.column(row), 1.0);
                        square.column_mut(i).axpy(*v, &column, 1.0);
                    }
                    c.axpy(self.residual[row], &column, 1.0);
                }
            }
            let s: DMatrix<f64> = &square - w.tr_mul(&w);
            all.push(ScoreTest::of(&square, &s, &c, self.inflation));
        }
        all.reverse();
        all
    }

    /// The part of columns, given by rows (rows × p), that the model cannot imitate.
    pub(crate) fn projected(&self, mut x: DMatrix<f64>) -> DMatrix<f64> {
        let q_t = self.q_t();
        let w = q_t * &x;
        // A few columns at a time need no transposed copy of `Qᵀ`.
        for (mut to, w) in x.column_iter_mut().zip(w.column_iter()) {
            to.gemv_tr(-1.0, q_t, &w, 1.0);
        }
        x
    }

    /// Steps of the nuisance and of the accepted effects from the point of the table.
    pub(crate) fn step(&self) -> DVector<f64> {
        -self.inverse.tr_mul(&self.t)
    }

    /// Covariance of the parameters of the accepted effects, for unit noise.
    pub(crate) fn effect_covariance(&self) -> DMatrix<f64> {
        let first = self.table().nuisance;
        let columns = self.inverse.columns(first, self.inverse.ncols() - first);
        columns.tr_mul(&columns)
    }

    /// `Qᵀ` of the rows of a sample (z × rows).
    pub(crate) fn leverage(&self, first: usize, n: usize) -> nalgebra::DMatrixView<'_, f64> {
        self.q_t().columns(first, n)
    }

    /// Residual and `Qᵀ` of the rows of a sample that was left out.
    pub(crate) fn predicted(&self, first: usize, n: usize) -> (DVector<f64>, DMatrix<f64>) {
        let table = self.table();
        let mut q_t = DMatrix::zeros(self.inverse.nrows(), n);
        let mut at = 0;
        for block in &self.blocks {
            let p = block.columns.len();
            if first >= block.first {
                let columns = table.a_t.view((block.columns.start, first), (p, n));
                q_t.gemm(1.0, &self.inverse.columns(at, p), &columns, 1.0);
            }
            at += p;
        }
        (table.r.rows(first, n) - q_t.tr_mul(&self.t), q_t)
    }

    /// The unit displacement of a place in each sample by itself.
    pub(crate) fn samples_at(&self, place: Place) -> PlaceSamples {
        let (table, q_t) = (self.table(), self.q_t());
        let column = table.column_of(place);
        let samples = table.samples();
        let mut w = DMatrix::zeros(q_t.nrows(), samples);
        let mut square = DVector::zeros(samples);
        let mut along = DVector::zeros(samples);
        for (k, (first, n)) in table.rows.iter().enumerate().filter(|(k, _)| !self.kept.is_out(*k)) {
            for row in *first..first + n {
                let v = table.a_t[(column, row)];
                w.column_mut(k).axpy(v, &q_t.column(row), 1.0);
                square[k] += v * v;
                along[k] += v * self.residual[row];
            }
        }
        PlaceSamples { w, square, along, inflation: self.inflation }
    }
}

/// Part of the stated noise (or of a micrometre without one) that is rounding.
const ROUNDING: f64 = 1e-5;
/// Variance of a parameter over that without the others, up to which sums of products keep seven digits.
const SOUND: f64 = 1e9;
