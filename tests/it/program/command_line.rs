//! The program as a user runs it: the JSON keys that scripts rely on, files that go from command to command.

use crate::common;

use std::path::Path;
use std::process::Output;

use crate::common::path;
use assert_cmd::cargo::cargo_bin_cmd;
use serde_json::Value;

fn paracal(folder: &Path, args: &[&str]) -> Output {
    cargo_bin_cmd!("paracal").current_dir(folder).args(args).output().unwrap()
}

fn json(folder: &Path, args: &[&str]) -> Value {
    let output = paracal(folder, &[args, &["--json"]].concat());
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(v: &Value, keys: &[&str]) -> f64 {
    keys.iter().fold(v, |v, k| &v[*k]).as_f64().unwrap_or_else(|| panic!("no number at {keys:?} in {v}"))
}

#[test]
fn the_bundled_case_calibrates_evaluates_and_compensates() {
    let folder = tempfile::tempdir().unwrap();
    let (table5, exact) = (path("mechanisms/table5.toml"), path("examples/data/hardpoint-exact.csv"));
    let targets = path("examples/data/hardpoint-targets.csv");
    let result = json(folder.path(), &["calibrate", &table5, &exact, "-o", "c.toml"]);
    assert_eq!(result["converged"], true);
    assert_eq!(result["trusted"], true);
    assert!(result["iterations"].as_u64().unwrap() <= 5);
    let parameters = result["parameters"].as_array().unwrap();
    let names: Vec<&str> = parameters.iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(&names[..8], ["xA1", "yA1", "zA1", "h1", "xB1", "yB1", "zB1", "xA2"]);
    assert_eq!(parameters.len(), 42);
    let h1 = &parameters[3];
    assert!((number(h1, &["nominal"]) - 0.8).abs() < 1e-15 && (number(h1, &["value"]) - 0.8006).abs() < 1e-12);
    assert!(number(h1, &["sigma"]) > 0.0 && h1["unit"] == "m");
    for key in ["rms_before", "rms_after", "held_out"] {
        assert!(number(&result, &[key, "position_m"]) < 2e-3 && number(&result, &[key, "rotation_rad"]) < 3e-3);
    }
    for key in ["frames", "weak_directions", "implausible"] {
        assert!(!result[key].is_null(), "{key}");
    }
    let errors = json(folder.path(), &["evaluate", "c.toml", &targets]);
    assert_eq!(errors["rows"], 150);
    assert!(number(&errors, &["max", "position_m"]) <= 1e-12 && number(&errors, &["max", "rotation_rad"]) <= 2e-12);
    assert!(number(&errors, &["mean", "position_m"]) <= number(&errors, &["rms", "position_m"]));

    // The lengths to command for the targets are those with which the targets were made.
    json(folder.path(), &["compensate", "c.toml", &targets, "-o", "lengths.csv"]);
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(name).unwrap();
        let data = text.lines().filter(|l| !l.starts_with('#')).skip(1);
        data.map(|l| l.split(',').map(|c| c.parse().unwrap()).collect()).collect()
    };
    let lengths = rows(folder.path().join("lengths.csv").to_str().unwrap());
    for (found, wanted) in lengths.iter().zip(rows(&targets)) {
        for (f, w) in found.iter().zip(&wanted) {
            assert!((f - w).abs() <= 2e-9, "{f} mm against {w} mm");
        }
    }
}

#[test]
fn a_simulated_campaign_is_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    let poses = path("examples/data/hardpoint-exact.csv");
    let mut results = Vec::new();
    for threads in ["1", "2"] {
        let simulate = [
            "simulate",
            &table5,
            "--poses",
            &poses,
            "-o",
            "d.csv",
            "--error-sd",
            "0.5mm",
            "--seed",
            "3",
            "--truth",
            "t.toml",
        ];
        assert!(paracal(folder.path(), &[&simulate[..], &["--threads", threads]].concat()).status.success());
        let calibrate = ["calibrate", &table5, "d.csv", "-o", "c.toml", "--json", "--threads", threads];
        let output = paracal(folder.path(), &calibrate);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
        results.push((read("d.csv"), read("t.toml"), read("c.toml"), output.stdout));
    }
    assert!(results[0] == results[1]);
    // The written truth is the mechanism that was measured.
    let errors = json(folder.path(), &["evaluate", "t.toml", "d.csv"]);
    let rms = number(&errors, &["rms", "position_m"]);
    assert!((1.2e-6..2.3e-6).contains(&rms), "{rms:.2e}: the noise is 1 um a coordinate");
}

