//! The diagnosis against blind cases of a fixed seed: what was hidden is found, with its place and its size, and where
//! nothing was hidden nothing is found.

use crate::common::hidden;

use crate::common::asked::{Files, asked, place, said};
use crate::common::hidden::cases::{Case, Kind, ROWS, Truth, WARM_UP_CAUSES, draw};
use crate::common::hidden::effects::{CATALOGUE, Planted, measured, named};
use crate::common::hidden::hexapod::Geometry;
use crate::common::hidden::limits::NOISE;
use crate::common::hidden::mistakes::FORMS;
use crate::common::hidden::run::{Row, Run, Weather, normal};
use crate::common::hidden::text::Sheet;
use crate::common::hidden::unlisted_effects;
use paracal::diagnosis::{COORDINATES, Cause, Diagnosis, JointResiduals, MeasurementPlan, Verdict, settle};
use paracal::measurement::DataRow;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

const SEED: u64 = 20;

/// Asks about these cases of a kind, and complains of all answers that are wrong together.
fn examine(kind: Kind, numbers: impl IntoIterator<Item = usize>, check: impl Fn(&Truth, &Diagnosis) -> Vec<String>) {
    let mut complaints = String::new();
    for number in numbers {
        let Case { mechanism, data, truth } = draw(kind, SEED, number).unwrap();
        let found = asked(&mechanism, &data);
        let wrong = check(&truth, &found);
        if !wrong.is_empty() {
            complaints += &format!("\n{number} {}: {} -> {}", hidden_text(&truth), wrong.join(", "), said(&found));
        }
    }
    assert!(complaints.is_empty(), "{kind:?}{complaints}");
}

fn hidden_text(truth: &Truth) -> String {
    let at = |places: &[Option<usize>], k: usize| places.get(k).copied().flatten();
    let effects = truth.effects.iter().enumerate();
    let effects: Vec<String> = effects.map(|(k, e)| place(e, at(&truth.legs, k), at(&truth.rows, k))).collect();
    format!("{} {}", effects.join(" + "), truth.detail)
}

/// What is not true of it is told.
fn unless(holds: bool, wrong: impl Into<String>) -> Vec<String> {
    if holds { Vec::new() } else { vec![wrong.into()] }
}

/// Norm of the parameters of an effect, each in its usual size.
fn size(effect: &str, values: impl IntoIterator<Item = f64>) -> f64 {
    let scale = named(effect).unwrap().scale;
    values.into_iter().zip(scale).map(|(v, s)| (v / s).powi(2)).sum::<f64>().sqrt()
}

/// Whether a cause has the place and the size of the hidden effect `k`.
fn right(truth: &Truth, k: usize, cause: &Cause) -> Vec<String> {
    let found = size(&cause.effect, cause.parameters.iter().map(|p| p.value));
    let ratio = found / size(&cause.effect, truth.parameters[k].iter().copied());
    let row = match (truth.rows[k], cause.row) {
        (Some(hidden), Some(found)) => hidden.abs_diff(found) <= 1,
        (hidden, found) => hidden.is_none() && found.is_none(),
    };
    [
        unless(cause.leg.map(|leg| leg + 1) == truth.legs[k], "leg"),
        unless(row, "row"),
        unless((ratio - 1.0).abs() <= 0.15, format!("size {ratio:.3}")),
    ]
    .concat()
}

/// Held-out position errors: near the floor with the causes, and far above without them.
fn gained(found: &Diagnosis) -> Vec<String> {
    let gain = &found.gain;
    let floor = gain.noise_floor_position.unwrap();
    let (before, after) = (gain.position_before.unwrap() / floor, gain.position_after.unwrap() / floor);
    unless(after <= 1.10 && before > 1.2 * after, format!("held out {before:.3} -> {after:.3} floors"))
}

fn rows(rows: &[DataRow]) -> Vec<usize> {
    rows.iter().map(|row| row.0).collect()
}

#[test]
fn each_effect_is_named_with_its_place_and_its_size() {
    examine(Kind::One(4.0), 0..CATALOGUE.len(), |truth, found| {
        let effect = &truth.effects[0];
        let twin = |name: &str| matches!(name, "compliance.gravity" | "sag.frame");
        // In so small a workspace bodies that grow move the platform as a frame would move; scales of joints and of
        // readings differ by the size of the machine.
        let alike = |rival: &str| match effect.as_str() {
            "thermal.legs.uniform" | "thermal.base" | "thermal.platform" => rival == "thermal.frame",
            "scale.common" => rival == "instrument.scale",
            _ => twin(effect) && twin(rival),
        };
        let [cause] = &found.causes[..] else { return vec!["not one cause".into()] };
        let mut wrong = unless(found.outlier_rows.is_empty() && found.noise_varies.is_none(), "more than a cause");
        if cause.effect != *effect {
            let tied = twin(effect) && twin(&cause.effect) && cause.tied_with.iter().any(|r| r.effect == *effect);
            return unless(tied, "name");
        }
        wrong.extend(unless(cause.tied_with.iter().all(|r| alike(&r.effect)), "verdict"));
        wrong.extend(right(truth, 0, cause));
        wrong.extend(gained(found));
        wrong.extend(drawn(found, cause));
        wrong
    });
}

