//! Diagnoses of the reference data: cases of an independent generator, a finite-element table, and a telescope on sky.

use std::path::Path;

use paracal::diagnosis::{Cause, Diagnosis, Verdict};
use serde_json::Value;

use super::folder;
use crate::common::asked::{Files, asked, said};

/// The answers to all cases of a kind, each with its truth.
fn examples(kind: &str) -> Vec<(Value, Diagnosis)> {
    let Some(folder) = folder("diagnosis-examples") else { return Vec::new() };
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let truths: Value = serde_json::from_str(&read(&folder.join(kind).join("truth.json"))).unwrap();
    let answer = |truth: &Value| {
        let case = folder.join(kind).join(truth["case"].as_str().unwrap());
        (truth.clone(), asked(&read(&case.join("mechanism.toml")), &read(&case.join("data.csv"))))
    };
    truths.as_array().unwrap().iter().map(answer).collect()
}

/// The leg of a truth, from 0.
fn leg(truth: &Value, k: usize) -> Option<usize> {
    truth["leg"][k].as_u64().map(|leg| leg as usize - 1)
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

/// Requires that the hidden effect `k` is among the causes, with its leg and its size.
#[track_caller]
fn named<'a>(truth: &Value, k: usize, found: &'a Diagnosis) -> &'a Cause {
    let effect = truth["effects"][k].as_str().unwrap();
    let cause = found.causes.iter().find(|c| c.effect == effect);
    let cause = cause.unwrap_or_else(|| panic!("{truth}: {}", said(found)));
    assert_eq!(cause.leg, leg(truth, k), "{truth}: {}", said(found));
    let hidden = norm(truth["parameters_si"][k].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()));
    let ratio = norm(cause.parameters.iter().map(|p| p.value)) / hidden;
    assert!((ratio - 1.0).abs() <= 0.15, "{truth}: {ratio}");
    cause
}

#[test]
fn each_effect_of_the_examples_is_named() {
    for (truth, found) in examples("effect") {
        named(&truth, 0, &found);
        // In a small workspace growth is a motion of the frame, and a scale of the joints one of the readings.
        let twin = |name: &str| matches!(name, "thermal.frame" | "instrument.scale");
        assert!(found.causes.len() == 1, "{truth}: {}", said(&found));
        assert!(found.causes[0].tied_with.iter().all(|r| twin(&r.effect)), "{truth}: {}", said(&found));
    }
}

#[test]
fn both_effects_of_the_examples_are_named() {
    for (truth, found) in examples("pair") {
        named(&truth, 0, &found);
        named(&truth, 1, &found);
        assert_eq!(found.causes.len(), 2, "{truth}: {}", said(&found));
    }
}

#[test]
fn nothing_is_found_in_the_examples_without_an_effect() {
    for (truth, found) in examples("null") {
        assert!(found.verdict == Verdict::Clean && found.outlier_rows.is_empty(), "{truth}: {}", said(&found));
        assert!(found.noise_varies.is_none(), "{truth}: {}", said(&found));
    }
}

#[test]
fn what_no_name_explains_is_found_where_it_is() {
    for (truth, found) in examples("unknown") {
        let unknown = found.unknown.as_ref().unwrap_or_else(|| panic!("{truth}: {}", said(&found)));
        let covariates = truth["covariates"].as_array().unwrap();
        let right = covariates.iter().any(|c| c.as_str() == unknown.covariate.as_deref());
        assert!(found.verdict == Verdict::Unknown && right, "{truth}: {}", said(&found));
        assert_eq!(unknown.leg, leg(&truth, 0), "{truth}: {}", said(&found));
    }
}

#[test]
fn misread_examples_are_told_how_to_read_them() {
    for (truth, found) in examples("misread") {
        let reading = found.misread.as_ref().map(|m| m.reading.as_str());
        assert!(found.verdict == Verdict::Misread && reading == truth["reading"].as_str(), "{truth}: {}", said(&found));
    }
}

fn positioner(axis: &str) -> String {
    format!(
        "name = \"secondary\"\ntype = \"pose\"\nlength_unit = \"um\"\nangle_unit = \"deg\"\ngravity_axis = \"{axis}\"\n"
    )
}

/// Nineteen rows of finite elements are one linear function of gravity and the digits of the table.
#[test]
fn finite_elements_of_a_mirror_are_a_linear_sag() {
    let Some(folder) = folder("telescope-hexapods") else { return };
    let table = std::fs::read_to_string(folder.join("m2_zenith_distance_fea.txt")).unwrap();
    let mut data = String::from("zenith_distance_deg,x_um,y_um,z_um,rx_deg,ry_deg,rz_deg\n");
    for line in table.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(cells.len(), 7, "{line}");
        data += &(cells.join(",") + "\n");
    }
    let found = asked(&positioner("y"), &data);
    assert_eq!(found.verdict, Verdict::Named, "{}", said(&found));
    let [cause] = &found.causes[..] else { panic!("{}", said(&found)) };
    assert_eq!(cause.effect, "sag.linear");
    let (before, after) = (found.before.position.unwrap(), found.after.position.unwrap());
    assert!(before > 1e-4 && after < 1e-11, "{before:.2e} m, {after:.2e} m");
}

/// A telescope on sky: the secondary hangs in springs, and whatever else there is comes second.
#[test]
fn a_secondary_mirror_on_sky_sags() {
    let Some(folder) = folder("mmt-hexapod") else { return };
    let answer = |name: &str| {
        let data = std::fs::read_to_string(folder.join(name)).unwrap();
        let files = Files::new(&positioner("x").replace("\"deg\"", "\"arcsec\""), &data);
        files.diagnosis()
    };
    let night = answer("elcoll_20170110_0.csv");
    assert_eq!(night.causes[0].effect, "sag.linear", "{}", said(&night));
    let short = answer("elcoll_20170110_1.csv");
    assert_eq!(short.verdict, Verdict::Named, "{}", said(&short));
    let [cause] = &short.causes[..] else { panic!("{}", said(&short)) };
    assert_eq!(cause.effect, "sag.linear");
    assert!(cause.parameters.iter().all(|p| p.sigma.is_none() || p.sigma < Some(1.0)), "{cause:?}");
}
