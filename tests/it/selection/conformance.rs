//! The built-in indices and selectors obey the laws that a consumer's own are held to, and wrong ones are caught.

use crate::common;

use crate::common::planar::{self, Planar};
use paracal::conformance;
use paracal::measurement::Noise;
use paracal::mechanism::{Mechanism, Workspace};
use paracal::observability::{
    Extremes, FastForm, Goal, O1, O2, O3, ObservabilityIndex, PoseError, PoseSet, Scaling, Spectrum, index,
};
use paracal::selection::{
    Campaign, Candidates, Choice, Forecaster, PoseSelector, Problem, Random, SELECTORS, SelectionError, Sources,
    selector,
};

/// The predicted error over the whole workspace, and the number of directions that it is made for.
fn pose_error(mechanism: &dyn Mechanism, workspace: &Workspace, prior: bool) -> (PoseError, usize) {
    let noise = Noise::stated(1e-6, 1e-6);
    let campaign = Campaign::new(mechanism, workspace, Some(&noise), Scaling::Whitened).unwrap();
    let sources = Sources { random: 40, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources).unwrap();
    let visible = candidates.pool.visible();
    (Forecaster::new(campaign.clone(), &[]).unwrap().index(visible, prior), visible.ncols())
}

#[test]
fn every_index_conforms_on_blocks_of_either_structure() {
    for name in ["o1", "o2", "o3", "o4", "o5"] {
        for directions in [12, 42] {
            let found = conformance::index(index(name).unwrap().as_ref(), directions);
            found.unwrap_or_else(|v| panic!("{name}, {directions} directions: {v}"));
        }
    }
}

#[test]
fn the_predicted_error_conforms_with_and_without_a_prior() {
    let m = common::machine("table5");
    for prior in [false, true] {
        let (index, directions) = pose_error(m.mechanism.as_ref(), &m.workspace.unwrap(), prior);
        assert_eq!(directions, 42);
        conformance::index(&index, directions).unwrap_or_else(|v| panic!("table5, prior {prior}: {v}"));
        let (index, directions) = pose_error(&Planar::new(false), &planar::workspace(), prior);
        conformance::index(&index, directions).unwrap_or_else(|v| panic!("planar, prior {prior}: {v}"));
    }
}

/// Built-in indices scale with the singular values, so that the units of all rows together do not matter.
#[test]
fn scaled_rows_keep_the_order_of_the_built_in_indices() {
    let spectrum = |values: &[f64], factor: f64| Spectrum {
        values: values.iter().map(|v| factor * v).collect(),
        directions: paracal::nalgebra::DMatrix::identity(3, 3),
        poses: 3,
    };
    let gain = [paracal::nalgebra::DMatrix::from_fn(6, 3, |r, c| (r + 2 * c) as f64)];
    let error = PoseError::new(&gain, &paracal::nalgebra::DMatrix::identity(3, 3), false);
    let mut indices: Vec<Box<dyn ObservabilityIndex>> = vec![Box::new(error)];
    indices.extend(["o1", "o2", "o3", "o4", "o5"].map(|name| index(name).unwrap()));
    let (a, b) = ([9.0, 4.0, 1.0], [8.0, 3.0, 0.5]);
    for index in indices {
        let order = |f: f64| index.value(&spectrum(&a, f)).total_cmp(&index.value(&spectrum(&b, f)));
        assert!([1e-6, 1e-3, 1e3, 1e6].iter().all(|f| order(*f) == order(1.0)), "{}", index.name());
    }
}

/// An index with something wrong.
#[derive(Clone, Copy, Debug, Default)]
struct Wrong {
    goal: Option<Goal>,
    fast: Option<FastForm<'static>>,
    value: Option<fn(&Spectrum) -> f64>,
    directions: bool,
}

