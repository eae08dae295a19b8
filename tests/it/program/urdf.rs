//! The program with URDF files: every command from a URDF, `convert`, and what is refused.

use crate::common::bench::{Bench, Printed, TABLE_5};
use crate::common::urdf_robots::{Style, expected, pairs, robot};
use serde_json::Value;

const SIDE: &str = "length_unit = \"mm\"\nangle_unit = \"deg\"\n[workspace]\nposition = [20.0, 20.0, 20.0]\n\
                    rotation = [3.0, 3.0, 3.0]\n[tolerance]\nanchor = 0.5\n[noise]\nposition = 0.001\nrotation = 0.0002\n";

fn with_urdf(text: &str) -> Bench {
    Bench::empty().with("r.urdf", text)
}

fn bench() -> Bench {
    with_urdf(&robot(Style::Frames).text()).with("r.toml", SIDE)
}

#[test]
fn a_urdf_goes_through_every_command_with_columns_by_joint_name() {
    let b = bench();
    let e = expected();
    let seen = b.json("inspect r.urdf");
    let names: Vec<&str> = seen["joints"].as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
    assert_eq!(names, e.joint.each_ref().map(String::as_str));
    b.done("select r.urdf -o poses.csv -n 20 --candidates 300 --seed 1");
    b.done("simulate r.urdf --poses poses.csv -o data.csv --error-sd 0.2mm --truth truth.urdf --seed 3");
    assert!(b.has("truth.toml"));

    // The same data with joint coordinates instead of lengths.
    let data = b.text("data.csv");
    let mut lines: Vec<String> = data.lines().map(str::to_owned).collect();
    let header = lines.iter().position(|l| l.contains("leg1_mm")).unwrap();
    let first = lines[header].split(',').position(|c| c == "leg1_mm").unwrap();
    for (n, line) in lines.iter_mut().enumerate().skip(header).filter(|(_, l)| !l.starts_with('#')) {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        for k in 0..6 {
            cells[first + k] = if n == header {
                format!("{}_m", e.joint[k])
            } else {
                let q = cells[first + k].parse::<f64>().unwrap() / 1000.0 - e.length[k];
                format!("{:?}", if e.reversed[k] { -q } else { q })
            };
        }
        *line = cells.join(",");
    }
    b.write("joints.csv", lines.join("\n") + "\n");
    let by_length = b.json("calibrate r.urdf data.csv -o by_length.toml");
    let by_joint = b.json("calibrate r.urdf joints.csv -o by_joint.toml");
    let value = |r: &Value, k: usize| r["parameters"][k]["value"].as_f64().unwrap();
    for k in 0..42 {
        assert!((value(&by_length, k) - value(&by_joint, k)).abs() < 1e-9, "parameter {k}");
    }
    // The calibrated file still reads the same data, as TOML and as URDF.
    let rms = |mechanism: &str| {
        let errors = b.json(&format!("evaluate {mechanism} joints.csv"));
        errors["rms"]["position_m"].as_f64().unwrap()
    };
    b.done("calibrate r.urdf joints.csv -o calibrated.urdf");
    assert!(rms("by_joint.toml") < 1e-5 && rms("r.urdf") > 1e-5);
    assert!((rms("calibrated.urdf") - rms("by_joint.toml")).abs() < 1e-10);
    b.done("compensate calibrated.urdf poses.csv -o lengths_urdf.csv");
    b.done("compensate by_joint.toml poses.csv -o lengths_toml.csv");
    let rows = |name: &str| -> Vec<f64> {
        let text = b.text(name);
        let cells = text.lines().filter(|l| !l.starts_with('#')).skip(1).flat_map(|l| l.split(',')).collect::<Vec<_>>();
        cells.iter().filter_map(|c| c.parse().ok()).collect()
    };
    let (urdf, toml) = (rows("lengths_urdf.csv"), rows("lengths_toml.csv"));
    assert!(urdf.len() == toml.len() && urdf.iter().zip(&toml).all(|(a, b)| (a - b).abs() < 1e-9));
}

#[test]
fn the_options_close_what_the_file_leaves_open() {
    let b = with_urdf(&robot(Style::Pairs).text());
    let close: String = pairs().iter().map(|[a, b]| format!(" --close {a}={b}")).collect();
    b.refuses("inspect r.urdf", &["NoLoopClosures", "--close strut_A_tip=strut_A_seat"]);
    let seen = b.json(&format!("inspect r.urdf{close}"));
    assert!((seen["legs"][3]["length"].as_f64().unwrap() - expected().length[3]).abs() < 1e-12);
    b.done(&format!("convert r.urdf -o closed.urdf{close} --quiet"));
    b.done("inspect closed.urdf");
    b.refuses(&format!("inspect r.urdf{close} --platform-link nowhere"), &["UnknownLink", "nowhere"]);
    b.refuses(&format!("inspect r.urdf{close} --home drive_a=3deg"), &["BadSetting", "drive_a"]);
    b.refuses("inspect r.urdf --close a", &["--close a", "="]);
    b.refuses("inspect r.urdf --home drive_a=long", &["--home drive_a=long"]);
    b.write("m.toml", TABLE_5);
    b.refuses("inspect m.toml --base-link base", &["m.toml", "URDF"]);
    b.write("side.toml", "urdf = \"r.urdf\"\n[nosie]\nposition = 1.0\n");
    b.refuses("inspect side.toml", &["side.toml", "nosie"]);
    b.write("r.toml", "[noise]\nposition = -1.0\nrotation = 1.0\n");
    b.refuses(&format!("inspect r.urdf{close}"), &["r.toml", "[noise] position"]);
}

