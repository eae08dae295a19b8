//! Laws of a [`PoseSelector`].

use nalgebra::DMatrix;

use super::{Violation, violation};
use crate::mechanism::{Mechanism, Workspace};
use crate::observability::{FastForm, Goal, O1, ObservabilityIndex, Pool, Scaling, Spectrum};
use crate::pose::Pose;
use crate::selection::{Campaign, Candidates, Choice, PoseSelector, Problem, SelectionError, Sources};

/// Random candidates.
const CANDIDATES: usize = 60;
/// Poses that are given where some are.
const GIVEN: usize = 3;
/// Poses chosen beyond the number with as many rows as directions.
const BEYOND: usize = 3;
/// Agreement of the trace with the value of the poses.
const AGREES: f64 = 1e-6;
/// Poses closer than this part of the workspace are the same.
const SAME: f64 = 1e-9;

/// Checks a selector with a mechanism and a workspace, in mm and rad, so that neither noise nor tolerances are needed.
///
/// * it chooses exactly as many poses as wanted; they are candidates, or feasible poses of the workspace, and differ;
/// * the same problem gives the same choice, on any number of threads;
/// * the trace has the value of the first set and one for each iteration, and the choice is the best of them, for an
///   index that should be large and for one that should be small, given poses included;
/// * a single pose beside given ones, all candidates, too few poses to determine anything, and candidates that are
///   all equal give a choice too;
/// * too few candidates give [`SelectionError::TooFewCandidates`].
///
/// # Errors
/// The first [`Violation`].
pub fn selector(
    selector: &dyn PoseSelector,
    mechanism: &dyn Mechanism,
    workspace: &Workspace,
) -> Result<(), Violation> {
    const LAW: &str = "the workspace has poses to choose from";
    let unusable = |e: SelectionError| violation(LAW, e.to_string());
    let campaign = Campaign::new(mechanism, workspace, None, Scaling::Paper).map_err(unusable)?;
    let sources = |random, seed| Sources { random, seed, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources(CANDIDATES, 7)).map_err(unusable)?;
    let others = Candidates::collect(&campaign, &sources(GIVEN, 8)).map_err(unusable)?;
    let enough = candidates.pool.directions().div_ceil(6) + BEYOND;
    if candidates.len() < enough + BEYOND {
        return Err(violation(LAW, format!("{} candidates, {enough} to choose", candidates.len())));
    }
    let rows = |pose: &Pose| Some(campaign.block(pose).ok()?.rows()? * candidates.pool.visible());
    let given: Vec<DMatrix<f64>> = others.poses.iter().filter_map(rows).collect();
    let bench = Bench { selector, campaign: &campaign, candidates: &candidates };

    bench.ordinary(enough, &given)?;
    bench.repeatable(&bench.problem(enough, &given))?;
    bench.unusual(enough, &candidates.pool)?;
    bench.equal_candidates()?;
    bench.too_few()
}

struct Bench<'a> {
    selector: &'a dyn PoseSelector,
    campaign: &'a Campaign<'a>,
    candidates: &'a Candidates,
}

