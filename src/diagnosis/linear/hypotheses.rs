//! The hypotheses: mechanism, data, and the effects that can be tested; the columns of all of them at a point, and
//! fits.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::conditions::TIME;
use crate::diagnosis::answer::result::NotTestable;
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::design_matrix::DesignMatrix;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::spreads::Spreads;
use crate::diagnosis::linear::unit_motion::UnitMotion;
use crate::effect::{
    ActiveEffect, ActsOn, AvailableData, Catalogue, Effect, EffectContext, EffectParameter, Environment, Extended,
    Scan, ScanPoint, WithInstrumentEffects,
};
use crate::identification::{CalibrationProblem, IdentifyError, Prior, Task};
use crate::measurement::{Dataset, RowKind};
use crate::mechanism::Mechanism;
use crate::solve::{LeastSquaresMethod, LeastSquaresOptions, SolveError, least_squares, linearized};

/// An effect that can be tested, with its columns at each place of its scan.
#[derive(Clone, Debug)]
pub(crate) struct EffectColumns {
    pub(crate) effect: Arc<dyn Effect>,
    pub(crate) parameters: Vec<EffectParameter>,
    /// Directions of its parameters along one of which it often acts alone.
    pub(crate) alone: Vec<Vec<f64>>,
    pub(crate) places: Vec<ScanSite>,
}

impl EffectColumns {
    /// The effect as one whose columns the data do not see, because what it depends on hardly changes.
    pub(crate) fn unchanging(&self) -> NotTestable {
        let covariates = self.effect.covariates(&self.places[0].at);
        let what = match covariates.len() {
            0 => "what it depends on".into(),
            1..=3 => covariates.join(", "),
            _ => format!("{} and the others", covariates[0]),
        };
        NotTestable {
            effect: self.effect.name().into(),
            missing: vec![format!("{what} to vary more than in these data")],
        }
    }
}

/// Columns of the table for one place of a scan. Where rows are scanned, those of row 0, of which each row cuts off the
/// beginning.
#[derive(Clone, Debug)]
pub(crate) struct ScanSite {
    pub(crate) at: ScanPoint,
    pub(crate) columns: Range<usize>,
    pub(crate) scans_rows: bool,
}

/// What is asked, apart from values.
pub(crate) struct Hypotheses<'a> {
    pub(crate) mechanism: &'a dyn Mechanism,
    pub(crate) data: &'a Dataset,
    pub(crate) environment: Arc<Environment>,
    pub(crate) prior: Prior,
    pub(crate) groups: Vec<EffectColumns>,
}

/// Values at which the table is made.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    /// Parameters of the mechanism.
    pub(crate) values: Vec<f64>,
    /// Effects of the model with their values.
    pub(crate) effects: Vec<ActiveEffect>,
    /// Estimated σ of the readings over the stated one.
    pub(crate) scale: f64,
}

impl<'a> Hypotheses<'a> {
    /// The effects of a catalogue that can be tested, and what the others miss. Where times were recorded those that may act
    /// with a lag have columns for these time constants, s, too.
    pub(crate) fn new(
        mechanism: &'a dyn Mechanism,
        data: &'a Dataset,
        environment: Arc<Environment>,
        prior: Prior,
        catalogue: &Catalogue,
        lags: &[f64],
    ) -> (Self, Vec<NotTestable>) {
        let available = AvailableData::of(data);
        let mut groups = Vec::new();
        let mut missing = Vec::new();
        let mut next = mechanism.parameters().len() + data.model().nuisance_parameters().len();
        {
            let context = EffectContext::new(mechanism, &environment);
            for effect in catalogue {
                let lacks = effect.missing(&context, &available);
                if !lacks.is_empty() {
                    missing.push(NotTestable { effect: effect.name().to_owned(), missing: lacks });
                    continue;
                }
                let parameters = effect.parameters(&context);
                let (mut points, scans_rows) = scan_points(effect.as_ref(), &context, &available);
                if effect.may_lag() && available.run && available.has(TIME) {
                    points = points.into_iter().flat_map(|at| lagged(&at, lags)).collect();
                }
                let place = |at: ScanPoint| {
                    let columns = next..next + parameters.len();
                    next = columns.end;
                    ScanSite { at, columns, scans_rows }
                };
                let places = points.into_iter().map(place).collect();
                let alone = effect.often_alone(&context);
                groups.push(EffectColumns { effect: Arc::clone(effect), parameters, alone, places });
            }
        }
        (Self { mechanism, data, environment, prior, groups }, missing)
    }

    /// The same question to these effects, with lags.
    pub(crate) fn with_lags(&self, catalogue: &Catalogue, lags: &[f64]) -> Self {
        Self::new(self.mechanism, self.data, Arc::clone(&self.environment), self.prior.clone(), catalogue, lags).0
    }

    /// The place of a hypothesis.
    pub(crate) fn place(&self, name: &Hypothesis) -> &ScanSite {
        &self.groups[name.group].places[name.place]
    }

