//! Choosing poses.

use super::{Row, all_are_refused, file, row, some_poses, with_stroke, without_tolerance};
use crate::common::bench::TABLE_5;

const SELECT: &str = "select m.toml -o p.csv";

fn with(name: &'static str, options: &str, parts: &[&str]) -> Row {
    row(name, [], format!("{SELECT} {options}"), parts.iter().copied())
}

#[test]
fn numbers_and_names() {
    all_are_refused(&[
        with("too few poses", "-n 6", &["6 poses give 36 rows for 42", "o1 = 0", "at least 7"]),
        with("no poses", "-n 0", &["-n 0", "at least one"]),
        row(
            "no more poses than given",
            [file("g.csv", some_poses(3))],
            format!("{SELECT} -n 3 --given g.csv"),
            ["3 poses are given", "-n"],
        ),
        with("unknown index", "--index o6", &["o6", "o1", "pose-error"]),
        with("unknown selector", "--selector best", &["best", "tabu-detmax"]),
        with("unknown scaling", "--scaling metres", &["metres", "whitened", "paper"]),
    ]);
}

#[test]
fn requirements() {
    let require = |name, what: &str, parts: &[&str]| {
        with(name, &format!("--candidates 50 --no-polish --no-corners --require {what}"), parts)
    };
    all_are_refused(&[
        require(
            "requirement that cannot be met",
            "0.01um",
            &["50 poses are predicted", "does not meet", "times as precisely"],
        ),
        require("requirement in words", "fast", &["'fast'", "2um", "0.5arcsec"]),
        require("two lengths", "1um,2um", &["one length and one angle"]),
        require("requirement of zero", "0um", &["'0um' must be positive"]),
        require("requirement and number", "1um -n 20", &["--require", "-n"]),
    ]);
}

#[test]
fn mechanisms_that_do_not_say_enough() {
    let bare = |name, options: &str, parts: &[&str]| {
        let bare = file("m.toml", without_tolerance());
        row(name, [bare], format!("{SELECT} {options}"), parts.iter().copied())
    };
    all_are_refused(&[
        row(
            "no workspace",
            [file("m.toml", TABLE_5.split("[workspace]").next().unwrap())],
            SELECT,
            ["m.toml", "[workspace]"],
        ),
        bare("whitened without tolerance", "--scaling whitened", &["[tolerance]", "xA1", "--scaling paper"]),
        bare("pose error without tolerance", "--index pose-error", &["pose-error", "[tolerance]"]),
        bare("requirement without tolerance", "--require 1um", &["[noise] and [tolerance]"]),
        row(
            "no feasible candidate",
            [file("m.toml", with_stroke("[799.0, 800.0]"))],
            format!("{SELECT} --candidates 3 --selector random -n 3 --index o3 --quiet"),
            ["m.toml", "none of 600", "600 need a joint outside its stroke", "make the workspace smaller"],
        ),
    ]);
}

#[test]
fn lists() {
    let lists = |name, call: &str, parts: &[&str]| {
        let lists = [file("list.csv", some_poses(5)), file("empty.csv", some_poses(0))];
        row(name, lists, call, parts.iter().copied())
    };
    let far = some_poses(1) + "1e9,0.0,0.0,0.0,0.0,0.0\n";
    all_are_refused(&[
        lists(
            "more poses than candidates",
            "select m.toml -o p.csv -n 9 --candidates list.csv",
            &["9 poses are requested", "only 5 candidates"],
        ),
        lists("list without a row", "select m.toml -o p.csv --candidates empty.csv", &["empty.csv", "no data row"]),
        lists("missing list", "select m.toml -o p.csv --candidates missing.csv", &["missing.csv"]),
        lists(
            "no candidates",
            "select m.toml -o p.csv --candidates 0 --no-corners",
            &["--candidates 0", "nothing to choose"],
        ),
        lists("negative number of candidates", "select m.toml -o p.csv --candidates -5", &["-5"]),
        lists("over the list", "select m.toml -o list.csv --candidates list.csv", &["list.csv", "input"]),
        lists("over the mechanism", "select m.toml -o m.toml", &["m.toml", "input"]),
        lists("missing given poses", "select m.toml -o p.csv --given missing.csv", &["missing.csv"]),
        row(
            "candidate out of reach",
            [file("far.csv", far)],
            "select m.toml -o p.csv -n 9 --candidates far.csv",
            ["9 poses are requested", "only 1 candidates"],
        ),
    ]);
}

#[test]
fn resolutions() {
    all_are_refused(&[
        with("resolution without unit", "--resolution 3", &["--resolution 3", "1um"]),
        with("resolution of zero", "--resolution 0um", &["--resolution 0um", "positive"]),
        with("resolution of angles for lengths", "--resolution 1arcsec -n 8", &["--resolution 1arcsec", "lengths"]),
        with("unknown order", "--order sorted", &["sorted", "random", "given"]),
    ]);
}