impl<'a> Bench<'a> {
    fn problem<'b>(&self, count: usize, given: &'b [DMatrix<f64>]) -> Problem<'b>
    where
        'a: 'b,
    {
        let (campaign, candidates) = (self.campaign, self.candidates);
        Problem { campaign, candidates, index: &O1, given, count, seed: 9, watch: &|_| {} }
    }

    /// The choice, which has the right number of feasible poses and a trace.
    fn choice(&self, context: &str, problem: &Problem<'_>) -> Result<Choice, Violation> {
        const NUMBER: &str = "as many poses as wanted are chosen";
        const FEASIBLE: &str = "chosen poses are candidates or feasible poses of the workspace";
        let choice = self.selector.select(problem).map_err(|e| violation(NUMBER, format!("{context}: {e}")))?;
        if choice.poses.len() != problem.count {
            let detail = format!("{context}: {} poses, {} wanted", choice.poses.len(), problem.count);
            return Err(violation(NUMBER, detail));
        }
        for pose in choice.poses.iter().filter(|p| !problem.candidates.poses.contains(p)) {
            if let Err(reason) = self.campaign.feasible(pose) {
                return Err(violation(FEASIBLE, format!("{context}: {} is {reason:?}", self.shown(pose))));
            }
            let outside = |(k, u): (usize, f64)| self.campaign.workspace.half[k] > 0.0 && u.abs() > 1.0 + SAME;
            if self.place(pose).into_iter().enumerate().any(outside) {
                return Err(violation(FEASIBLE, format!("{context}: {} is outside", self.shown(pose))));
            }
        }
        if choice.trace.len() != choice.iterations + 1 {
            let detail = format!("{context}: {} values, {} iterations", choice.trace.len(), choice.iterations);
            return Err(violation("the trace has the first value and one for each iteration", detail));
        }
        Ok(choice)
    }

    fn different(&self, context: &str, choice: &Choice) -> Result<(), Violation> {
        let places: Vec<[f64; 6]> = choice.poses.iter().map(|p| self.place(p)).collect();
        for (k, b) in places.iter().enumerate() {
            let same = |a: &[f64; 6]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME);
            if let Some(first) = places[..k].iter().position(same) {
                let detail = format!("{context}: number {first} and number {k}, {}", self.shown(&choice.poses[k]));
                return Err(violation("chosen poses differ from one another", detail));
            }
        }
        Ok(())
    }

    fn ordinary(&self, count: usize, given: &[DMatrix<f64>]) -> Result<(), Violation> {
        let indices: [&dyn ObservabilityIndex; 2] = [&O1, &InverseVolume];
        for index in indices {
            for given in [&[], given] {
                let context = format!("{count} poses in addition to {} given, index {}", given.len(), index.name());
                let problem = Problem { index, ..self.problem(count, given) };
                let choice = self.choice(&context, &problem)?;
                self.different(&context, &choice)?;
                let better = match index.goal() {
                    Goal::Largest => f64::max,
                    Goal::Smallest => f64::min,
                };
                let best = choice.trace.iter().copied().fold(f64::NAN, better);
                let value = problem.value_of(&choice.poses);
                if !((value - best).abs() <= AGREES * value.abs()) {
                    let detail = format!("{context}: the poses have {value:.9e}, the best of the trace is {best:.9e}");
                    return Err(violation("the choice is the best of its trace", detail));
                }
            }
        }
        Ok(())
    }

    fn repeatable(&self, problem: &Problem<'_>) -> Result<(), Violation> {
        const LAW: &str = "the same problem gives the same choice on any number of threads";
        let mut first: Option<Choice> = None;
        for threads in [1, 2, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.map_err(|e| violation(LAW, format!("{threads} threads cannot be started: {e}")))?;
            let choice = pool.install(|| self.choice(&format!("{threads} threads"), problem))?;
            match &first {
                Some(first) if first.poses != choice.poses => {
                    let (a, b) = (problem.value_of(&first.poses), problem.value_of(&choice.poses));
                    let place = first.poses.iter().zip(&choice.poses).position(|(a, b)| a != b).unwrap_or(0);
                    let detail = format!("on {threads}, number {place} is another; values {a:.12e} and {b:.12e}");
                    return Err(violation(LAW, detail));
                }
                Some(_) => {}
                None => first = Some(choice),
            }
        }
        Ok(())
    }

    fn unusual(&self, enough: usize, pool: &Pool) -> Result<(), Violation> {
        // Given poses that determine everything, so that one more pose has a value.
        let given: Vec<DMatrix<f64>> = (0..enough).map(|k| pool.rows(k)).collect();
        self.choice("one pose in addition to given ones", &self.problem(1, &given))?;
        let all = self.candidates.len();
        let everything = self.choice("all candidates", &self.problem(all, &[]))?;
        self.different("all candidates", &everything)?;
        let singular = self.choice("two poses, which determine nothing", &self.problem(2, &[]))?;
        self.different("two poses", &singular)
    }

    fn equal_candidates(&self) -> Result<(), Violation> {
        let listed = vec![self.candidates.poses[0]; 3 * BEYOND];
        let equal = Candidates::collect(self.campaign, &Sources { listed, ..Sources::default() })
            .map_err(|e| violation("equal candidates are candidates", e.to_string()))?;
        let problem = Problem { candidates: &equal, ..self.problem(BEYOND, &[]) };
        self.choice("candidates that are all equal", &problem).map(|_| ())
    }

    fn too_few(&self) -> Result<(), Violation> {
        let found = match self.selector.select(&self.problem(self.candidates.len() + 1, &[])) {
            Err(SelectionError::TooFewCandidates { .. }) => return Ok(()),
            Err(other) => other.to_string(),
            Ok(choice) => format!("{} poses", choice.poses.len()),
        };
        let (len, wanted) = (self.candidates.len(), self.candidates.len() + 1);
        Err(violation("too few candidates are refused", format!("{len} candidates, {wanted} wanted: {found}")))
    }

    /// A pose in half-ranges of the workspace, m and rad along coordinates without one.
    fn place(&self, pose: &Pose) -> [f64; 6] {
        let w = &self.campaign.workspace;
        let offsets = w.offsets(pose);
        std::array::from_fn(|k| offsets[k] / if w.half[k] > 0.0 { w.half[k] } else { 1.0 })
    }

    fn shown(&self, pose: &Pose) -> String {
        let q = self.campaign.convention().coordinates(pose).map(|v| format!("{v:.6}"));
        format!("pose ({})", q.join(", "))
    }
}

/// An index that should be small, and is found fast.
#[derive(Debug)]
struct InverseVolume;

impl ObservabilityIndex for InverseVolume {
    fn name(&self) -> &str {
        "inverse volume"
    }

    fn goal(&self) -> Goal {
        Goal::Smallest
    }

    fn value(&self, s: &Spectrum) -> f64 {
        1.0 / O1.value(s)
    }

    fn fast(&self) -> FastForm<'_> {
        FastForm::Determinant
    }
}
