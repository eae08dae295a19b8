//! Does the machine agree with its drawing?
//!
//! At the estimate with a prior the cost `|r|² + |M (x - x₀)|²` is χ² with as many degrees of freedom as there are measured
//! rows, if model, noise and tolerances are right. The misfit of the model is what no parameter explains, and says nothing of
//! the prior; the rest of the cost is the prior's, and tells whether the machine is as near its drawing as the tolerances say.
//! Where it is not, the data say by how much: a factor for each group of parameters by maximum marginal likelihood
//! (MacKay, *Bayesian interpolation*, Neural Computation 4, 1992).

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::identification::error::IdentifyError;
use crate::identification::estimators::fit::Fit;
use crate::identification::judgement::goodness_of_fit::GoodnessOfFit;
use crate::identification::problem::belief::{Belief, FREE, GROUPS, Group};
use crate::identification::problem::calibration_problem::CalibrationProblem;
use crate::identification::problem::prior::Prior;
use crate::solve::Triangle;

/// Rounds of the search for factors, and the change that ends it.
const ROUNDS: usize = 500;
const SETTLED: f64 = 1e-3;

/// The misfit of a fit with a prior.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DrawingTest {
    /// The whole cost.
    pub with_prior: GoodnessOfFit,
    /// The part of the prior.
    pub prior: GoodnessOfFit,
    /// Degrees of freedom of the model, against which the prior is tested where the noise is not known.
    free: usize,
}

impl DrawingTest {
    /// The test of a fit; `None` without a prior that informs.
    pub(crate) fn of(problem: &CalibrationProblem<'_>, fit: &Fit) -> Result<Option<Self>, IdentifyError> {
        Ok(Linear::of(problem, fit)?.map(|linear| linear.test(problem)))
    }

    /// Probability that the machine is at least so far from its drawing by chance.
    pub fn p_value(&self) -> Option<f64> {
        if self.prior.noise_known {
            return self.prior.p_value();
        }
        let (a, b) = (self.prior.degrees_of_freedom as f64, self.free as f64);
        FisherSnedecor::new(a, b).ok().map(|f| f.sf(self.prior.chi_square / a))
    }
}

/// How much wider than stated the tolerances of each group are, one where the stated ones hold.
pub(crate) fn widened(problem: &CalibrationProblem<'_>, fit: &Fit) -> Result<[f64; 4], IdentifyError> {
    let factors = problem.belief().factors;
    Ok(Linear::of(problem, fit)?.map_or(factors, |linear| linear.factors(problem)))
}

/// The rows of the data about an estimate, for the noise as it was found, and the prior.
struct Linear<'a> {
    data: Triangle,
    prior: &'a Prior,
    values: &'a DVector<f64>,
}

impl<'a> Linear<'a> {
    fn of(problem: &'a CalibrationProblem<'_>, fit: &'a Fit) -> Result<Option<Self>, IdentifyError> {
        let Some(prior) = problem.prior().filter(|p| p.informs()) else { return Ok(None) };
        let (residual, jacobian) = match problem.data_at(&fit.values) {
            Ok(rows) => rows,
            // The misfit of the model says what there is to say.
            Err(IdentifyError::Solve(_)) => return Ok(None),
            Err(other) => return Err(other),
        };
        let mut data = GoodnessOfFit::rows(problem, fit, &residual, &jacobian);
        data.scale(1.0 / problem.noise_scale());
        Ok(Some(Self { data, prior, values: &fit.values }))
    }

    fn test(&self, problem: &CalibrationProblem<'_>) -> DrawingTest {
        let n = self.values.len();
        let (model, rank) = self.data.misfit();
        let mut all = self.data.clone();
        let (mut r, mut j) = (DVector::zeros(self.prior.rows()), DMatrix::zeros(self.prior.rows(), n));
        self.prior.write(self.values, 0, &mut r, &mut j);
        all.add(&j, &r, 0..self.prior.rows(), 1.0);
        let (cost, _) = all.misfit();
        let (covariance, ..) = all.covariance();
        let noise_known = problem.data().noise.known;
        let rows = self.data.rows();
        // Along free directions there is no prior: the data use up as many rows as they decide.
        let held: usize = Group::all(problem.mechanism()).iter().flatten().map(|g| g.members.len()).sum();
        let used = (n - held) as f64 + decided(problem, &covariance);
        let free = rows.saturating_sub(rank);
        let with_prior = GoodnessOfFit {
            chi_square: cost,
            degrees_of_freedom: rows.saturating_sub(used.round() as usize),
            noise_known,
        };
        let prior = GoodnessOfFit {
            chi_square: (cost - model).max(0.0),
            degrees_of_freedom: with_prior.degrees_of_freedom.saturating_sub(free),
            noise_known,
        };
        DrawingTest { with_prior, prior, free }
    }

    /// The factors for which the data are most probable. Points of platform and base share one unless the data say decisively
    /// that they do not: where poses hardly tell the two apart, either could stand for both.
    fn factors(&self, problem: &CalibrationProblem<'_>) -> [f64; 4] {
        let search = |from: &Belief, shared| self.most_probable(problem, from.clone(), shared);
        let (together, likelihood) = search(problem.belief(), true);
        let from = Belief { factors: together, ..problem.belief().clone() };
        let (apart, of_its_own) = search(&from, false);
        if of_its_own - likelihood > DECISIVE { apart } else { together }
    }

