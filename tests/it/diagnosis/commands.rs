//! `diagnose` and `settle` as a user runs them: keys, files and exit codes, and answers to files that are not as they
//! should be.

use crate::common::bench::{Bench, SEED, names, strings, verdict};
use crate::common::hidden::cases::{Kind, draw};
use serde_json::Value;

/// Requires a number, or null where that is allowed.
#[track_caller]
fn number(value: &Value, null: bool) {
    assert!(value.is_f64() || value.is_u64() || (null && value.is_null()), "{value}");
}

#[test]
fn every_key_of_the_format_is_there_with_its_type() {
    let (bench, truth) = Bench::of(Kind::OneWithOutliers(4.0), 18);
    let found = bench.json("diagnose m.toml d.csv");
    assert_eq!(verdict(&found), "named");
    let cause = &found["causes"][0];
    assert_eq!((cause["effect"].as_str(), cause["leg"].as_u64()), (Some("step.leg"), truth.legs[0].map(|l| l as u64)));
    let parameters = cause["parameters"].as_array().unwrap();
    for parameter in parameters {
        assert!(parameter["name"].is_string() && parameter["unit"].is_string(), "{parameter}");
        number(&parameter["value"], false);
        number(&parameter["sigma"], true);
    }
    let row = parameters.iter().find(|p| p["name"] == "row").unwrap()["value"].as_u64().unwrap();
    assert!(row.abs_diff(truth.rows[0].unwrap() as u64) <= 1);
    for key in ["p_value", "evidence", "size_over_limit"] {
        number(&cause[key], false);
    }
    assert!(strings(&cause["tied_with"]).is_empty() && cause["tentative"].is_boolean());
    assert!(found["unknown"].is_null() && found["misread"].is_null() && found["noise_varies"].is_null());
    let rows: Vec<usize> =
        found["outlier_rows"].as_array().unwrap().iter().map(|r| r.as_u64().unwrap() as usize).collect();
    assert_eq!(rows, truth.outlier_rows);
    for key in ["position_before_m", "position_after_m", "rotation_before_rad", "rotation_after_rad"] {
        number(&found["gain"][key], false);
    }
    assert!((found["gain"]["noise_floor_position_m"].as_f64().unwrap() / 3_f64.sqrt() - 1e-6).abs() < 1e-15);
    for entry in found["not_found"].as_array().unwrap() {
        assert!(entry["effect"].is_string() && entry["unit"].is_string(), "{entry}");
        number(&entry["limit"], false);
    }
    assert!(strings(&found["not_testable"][0]["missing"]).len() == 1 && found["not_testable"][0]["effect"].is_string());
    let text = bench.done("diagnose m.toml d.csv").out;
    for part in
        ["NAMED: step.leg at leg", "what to do", "gross errors, left out: data rows", "held out, with the causes"]
    {
        assert!(text.contains(part), "'{part}' is not in:\n{text}");
    }
}

#[test]
fn the_other_verdicts_are_told_with_their_keys() {
    let (clean, _) = Bench::of(Kind::Null, 0);
    let found = clean.json("diagnose m.toml d.csv --noise-known");
    assert_eq!((verdict(&found), names(&found).len()), ("clean", 0));
    assert!(clean.done("diagnose m.toml d.csv").out.contains("CLEAN"));

    let (outside, truth) = Bench::of(Kind::Outside(5.0), 1);
    let found = outside.json("diagnose m.toml d.csv");
    assert_eq!((verdict(&found), found["unknown"]["covariate"].as_str()), ("unknown", Some("azimuth")), "{found}");
    assert_eq!(found["unknown"]["leg"].as_u64(), truth.legs[0].map(|leg| leg as u64));
    assert!(outside.done("diagnose m.toml d.csv").out.contains("UNKNOWN"));

    let (misread, _) = Bench::of(Kind::Misread, 18);
    let found: Value = serde_json::from_str(&misread.exits(3, "diagnose m.toml d.csv -o e.toml --json").out).unwrap();
    assert_eq!((verdict(&found), found["misread"]["reading"].as_str()), ("misread", Some("leg-order")));
    assert!(!misread.has("e.toml"));
    assert!(misread.exits(3, "diagnose m.toml d.csv").out.contains("MISREAD (leg-order)"));
    assert!(misread.exits(3, "settle m.toml d.csv -o x.csv").out.contains("misread") && !misread.has("x.csv"));
}

