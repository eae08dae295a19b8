//! Kinds of reading: a simulated campaign of one is read back, and what was identified with it is written.

use crate::common;
use crate::common::bench::Bench;

use nalgebra::Vector3;
use paracal::files::Machine;
use paracal::measurement::TargetPoint;
use std::path::Path;

const PLACES: [(&str, [f64; 3]); 4] = [
    ("p1", [1300.0, 0.0, 80.0]),
    ("ball", [-600.0, 1100.0, 80.0]),
    ("p3", [-600.0, -1100.0, 100.0]),
    ("p4", [0.0, 200.0, 900.0]),
];

/// The mechanism of Table 5 with targets, of which `unknown` has no place.
fn mechanism(unknown: &str) -> String {
    let place = |name: &str, p: [f64; 3]| if name == unknown { String::new() } else { format!("platform = {p:?}\n") };
    let target = |(name, p): &(&str, [f64; 3])| format!("\n[[target]]\nname = \"{name}\"\n{}", place(name, *p));
    common::text("mechanisms/table5.toml") + &PLACES.iter().map(target).collect::<String>()
}

#[test]
fn simulated_targets_are_calibrated_and_an_unknown_place_is_written_into_its_entry() {
    let bench = Bench::new(mechanism(""), "");
    bench.done("select m.toml -n 40 -o p.csv --selector random --candidates 100");
    bench.done("simulate m.toml --poses p.csv -o d.csv --error-sd 0.3mm --measure targets --seed 3");
    let data = bench.text("d.csv");
    let header = data.lines().find(|l| !l.starts_with('#')).unwrap();
    assert!(
        header.ends_with(
            "leg6_mm,p1x_mm,p1y_mm,p1z_mm,ballx_mm,bally_mm,ballz_mm,p3x_mm,p3y_mm,p3z_mm,p4x_mm,p4y_mm,p4z_mm"
        ),
        "{header}"
    );
    let found = bench.json("calibrate m.toml d.csv -o c.toml");
    assert_eq!((&found["trusted"], found["measurement_parameters"].as_array().unwrap().len()), (&true.into(), 0));

    bench.write("u.toml", mechanism("ball") + "\n[[target]]\nname = \"spare\"\nplatform = [1.0, 2.0, 3.0]\n");
    let found = bench.done("calibrate u.toml d.csv -o cu.toml").out;
    assert!(found.contains("\nIdentified target coordinates\n"), "{found}");
    let written = Machine::from_text(&bench.text("cu.toml"), Path::new("cu.toml")).unwrap().targets;
    let names: Vec<&str> = written.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["p1", "ball", "p3", "p4", "spare"]);
    let off = |(t, (_, p)): (&TargetPoint, &(&str, [f64; 3]))| (t.platform.unwrap() - 1e-3 * Vector3::from(*p)).norm();
    let off: Vec<f64> = written.iter().zip(&PLACES).map(off).collect();
    // The noise of a coordinate is 1 um, and 40 poses see the target.
    assert!(off[1] < 3e-6 && off[1] > 0.0 && off[0].max(off[2]).max(off[3]) < 1e-15, "{off:?}");
    assert!((written[4].platform.unwrap() - Vector3::new(1e-3, 2e-3, 3e-3)).norm() < 1e-15);
}

#[test]
fn targets_without_a_place_are_not_simulated() {
    let bench = Bench::new(mechanism("ball"), "");
    bench.write("none.toml", common::text("mechanisms/table5.toml"));
    bench.write("p.csv", "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n0,0,480,0,0,0\n");
    let call = |file: &str| format!("simulate {file} --poses p.csv -o d.csv --measure targets");
    bench.refuses(&call("m.toml"), &["m.toml", "[[target]] 'ball'", "has no place"]);
    bench.refuses(&call("none.toml"), &["none.toml", "[[target]]", "there is none"]);
    assert!(bench.text("d.csv").is_empty());
}