    /// The hypothesis that an effect acts at a place, from a sample on if rows are scanned.
    pub(crate) fn find(&self, effect: &str, at: &ScanPoint, from: Option<usize>) -> Option<Hypothesis> {
        let group = self.groups.iter().position(|g| g.effect.name() == effect)?;
        let same = |p: &ScanSite| p.at.leg == at.leg && p.at.covariate == at.covariate && p.at.lag == at.lag;
        let place = self.groups[group].places.iter().position(same)?;
        Some(Hypothesis { group, place, from })
    }

    /// The same effect at the same place with another lag.
    pub(crate) fn at_lag(&self, name: &Hypothesis, lag: Option<f64>) -> Option<Hypothesis> {
        let at = ScanPoint { lag, ..self.place(name).at.clone() };
        self.find(self.groups[name.group].effect.name(), &at, name.from)
    }

    /// True if the joints are the coordinates of the pose.
    pub(crate) fn is_pose_space(&self) -> bool {
        EffectContext::new(self.mechanism, &self.environment).is_pose_space()
    }

    /// Coordinates at which nameless errors are looked for: none where they are the joints.
    fn coordinates(&self) -> usize {
        if self.is_pose_space() { 0 } else { 6 }
    }

    /// The mechanism with the effects of a point and its values.
    fn extended(&self, point: &Point, asked: &[ActiveEffect]) -> Result<Extended, DiagnoseError> {
        let inner = self.mechanism.with_values(&point.values, self.mechanism.home())?;
        let all = point.effects.iter().chain(asked).cloned().collect();
        Ok(Extended::new(inner, Arc::clone(&self.environment), all))
    }

    /// Everything that is asked, with values of zero; or unit displacements alone.
    fn asked(&self, effects: bool) -> Vec<ActiveEffect> {
        let zero = |effect: &Arc<dyn Effect>, at: ScanPoint, count: usize| ActiveEffect {
            effect: Arc::clone(effect),
            at,
            values: vec![0.0; count],
            range: Default::default(),
        };
        let mut asked: Vec<ActiveEffect> = Vec::new();
        for group in self.groups.iter().filter(|_| effects) {
            asked.extend(group.places.iter().map(|p| zero(&group.effect, p.at.clone(), group.parameters.len())));
        }
        let mut unit = |motion: UnitMotion, count: usize| {
            let unit: Arc<dyn Effect> = Arc::new(motion);
            asked.push(zero(&unit, ScanPoint::none(), count));
        };
        unit(UnitMotion::Joints, self.mechanism.joints().len());
        unit(UnitMotion::Coordinates, self.coordinates());
        asked
    }

    /// Makes the table at a point, with rows weighted by these spreads.
    pub(crate) fn table(&self, point: &Point, spreads: &Spreads) -> Result<DesignMatrix, DiagnoseError> {
        self.table_with(point, spreads, true)
    }

    /// The table without the columns of effects.
    pub(crate) fn table_of_parameters(&self, point: &Point, spreads: &Spreads) -> Result<DesignMatrix, DiagnoseError> {
        self.table_with(point, spreads, false)
    }

    fn table_with(&self, point: &Point, spreads: &Spreads, effects: bool) -> Result<DesignMatrix, DiagnoseError> {
        let asked = self.asked(effects);
        let extended = self.extended(point, &asked)?;
        let everything: Vec<ActiveEffect> = point.effects.iter().chain(&asked).cloned().collect();
        let seen = WithInstrumentEffects::wrap(self.data, self.mechanism, &self.environment, &everything)?;
        // The columns of the Jacobian: mechanism, effects on it, own parameters, effects on the measurement.
        let specs = self.mechanism.parameters().len();
        let first_own = extended.parameters().len();
        let own = self.data.model().nuisance_parameters().len();
        let nuisance = specs + own;
        let mut from: Vec<usize> = (0..specs).chain(first_own..first_own + own).collect();
        for columns in unknowns(&everything, specs, first_own + own).into_iter().skip(point.effects.len()) {
            from.extend(columns);
        }
        let problem = CalibrationProblem::new(&Task::new(&extended, &seen))?;
        let all: Vec<usize> = (0..seen.len()).collect();
        let mut parts = Parts::default();
        for (k, some) in all.chunks(AT_ONCE).enumerate() {
            parts.add(&problem, some, &from)?;
            if k == 0 && all.len() > AT_ONCE {
                // Samples have about as many rows each.
                parts.a_t.reserve_exact(parts.a_t.len() / AT_ONCE * (all.len() - AT_ONCE));
            }
        }
        let (precision, gradient, penalty) = self.prior.quadratic(&point.values, nuisance);
        let m = parts.r.len();
        let first_coordinate = from.len() - self.coordinates();
        let mut table = DesignMatrix {
            a_t: DMatrix::from_vec(from.len(), m, parts.a_t),
            r: DVector::from_vec(parts.r),
            rows: parts.rows,
            kinds: parts.kinds,
            nuisance,
            joints: first_coordinate - self.mechanism.joints().len()..first_coordinate,
            coordinates: first_coordinate..from.len(),
            precision,
            gradient,
            penalty,
            own: problem.start().rows(first_own, own).iter().copied().collect(),
            unwhiten: parts.unwhiten,
        };
        table.weigh(spreads);
        Ok(table)
    }