#[test]
fn parameter_errors_from_a_file_and_no_noise_give_exact_data() {
    let folder = tempfile::tempdir().unwrap();
    let (table5, errors) = (path("mechanisms/table5.toml"), path("examples/data/hardpoint-errors.csv"));
    let poses = path("examples/data/hardpoint-exact.csv");
    let none = ["--noise-position", "0um", "--noise-rotation", "0deg"];
    let simulate = ["simulate", &table5, "--poses", &poses, "-o", "d.csv", "--errors", &errors];
    assert!(paracal(folder.path(), &[&simulate[..], &none].concat()).status.success());
    let result = json(folder.path(), &["calibrate", &table5, "d.csv", "-o", "c.toml"]);
    let xb5 = result["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "xB5").unwrap();
    assert!((number(xb5, &["value"]) - number(xb5, &["nominal"]) + 1.3e-3).abs() < 1e-11);
}

#[test]
fn simulated_heights_calibrate_the_mechanism_and_an_unknown_plane() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = common::text("mechanisms/table5.toml");
    let write = |name: &str, plane: &str| {
        std::fs::write(folder.path().join(name), format!("{table5}\n[plane]\n{plane}\n")).unwrap();
    };
    write("stands.toml", "normal = [0.05, 0, 1]\ndistance = 120\ntip = [100, 0, -200]");
    write("drawn.toml", "tip = [100, 0, -200]\nidentify = true");
    let select = "select stands.toml -n 150 -o p.csv --selector random --candidates 160";
    json(folder.path(), &select.split(' ').collect::<Vec<_>>());
    let simulate = "simulate stands.toml --poses p.csv -o d.csv --error-sd 0.3mm --measure contact --seed 4";
    json(folder.path(), &simulate.split(' ').collect::<Vec<_>>());
    let (header, _) = listed(folder.path(), "d.csv");
    assert_eq!(header.join(","), "leg1_mm,leg2_mm,leg3_mm,leg4_mm,leg5_mm,leg6_mm,contact_mm");
    let found = json(folder.path(), &["calibrate", "drawn.toml", "d.csv", "-o", "c.toml"]);
    assert_eq!(found["trusted"], true);
    assert!(number(&found, &["rms_after", "position_m"]) < 1.2e-6 && found["rms_after"]["rotation_rad"].is_null());
    let plane: Vec<(&str, &str)> = found["measurement_parameters"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| (p["name"].as_str().unwrap(), p["unit"].as_str().unwrap()))
        .collect();
    assert_eq!(plane, [("plane_tilt1", "rad"), ("plane_tilt2", "rad"), ("plane_distance", "m")]);
    // About y, by the arc tangent of 0.05.
    let tilt = number(&found["measurement_parameters"][1], &["value"]);
    assert!((tilt - 0.05_f64.atan()).abs() < 1e-3, "{tilt}");
    // The calibrated file has the plane and needs to find none.
    let calibrated = std::fs::read_to_string(folder.path().join("c.toml")).unwrap();
    assert!(calibrated.contains("\n[plane]\nnormal = [0.0") && !calibrated.contains("identify"), "{calibrated}");
    let errors = json(folder.path(), &["evaluate", "c.toml", "d.csv"]);
    assert!(number(&errors, &["rms", "position_m"]) < 1.2e-6 && errors["rms"]["rotation_rad"].is_null());
    let shown = paracal(folder.path(), &["calibrate", "drawn.toml", "d.csv", "-o", "c.toml"]);
    let shown = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.contains("150 samples (heights over an unknown plane)"), "{shown}");
    assert!(shown.contains("Identified measurement parameters\nparameter "), "{shown}");
}

#[test]
fn misfit_beyond_chance_is_written_but_not_trusted() {
    let folder = tempfile::tempdir().unwrap();
    let text = common::text("mechanisms/table5.toml").replace("position = 0.001\n", "position = 0.0003\n");
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let noisy = path("examples/data/hardpoint-noisy.csv");
    let output = paracal(folder.path(), &["calibrate", "m.toml", &noisy, "-o", "c.toml"]);
    assert_eq!(output.status.code(), Some(3));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("Do not trust this result") && text.contains("times the stated noise"), "{text}");
    assert!(folder.path().join("c.toml").exists());
}