#[test]
fn the_extended_model_loads_again_and_leaves_the_noise() {
    for number in [1, 15, 18] {
        let (bench, truth) = Bench::of(Kind::One(10.0), number);
        let found = bench.json("diagnose m.toml d.csv -o extended.toml");
        assert_eq!(names(&found), [truth.effects[0].as_str()]);
        let rms = |mechanism: &str| {
            let errors = bench.json(&format!("evaluate {mechanism} d.csv"));
            errors["rms"]["position_m"].as_f64().unwrap()
        };
        // Without the effect the misfit is beyond chance, and calibration says so.
        bench.exits(3, "calibrate m.toml d.csv -o calibrated.toml");
        let (calibrated, extended) = (rms("calibrated.toml"), rms("extended.toml"));
        println!(
            "{:?} {calibrated:.3e} {extended:.3e} {} {}",
            truth.effects, found["residual_before"], found["residual_after"]
        );
        assert!(extended < 1.1 * 3_f64.sqrt() * 1e-6, "{:?}: {extended:.2e}", truth.effects);
        assert!(calibrated > 1.3 * extended, "{:?}: {calibrated:.2e}, {extended:.2e}", truth.effects);
        let after = found["residual_after"]["position_m"].as_f64().unwrap();
        assert!((extended / after - 1.0).abs() < 0.01, "{extended:.3e}, {after:.3e}");
        // Its own effects are looked for anew.
        let again = bench.json("diagnose extended.toml d.csv");
        assert_eq!(names(&again), names(&found));
    }
}

#[test]
fn what_the_extended_model_commands_is_what_led_to_the_measured_poses() {
    let (bench, _) = Bench::of(Kind::One(10.0), 1);
    bench.json("diagnose m.toml d.csv -o extended.toml");
    bench.exits(3, "calibrate m.toml d.csv -o calibrated.toml");
    let data = bench.text("d.csv");
    let lines: Vec<Vec<f64>> =
        data.lines().skip(1).map(|l| l.split(',').map(|c| c.parse().unwrap()).collect()).collect();
    // Time, six legs, the poses and their conditions.
    let poses = data.lines().map(|l| l.splitn(8, ',').last().unwrap().to_owned() + "\n");
    bench.write("p.csv", poses.collect::<String>());
    let miss = |mechanism: &str| {
        // Measured poses that are a little outside the workspace are marked, and the call ends with 3.
        let printed = bench.run(&format!("compensate {mechanism} p.csv -o lengths.csv --json --force")).stdout;
        let found: Value = serde_json::from_slice(&printed).unwrap();
        let lengths = found["lengths_m"].as_array().unwrap().iter();
        let squares = lengths
            .zip(&lines)
            .flat_map(|(row, line)| (0..6).map(move |i| (row[i].as_f64().unwrap() - 1e-3 * line[1 + i]).powi(2)));
        (squares.sum::<f64>() / (6 * lines.len()) as f64).sqrt()
    };
    let (calibrated, extended) = (miss("calibrated.toml"), miss("extended.toml"));
    println!("{calibrated:.2e} {extended:.2e}");
    // The noise of the poses, seen along the legs.
    assert!(extended < 2.5e-6 && calibrated > 1.5 * extended, "{calibrated:.2e} m, {extended:.2e} m");
}

#[test]
fn settle_writes_the_table_of_the_best_plan() {
    let (bench, _) = Bench::of(Kind::WarmUp(4.0), 0);
    let found = bench.json("settle m.toml d.csv -o extra.csv");
    assert_eq!(verdict(&found), "tied");
    let plans = found["measurements"].as_array().unwrap();
    let best = &plans[0];
    assert!(best["settles"].as_bool().unwrap() && best["weakest"].as_f64().unwrap() >= 10.0, "{best}");
    let rows = best["joints"].as_array().unwrap().len();
    assert_eq!(best["conditions"].as_array().unwrap().len(), rows);
    for pair in best["separations"].as_array().unwrap() {
        assert!(pair["effect"].is_string() && pair["rival"].is_string());
        number(&pair["separability"], false);
    }
    let present = plans.last().unwrap();
    assert!(!present["settles"].as_bool().unwrap() && present["joints"].as_array().unwrap().is_empty());
    // The table is a measurement file whose poses are those of the drawing.
    assert!(bench.text("extra.csv").contains("temp_leg6_degC"));
    let errors = bench.json("evaluate m.toml extra.csv");
    assert!(errors["rows"] == rows && errors["max"]["position_m"].as_f64().unwrap() < 1e-9, "{errors}");
    let text = bench.done("settle m.toml d.csv").out;
    let what = best["what"].as_str().unwrap();
    assert!(text.contains(&format!("Measure {what}: that separates every pair of rivals.")), "{text}");

    let (clean, _) = Bench::of(Kind::Null, 0);
    assert!(clean.done("settle m.toml d.csv -o x.csv").out.contains("no tie to settle") && !clean.has("x.csv"));
}

#[test]
fn noise_that_nobody_stated_is_not_known() {
    let case = draw(Kind::Null, SEED, 0).unwrap();
    let (from, to) = (case.mechanism.find("[noise]").unwrap(), case.mechanism.find("[platform]").unwrap());
    let mechanism = format!("{}{}", &case.mechanism[..from], &case.mechanism[to..]);
    let bench = Bench::new(&mechanism, &case.data);
    bench.refuses("diagnose m.toml d.csv --noise-known -o e.toml", &["--noise-known", "m.toml", "[noise]"]);
    let found = bench.json("diagnose m.toml d.csv");
    assert_eq!(verdict(&found), "clean", "{found}");
    assert!(found["gain"]["noise_floor_position_m"].is_null());
}