    /// Identifies the parameters and the values of the effects of a point together, starting from it, with the samples
    /// that are kept. Values of effects are not drawn towards zero.
    pub(crate) fn fit(&self, point: &Point, kept: &[usize]) -> Result<Point, DiagnoseError> {
        let extended = self.extended(point, &[])?;
        let seen = WithInstrumentEffects::wrap(self.data, self.mechanism, &self.environment, &point.effects)?;
        let data = seen.subset(kept);
        let prior = self.prior.for_more_parameters(extended.parameters().len());
        let task = Task::new(&extended, &data);
        let mut problem = CalibrationProblem::new(&task)?.with_prior(Some(prior));
        problem.scale_noise(point.scale);
        let start = problem.first_guess();
        // The search goes on with linear steps of its own, so that this one may end early.
        let options = LeastSquaresOptions {
            gradient_tolerance: 1e-4,
            step_tolerance: 1e-9,
            max_iterations: MOST_STEPS,
            ..Default::default()
        };
        let solution = match least_squares(&mut problem, start, LeastSquaresMethod::LevenbergMarquardt, &options) {
            Ok(solution) => solution,
            // The last point is a start like another.
            Err(SolveError::NoConvergence { last, .. }) => *last,
            Err(error) => return Err(IdentifyError::Solve(error).into()),
        };
        let x = solution.x.as_slice();
        let specs = self.mechanism.parameters().len();
        let mut fitted = Point { values: x[..specs].to_vec(), ..point.clone() };
        let own = self.data.model().nuisance_parameters().len();
        let places = unknowns(&point.effects, specs, extended.parameters().len() + own);
        for (effect, place) in fitted.effects.iter_mut().zip(places) {
            effect.values.copy_from_slice(&x[place]);
        }
        Ok(fitted)
    }
}

/// Steps of a fit: three to ten lead to where there is something to find.
const MOST_STEPS: u64 = 40;
/// Samples that are linearized at once: their Jacobian is a second copy of their columns.
const AT_ONCE: usize = 512;

/// What the samples of a table give, one part of them after the other.
#[derive(Default)]
struct Parts {
    a_t: Vec<f64>,
    r: Vec<f64>,
    rows: Vec<(usize, usize)>,
    kinds: Vec<RowKind>,
    unwhiten: Vec<DMatrix<f64>>,
}

impl Parts {
    /// Residual and Jacobian of further samples of a problem at its start, of which these columns are taken.
    fn add(&mut self, all: &CalibrationProblem<'_>, some: &[usize], from: &[usize]) -> Result<(), DiagnoseError> {
        let x = all.start();
        let mut problem = all.subset(some, &x);
        let (r, j) = linearized(&mut problem, &x).map_err(IdentifyError::Solve)?;
        let before = self.r.len();
        self.rows.extend(problem.sample_rows().into_iter().map(|(first, n)| (before + first, n)));
        self.kinds.extend(problem.row_kinds());
        self.unwhiten.extend(problem.unwhitening());
        self.r.extend(r.iter());
        for row in 0..r.len() {
            self.a_t.extend(from.iter().map(|column| j[(row, *column)]));
        }
        Ok(())
    }
}

/// The places of the scan of an effect that have columns of their own, and whether each is scanned over the rows.
fn scan_points(effect: &dyn Effect, context: &EffectContext<'_>, available: &AvailableData) -> (Vec<ScanPoint>, bool) {
    let legs = || (0..context.joints()).map(ScanPoint::leg);
    let scan = effect.scan(context, available);
    let scans_rows = matches!(scan, Scan::Rows | Scan::LegsAndRows);
    let points = match scan {
        Scan::None | Scan::Rows => vec![ScanPoint::none()],
        Scan::Legs | Scan::LegsAndRows => legs().collect(),
        Scan::Covariates(names) => {
            names.into_iter().map(|name| ScanPoint { covariate: Some(name), ..ScanPoint::none() }).collect()
        }
    };
    (points, scans_rows)
}

/// A place at once, and with each lag.
fn lagged(at: &ScanPoint, lags: &[f64]) -> Vec<ScanPoint> {
    let with = |lag: Option<f64>| ScanPoint { lag, ..at.clone() };
    std::iter::once(None).chain(lags.iter().copied().map(Some)).map(with).collect()
}

/// Where the values of each effect stand among the unknowns of an identification: those on the mechanism behind its
/// parameters, those on the measurement behind its own.
fn unknowns(effects: &[ActiveEffect], mut on_mechanism: usize, mut on_measurement: usize) -> Vec<Range<usize>> {
    let place = |effect: &ActiveEffect| {
        let next = if effect.effect.acts_on() == ActsOn::Mechanism { &mut on_mechanism } else { &mut on_measurement };
        let place = *next..*next + effect.values.len();
        *next = place.end;
        place
    };
    effects.iter().map(place).collect()
}