#[test]
fn poses_that_cannot_tell_are_not_trusted_without_a_prior() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    // Translations alone: no pose turns the platform.
    let mut poses = String::from("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n");
    for k in 0..27 {
        poses += &format!("{},{},{},0,0,0\n", 50 * (k % 3 - 1), 50 * (k / 3 % 3 - 1), 475 + 50 * (k / 9 - 1));
    }
    std::fs::write(folder.path().join("p.csv"), poses).unwrap();
    let simulate = ["simulate", &table5, "--poses", "p.csv", "-o", "d.csv"];
    assert!(paracal(folder.path(), &simulate).status.success());
    let without = paracal(folder.path(), &["calibrate", &table5, "d.csv", "-o", "c.toml", "--prior", "none"]);
    assert_eq!(without.status.code(), Some(3), "{}", String::from_utf8_lossy(&without.stdout));
    let text = String::from_utf8(without.stdout).unwrap();
    assert!(text.contains("directions undetermined"), "{text}");
    let with = paracal(folder.path(), &["calibrate", &table5, "d.csv", "-o", "c.toml"]);
    assert_eq!(with.status.code(), Some(0), "{}", String::from_utf8_lossy(&with.stdout));
}

#[test]
fn gross_errors_are_found_by_the_robust_identifier() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    let mut poses = String::from("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n");
    for k in 0..60_i32 {
        let digit = |step: i32| f64::from((k * step) % 19 - 9) / 9.0;
        let (p, r) = ([digit(1), digit(5), digit(7)], [digit(3), digit(11), digit(13)]);
        poses += &format!("{},{},{},", 90.0 * p[0], 90.0 * p[1], 475.0 + 90.0 * p[2]);
        poses += &format!("{},{},{}\n", 9.0 * r[0], 9.0 * r[1], 9.0 * r[2]);
    }
    std::fs::write(folder.path().join("p.csv"), poses).unwrap();
    let simulate = ["simulate", &table5, "--poses", "p.csv", "-o", "d.csv", "--error-sd", "0.5mm", "--truth", "t.toml"];
    assert!(paracal(folder.path(), &simulate).status.success());
    let text = std::fs::read_to_string(folder.path().join("d.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    // Rows 4, 17 and 40 get 30 um in x; two lines of comment and header stand above.
    for row in [4, 17, 40] {
        let mut cells: Vec<String> = lines[row + 2].split(',').map(str::to_owned).collect();
        cells[6] = (cells[6].parse::<f64>().unwrap() + 0.03).to_string();
        lines[row + 2] = cells.join(",");
    }
    std::fs::write(folder.path().join("bad.csv"), lines.join("\n")).unwrap();
    let plain = paracal(folder.path(), &["calibrate", &table5, "bad.csv", "-o", "c.toml"]);
    assert_eq!(plain.status.code(), Some(3));
    for loss in ["huber", "tukey"] {
        let args = ["calibrate", &table5, "bad.csv", "-o", "r.toml", "--identifier", "robust", "--loss", loss];
        let result = json(folder.path(), &args);
        assert_eq!(result["outlier_rows"], serde_json::json!([4, 17, 40]), "{loss}");
        let scale = number(&result, &["noise_scale"]);
        assert!((0.8..1.25).contains(&scale), "{loss}: {scale}");
    }
    // The robust model is as good as one from the clean rows.
    let clean = json(folder.path(), &["evaluate", "r.toml", "d.csv"]);
    assert!(number(&clean, &["rms", "position_m"]) < 1.9e-6, "{clean}");
}

#[test]
fn noise_that_is_not_stated_is_estimated() {
    let folder = tempfile::tempdir().unwrap();
    let text = common::text("mechanisms/table5.toml");
    let (head, _) = text.split_once("[noise]").unwrap();
    std::fs::write(folder.path().join("m.toml"), head).unwrap();
    let noisy = path("examples/data/hardpoint-noisy.csv");
    let result = json(folder.path(), &["calibrate", "m.toml", &noisy, "-o", "c.toml"]);
    assert_eq!(result["trusted"], true);
    // Position : rotation = 1 : 1/radius is not the ratio of these data, so the size is only about 1 um.
    let scale = number(&result, &["noise_scale"]);
    assert!((0.3..3.0).contains(&scale), "{scale}");
    assert!(result["p_value"].is_null());
}

#[test]
fn inspect_states_the_contract_keys_and_looks_ahead() {
    let folder = tempfile::tempdir().unwrap();
    let seen = json(folder.path(), &["inspect", &path("mechanisms/table5.toml")]);
    assert_eq!(seen["legs"].as_array().unwrap().len(), 6);
    assert!((seen["legs"][0]["platform"][0].as_f64().unwrap() - 1.29917).abs() < 1e-15);
    assert!((number(&seen["legs"][0], &["length"]) - 0.8).abs() < 1e-6);
    assert!((seen["home"][2].as_f64().unwrap() - 0.475_695_8).abs() < 1e-7);
    assert_eq!(seen["joints"][5], "leg6");
    assert!(number(&seen, &["prospect", "predicted", "rms", "position_m"]) < 2e-6);
    for name in ["table2", "rubin-camera-hexapod", "rubin-m2-hexapod", "nategh-agheli"] {
        let output = paracal(folder.path(), &["inspect", &path(&format!("mechanisms/{name}.toml"))]);
        assert!(output.status.success() && output.stderr.is_empty(), "{name}");
    }
}

#[test]
fn argmins_solver_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let (table5, noisy) = (path("mechanisms/table5.toml"), path("examples/data/hardpoint-noisy.csv"));
    let with = |solver: &str| {
        let args = ["calibrate", &table5, &noisy, "-o", "c.toml", "--identifier", "least-squares", "--solver", solver];
        json(folder.path(), &args)
    };
    let (qr, argmin) = (with("qr"), with("argmin"));
    for (a, b) in qr["parameters"].as_array().unwrap().iter().zip(argmin["parameters"].as_array().unwrap()) {
        assert!((number(a, &["value"]) - number(b, &["value"])).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn commanded_poses_become_lengths_by_the_nominal_geometry_also_in_a_calibrated_file() {
    let folder = tempfile::tempdir().unwrap();
    let (table5, noisy) = (path("mechanisms/table5.toml"), path("examples/data/hardpoint-noisy.csv"));
    // The poses that the nominal mechanism was commanded to take, found by its forward kinematics.
    let m = common::machine("table5");
    let data = common::data("hardpoint-noisy", &m).data;
    let at = paracal::conditions::Conditions::unknown();
    let mut text =
        String::from("cmd_x_m,cmd_y_m,cmd_z_m,cmd_rx_rad,cmd_ry_rad,cmd_rz_rad,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad\n");
    for k in 0..data.len() {
        let mechanism = m.mechanism.as_ref();
        let commanded = mechanism.forward(mechanism.values(), &data.sample(k).joints, &at, &mechanism.home()).unwrap();
        let measured = data.model().rigid_pose(k).unwrap();
        let cells = commanded.coordinates().into_iter().chain(measured.coordinates());
        text += &(cells.map(|v| format!("{v:.15}")).collect::<Vec<_>>().join(",") + "\n");
    }
    std::fs::write(folder.path().join("cmd.csv"), text).unwrap();
    let by_pose = json(folder.path(), &["calibrate", &table5, "cmd.csv", "-o", "c.toml"]);
    let by_length = json(folder.path(), &["calibrate", &table5, &noisy, "-o", "c2.toml"]);
    let rms = number(&by_length, &["rms_after", "position_m"]);
    assert!((number(&by_pose, &["rms_after", "position_m"]) - rms).abs() < 1e-11);
    for file in ["cmd.csv", &noisy] {
        let errors = json(folder.path(), &["evaluate", "c.toml", file]);
        assert!((number(&errors, &["rms", "position_m"]) - rms).abs() < 1e-11, "{file}");
    }
}

#[test]
fn a_calibrated_file_calibrates_again_and_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (table5, noisy) = (path("mechanisms/table5.toml"), path("examples/data/hardpoint-noisy.csv"));
    let first = json(folder.path(), &["calibrate", &table5, &noisy, "-o", "a.toml"]);
    let second = json(folder.path(), &["calibrate", "a.toml", &noisy, "-o", "b.toml"]);
    for (a, b) in first["parameters"].as_array().unwrap().iter().zip(second["parameters"].as_array().unwrap()) {
        assert!((number(a, &["value"]) - number(b, &["value"])).abs() < 1e-11, "{a} {b}");
    }
    let h2 = &second["parameters"].as_array().unwrap()[10];
    assert!(h2["name"] == "h2" && (number(h2, &["nominal"]) - 0.8).abs() < 1e-15, "{h2}");
    assert!(
        (number(&second, &["rms_before", "position_m"]) - number(&first, &["rms_after", "position_m"])).abs() < 1e-12
    );
}

#[test]
fn columns_that_only_look_like_coordinates_are_covariates_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    let text = common::text("examples/data/hardpoint-noisy.csv");
    let with = |column: &str| {
        let mut lines = text.lines();
        let mut changed = format!("{},{column}\n", lines.next().unwrap());
        lines.for_each(|l| changed += &format!("{l},1.5\n"));
        std::fs::write(folder.path().join("d.csv"), changed).unwrap();
        paracal(folder.path(), &["calibrate", &table5, "d.csv", "-o", "c.toml"])
    };
    assert!(with("leg1_load").status.success());
    assert!(with("pressure").status.success());
    let capital = with("Sigma_x_mm");
    assert_eq!(capital.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&capital.stderr).contains("did you mean 'sigma_x_mm'"));
}