/// What is left without the cause follows what the cause predicts, one to one, and less is left in the joints with it.
fn drawn(found: &Diagnosis, cause: &Cause) -> Vec<String> {
    let points = &cause.added_variable.points;
    let (xx, xy) = points.iter().fold((0.0, 0.0), |(xx, xy), [x, y]| (xx + x * x, xy + x * y));
    let scatter = points.iter().map(|[x, y]| (y - x).powi(2)).sum::<f64>() / points.len() as f64;
    let sum = |of: fn(&JointResiduals) -> &Vec<f64>| found.residuals.iter().flat_map(of).map(|r| r * r).sum::<f64>();
    [
        unless(points.len() == 6 * ROWS, format!("{} points", points.len())),
        unless((xy / xx - 1.0).abs() < 0.02, format!("slope {}", xy / xx)),
        // The parameters take a part of the noise away.
        unless((0.3..1.1).contains(&scatter), format!("scatter {scatter}")),
        unless(sum(|r| &r.after) < sum(|r| &r.before), "the joints"),
    ]
    .concat()
}

#[test]
fn two_effects_are_both_named() {
    examine(Kind::Two(4.0), 0..6, |truth, found| {
        let wrong = (0..2).flat_map(|k| {
            let effect = &truth.effects[k];
            let cause = found.causes.iter().find(|c| c.effect == *effect);
            // Scales of joints and of readings differ by the size of the machine.
            let twin = |c: &&Cause| c.effect == "instrument.scale" && c.tied_with.iter().any(|r| r.effect == *effect);
            if cause.is_none() && effect == "scale.common" && found.causes.iter().any(|c| twin(&c)) {
                return Vec::new();
            }
            cause.map_or_else(|| vec![format!("no {effect}")], |cause| right(truth, k, cause))
        });
        wrong.chain(unless(found.causes.len() == 2, "not two causes")).collect()
    });
}

#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    examine(Kind::Null, 0..8, |_, found| {
        let clean = found.verdict == Verdict::Clean && found.causes.is_empty() && found.outlier_rows.is_empty();
        let mut wrong = unless(clean && found.noise_varies.is_none(), "a finding");
        wrong.extend(unless((found.noise_scale - 1.0).abs() < 0.1, format!("noise {}", found.noise_scale)));
        wrong
    });
}

#[test]
fn gross_errors_are_found_and_no_good_row() {
    examine(Kind::Outliers(0.05), 0..4, |truth, found| {
        unless(found.verdict == Verdict::Clean && rows(&found.outlier_rows) == truth.outlier_rows, "rows")
    });
    examine(Kind::OneWithOutliers(4.0), [2, 9, 16], |truth, found| {
        let named = found.causes.first().is_some_and(|c| c.effect == truth.effects[0]);
        let left_out: Vec<DataRow> = found.residuals.iter().filter(|r| r.left_out).map(|r| r.row).collect();
        let size = |r: &&JointResiduals| r.after.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let far = found.residuals.iter().max_by(|a, b| size(a).total_cmp(&size(b))).unwrap();
        [
            unless(named, "name"),
            unless(rows(&found.outlier_rows) == truth.outlier_rows && rows(&left_out) == truth.outlier_rows, "rows"),
            unless(far.left_out, "the farthest row of the strips"),
        ]
        .concat()
    });
}

#[test]
fn what_no_catalogue_lists_is_unknown_over_the_right_covariate() {
    // Errors of a leg that depend on one recorded thing: the covariate and the leg must both be right.
    examine(Kind::Outside(5.0), 0..9, |truth, found| {
        let Some(unknown) = &found.unknown else { return vec!["not unknown".into()] };
        // A leg whose length is uncertain depends on nothing, and a wave may fit it by chance.
        let covariate = truth.covariates.is_empty()
            || unknown.covariate.as_ref().is_some_and(|covariate| truth.covariates.contains(covariate));
        let leg = truth.legs[0].is_none() || unknown.leg.map(|leg| leg + 1) == truth.legs[0];
        let verdict = found.verdict == Verdict::Unknown;
        [unless(verdict, "verdict"), unless(covariate, "covariate"), unless(leg, "leg")].concat()
    });
}

#[test]
fn what_acts_on_frames_instruments_and_loads_is_unknown_where_it_acts_or_has_a_related_name() {
    examine(Kind::Outside(6.0), 9..unlisted_effects::NAMES.len(), |truth, found| {
        let names = found.causes.iter().flat_map(|c| c.tied_with.iter().map(|r| &r.effect).chain([&c.effect]));
        if names.clone().any(|name| truth.also.contains(name)) {
            return Vec::new();
        }
        let Some(unknown) = &found.unknown else { return vec!["not unknown".into()] };
        let covariate = unknown.covariate.as_ref().is_some_and(|covariate| truth.covariates.contains(covariate));
        let coordinate = unknown.coordinate.is_some_and(|k| truth.coordinates.iter().any(|c| c == COORDINATES[k]));
        let leg = unknown.leg.is_some_and(|leg| truth.legs[0] == Some(leg + 1));
        unless(covariate || coordinate || leg, "neither covariate nor place")
    });
}

