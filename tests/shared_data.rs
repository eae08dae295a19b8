//! Checks against reference data outside the project, found through the environment variable `PARACAL_DATA`.
//!
//! Without it they say so and pass; the bundled copies are tested elsewhere.
#![allow(clippy::unwrap_used)]

mod common;

use std::path::PathBuf;

use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};

fn folder(name: &str) -> Option<PathBuf> {
    let found = std::env::var_os("PARACAL_DATA").map(|root| PathBuf::from(root).join(name)).filter(|p| p.is_dir());
    if found.is_none() {
        eprintln!("skipped: PARACAL_DATA does not lead to {name}");
    }
    found
}

#[test]
fn the_hardpoint_reference_is_met_and_the_bundled_copies_are_the_same() {
    let Some(folder) = folder("hardpoint-reference") else { return };
    let machine = Machine::read(folder.join("mechanism.toml")).unwrap();
    let read = |name: &str| read_measurement(folder.join(name), &machine).unwrap().data;
    let identifier = LevenbergMarquardt::default();
    let options = CalibrationOptions::default();
    let mechanism = machine.mechanism.as_ref();
    let result = calibrate(mechanism, &read("exact.csv"), machine.workspace.as_ref(), &identifier, &options).unwrap();
    let (position, rotation) = common::errors_of(result.mechanism.as_ref(), &read("targets_exact.csv"));
    assert!(position <= 1e-12 && rotation <= 1e-10_f64.to_radians(), "{position:.2e} m, {rotation:.2e} rad");
    for (theirs, ours) in [
        ("exact.csv", "hardpoint-exact.csv"),
        ("noisy.csv", "hardpoint-noisy.csv"),
        ("targets_exact.csv", "hardpoint-targets.csv"),
        ("truth_errors_mm.csv", "hardpoint-errors.csv"),
    ] {
        let theirs = std::fs::read_to_string(folder.join(theirs)).unwrap();
        assert_eq!(theirs, common::text(&format!("examples/data/{ours}")));
    }
}
