//! Standard input and output, objects for scripts, and names that would play with the terminal.

use std::io::Write;
use std::process::Stdio;

use serde_json::Value;

use crate::common::bench::{Bench, NOISY, TABLE_5, number, says};

/// What a call prints when it is given this on standard input.
fn piped(bench: &Bench, call: &str, input: &str) -> (Option<i32>, String, String) {
    let mut command = bench.command(call);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_dash_is_standard_input_and_output() {
    let bench = Bench::bundled();
    bench.done("calibrate m.toml d.csv -o c.toml");
    let (code, out, err) = piped(&bench, "calibrate m.toml - -o -", NOISY);
    assert_eq!(code, Some(0), "{err}");
    assert_eq!(out, bench.text("c.toml"));
    says(&err, &["Trusted: poses to", "20 poses"]);
    let (code, out, err) = piped(&bench, "evaluate - d.csv --json", &out);
    assert_eq!(code, Some(0), "{err}");
    let evaluated: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(evaluated, bench.json("evaluate c.toml d.csv"));
    let (code, _, err) = piped(&bench, "calibrate - -", TABLE_5);
    assert_eq!(code, Some(2));
    says(&err, &["-: ", "standard input was read already"]);
    // Nothing of a result stands in a table that another program reads.
    let (_, list, _) = piped(&bench, "select m.toml -n 8 --candidates 100 --no-polish -o - --quiet", "");
    assert!(list.starts_with("leg1_mm,"), "{list}");
    assert_eq!(list.lines().filter(|l| !l.starts_with('#')).count(), 9);
}

#[test]
fn without_an_output_nothing_is_written() {
    let bench = Bench::bundled();
    let before = bench.listing();
    let shown = bench.done("calibrate m.toml d.csv");
    says(&bench.done("select m.toml -n 8 --candidates 100 --no-polish").out, &["Nothing was written", "-o poses.csv"]);
    assert_eq!(bench.listing(), before);
    assert_eq!(shown.out, bench.done("calibrate m.toml d.csv -o c.toml").out);
}

#[test]
fn scripts_get_an_object_whatever_happens() {
    let bench = Bench::bundled();
    for (call, part) in [
        ("calibrate m.toml missing.csv --json", "missing.csv: cannot be read"),
        ("calibrate d.csv m.toml --json", "name the mechanism file first"),
        ("calibrate m.toml m.toml --json", "name the mechanism file first"),
        ("calibrate m.toml --json", "<DATA>"),
        ("calibrate m.toml d.csv -o - --json", "standard output"),
        ("nonsense --json", "nonsense"),
    ] {
        let printed = bench.exits(2, call);
        let object: Value =
            serde_json::from_str(&printed.out).unwrap_or_else(|e| panic!("{call}: {e}: {}", printed.out));
        assert_eq!(object["exit"], 2, "{call}");
        assert!(object["error"].as_str().unwrap().contains(part), "{call}: {object}");
        assert!(printed.err.starts_with("error: "), "{call}: {}", printed.err);
    }
    // Help is no error.
    assert!(bench.done("calibrate --help --json").out.contains("Usage"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_an_error() {
    let bench = Bench::bundled();
    for call in
        ["calibrate m.toml d.csv --json", "evaluate m.toml d.csv", "inspect m.toml", "calibrate m.toml d.csv -o -"]
    {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = bench.command(call).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{call}");
        says(&String::from_utf8(output.stderr).unwrap(), &["cannot be written", "No space left"]);
    }
}

#[test]
fn names_do_not_play_with_the_terminal_and_are_kept() {
    let name = "a\\u001B[31mred\\nTrusted: poses to 1 nm.";
    let text = TABLE_5.replacen("name = \"Six-hardpoint positioner, Table 5\"", &format!("name = \"{name}\""), 1);
    assert!(text.contains(name));
    // A column without numbers is named in a warning.
    let line = |(k, line): (usize, &str)| format!("{},{line}\n", if k == 0 { "\u{1b}[2Jx" } else { "remark" });
    let bench = Bench::new(&text, NOISY.lines().enumerate().map(line).collect::<String>());
    for call in [
        "inspect m.toml",
        "convert m.toml -o c.toml",
        "convert m.toml -o robot.urdf",
        "inspect robot.urdf",
        "calibrate m.toml d.csv",
        "evaluate m.toml d.csv",
        "select m.toml -n 7 --candidates 50 --no-polish",
    ] {
        let printed = bench.done(call);
        for shown in [&printed.out, &printed.err] {
            assert!(!shown.chars().any(|c| c.is_control() && c != '\n'), "{call}: {shown:?}");
        }
        // The name promises nothing on a line of its own.
        let promised = printed.out.lines().any(|line| line.starts_with("Trusted"));
        assert_eq!(promised, call.starts_with("calibrate"), "{call}: {}", printed.out);
    }
    let of = |file: &str| bench.text(file).parse::<toml::Table>().unwrap()["name"].as_str().unwrap().to_owned();
    assert_eq!(of("c.toml"), of("m.toml"));
    says(&bench.text("robot.urdf"), &["a\\u{1b}[31mred"]);
}

/// The object has what the text shows, and what a script needs to look further.
#[test]
fn residuals_and_deviations_are_those_of_the_result() {
    let bench = Bench::bundled();
    bench.write("d.csv", NOISY.replacen(",-4.697230491850", ",", 1));
    let found = bench.json("calibrate m.toml d.csv --covariance v.csv");
    let rows = found["residuals"].as_array().unwrap();
    assert_eq!(rows.len(), 20);
    assert!(rows.iter().all(|row| row.as_array().unwrap().len() == 6));
    assert_eq!(rows.iter().flat_map(|row| row.as_array().unwrap()).filter(|v| v.is_null()).count(), 1);
    // The errors of whole positions are those that are printed.
    let squares = |row: &Value| (0..3).map(|k| row[k].as_f64().unwrap().powi(2)).sum::<f64>();
    let whole: Vec<f64> = rows.iter().filter(|row| (0..3).all(|k| row[k].is_f64())).map(squares).collect();
    let rms = (whole.iter().sum::<f64>() / whole.len() as f64).sqrt();
    assert!((rms / number(&found, &["rms_after", "position_m"]) - 1.0).abs() < 1e-9, "{rms}");
    let parameters = found["parameters"].as_array().unwrap();
    for p in parameters {
        // These data are in the frame of the drawing.
        let by_hand = number(p, &["value"]) - number(p, &["nominal"]);
        assert!((number(p, &["deviation"]) - by_hand).abs() < 1e-12, "{p}");
    }
    let covariance = found["covariance"].as_array().unwrap();
    for (k, p) in parameters.iter().enumerate() {
        let sigma = covariance[k][k].as_f64().unwrap().sqrt();
        assert!((sigma / number(p, &["sigma"]) - 1.0).abs() < 1e-9, "{p}");
    }
    assert_eq!(found["trusted_to"]["position_m"], found["predicted"]["rms"]["position_m"]);
    assert_eq!(found["misfit"]["chi_square"], found["chi_square"]);
    assert!(found.get("covariance").is_some() && bench.json("calibrate m.toml d.csv").get("covariance").is_none());
}
