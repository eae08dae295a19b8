//! `paracal new`: files to start from, which every other command accepts.

use paracal::files::example_files;

use crate::common::bench::{Bench, says, strings};

#[test]
fn the_file_of_each_kind_is_inspected_without_a_warning() {
    let bench = Bench::empty();
    assert_eq!(example_files().count(), 9);
    for example in example_files() {
        let printed = bench.done(&format!("new {}", example.kind));
        assert_eq!((printed.out.as_str(), printed.err.as_str()), (example.text, ""));
        bench.write("m.toml", &printed.out);
        let (seen, errors) = bench.json_and_warnings("inspect m.toml");
        assert!(errors.is_empty() && strings(&seen["warnings"]).is_empty(), "{}: {errors}{seen}", example.kind);
    }
}

#[test]
fn the_commands_that_a_file_names_next_work() {
    for example in example_files() {
        let bench = Bench::empty().with("m.toml", example.text);
        // Fewer candidates than by default, for time.
        bench.done("select m.toml -n 20 -o p.csv --candidates 100 --no-polish");
        bench.done("simulate m.toml --poses p.csv -o d.csv --error-sd tolerance --seed 1");
        let found = bench.json("calibrate m.toml d.csv -o c.toml");
        assert_eq!(found["trusted"], true, "{}: {found}", example.kind);
        bench.done("diagnose m.toml d.csv");
    }
}

#[test]
fn without_a_kind_they_are_listed() {
    let bench = Bench::empty();
    let message = bench.refuses("new", &["paracal new six-hardpoint > hexapod.toml"]);
    for example in example_files() {
        says(&message, &[example.kind, example.label]);
    }
    let message = bench.exits(2, "new hexapod").err;
    says(&message, &["'hexapod'", "six-hardpoint, rotary-stewart, rotary-delta"]);
}

#[test]
fn one_object_for_scripts() {
    let found = Bench::empty().json("new linear-delta");
    assert_eq!(found["type"], "linear-delta");
    assert!(found["text"].as_str().unwrap().contains("type = \"linear-delta\""));
}

#[test]
fn a_file_is_written_but_none_is_overwritten() {
    let bench = Bench::empty();
    let said = bench.done("new tripod-3rps -o tripod.toml").out;
    says(&said, &["tripod.toml written", "paracal inspect tripod.toml"]);
    assert_eq!(bench.text("tripod.toml"), bench.done("new tripod-3rps").out);
    assert_eq!(bench.json("new pose -o pose.toml")["output"], "pose.toml");
    bench.refuses("new pose -o tripod.toml", &["tripod.toml: exists already"]);
    bench.refuses("new pose -o nowhere/pose.toml", &["nowhere"]);
}
