//! The pages of `--report`: whole, self-contained, saying what the command says.

use crate::common;
use crate::common::bench::{Bench, NOISY, TABLE_5};
use paracal::diagnosis::{JointResiduals, Question, diagnose};

/// A call with `--report`: the page and what was printed.
fn report(bench: &Bench, call: &str) -> (String, String) {
    let printed = bench.done(&format!("{call} --quiet --report report.html"));
    (bench.text("report.html"), printed.out)
}

/// One element after the other is closed, nothing runs, nothing is fetched.
fn whole(page: &str) {
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    for no in ["<script", "javascript:", "http-equiv", "<link", "<img", "<iframe", "@import", "url(http", "NaN", "inf "]
    {
        assert!(!page.contains(no), "{no}");
    }
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
    let parsed = scraper::Html::parse_document(page);
    assert!(parsed.errors.is_empty(), "{:?}", parsed.errors);
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
    let bench = Bench::project();
    let call = "calibrate mechanisms/table5.toml examples/data/hardpoint-noisy.csv -o calibrated.toml";
    let (page, printed) = report(&bench, call);
    whole(&page);
    // The headline and the tiles say what is printed, in the units of a page.
    let last = printed.trim_end().lines().last().unwrap();
    let (before, after) = last.split_once(" -> ").unwrap();
    let (before, after) = (before.split("RMS ").nth(1).unwrap(), after.split(" (fitted)").next().unwrap());
    let [before, after] = [before, after].map(|shown| shown.replace(" um", " µm"));
    assert!(page.contains("(1 sigma over the workspace). 42 parameters from"), "{last}");
    assert!(page.contains(&format!("RMS position error {before} as given, {after} calibrated")), "{last}");
    assert!(page.contains(&format!("position error, as given</dt> <dd>{before}</dd>").replace("> <", "><")), "{last}");
    for shown in [
        "Errors row by row",
        "Deviations of the length parameters",
        "Convergence",
        "xA1",
        "h6",
        "stated noise",
        "Where in the workspace",
        "Residuals against the noise",
        "Leg by leg against the length of the leg",
        "Correlations of the identified parameters",
        "base in the tracker's frame",
        "<th scope=\"col\">deviation</th>",
        "times as long as the errors",
        "hardpoint-noisy.csv",
    ] {
        assert!(page.contains(shown), "{shown}");
    }
    assert!(bench.has("calibrated.toml"));
}

#[test]
fn a_diagnosis_is_shown_with_its_causes_limits_and_gain() {
    let bench = Bench::project();
    let call = "diagnose mechanisms/table5-telescope.toml examples/data/hardpoint-two-causes.csv";
    let (page, printed) = report(&bench, call);
    whole(&page);
    assert!(printed.contains("NAMED: scale.per_leg and drift.leg at leg 1."));
    for shown in [
        "NAMED: scale.per_leg and drift.leg at leg 1.",
        "scale6",
        "Detection limits",
        "held out",
        "Added-variable plots",
        "Leg by leg against time",
        "Leg by leg against the temperature of the leg",
        "Leg by leg against the elevation",
        "leg named by a cause",
        "Leg 1 crept by 17.2 µm in the course of the run, towards shorter: check its encoder",
        "most of all leg 6, by 898 ppm less than commanded",
        "What was recorded during the run",
        "Squares on the ground are",
    ] {
        assert!(page.contains(shown), "{shown}");
    }
}

#[test]
fn a_creeping_leg_is_seen_in_its_strip_and_gone_with_its_cause() {
    let machine = common::machine("table5-telescope");
    let measurement = common::data("hardpoint-two-causes", &machine);
    let found = diagnose(&Question::of(&machine, &measurement.data)).unwrap();
    let creep = found.causes.iter().find(|c| c.effect == "drift.leg").unwrap();
    assert_eq!(creep.leg, Some(0));
    // Slope of the residual of leg 1 over the run, m.
    let slope = |of: fn(&JointResiduals) -> &Vec<f64>| {
        let n = found.residuals.len() as f64;
        let at = |k: usize| k as f64 / (n - 1.0) - 0.5;
        let ys = found.residuals.iter().map(|r| of(r)[0]);
        let sum = ys.enumerate().fold((0.0, 0.0), |(xy, xx), (k, y)| (xy + at(k) * y, xx + at(k) * at(k)));
        sum.0 / sum.1
    };
    let (before, after) = (slope(|r| &r.before), slope(|r| &r.after));
    let whole = creep.parameters[0].value;
    assert!((before / whole - 1.0).abs() < 0.15, "{before:e} of {whole:e}");
    // The slope of the noise alone has a sigma of 6 % of the creep.
    assert!((after / whole).abs() < 0.2, "{after:e} of {whole:e}");
}