#[test]
fn the_side_file_is_an_input_like_the_urdf() {
    let b = bench();
    b.refuses("convert r.urdf -o r.toml", &["r.toml", "also an input"]);
    b.write("poses.csv", "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n20,15,710,2,3,-6\n");
    b.refuses("simulate r.urdf --poses poses.csv -o r.toml", &["r.toml", "also an input"]);
    b.refuses("compensate r.urdf poses.csv -o r.toml", &["r.toml", "also an input"]);
}

#[test]
fn convert_goes_both_ways_and_loses_nothing_silently() {
    let b = bench();
    b.done("convert r.urdf -o flat.toml");
    let shown = b.json("convert flat.toml -o again.urdf");
    assert_eq!((shown["output"].as_str(), shown["side_file"].as_str()), (Some("again.urdf"), Some("again.toml")));
    let legs = |name: &str| b.json(&format!("inspect {name}"))["legs"].clone();
    let (first, second) = (legs("r.urdf"), legs("again.urdf"));
    for k in 0..6 {
        for key in ["platform", "base"] {
            for axis in 0..3 {
                let off = first[k][key][axis].as_f64().unwrap() - second[k][key][axis].as_f64().unwrap();
                assert!(off.abs() < 1e-12);
            }
        }
    }
    b.refuses("convert r.urdf -o out.xml", &["out.xml", ".urdf", ".toml"]);
    b.refuses("convert r.urdf -o out", &["out", ".urdf"]);
    // The side file would be the input, and its workspace would be lost.
    b.write("m.toml", TABLE_5);
    b.refuses("convert m.toml -o m.urdf", &["m.toml", "input", "a different stem"]);
    // With nothing but units beside the legs, the URDF can stand alone.
    let bare = &TABLE_5[..TABLE_5.find("[workspace]").unwrap()];
    let bare = bare.replace("length = 800.0", "length = 800.0\nstroke = [700.0, 900.0]");
    b.write("bare.toml", &bare);
    let message = b.done("convert bare.toml -o bare.urdf").err;
    assert!(message.contains("has no side file") && b.text("bare.toml") == bare, "{message}");
    let message = b.done("inspect bare.urdf").err;
    assert!(message.contains("bare.toml is not used") && message.lines().count() == 1, "{message}");
    // A mechanism file that nobody named is not replaced.
    b.write("other.toml", TABLE_5);
    b.refuses("convert flat.toml -o other.urdf", &["other.toml", "of its own"]);
    // Nor is anything else that happens to be TOML, or a side file of another URDF.
    for (text, reason) in [
        ("[package]\nname = \"x\"\n", "not a side file of a URDF"),
        ("a = = 1\n", "cannot be read as TOML"),
        ("type = \"linear-delta\"\n", "of kind 'linear-delta'"),
        ("urdf = \"r.urdf\"\n", "belongs to 'r.urdf'"),
        ("name = \"x\"\n", "no URDF with its stem"),
    ] {
        b.write("other.toml", text);
        b.refuses("convert flat.toml -o other.urdf", &["other.toml", reason]);
        assert_eq!(b.text("other.toml"), text);
    }
    // Its own is.
    b.done("convert flat.toml -o again.urdf");
    let delta = include_str!("../../../mechanisms/linear-delta.toml");
    b.write("delta.toml", delta);
    b.refuses("convert delta.toml -o x.urdf", &["delta.toml", "write .toml"]);
    // A leg without a stroke gets limits, and the side file says that it has none.
    let message = b.done("convert m.toml -o loose.urdf").err;
    assert!(
        message.contains("no leg states a stroke") && b.text("loose.toml").contains("strokes = [[], "),
        "{message}"
    );
}

#[test]
fn every_finding_of_a_file_is_shown_at_once() {
    let mut r = robot(Style::Frames);
    r.joints.retain(|j| !j.contains("\"drive_c\""));
    let text =
        r.text().replacen("0 0 0.5", "0 0 nan", 1).replacen("strut_B_rod\"/><origin", "strut_B_rot\"/><origin", 1);
    let b = with_urdf(&text);
    b.refuses("inspect r.urdf", &["r.urdf: line ", "NotFinite: joint 'drive_a' axis"]);
    let b = with_urdf(&text.replacen("0 0 nan", "0 0 1", 1));
    b.refuses("inspect r.urdf", &["UnknownLink: joint 'drive_b'", "did you mean 'strut_B_rod'", "SeveralRoots"]);
}

#[test]
fn inspect_prints_the_warnings_of_a_file_in_both_places() {
    let b = with_urdf(&robot(Style::Gazebo).text());
    let Printed { out, err } = b.done("inspect r.urdf");
    assert!(out.contains("PlaceTakenAtHome") && err.contains("warning: r.urdf: line "), "{out}{err}");
    assert!(b.done("inspect r.urdf --quiet").err.is_empty());
}