#[test]
fn the_readme_shows_what_the_program_prints() {
    let folder = tempfile::tempdir().unwrap();
    let (table5, noisy) = (path("mechanisms/table5.toml"), path("examples/data/hardpoint-noisy.csv"));
    let print = |args: &[&str]| String::from_utf8(paracal(folder.path(), args).stdout).unwrap();
    let calibrated = print(&["calibrate", &table5, &noisy, "-o", "calibrated.toml"]);
    let evaluated = print(&["evaluate", "calibrated.toml", &path("examples/data/hardpoint-targets.csv")]);
    let readme = common::text("README.md");
    let shown: Vec<&str> = readme.split("```text\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    let selected = print(&["select", &table5, "-n", "20", "-o", "poses.csv"]);
    let (telescope, causes) =
        (path("mechanisms/table5-telescope.toml"), path("examples/data/hardpoint-two-causes.csv"));
    let diagnosed = print(&["diagnose", &telescope, &causes]);
    assert_eq!(shown.len(), 4);
    assert!(calibrated.ends_with(shown[0]), "the program prints\n{calibrated}");
    assert!(evaluated.contains(shown[1]), "the program prints\n{evaluated}");
    assert!(selected.contains(shown[2]), "the program prints\n{selected}");
    assert!(diagnosed.contains(shown[3]), "the program prints\n{diagnosed}");
}

/// Poses of a list that the program wrote, in its units, and the header.
fn listed(folder: &Path, name: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let mut lines =
        text.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}

#[test]
fn select_states_the_contract_keys_and_its_list_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    let found = json(folder.path(), &["select", &table5, "-o", "poses.csv", "--candidates", "300"]);
    assert_eq!(
        (&found["index"], &found["scaling"], &found["selector"]),
        (&"o1".into(), &"whitened".into(), &"exchange".into())
    );
    let (value, bound) = (number(&found, &["value"]), number(&found, &["bound"]));
    let efficiency = number(&found, &["efficiency"]);
    assert!(efficiency <= 1.0 && efficiency > 0.97 && (efficiency - value / bound).abs() < 1e-12);
    assert_eq!(found["iterations"].as_u64().unwrap() as usize, found["trace"].as_array().unwrap().len());
    assert!(number(&found, &["candidates"]) == 1029.0 && number(&found, &["seconds"]) > 0.0);
    let poses = found["poses"].as_array().unwrap();
    assert_eq!(poses.len(), 20);
    let (header, rows) = listed(folder.path(), "poses.csv");
    assert_eq!(header.join(","), "leg1_mm,leg2_mm,leg3_mm,leg4_mm,leg5_mm,leg6_mm,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg");
    for (pose, row) in poses.iter().zip(&rows) {
        assert!((pose[0].as_f64().unwrap() - 1e-3 * row[6].parse::<f64>().unwrap()).abs() < 1e-12);
        assert!((pose[5].as_f64().unwrap() - row[11].parse::<f64>().unwrap().to_radians()).abs() < 1e-12);
    }
    // What was chosen is simulated and calibrated, and errs as predicted.
    json(folder.path(), &["simulate", &table5, "--poses", "poses.csv", "-o", "d.csv", "--error-sd", "0.5mm"]);
    let calibrated = json(folder.path(), &["calibrate", &table5, "d.csv", "-o", "c.toml"]);
    assert_eq!(calibrated["trusted"], true);
    let (before, after) =
        (number(&found, &["predicted", "rms", "position_m"]), number(&calibrated, &["predicted", "rms", "position_m"]));
    assert!((before / after - 1.0).abs() < 0.1, "{before} and {after}");
}

