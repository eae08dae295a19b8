//! Results of an identification.

use nalgebra::{DMatrix, DVector};

use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::measurement::DataRow;
use crate::mechanism::ParameterSpec;
use crate::pose::Pose;
use crate::solve::{Convergence, IterationRecord};

/// One identified parameter.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// Specification of the parameter.
    pub spec: ParameterSpec,
    /// Where the identification started: the value in the mechanism file.
    pub start: f64,
    /// Identified value, SI.
    pub value: f64,
    /// Its 1σ; `None` if the data (and the prior) do not determine it.
    pub sigma: Option<f64>,
}

/// Parameters, covariance and how they were reached.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Identification {
    /// Parameters of the mechanism, then those of the measurement.
    pub parameters: Vec<Estimate>,
    /// How many of them belong to the mechanism.
    pub mechanism_parameters: usize,
    /// Covariance of all of them, SI; undetermined directions are left out.
    pub covariance: DMatrix<f64>,
    /// Accepted steps.
    pub history: Vec<IterationRecord>,
    /// Why the iteration ended.
    pub convergence: Convergence,
    /// Rank of the rows, prior included; below the number of parameters some are not determined.
    pub rank: usize,
    /// True if tolerances were used as prior.
    pub prior: bool,
    /// Estimated σ of the readings over the stated one; 1 where the stated noise is taken as known.
    pub noise_scale: f64,
    /// Test of the residuals against the noise.
    pub misfit: GoodnessOfFit,
    /// Weight of each sample; below one only in robust fits.
    pub weights: Vec<f64>,
    /// Data rows that a robust fit judges to be gross errors.
    pub outliers: Vec<DataRow>,
    /// Predicted pose of each sample, base frame.
    pub poses: Vec<Pose>,
}

impl Identification {
    /// Values of the mechanism's parameters.
    pub fn mechanism_values(&self) -> Vec<f64> {
        self.parameters[..self.mechanism_parameters].iter().map(|p| p.value).collect()
    }

    /// Without its last parameters, whose values are returned too.
    pub(crate) fn without_last(mut self, count: usize) -> (Self, Vec<f64>) {
        let n = self.parameters.len() - count;
        let values: Vec<f64> = self.parameters.drain(n..).map(|p| p.value).collect();
        self.covariance = self.covariance.view((0, 0), (n, n)).into_owned();
        // Where the last ones are what is not determined, the others are.
        let all = self.parameters.iter().all(|p| p.sigma.is_some());
        self.rank = if all { n } else { self.rank.saturating_sub(count) };
        (self, values)
    }

    /// Values of the measurement's own parameters.
    pub fn own_values(&self) -> Vec<f64> {
        self.parameters[self.mechanism_parameters..].iter().map(|p| p.value).collect()
    }

    /// Covariance of the mechanism's parameters alone.
    pub fn mechanism_covariance(&self) -> DMatrix<f64> {
        let n = self.mechanism_parameters;
        self.covariance.view((0, 0), (n, n)).into_owned()
    }

    /// The `most` pairs of parameters that are most correlated, by name.
    pub fn strongest_correlations(&self, most: usize) -> Vec<(&str, &str, f64)> {
        let correlation = self.correlation();
        let name = |k: usize| self.parameters[k].spec.name.as_str();
        let n = self.parameters.len();
        let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
        let mut pairs: Vec<_> = pairs.map(|(i, j)| (name(i), name(j), correlation[(i, j)])).collect();
        pairs.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        pairs.truncate(most);
        pairs
    }

    /// Correlation of every two parameters; 0 where one is not determined.
    pub fn correlation(&self) -> DMatrix<f64> {
        let sigma: DVector<f64> = self.covariance.diagonal().map(f64::sqrt);
        let n = sigma.len();
        DMatrix::from_fn(n, n, |i, j| {
            let product = sigma[i] * sigma[j];
            if product > 0.0 { self.covariance[(i, j)] / product } else { 0.0 }
        })
    }
}