impl ObservabilityIndex for Wrong {
    fn name(&self) -> &str {
        "wrong"
    }
    fn value(&self, s: &Spectrum) -> f64 {
        self.value.map_or_else(|| O3.value(s), |f| f(s))
    }
    fn goal(&self) -> Goal {
        self.goal.unwrap_or(Goal::Largest)
    }
    fn needs_directions(&self) -> bool {
        self.directions
    }
    fn fast(&self) -> FastForm<'_> {
        self.fast.unwrap_or(FastForm::None)
    }
}

fn law_of_index(wrong: Wrong, directions: usize) -> &'static str {
    conformance::index(&wrong, directions).unwrap_err().law
}

#[test]
fn wrong_indices_are_caught_and_the_law_is_named() {
    conformance::index(&Wrong::default(), 12).unwrap();
    let swapped = Wrong { goal: Some(Goal::Smallest), ..Wrong::default() };
    assert_eq!(law_of_index(swapped, 12), "stronger rows are not worse");
    // O2 does not change with the scale: its goal shows in what the scans find.
    let o2 = FastForm::Extremes(Extremes { smallest: 1, over_largest: true });
    let swapped = Wrong { goal: Some(Goal::Smallest), fast: Some(o2), value: Some(|s| O2.value(s)), directions: false };
    assert_eq!(law_of_index(swapped, 12), "the best addition is that of brute force");
    assert_eq!(law_of_index(swapped, 42), "the best addition is that of brute force");
    for lie in [FastForm::HarmonicSum, FastForm::Extremes(Extremes { smallest: 2, over_largest: true })] {
        let lying = Wrong { fast: Some(lie), ..Wrong::default() };
        assert!(law_of_index(lying, 12).starts_with("the best"), "{lie:?}");
    }
    // The quick value of a determinant comes from it alone.
    let lying = Wrong { fast: Some(FastForm::Determinant), ..Wrong::default() };
    assert_eq!(law_of_index(lying, 12), "the quick value is the value");
    let secret = Wrong { value: Some(|s| s.directions.get(0).copied().unwrap_or(0.0).abs()), ..Wrong::default() };
    assert_eq!(law_of_index(secret, 12), "directions are read only if the index needs them");
    let signed = Wrong { value: Some(|s| s.values[0] * (2.0 + s.directions[0])), directions: true, ..Wrong::default() };
    assert_eq!(law_of_index(signed, 12), "signs of directions do not matter");
    let product =
        Wrong { value: Some(|s| s.values.iter().map(|v| v * 1e-9).product::<f64>().ln()), ..Wrong::default() };
    assert_eq!(law_of_index(product, 42), "a regular spectrum has a finite value");
}

#[test]
fn a_wrong_gain_is_caught() {
    let (right, directions) = pose_error(&Planar::new(false), &planar::workspace(), false);
    #[derive(Debug)]
    struct WrongGain(PoseError, paracal::nalgebra::DMatrix<f64>);
    impl ObservabilityIndex for WrongGain {
        fn name(&self) -> &str {
            "wrong gain"
        }
        fn value(&self, s: &Spectrum) -> f64 {
            self.0.value(s)
        }
        fn goal(&self) -> Goal {
            Goal::Smallest
        }
        fn needs_directions(&self) -> bool {
            true
        }
        fn fast(&self) -> FastForm<'_> {
            FastForm::Trace(&self.1)
        }
    }
    let wrong = WrongGain(right, paracal::nalgebra::DMatrix::identity(directions, directions));
    assert!(conformance::index(&wrong, directions).unwrap_err().law.starts_with("the best"));
}

#[test]
fn every_selector_conforms_with_six_legs() {
    let m = common::machine("table5");
    let workspace = m.workspace.unwrap();
    for name in SELECTORS {
        let found = conformance::selector(selector(name).unwrap().as_ref(), m.mechanism.as_ref(), &workspace);
        found.unwrap_or_else(|v| panic!("{name}: {v}"));
    }
}

#[test]
fn every_selector_conforms_without_leg_structure() {
    for name in SELECTORS {
        let found = conformance::selector(selector(name).unwrap().as_ref(), &Planar::new(false), &planar::workspace());
        found.unwrap_or_else(|v| panic!("{name}: {v}"));
    }
}

