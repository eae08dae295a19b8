//! The pages of `--report`: whole, self-contained, saying what the command says.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::path::Path;
use std::process::Command;

use assert_cmd::cargo::cargo_bin;

/// Runs the program in the project's folder with `--report`; the page and what was printed.
fn report(arguments: &[&str], folder: &Path) -> (String, String) {
    let path = folder.join("report.html");
    let output = Command::new(cargo_bin!("paracal"))
        .args(arguments)
        .arg("--quiet")
        .arg("--report")
        .arg(&path)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (std::fs::read_to_string(path).unwrap(), String::from_utf8(output.stdout).unwrap())
}

/// One element after the other is closed, nothing runs, nothing is fetched.
fn whole(page: &str) {
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    for no in ["<script", "javascript:", "http-equiv", "<link", "<img", "<iframe", "@import", "url(http", "NaN", "inf "]
    {
        assert!(!page.contains(no), "{no}");
    }
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
    // Every picture has a title and a text alternative.
    assert_eq!(page.matches("<svg").count(), page.matches("role=\"img\"").count());
    assert_eq!(page.matches("<svg").count(), page.matches("<desc").count());
    let ids: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let mut different = ids.clone();
    different.sort_unstable();
    different.dedup();
    assert_eq!(different.len(), ids.len(), "an id stands twice");
}

#[test]
fn a_calibration_is_shown_with_errors_parameters_and_what_repeats_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("calibrated.toml");
    let call =
        ["calibrate", "mechanisms/table5.toml", "examples/data/hardpoint-noisy.csv", "-o", out.to_str().unwrap()];
    let (page, printed) = report(&call, folder.path());
    whole(&page);
    let last = printed.trim_end().lines().last().unwrap();
    assert!(page.contains(&format!("The result can be trusted. {}", last.replace('>', "&gt;"))), "{last}");
    for shown in [
        "Errors row by row",
        "Deviations of the parameters",
        "Convergence",
        "xA1",
        "h6",
        "stated noise",
        "hardpoint-noisy.csv",
    ] {
        assert!(page.contains(shown), "{shown}");
    }
    assert!(out.exists());
}

#[test]
fn a_diagnosis_is_shown_with_its_causes_limits_and_gain() {
    let folder = tempfile::tempdir().unwrap();
    let call = ["diagnose", "mechanisms/table5-telescope.toml", "examples/data/hardpoint-two-causes.csv"];
    let (page, printed) = report(&call, folder.path());
    whole(&page);
    assert!(printed.contains("NAMED: scale.per_leg and drift.leg at leg 1."));
    for shown in
        ["NAMED: scale.per_leg and drift.leg at leg 1.", "What to do:", "scale6", "Detection limits", "held out"]
    {
        assert!(page.contains(shown), "{shown}");
    }
}

#[test]
fn an_evaluation_is_shown_and_inputs_are_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let call = ["evaluate", "mechanisms/table5.toml", "examples/data/hardpoint-targets.csv"];
    let (page, _) = report(&call, folder.path());
    whole(&page);
    assert!(page.contains("150 rows"));
    let copy = folder.path().join("table5.toml");
    std::fs::copy(common::path("mechanisms/table5.toml"), &copy).unwrap();
    let before = std::fs::read(&copy).unwrap();
    for command in ["evaluate", "diagnose"] {
        let data = common::path("examples/data/hardpoint-targets.csv");
        let output = Command::new(cargo_bin!("paracal"))
            .args([command, copy.to_str().unwrap(), &data, "--report", copy.to_str().unwrap()])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(std::fs::read(&copy).unwrap(), before);
    }
}