#[test]
fn every_bundled_mechanism_gets_feasible_poses() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["table2", "table5", "rubin-camera-hexapod", "rubin-m2-hexapod", "nategh-agheli"] {
        let file = path(&format!("mechanisms/{name}.toml"));
        let found = json(folder.path(), &["select", &file, "-n", "12", "-o", "p.csv", "--candidates", "200"]);
        let machine = common::machine(name);
        let m = machine.mechanism.as_ref();
        let at = paracal::conditions::Conditions::unknown();
        let w = machine.workspace.unwrap();
        for pose in found["poses"].as_array().unwrap() {
            let q: [f64; 6] = std::array::from_fn(|k| pose[k].as_f64().unwrap());
            for k in 0..6 {
                assert!((q[k] - w.centre[k]).abs() <= w.half[k] * (1.0 + 1e-12), "{name}: {q:?}");
            }
            let pose = machine.convention.pose(&q);
            let joints = m.inverse(m.values(), &pose, &at).unwrap();
            assert!(m.within_strokes(&joints), "{name}: {joints:?}");
            let back = m.forward(m.values(), &joints, &at, &m.home()).unwrap();
            assert!(pose.motion_to(&back).amax() < 1e-9, "{name}");
        }
    }
}

#[test]
fn strokes_are_kept_and_given_poses_stay_in_front() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        common::text("mechanisms/table5.toml").replace("length = 800.0", "length = 800.0\nstroke = [700.0, 900.0]");
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let first = json(folder.path(), &["select", "m.toml", "-n", "8", "-o", "first.csv", "--candidates", "200"]);
    let (_, rows) = listed(folder.path(), "first.csv");
    for length in rows.iter().flat_map(|r| &r[..6]) {
        let length: f64 = length.parse().unwrap();
        assert!((700.0..=900.0).contains(&length), "{length}");
    }
    let all = json(
        folder.path(),
        &["select", "m.toml", "-n", "14", "-o", "all.csv", "--given", "first.csv", "--candidates", "200"],
    );
    assert_eq!(all["given"], 8);
    for k in 0..8 {
        for c in 0..6 {
            let (a, b) = (all["poses"][k][c].as_f64().unwrap(), first["poses"][k][c].as_f64().unwrap());
            assert!((a - b).abs() < 1e-12);
        }
    }
    assert!(number(&all, &["value"]) > number(&first, &["value"]) && number(&all, &["efficiency"]) <= 1.0);
    let (header, rows) = listed(folder.path(), "all.csv");
    assert_eq!((header[0].as_str(), rows[0][0].as_str(), rows[8][0].as_str()), ("id", "given1", "new1"));
}

