//! What a drawing says that is wrong: tolerances too narrow, joints that count from elsewhere, and what is said of it.

use paracal::files::Machine;
use paracal::identification::{Calibration, CalibrationOptions, Holdout, LevenbergMarquardt, PriorPolicy, calibrate};
use paracal::measurement::Dataset;
use paracal::mechanism::{Mechanism, ParameterRole};
use paracal::pose::Pose;
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::common::bench::TABLE_5;
use crate::common::{errors_of, paper_noise, workspace};

/// Anchors and lengths err by this, 1σ, m.
const ERROR: f64 = 0.4e-3;
/// Half-ranges in which every direction is not decided, so that the tolerances are a prior: mm and degrees.
const HALF: (f64, f64) = (15.0, 1.5);

/// The machine of Table 5 whose file states this tolerance of anchors and lengths, mm.
fn stating(tolerance: f64) -> Machine {
    let stated = format!("anchor = {tolerance}\nlength = {tolerance}");
    let text = TABLE_5.replacen("anchor = 0.5\nlength = 0.5", &stated, 1);
    assert!(text.contains(&stated));
    Machine::from_text(&text, "m.toml".as_ref()).unwrap()
}

/// A campaign of a machine that errs by [`ERROR`], its joints by further offsets, and exact poses of it elsewhere in the box.
fn campaign(nominal: &dyn Mechanism, offset: f64, seed: u64) -> (Dataset, Dataset) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut values = draw_parameters(nominal, Some(ERROR), &mut rng);
    for (value, spec) in values.iter_mut().zip(nominal.parameters()) {
        if let ParameterRole::JointOffset { leg } = spec.role {
            *value += offset * (1.0 + 0.1 * leg as f64);
        }
    }
    let truth = nominal.with_values(&values, nominal.home()).unwrap();
    let space = workspace(nominal, HALF.0, HALF.1);
    let mut seen = |count: usize, noise| {
        let poses: Vec<Pose> = (0..count).map(|_| space.random(&mut rng)).collect();
        let run = simulate(nominal, truth.as_ref(), &poses, &space.convention, &noise, &mut rng).unwrap();
        as_dataset(&run, &space.convention, &paper_noise())
    };
    (seen(30, paper_noise()), seen(100, paracal::measurement::Noise::stated(1e-15, 1e-15)))
}

fn calibrated(machine: &Machine, data: &Dataset, prior: PriorPolicy) -> Calibration {
    let nominal = machine.mechanism.as_ref();
    let options = CalibrationOptions { prior, holdout: Holdout::None, ..CalibrationOptions::default() };
    let space = workspace(nominal, HALF.0, HALF.1);
    calibrate(nominal, data, Some(&space), &LevenbergMarquardt::default(), &options).unwrap()
}

/// True over stated error of the position.
fn ratio(result: &Calibration, fresh: &Dataset) -> f64 {
    errors_of(result.mechanism.as_ref(), fresh).0 / result.predicted.unwrap().position_rms
}

#[test]
fn tolerances_that_hold_stay_as_they_are() {
    let machine = stating(0.4);
    let (mut cost, mut free, mut ratios) = (0.0, 0.0, Vec::new());
    for seed in 0..40 {
        let (data, fresh) = campaign(machine.mechanism.as_ref(), 0.0, seed);
        let found = calibrated(&machine, &data, PriorPolicy::Auto);
        assert!(found.verdict.trusted && found.tolerance_factors == [1.0; 4], "{seed}: {:?}", found.verdict);
        let test = found.drawing.unwrap();
        cost += test.with_prior.chi_square;
        free += test.with_prior.degrees_of_freedom as f64;
        ratios.push(ratio(&found, &fresh));
    }
    // χ² of 40 × 180 degrees of freedom: σ is 0.017.
    assert!((cost / free - 1.0).abs() < 0.06, "{}", cost / free);
    ratios.sort_by(f64::total_cmp);
    assert!((0.8..1.2).contains(&ratios[20]) && ratios[39] < 2.0, "{ratios:?}");
}

#[test]
fn tolerances_that_the_data_contradict_are_widened_and_the_error_is_true() {
    for stated in [0.1, 0.02, 0.004] {
        let machine = stating(stated);
        let mut ratios = Vec::new();
        for seed in 0..10 {
            let (data, fresh) = campaign(machine.mechanism.as_ref(), 0.0, 100 + seed);
            let found = calibrated(&machine, &data, PriorPolicy::Auto);
            assert!(found.verdict.trusted, "{stated}, {seed}: {:?}", found.verdict.reasons);
            let [platform, base, ..] = found.tolerance_factors;
            // Both bodies move the legs alike, and what one does not take the other does.
            let factor = f64::midpoint(platform * platform, base * base).sqrt() / (0.4 / stated);
            assert!((0.4..2.0).contains(&factor), "{stated}, {seed}: {:?}", found.tolerance_factors);
            assert!(found.verdict.warnings.iter().any(|w| w.contains("times as much as [tolerance] states")));
            ratios.push(ratio(&found, &fresh));
            // Whoever insists on the stated width is told that it does not hold.
            let insisted = calibrated(&machine, &data, PriorPolicy::Tolerance);
            let why = insisted.verdict.reasons.join("; ");
            assert!(!insisted.verdict.trusted && why.contains("farther from its drawing"), "{stated}: {why}");
        }
        ratios.sort_by(f64::total_cmp);
        assert!((0.7..1.3).contains(&ratios[5]) && ratios[9] < 2.0, "{stated}: {ratios:?}");
    }
}

#[test]
fn joints_that_count_from_elsewhere_cost_nothing() {
    let machine = stating(0.4);
    for (seed, offset) in [(1, 3e-3), (2, -12e-3), (3, 40e-3)] {
        let nominal = machine.mechanism.as_ref();
        let (data, fresh) = campaign(nominal, offset, seed);
        let found = calibrated(&machine, &data, PriorPolicy::Auto);
        assert!(found.verdict.trusted, "{offset}: {:?}", found.verdict.reasons);
        let ratio = ratio(&found, &fresh);
        assert!((0.3..1.6).contains(&ratio), "{offset}: {ratio}");
        assert!(found.predicted.unwrap().position_rms < 20e-6, "{:?}", found.predicted);
        for (leg, moved) in found.plausibility.leg_offsets.iter().enumerate() {
            let expected = offset * (1.0 + 0.1 * leg as f64);
            assert!((moved - expected).abs() < 5.0 * ERROR, "{offset}, leg {leg}: {moved}");
        }
    }
}

#[test]
fn few_poses_are_not_enough_however_many_times_they_are_measured() {
    let machine = stating(0.4);
    let nominal = machine.mechanism.as_ref();
    let (data, _) = campaign(nominal, 0.0, 7);
    for kept in [vec![4], vec![4, 9], vec![11; 24]] {
        let result = calibrated(&machine, &data.subset(&kept), PriorPolicy::Auto);
        let why = result.verdict.reasons.join("; ");
        assert!(!result.verdict.trusted && why.contains("measure more and other poses"), "{kept:?}: {why}");
    }
}