    /// Alternately the parameters for these widths, and the widths for which they are most probable; and the logarithm of that
    /// probability, up to a constant.
    fn most_probable(&self, problem: &CalibrationProblem<'_>, mut belief: Belief, shared: bool) -> ([f64; 4], f64) {
        let mechanism = problem.mechanism();
        let n = self.values.len();
        let (r, c) = (self.data.jacobian(), self.data.upper().view((0, n), (n, 1)).column(0).into_owned());
        let (normal, gradient) = (r.transpose() * &r, r.transpose() * &c);
        let groups = Group::all(mechanism);
        let mut likelihood = f64::NEG_INFINITY;
        for _ in 0..ROUNDS {
            let Ok(prior) = Prior::from_tolerance(mechanism, &belief) else { break };
            let (precision, pull, _) = prior.quadratic(self.values.as_slice(), n);
            let Some(factor) = Cholesky::new(&normal + precision) else { break };
            let step = factor.solve(&(&gradient + pull));
            let values = self.values - &step;
            let (_, _, penalty) = prior.quadratic(values.as_slice(), n);
            let widths = groups
                .iter()
                .zip(belief.factors)
                .map(|(g, f)| g.as_ref().map_or(0, |g| g.members.len()) as f64 * f.ln());
            likelihood =
                -0.5 * ((&c - &r * step).norm_squared() + penalty + factor.ln_determinant()) - widths.sum::<f64>();
            let next = spread(&groups, &belief, &prior, &values, &factor.inverse(), shared);
            let settled = next.iter().zip(belief.factors).all(|(a, b)| (a / b - 1.0).abs() < SETTLED);
            belief.factors = next;
            if settled {
                break;
            }
        }
        (belief.factors, likelihood)
    }
}

/// By how much the logarithm of the probability must grow for factors apart.
const DECISIVE: f64 = 5.0;

/// How many directions of free conventions the data decide.
fn decided(problem: &CalibrationProblem<'_>, covariance: &DMatrix<f64>) -> f64 {
    let belief = problem.belief();
    let groups = Group::all(problem.mechanism());
    let free = groups.iter().zip(belief.conventions.free()).zip(belief.factors).filter(|((_, free), _)| *free);
    let count = |((group, _), factor): ((&Option<Group>, bool), f64)| {
        let group = group.as_ref()?;
        let q = group.convention.as_ref()?;
        let known = q.transpose() * scaled(group, covariance) * q;
        let left = known.trace() / (FREE * factor).powi(2);
        Some(q.ncols() as f64 - left)
    };
    free.filter_map(count).sum()
}

/// Covariance of the members of a group over their tolerances.
fn scaled(group: &Group, covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let n = group.members.len();
    let (k, w) = (&group.members, &group.widths);
    DMatrix::from_fn(n, n, |i, j| covariance[(k[i], k[j])] / (w[i] * w[j]))
}

/// The next factor of each group, `|s|²/γ` with its deviations `s` over tolerances, without free conventions, and the number `γ`
/// of directions that the data decide (MacKay 1992, eq. 4.8); at least one. Points of platform and base may have a `shared` one.
fn spread(
    groups: &[Option<Group>; 4],
    belief: &Belief,
    prior: &Prior,
    values: &DVector<f64>,
    covariance: &DMatrix<f64>,
    shared: bool,
) -> [f64; 4] {
    let mut sums: [[f64; 3]; 4] = std::array::from_fn(|k| {
        let Some(group) = &groups[k] else { return [0.0; 3] };
        let free = belief.conventions.free()[k];
        let conventions = group.convention.as_ref().filter(|_| free).map_or(0, DMatrix::ncols);
        let held = group.convention_times(if free { 0.0 } else { 1.0 });
        let shift = &held * group.shift(prior.centre(), values.as_slice());
        let left = (&held * scaled(group, covariance)).trace();
        [shift.norm_squared(), left, (group.members.len() - conventions) as f64]
    });
    if shared {
        let both = std::array::from_fn(|i| sums[0][i] + sums[1][i]);
        sums[..2].fill(both);
    }
    std::array::from_fn(|k| {
        let [squares, left, directions] = sums[k];
        if directions == 0.0 {
            return 1.0;
        }
        let decided = directions - left / belief.factors[k].powi(2);
        // Of what the data hardly decide the expected square is all there is.
        let square = if decided > FEW * directions { squares / decided } else { (squares + left) / directions };
        square.sqrt().max(1.0)
    })
}

/// Part of its directions of which a group needs more for a factor of its own.
const FEW: f64 = 0.01;

/// The groups whose tolerances were widened, and by how much, in words.
pub(crate) fn widened_in_words(factors: &[f64; 4]) -> Vec<String> {
    let told = factors.iter().zip(GROUPS).filter(|(factor, _)| **factor > TOLD);
    told.map(|(factor, group)| format!("the {group} deviate {factor:.1} times as much as [tolerance] states")).collect()
}

/// Factors up to this are not worth a word.
const TOLD: f64 = 1.05;