#[test]
fn a_requirement_is_met_with_as_few_poses_as_possible() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    let args = ["select", &table5, "-o", "p.csv", "--candidates", "100", "--no-polish", "--require", "0.5arcsec,2um"];
    let found = json(folder.path(), &args);
    let n = found["poses"].as_array().unwrap().len();
    assert!((7..=12).contains(&n), "{n}");
    assert!(number(&found, &["predicted", "rms", "position_m"]) <= 2e-6);
    assert!(number(&found, &["predicted", "rms", "rotation_rad"]) <= 0.5 / 206_264.8);
    let fewer = (n - 1).to_string();
    let args = ["select", &table5, "-o", "p.csv", "--candidates", "100", "--no-polish", "-n", &fewer];
    let less = json(folder.path(), &args);
    let error = |v: &Value, what: &str| number(v, &["predicted", "rms", what]);
    assert!(error(&less, "position_m") > 2e-6 || error(&less, "rotation_rad") > 0.5 / 206_264.8);
}

#[test]
fn the_table_shows_seven_to_sixty_poses() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    let args = ["select", &table5, "-o", "p.csv", "--candidates", "50", "--no-polish", "--table"];
    let found = json(folder.path(), &args);
    let rows = found["table"].as_array().unwrap();
    let numbers: Vec<u64> = rows.iter().map(|r| r["n"].as_u64().unwrap()).collect();
    assert_eq!(numbers, (7..=60).collect::<Vec<u64>>());
    assert!(rows.iter().all(|r| r["efficiency"].as_f64().unwrap() <= 1.0));
    let error = |k: usize| number(&rows[k], &["predicted", "rms", "position_m"]);
    assert!(error(0) > 1.5 * error(13) && error(13) > 1.2 * error(53), "{} {} {}", error(0), error(13), error(53));
}

