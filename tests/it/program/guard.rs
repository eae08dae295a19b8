//! `compensate` guards the machine: what it cannot follow is marked and said.

use serde_json::Value;

use crate::common::bench::{Bench, TABLE_5, says, strings};

fn bench(mechanism: impl AsRef<[u8]>, poses: &str) -> Bench {
    let list = format!("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n{poses}");
    Bench::empty().with("m.toml", mechanism).with("p.csv", list)
}

/// The marks of the rows, in the object and in the table.
fn marks(bench: &Bench, code: i32) -> (Vec<String>, String) {
    let printed = bench.exits(code, "compensate m.toml p.csv -o l.csv --json");
    let shown: Value = serde_json::from_str(&printed.out).unwrap();
    let of_object: Vec<String> = strings(&shown["check"]).into_iter().map(str::to_owned).collect();
    let table = bench.text("l.csv");
    let mut lines = table.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').collect::<Vec<_>>());
    let k = lines.next().unwrap().iter().position(|name| *name == "check").unwrap();
    assert_eq!(lines.map(|cells| cells[k].to_owned()).collect::<Vec<_>>(), of_object);
    (of_object, printed.err)
}

#[test]
fn every_row_is_marked() {
    let stroke = TABLE_5.replacen("length = 800.0", "length = 800.0\nstroke = [760.0, 840.0]", 1);
    let poses = "0,0,476,0,0,0\n130,0,470,0,0,0\n0,0,560,0,0,0\n0,0,476,0,0,160\n0,0,-480,0,0,0\n";
    let (found, warnings) = marks(&bench(stroke, poses), 3);
    assert_eq!(found, ["ok", "outside-workspace", "outside-stroke", "not-reached", "not-reached"]);
    says(&warnings, &["data rows 1, 3 and 4: outside the [workspace]", "in x", "in z", "150 deg in rz"]);
    says(&warnings, &["data rows 3 and 4: not reached", "singularity"]);
    let (found, warnings) = marks(&bench(TABLE_5, "0,0,476,0,0,0\n130,0,470,0,0,0\n"), 3);
    assert_eq!(found, ["ok", "outside-workspace"]);
    says(&warnings, &["data row 1: outside the [workspace] and its margin of 5 %, by up to 30.0 mm in x"]);
}

#[test]
fn commands_that_can_be_followed_are_clear() {
    // A little beyond the edge is within the margin.
    let bench = bench(TABLE_5, "0,0,476,0,0,0\n100,-100,376,10,-10,10\n0,0,476,0,0,-10.2\n");
    let (shown, warnings) = bench.json_and_warnings("compensate m.toml p.csv -o l.csv");
    assert_eq!(strings(&shown["check"]), ["ok"; 3]);
    assert!(warnings.is_empty(), "{warnings}");
    assert!(!bench.text("l.csv").contains("check"));
}

#[test]
fn marks_are_no_condition() {
    let bench = bench(TABLE_5, "0,0,476,0,0,0\n130,0,470,0,0,0\n");
    bench.exits(3, "compensate m.toml p.csv -o l.csv");
    let (shown, warnings) = bench.json_and_warnings("evaluate m.toml l.csv");
    assert!(warnings.is_empty(), "{warnings}");
    assert!(strings(&shown["columns_not_used"]).is_empty());
}

#[test]
fn a_model_that_is_not_trusted_commands_by_force_only() {
    let untrusted = format!(
        "{TABLE_5}\n[calibration]\nprogram = \"paracal 0.1.0\"\nrows = 5\ntrusted = false\n\
         reasons = [\"5 poses leave 12 directions to the drawing\"]\npredicted = {{ position_m = 1e-5 }}\n"
    );
    let bench = bench(&untrusted, "0,0,476,0,0,0\n");
    let parts = ["m.toml: [calibration]", "trusted = false", "5 poses leave 12 directions", "--force"];
    bench.refuses("compensate m.toml p.csv -o l.csv", &parts);
    bench.done("compensate m.toml p.csv -o l.csv --force");
    bench.done("inspect m.toml");
    // What was said of the old geometry is kept with it, and not handed on to another.
    bench.done("convert m.toml -o same.toml");
    says(&bench.text("same.toml"), &["[calibration]", "trusted = false", "reasons = [\"5 poses"]);
    bench.refuses("compensate same.toml p.csv -o l2.csv", &parts[1..]);
    bench.write("d.csv", crate::common::bench::NOISY);
    bench.done("calibrate m.toml d.csv -o c.toml");
    assert!(!bench.text("c.toml").contains("trusted = false"));
}