#[test]
fn a_choice_is_shown_with_its_bound_and_the_poses() {
    let bench = Bench::project();
    let call = "select mechanisms/table5.toml -n 12 --candidates 100 -o poses.csv";
    let (page, _) = report(&bench, call);
    whole(&page);
    for shown in [
        "Measure the 12 poses of",
        "certified to reach",
        "Where the poses lie",
        "platform at the poses",
        "no set of these candidates is better",
        "predicted position error, RMS",
    ] {
        assert!(page.contains(shown), "{shown}");
    }
}

#[test]
fn an_exhibit_of_the_paper_is_shown() {
    let bench = Bench::project();
    let (page, _) = report(&bench, "reproduce figure8 --out paper --draws 40 --lists 3 --candidates 200");
    whole(&page);
    assert!(page.contains("figure8: ") && page.contains("40 noise draws"));
}

#[test]
fn what_repeats_a_page_holds_the_hash_of_each_input_and_the_seed() {
    // The hash is what sha256sum says of the bundled file.
    let bench = Bench::bundled().with("it's measured.csv", NOISY);
    bench.done(&["calibrate", "m.toml", "it's measured.csv", "-o", "c.toml", "--seed", "7", "--report", "r.html"]);
    let page = bench.text("r.html");
    for shown in [
        "0563701c3823dd26331ccde41be664346a73e39dc298708e1bad56168759eb9a",
        "<dt>seed</dt><dd>7</dd>",
        "it'\\''s measured.csv",
    ] {
        assert!(page.contains(shown), "{shown}");
    }
}

#[test]
fn an_evaluation_is_shown_and_inputs_are_never_written_over() {
    let bench = Bench::project();
    let call = "evaluate mechanisms/table5.toml examples/data/hardpoint-targets.csv";
    let (page, _) = report(&bench, call);
    whole(&page);
    assert!(page.contains("150 rows"));
    for command in ["evaluate", "diagnose"] {
        let call = "mechanisms/table5.toml examples/data/hardpoint-targets.csv --report mechanisms/table5.toml";
        bench.refuses(&format!("{command} {call}"), &["is also an input"]);
        assert_eq!(bench.text("mechanisms/table5.toml"), TABLE_5);
    }
}

#[test]
fn what_the_command_warns_of_stands_on_its_page() {
    let bench = Bench::project();
    let call = "evaluate examples/data/secondary-hexapod.toml examples/data/secondary-campaign.csv";
    let (page, _) = report(&bench, call);
    whole(&page);
    assert!(page.contains("The errors are as large as the mechanism"));
    assert!(page.contains("class=\"verdict drawn\""));
}

#[test]
fn a_gross_row_is_marked_and_hides_nothing() {
    let mut lines: Vec<String> = NOISY.lines().map(str::to_owned).collect();
    let row = lines.iter().position(|l| l.starts_with("leg1_mm")).unwrap() + 4;
    let mut cells: Vec<String> = lines[row].split(',').map(str::to_owned).collect();
    cells[6] = (cells[6].parse::<f64>().unwrap() + 0.5).to_string();
    lines[row] = cells.join(",");
    let bench = Bench::new(TABLE_5, lines.join("\n"));
    let call = "calibrate m.toml d.csv -o c.toml --identifier robust";
    let (page, _) = report(&bench, call);
    whole(&page);
    let after =
        |name: &str| page.split(&format!("{name}</dt><dd>")).nth(1).unwrap().split('<').next().unwrap().to_owned();
    assert!(after("excluded from these numbers").split(", ").any(|row| row == "3"));
    assert!(page.contains("looks like a gross error"));
    // Without that row the error is that of the noise, and not a tenth of a millimetre.
    let of = after("<dt>position error, calibrated");
    let (value, unit) = of.split_once(' ').unwrap();
    assert!(unit == "µm" && value.parse::<f64>().unwrap() < 3.0, "{of}");
}

#[cfg(unix)]
#[test]
fn a_name_that_is_no_text_is_shown_as_well_as_it_goes() {
    use std::os::unix::ffi::OsStrExt;
    let bench = Bench::bundled();
    let data = std::ffi::OsStr::from_bytes(b"d\xff.csv");
    std::fs::write(bench.path().join(data), NOISY).unwrap();
    let mut command = bench.command("evaluate m.toml --report page.html");
    assert_eq!(command.arg(data).output().unwrap().status.code(), Some(0));
    whole(&bench.text("page.html"));
}