#[test]
fn selections_do_not_depend_on_threads_and_lists_can_be_chosen_from() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    for index in ["o1", "o4", "pose-error"] {
        let mut texts = Vec::new();
        for threads in ["1", "2"] {
            let args = [
                "select",
                &table5,
                "-o",
                "p.csv",
                "--candidates",
                "150",
                "--index",
                index,
                "-n",
                "9",
                "--threads",
                threads,
            ];
            let mut found = json(folder.path(), &args);
            found["seconds"] = Value::Null;
            texts.push((found, std::fs::read(folder.path().join("p.csv")).unwrap()));
        }
        assert!(texts[0] == texts[1], "{index}");
    }
    let many = ["select", &table5, "-o", "list.csv", "--selector", "random", "--candidates", "60", "-n", "50"];
    json(folder.path(), &many);
    let args = ["select", &table5, "-o", "p.csv", "--candidates", "list.csv", "--no-polish", "-n", "10"];
    let found = json(folder.path(), &args);
    assert_eq!(found["candidates"], 50);
    let (_, list) = listed(folder.path(), "list.csv");
    let (_, chosen) = listed(folder.path(), "p.csv");
    let near = |a: &[String], b: &[String]| {
        a.iter().zip(b).all(|(a, b)| (a.parse::<f64>().unwrap() - b.parse::<f64>().unwrap()).abs() < 1e-9)
    };
    assert!(chosen.iter().all(|c| list.iter().any(|l| near(c, l))));
}

#[test]
fn a_model_from_absurd_data_is_written_and_not_trusted() {
    let folder = tempfile::tempdir().unwrap();
    let table5 = path("mechanisms/table5.toml");
    let text = common::text("examples/data/hardpoint-noisy.csv");
    let (header, rows) = text.split_once('\n').unwrap();
    let rows: Vec<Vec<f64>> = rows.lines().map(|l| l.split(',').map(|c| c.parse().unwrap()).collect()).collect();
    type Change = fn(usize, &mut Vec<f64>);
    let changes: [(&str, Change); 3] = [
        ("the sign of z", |_, r| r[8] = -r[8]),
        ("the signs of the angles", |_, r| r[9..].iter_mut().for_each(|v| *v = -*v)),
        ("gross errors in every seventh row", |k, r| {
            if k % 7 == 0 {
                r[6] += 60.0;
                r[10] -= 1.5;
            }
        }),
    ];
    for (name, change) in changes {
        let line = |(k, row): (usize, &Vec<f64>)| {
            let mut row = row.clone();
            change(k, &mut row);
            row.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
        };
        let lines: Vec<String> = rows.iter().enumerate().map(line).collect();
        std::fs::write(folder.path().join("d.csv"), format!("{header}\n{}\n", lines.join("\n"))).unwrap();
        for identifier in ["levenberg-marquardt", "least-squares"] {
            let out = folder.path().join("c.toml");
            let args = ["calibrate", &table5, "d.csv", "-o", "c.toml", "--identifier", identifier];
            let output = paracal(folder.path(), &args);
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(3), "{name}, {identifier}: {errors}");
            assert!(out.exists(), "{name}, {identifier}");
            std::fs::remove_file(out).unwrap();
        }
    }
}
