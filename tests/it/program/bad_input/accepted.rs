//! What is unusual and no reason to refuse: it is said, and the work is done.

use std::process::Output;

use super::mechanism_files::with_a_shared_anchor;
use super::{CALIBRATE, poses, replaced, with_stroke, without_tolerance};
use crate::common::bench::{Bench, NOISY, TABLE_5};

/// The bundled case with another mechanism and the list of its poses.
fn bench(mechanism: String) -> Bench {
    let super::Entry(name, super::Content::Bytes(list)) = poses() else { unreachable!() };
    Bench::new(mechanism, NOISY).with(name, list)
}

/// The exit code of a call about joints outside their strokes: they are not to be commanded.
fn code(call: &str) -> i32 {
    if call.starts_with("compensate") { 3 } else { 0 }
}

/// Requires that a call succeeds and adds only these files.
#[track_caller]
fn writes(bench: &Bench, call: &str, files: &[&str]) -> Output {
    writes_and_exits(0, bench, call, files)
}

#[track_caller]
fn writes_and_exits(expected_code: i32, bench: &Bench, call: &str, files: &[&str]) -> Output {
    let mut expected: Vec<String> = bench.listing().into_keys().chain(files.iter().map(|f| (*f).into())).collect();
    expected.sort();
    expected.dedup();
    let output = bench.run(call);
    assert_eq!(output.status.code(), Some(expected_code), "{call}: {}", stderr(&output));
    assert_eq!(bench.listing().into_keys().collect::<Vec<_>>(), expected, "{call}");
    output
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn shared_anchors_that_are_stated() {
    let stated = replaced(&with_a_shared_anchor(), "angle_unit", "shared_anchors = true\nangle_unit");
    writes(&bench(stated), "compensate m.toml p.csv -o lengths.csv", &["lengths.csv"]);
}

#[test]
fn rows_without_a_reading_cannot_be_held_out() {
    // Four of the five folds leave the only measured row; the fifth leaves nothing to fit.
    let line = |(k, line): (usize, &str)| match k {
        0 | 1 => format!("{line}\n"),
        _ => line.split(',').take(6).collect::<Vec<_>>().join(",") + ",,,,,,\n",
    };
    let text: String = NOISY.lines().enumerate().map(line).collect();
    // One row says too little of 42 parameters to be trusted; the result is written all the same.
    let bench = Bench::new(TABLE_5, text);
    let shown = bench.exits(3, CALIBRATE).out;
    assert!(shown.contains("not held out") && shown.contains("Do not trust") && bench.has("o.toml"), "{shown}");
}

#[test]
fn lengths_outside_the_strokes_are_warned_of() {
    let bench = bench(with_stroke("[700.0, 900.0]"));
    let output = writes(&bench, CALIBRATE, &["o.toml"]);
    assert!(stderr(&output).contains("warning: joints outside their stroke in data row 0"), "{}", stderr(&output));
    let output = writes_and_exits(3, &bench, "compensate m.toml p.csv -o o.csv", &["o.csv"]);
    assert!(
        stderr(&output).contains("warning: data row 0: leg1 would be 513.616 mm, outside its stroke 700.000 to 900")
    );
    let output = writes(&bench, "simulate m.toml --poses p.csv -o s.csv", &["s.csv"]);
    assert!(stderr(&output).contains("warning: joints outside their stroke in data row 0, 1"));
}

#[test]
fn selections_without_tolerance() {
    let output = writes(&bench(without_tolerance()), "select m.toml -o o.csv --candidates 30 --no-polish", &["o.csv"]);
    assert!(stderr(&output).contains("mm and rad"), "{}", stderr(&output));
}

/// Calls that succeed with warnings.
fn warned() -> (Bench, [&'static str; 3]) {
    let calls = [CALIBRATE, "compensate m.toml p.csv -o o.csv", "simulate m.toml --poses p.csv -o s.csv"];
    (bench(with_stroke("[700.0, 900.0]")), calls)
}

#[test]
fn json_is_one_object_also_with_warnings() {
    let (bench, calls) = warned();
    for call in calls.into_iter().chain(["evaluate m.toml d.csv"]) {
        let printed = bench.exits(code(call), &format!("{call} --json"));
        let object: serde_json::Value = serde_json::from_str(&printed.out).unwrap();
        assert_eq!(printed.err.contains("warning: "), !call.starts_with("evaluate"), "{call}");
        assert!(object.is_object(), "{call}");
    }
}

#[test]
fn quiet_silences_warnings() {
    let (bench, calls) = warned();
    for call in calls {
        let printed = bench.exits(code(call), &format!("{call} --quiet"));
        assert!(printed.err.is_empty(), "{call}: {}", printed.err);
        assert!(!printed.out.is_empty(), "{call}");
    }
}

#[test]
fn readers_that_went_away_do_no_harm() {
    let (bench, calls) = warned();
    for call in calls {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let status = bench.command(call).stdout(writer.try_clone().unwrap()).stderr(writer).status().unwrap();
        assert_eq!(status.code(), Some(code(call)), "{call}");
    }
    for file in ["o.toml", "o.csv", "s.csv"] {
        assert!(bench.has(file), "{file}");
    }
}