#[test]
fn a_warm_up_leaves_the_truth_named_or_tied() {
    examine(Kind::WarmUp(4.0), 0..2 * WARM_UP_CAUSES.len(), |truth, found| {
        let names =
            |c: &Cause| c.effect == truth.effects[0] || c.tied_with.iter().any(|r| r.effect == truth.effects[0]);
        unless(found.causes.iter().any(names), "the truth is not mentioned")
    });
}

#[test]
fn a_file_that_is_read_wrongly_is_told_how() {
    examine(Kind::Misread, 0..FORMS.len(), |truth, found| {
        let reading = found.misread.as_ref().map(|m| m.reading.clone());
        unless(found.verdict == Verdict::Misread && reading == truth.reading, "reading")
    });
}

/// Legs that grow while everything warms up: what was measured, and what would be if it went on.
struct WarmUp {
    machine: Geometry,
    run: Run,
    legs: Planted,
    seed: u64,
}

impl WarmUp {
    fn new(seed: u64, expansion: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let run = Run::draw(ROWS, Weather::WarmUp, &mut rng);
        let machine = Geometry::nominal().changed(&std::array::from_fn(|_| 0.5e-3 * normal(&mut rng)));
        let legs = Planted { name: LEGS, leg: None, row: None, theta: vec![expansion] };
        Self { machine, run, legs, seed }
    }

    /// The two files; the noise of rows that were there before stays.
    fn files(&self) -> Files {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed + 1);
        let mut poses = measured(&self.machine, &self.run, &[&self.legs]).unwrap();
        for (k, value) in poses.iter_mut().flatten().enumerate() {
            *value += NOISE[usize::from(k % 6 >= 3)] * normal(&mut rng);
        }
        Files::new(&hidden::text::mechanism(), &Sheet::of(self.run.clone(), poses).csv())
    }

    /// Adds the samples of a plan, a minute apart after a pause. Temperatures count from where they did.
    fn carry_out(&mut self, plan: &MeasurementPlan) {
        let pause = 2.0 * 3600.0;
        for (k, sample) in plan.samples.iter().enumerate() {
            let last = self.run.rows.last().unwrap();
            let get = |name: &str| sample.conditions.get(name).unwrap();
            let planned = Row {
                time: last.time + if k == 0 { pause } else { 60.0 },
                commanded: sample.joints.clone().try_into().unwrap(),
                before: last.commanded,
                temp_legs: std::array::from_fn(|i| get(&format!("temp_leg{}", i + 1))),
                temp_platform: get("temp_platform"),
                temp_base: get("temp_base"),
                elevation: get("elevation"),
                azimuth: get("azimuth"),
                payload: get("payload"),
            };
            self.run.rows.push(planned);
        }
    }
}

const LEGS: &str = "thermal.legs.uniform";

/// Of a tie of three names or more every pair must be told apart, as each of them may be the truth.
#[test]
fn what_settle_proposes_settles_a_tie_when_it_is_measured() {
    let expansion = 2e-6;
    for seed in [SEED, SEED + 1] {
        let mut warm_up = WarmUp::new(seed, expansion);
        let files = warm_up.files();
        let tied = files.diagnosis();
        assert_eq!(tied.verdict, Verdict::Tied, "{}", said(&tied));
        let [cause] = &tied.causes[..] else { panic!("{}", said(&tied)) };
        let mut names: Vec<&str> = cause.tied_with.iter().map(|r| r.effect.as_str()).collect();
        names.push(&cause.effect);
        assert!(names.contains(&LEGS) && names.contains(&"thermal.base"), "{}", said(&tied));

        let plans = settle(&files.question(), &tied).unwrap();
        let (best, present) = (&plans[0], plans.last().unwrap());
        assert!(present.samples.is_empty() && !present.settles(), "{:?}", present.separations);
        assert_eq!(best.separations.len(), names.len() * (names.len() - 1) / 2);
        assert!(best.settles(), "{}: {:?}", best.what, best.separations);
        assert!(best.separations.iter().all(|s| s.separability >= 10.0), "{:?}", best.separations);

        warm_up.carry_out(best);
        let settled = warm_up.files().diagnosis();
        let [cause] = &settled.causes[..] else { panic!("{}", said(&settled)) };
        assert!(settled.verdict == Verdict::Named && cause.effect == LEGS, "{}", said(&settled));
        let growth = &cause.parameters[0];
        let error = (growth.value - expansion).abs();
        assert!(error < 4.0 * growth.sigma.unwrap() && error < 0.1 * expansion, "{growth:?}");
    }
}