/// The scans put a ridge under such a set; its value must stay that of its rows, or a search keeps it as the best.
#[test]
fn a_set_that_determines_nothing_has_no_quick_value_of_its_own() {
    let mechanism = Planar::new(false);
    let campaign = Campaign::new(&mechanism, &planar::workspace(), None, Scaling::Paper).unwrap();
    let sources = Sources { random: 20, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources).unwrap();
    let mut set = PoseSet::new(&candidates.pool, &O1, &[], &[0]);
    assert!(set.is_singular());
    assert_eq!(set.quick_value(), set.value());
}

/// A random selector with its choice spoilt.
#[derive(Debug)]
struct Spoilt(fn(&Problem<'_>, Choice) -> Choice);

impl PoseSelector for Spoilt {
    fn name(&self) -> &str {
        "spoilt"
    }
    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        Ok(self.0(problem, Random.select(problem)?))
    }
}

/// One that takes what there is.
#[derive(Debug)]
struct Modest;

impl PoseSelector for Modest {
    fn name(&self) -> &str {
        "modest"
    }
    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        Random.select(&Problem { count: problem.count.min(problem.candidates.len()), ..*problem })
    }
}

fn law_of_selector(wrong: &dyn PoseSelector) -> &'static str {
    conformance::selector(wrong, &Planar::new(false), &planar::workspace()).unwrap_err().law
}

#[test]
fn wrong_selectors_are_caught_and_the_law_is_named() {
    let cases: [(Spoilt, &str); 6] = [
        (
            Spoilt(|_, mut c| {
                c.poses.pop();
                c
            }),
            "as many poses as wanted are chosen",
        ),
        (
            Spoilt(|p, mut c| {
                c.poses[1] = c.poses[0];
                c.trace = vec![p.value_of(&c.poses)];
                c
            }),
            "chosen poses differ from one another",
        ),
        (
            Spoilt(|p, mut c| {
                c.poses[0] = p.campaign.workspace.pose(&[2.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
                c
            }),
            "chosen poses are candidates or feasible poses of the workspace",
        ),
        (
            Spoilt(|p, c| {
                let alone = Problem { given: &[], ..*p };
                Choice { trace: vec![alone.value_of(&c.poses)], ..c }
            }),
            "the choice is the best of its trace",
        ),
        (Spoilt(|_, c| Choice { trace: Vec::new(), ..c }), "the trace has the first value and one for each iteration"),
        (
            Spoilt(|p, c| {
                let problem = Problem { seed: p.seed + rayon::current_num_threads() as u64, ..*p };
                Random.select(&problem).unwrap_or(c)
            }),
            "the same problem gives the same choice on any number of threads",
        ),
    ];
    for (wrong, law) in cases {
        assert_eq!(law_of_selector(&wrong), law);
    }
    assert_eq!(law_of_selector(&Modest), "too few candidates are refused");
}

#[test]
fn dependent_coordinates_are_solved_from_the_structural_rows() {
    let mechanism = Planar::new(false);
    let mut space = planar::workspace();
    // The mechanism holds z and the two tilts at zero whatever the file says about its centre.
    (space.centre[2], space.centre[3], space.centre[4]) = (0.1, 0.05, -0.03);
    assert_eq!([space.half[2], space.half[3], space.half[4]], [0.0; 3]);
    let campaign = Campaign::new(&mechanism, &space, None, Scaling::Paper).unwrap();
    let sources = Sources { random: 30, corners_and_grid: true, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources).unwrap();
    assert_eq!(candidates.len(), 30 + 27);
    for pose in &candidates.poses {
        let q = space.convention.coordinates(pose);
        assert!([q[2], q[3], q[4]].iter().all(|v| v.abs() < 1e-12), "{q:?}");
        assert!([0, 1, 5].iter().all(|k| (q[*k] - space.centre[*k]).abs() <= space.half[*k] + 1e-12), "{q:?}");
    }
}
