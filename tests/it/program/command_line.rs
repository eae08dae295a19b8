//! The program as a user runs it: the JSON keys that scripts rely on, files that go from command to command.

use crate::common;
use crate::common::bench::{Bench, number};
use serde_json::Value;

#[test]
fn the_bundled_case_calibrates_evaluates_and_compensates() {
    let bench = Bench::project();
    let result = bench.json("calibrate mechanisms/table5.toml examples/data/hardpoint-exact.csv -o c.toml");
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
    let errors = bench.json("evaluate c.toml examples/data/hardpoint-targets.csv");
    assert_eq!(errors["rows"], 150);
    assert!(number(&errors, &["max", "position_m"]) <= 1e-12 && number(&errors, &["max", "rotation_rad"]) <= 2e-12);
    assert!(number(&errors, &["mean", "position_m"]) <= number(&errors, &["rms", "position_m"]));

    // The lengths to command for the targets are those with which the targets were made.
    bench.json("compensate c.toml examples/data/hardpoint-targets.csv -o lengths.csv");
    let rows = |text: &str| -> Vec<Vec<f64>> {
        let data = text.lines().filter(|l| !l.starts_with('#')).skip(1);
        data.map(|l| l.split(',').map(|c| c.parse().unwrap()).collect()).collect()
    };
    let lengths = rows(&bench.text("lengths.csv"));
    for (found, wanted) in lengths.iter().zip(rows(&bench.text("examples/data/hardpoint-targets.csv"))) {
        for (f, w) in found.iter().zip(&wanted) {
            assert!((f - w).abs() <= 2e-9, "{f} mm against {w} mm");
        }
    }
}

#[test]
fn a_simulated_campaign_is_the_same_bytes_on_any_number_of_threads() {
    let bench = Bench::project();
    let mut results = Vec::new();
    for threads in ["1", "2"] {
        let simulate = "simulate mechanisms/table5.toml --poses examples/data/hardpoint-exact.csv -o d.csv \
                        --error-sd 0.5mm --seed 3 --truth t.toml";
        bench.done(&format!("{simulate} --threads {threads}"));
        let calibrate = format!("calibrate mechanisms/table5.toml d.csv -o c.toml --json --threads {threads}");
        let output = bench.run(&calibrate);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let read = |name: &str| bench.bytes(name);
        results.push((read("d.csv"), read("t.toml"), read("c.toml"), output.stdout));
    }
    assert!(results[0] == results[1]);
    // The written truth is the mechanism that was measured.
    let errors = bench.json("evaluate t.toml d.csv");
    let rms = number(&errors, &["rms", "position_m"]);
    assert!((1.2e-6..2.3e-6).contains(&rms), "{rms:.2e}: the noise is 1 um a coordinate");
}

#[test]
fn parameter_errors_from_a_file_and_no_noise_give_exact_data() {
    let bench = Bench::project();
    let simulate = "simulate mechanisms/table5.toml --poses examples/data/hardpoint-exact.csv -o d.csv \
                    --errors examples/data/hardpoint-errors.csv --noise-position 0um --noise-rotation 0deg";
    bench.done(simulate);
    let result = bench.json("calibrate mechanisms/table5.toml d.csv -o c.toml");
    let xb5 = result["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "xB5").unwrap();
    assert!((number(xb5, &["value"]) - number(xb5, &["nominal"]) + 1.3e-3).abs() < 1e-11);
}

#[test]
fn simulated_heights_calibrate_the_mechanism_and_an_unknown_plane() {
    let bench = Bench::project();
    let table5 = common::text("mechanisms/table5.toml");
    let write = |name: &str, plane: &str| {
        bench.write(name, format!("{table5}\n[plane]\n{plane}\n"));
    };
    write("stands.toml", "normal = [0.05, 0, 1]\ndistance = 120\ntip = [100, 0, -200]");
    write("drawn.toml", "tip = [100, 0, -200]\nidentify = true");
    let select = "select stands.toml -n 150 -o p.csv --selector random --candidates 160";
    bench.json(select);
    let simulate = "simulate stands.toml --poses p.csv -o d.csv --error-sd 0.3mm --measure contact --seed 4";
    bench.json(simulate);
    let (header, _) = listed(&bench, "d.csv");
    assert_eq!(header.join(","), "leg1_mm,leg2_mm,leg3_mm,leg4_mm,leg5_mm,leg6_mm,contact_mm");
    let found = bench.json("calibrate drawn.toml d.csv -o c.toml");
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
    let calibrated = bench.text("c.toml");
    assert!(calibrated.contains("\n[plane]\nnormal = [0.0") && !calibrated.contains("identify"), "{calibrated}");
    let errors = bench.json("evaluate c.toml d.csv");
    assert!(number(&errors, &["rms", "position_m"]) < 1.2e-6 && errors["rms"]["rotation_rad"].is_null());
    let shown = bench.run("calibrate drawn.toml d.csv -o c.toml");
    let shown = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.contains("150 samples (heights over an unknown plane)"), "{shown}");
    assert!(shown.contains("Identified measurement parameters\nparameter "), "{shown}");
}

#[test]
fn misfit_beyond_chance_is_written_but_not_trusted() {
    let bench = Bench::project();
    let text = common::text("mechanisms/table5.toml").replace("position = 0.001\n", "position = 0.0003\n");
    bench.write("m.toml", text);
    let output = bench.run("calibrate m.toml examples/data/hardpoint-noisy.csv -o c.toml");
    assert_eq!(output.status.code(), Some(3));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("Do not trust this result") && text.contains("times the stated noise"), "{text}");
    assert!(bench.has("c.toml"));
}

#[test]
fn poses_that_cannot_tell_are_not_trusted_without_a_prior() {
    let bench = Bench::project();
    // Translations alone: no pose turns the platform.
    let mut poses = String::from("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n");
    for k in 0..27 {
        poses += &format!("{},{},{},0,0,0\n", 50 * (k % 3 - 1), 50 * (k / 3 % 3 - 1), 475 + 50 * (k / 9 - 1));
    }
    bench.write("p.csv", poses);
    let simulate = "simulate mechanisms/table5.toml --poses p.csv -o d.csv";
    bench.done(simulate);
    let without = bench.run("calibrate mechanisms/table5.toml d.csv -o c.toml --prior none");
    assert_eq!(without.status.code(), Some(3), "{}", String::from_utf8_lossy(&without.stdout));
    let text = String::from_utf8(without.stdout).unwrap();
    assert!(text.contains("directions undetermined"), "{text}");
    let with = bench.run("calibrate mechanisms/table5.toml d.csv -o c.toml");
    assert_eq!(with.status.code(), Some(0), "{}", String::from_utf8_lossy(&with.stdout));
}

#[test]
fn gross_errors_are_found_by_the_robust_identifier() {
    let bench = Bench::project();
    let mut poses = String::from("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n");
    for k in 0..60_i32 {
        let digit = |step: i32| f64::from((k * step) % 19 - 9) / 9.0;
        let (p, r) = ([digit(1), digit(5), digit(7)], [digit(3), digit(11), digit(13)]);
        poses += &format!("{},{},{},", 90.0 * p[0], 90.0 * p[1], 475.0 + 90.0 * p[2]);
        poses += &format!("{},{},{}\n", 9.0 * r[0], 9.0 * r[1], 9.0 * r[2]);
    }
    bench.write("p.csv", poses);
    let simulate = "simulate mechanisms/table5.toml --poses p.csv -o d.csv --error-sd 0.5mm --truth t.toml";
    bench.done(simulate);
    let text = bench.text("d.csv");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    // Rows 4, 17 and 40 get 30 um in x; the header stands above.
    for row in [4, 17, 40] {
        let mut cells: Vec<String> = lines[row + 1].split(',').map(str::to_owned).collect();
        cells[6] = (cells[6].parse::<f64>().unwrap() + 0.03).to_string();
        lines[row + 1] = cells.join(",");
    }
    bench.write("bad.csv", lines.join("\n"));
    let plain = bench.run("calibrate mechanisms/table5.toml bad.csv -o c.toml");
    assert_eq!(plain.status.code(), Some(3));
    for loss in ["huber", "tukey"] {
        let call = format!("calibrate mechanisms/table5.toml bad.csv -o r.toml --identifier robust --loss {loss}");
        let result = bench.json(&call);
        assert_eq!(result["outlier_rows"], serde_json::json!([4, 17, 40]), "{loss}");
        let scale = number(&result, &["noise_scale"]);
        assert!((0.8..1.25).contains(&scale), "{loss}: {scale}");
    }
    // The robust model is as good as one from the clean rows.
    let clean = bench.json("evaluate r.toml d.csv");
    assert!(number(&clean, &["rms", "position_m"]) < 1.9e-6, "{clean}");
}

#[test]
fn noise_that_is_not_stated_is_estimated() {
    let bench = Bench::project();
    let text = common::text("mechanisms/table5.toml");
    let (head, _) = text.split_once("[noise]").unwrap();
    bench.write("m.toml", head);
    let result = bench.json("calibrate m.toml examples/data/hardpoint-noisy.csv -o c.toml");
    assert_eq!(result["trusted"], true);
    // Position : rotation = 1 : 1/radius is not the ratio of these data, so the size is only about 1 um.
    let scale = number(&result, &["noise_scale"]);
    assert!((0.3..3.0).contains(&scale), "{scale}");
    assert!(result["p_value"].is_null());
}

#[test]
fn inspect_states_the_contract_keys_and_looks_ahead() {
    let bench = Bench::project();
    let seen = bench.json("inspect mechanisms/table5.toml");
    assert_eq!(seen["legs"].as_array().unwrap().len(), 6);
    assert!((seen["legs"][0]["platform"][0].as_f64().unwrap() - 1.29917).abs() < 1e-15);
    assert!((number(&seen["legs"][0], &["length"]) - 0.8).abs() < 1e-6);
    assert!((seen["home"][2].as_f64().unwrap() - 0.475_695_8).abs() < 1e-7);
    assert_eq!(seen["joints"][5], "leg6");
    assert!(number(&seen, &["prospect", "predicted", "rms", "position_m"]) < 2e-6);
    for name in ["table2", "rubin-camera-hexapod", "rubin-m2-hexapod", "nategh-agheli"] {
        let output = bench.run(&format!("inspect mechanisms/{name}.toml"));
        assert!(output.status.success() && output.stderr.is_empty(), "{name}");
    }
}

#[test]
fn argmins_solver_can_be_chosen() {
    let bench = Bench::project();
    let with = |solver: &str| {
        let call = format!(
            "calibrate mechanisms/table5.toml examples/data/hardpoint-noisy.csv -o c.toml \
             --identifier least-squares --solver {solver}"
        );
        bench.json(&call)
    };
    let (qr, argmin) = (with("qr"), with("argmin"));
    for (a, b) in qr["parameters"].as_array().unwrap().iter().zip(argmin["parameters"].as_array().unwrap()) {
        assert!((number(a, &["value"]) - number(b, &["value"])).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn commanded_poses_become_lengths_by_the_nominal_geometry_also_in_a_calibrated_file() {
    let bench = Bench::project();
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
    bench.write("cmd.csv", text);
    let by_pose = bench.json("calibrate mechanisms/table5.toml cmd.csv -o c.toml");
    let by_length = bench.json("calibrate mechanisms/table5.toml examples/data/hardpoint-noisy.csv -o c2.toml");
    let rms = number(&by_length, &["rms_after", "position_m"]);
    assert!((number(&by_pose, &["rms_after", "position_m"]) - rms).abs() < 1e-11);
    for file in ["cmd.csv", "examples/data/hardpoint-noisy.csv"] {
        let errors = bench.json(&format!("evaluate c.toml {file}"));
        assert!((number(&errors, &["rms", "position_m"]) - rms).abs() < 1e-11, "{file}");
    }
}

#[test]
fn a_calibrated_file_calibrates_again_and_stays() {
    let bench = Bench::project();
    let first = bench.json("calibrate mechanisms/table5.toml examples/data/hardpoint-noisy.csv -o a.toml");
    let second = bench.json("calibrate a.toml examples/data/hardpoint-noisy.csv -o b.toml");
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
    let bench = Bench::project();
    let text = common::text("examples/data/hardpoint-noisy.csv");
    let with = |column: &str| {
        let mut lines = text.lines();
        let mut changed = format!("{},{column}\n", lines.next().unwrap());
        lines.for_each(|l| changed += &format!("{l},1.5\n"));
        bench.write("d.csv", changed);
        bench.run("calibrate mechanisms/table5.toml d.csv -o c.toml")
    };
    assert!(with("leg1_load").status.success());
    assert!(with("pressure").status.success());
    let capital = with("Sigma_x_mm");
    assert_eq!(capital.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&capital.stderr).contains("did you mean 'sigma_x_mm'"));
}

#[test]
fn the_readme_shows_what_the_program_prints() {
    let bench = Bench::project();
    let print = |call: &str| bench.done(call).out;
    let calibrated = print("calibrate mechanisms/table5.toml examples/data/hardpoint-noisy.csv -o calibrated.toml");
    let evaluated = print("evaluate calibrated.toml examples/data/hardpoint-targets.csv");
    let readme = common::text("README.md");
    let shown: Vec<&str> = readme.split("```text\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    let selected = print("select mechanisms/table5.toml -n 20 -o poses.csv");
    let diagnosed = print("diagnose mechanisms/table5-telescope.toml examples/data/hardpoint-two-causes.csv");
    assert_eq!(shown.len(), 4);
    assert!(calibrated.ends_with(shown[0]), "the program prints\n{calibrated}");
    assert!(evaluated.contains(shown[1]), "the program prints\n{evaluated}");
    assert!(selected.contains(shown[2]), "the program prints\n{selected}");
    assert!(diagnosed.contains(shown[3]), "the program prints\n{diagnosed}");
}

/// Poses of a list that the program wrote, in its units, and the header.
fn listed(bench: &Bench, name: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let text = bench.text(name);
    let mut lines =
        text.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}

#[test]
fn select_states_the_contract_keys_and_its_list_goes_on() {
    let bench = Bench::project();
    let found = bench.json("select mechanisms/table5.toml -o poses.csv --candidates 300");
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
    let (header, rows) = listed(&bench, "poses.csv");
    assert_eq!(header.join(","), "leg1_mm,leg2_mm,leg3_mm,leg4_mm,leg5_mm,leg6_mm,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg");
    for (pose, row) in poses.iter().zip(&rows) {
        assert!((pose[0].as_f64().unwrap() - 1e-3 * row[6].parse::<f64>().unwrap()).abs() < 1e-12);
        assert!((pose[5].as_f64().unwrap() - row[11].parse::<f64>().unwrap().to_radians()).abs() < 1e-12);
    }
    // What was chosen is simulated and calibrated, and errs as predicted.
    bench.json("simulate mechanisms/table5.toml --poses poses.csv -o d.csv --error-sd 0.5mm");
    let calibrated = bench.json("calibrate mechanisms/table5.toml d.csv -o c.toml");
    assert_eq!(calibrated["trusted"], true);
    let (before, after) =
        (number(&found, &["predicted", "rms", "position_m"]), number(&calibrated, &["predicted", "rms", "position_m"]));
    assert!((before / after - 1.0).abs() < 0.1, "{before} and {after}");
}

#[test]
fn every_bundled_mechanism_gets_feasible_poses() {
    let bench = Bench::project();
    for name in ["table2", "table5", "rubin-camera-hexapod", "rubin-m2-hexapod", "nategh-agheli"] {
        let found = bench.json(&format!("select mechanisms/{name}.toml -n 12 -o p.csv --candidates 200"));
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
    let bench = Bench::project();
    let text =
        common::text("mechanisms/table5.toml").replace("length = 800.0", "length = 800.0\nstroke = [700.0, 900.0]");
    bench.write("m.toml", text);
    let first = bench.json("select m.toml -n 8 -o first.csv --candidates 200");
    let (_, rows) = listed(&bench, "first.csv");
    for length in rows.iter().flat_map(|r| &r[..6]) {
        let length: f64 = length.parse().unwrap();
        assert!((700.0..=900.0).contains(&length), "{length}");
    }
    let all = bench.json("select m.toml -n 14 -o all.csv --given first.csv --candidates 200");
    assert_eq!(all["given"], 8);
    for k in 0..8 {
        for c in 0..6 {
            let (a, b) = (all["poses"][k][c].as_f64().unwrap(), first["poses"][k][c].as_f64().unwrap());
            assert!((a - b).abs() < 1e-12);
        }
    }
    assert!(number(&all, &["value"]) > number(&first, &["value"]) && number(&all, &["efficiency"]) <= 1.0);
    let (header, rows) = listed(&bench, "all.csv");
    assert_eq!((header[0].as_str(), rows[0][0].as_str(), rows[8][0].as_str()), ("id", "given1", "new1"));
}

#[test]
fn a_requirement_is_met_with_as_few_poses_as_possible() {
    let bench = Bench::project();
    let call = "select mechanisms/table5.toml -o p.csv --candidates 100 --no-polish --require 0.5arcsec,2um";
    let found = bench.json(call);
    let n = found["poses"].as_array().unwrap().len();
    assert!((7..=12).contains(&n), "{n}");
    assert!(number(&found, &["predicted", "rms", "position_m"]) <= 2e-6);
    assert!(number(&found, &["predicted", "rms", "rotation_rad"]) <= 0.5 / 206_264.8);
    let fewer = (n - 1).to_string();
    let call = format!("select mechanisms/table5.toml -o p.csv --candidates 100 --no-polish -n {fewer}");
    let less = bench.json(&call);
    let error = |v: &Value, what: &str| number(v, &["predicted", "rms", what]);
    assert!(error(&less, "position_m") > 2e-6 || error(&less, "rotation_rad") > 0.5 / 206_264.8);
}

#[test]
fn the_table_shows_seven_to_sixty_poses() {
    let bench = Bench::project();
    let call = "select mechanisms/table5.toml -o p.csv --candidates 50 --no-polish --table";
    let found = bench.json(call);
    let rows = found["table"].as_array().unwrap();
    let numbers: Vec<u64> = rows.iter().map(|r| r["n"].as_u64().unwrap()).collect();
    assert_eq!(numbers, (7..=60).collect::<Vec<u64>>());
    assert!(rows.iter().all(|r| r["efficiency"].as_f64().unwrap() <= 1.0));
    let error = |k: usize| number(&rows[k], &["predicted", "rms", "position_m"]);
    assert!(error(0) > 1.5 * error(13) && error(13) > 1.2 * error(53), "{} {} {}", error(0), error(13), error(53));
}

#[test]
fn selections_do_not_depend_on_threads_and_lists_can_be_chosen_from() {
    let bench = Bench::project();
    for index in ["o1", "o4", "pose-error"] {
        let mut texts = Vec::new();
        for threads in ["1", "2"] {
            let call = format!(
                "select mechanisms/table5.toml -o p.csv --candidates 150 --index {index} -n 9 --threads {threads}"
            );
            let mut found = bench.json(&call);
            found["seconds"] = Value::Null;
            texts.push((found, bench.bytes("p.csv")));
        }
        assert!(texts[0] == texts[1], "{index}");
    }
    let call = "select mechanisms/table5.toml -o list.csv --selector random --candidates 60 -n 50";
    bench.json(call);
    let call = "select mechanisms/table5.toml -o p.csv --candidates list.csv --no-polish -n 10";
    let found = bench.json(call);
    assert_eq!(found["candidates"], 50);
    let (_, list) = listed(&bench, "list.csv");
    let (_, chosen) = listed(&bench, "p.csv");
    let near = |a: &[String], b: &[String]| {
        a.iter().zip(b).all(|(a, b)| (a.parse::<f64>().unwrap() - b.parse::<f64>().unwrap()).abs() < 1e-9)
    };
    assert!(chosen.iter().all(|c| list.iter().any(|l| near(c, l))));
}

#[test]
fn a_model_from_absurd_data_is_written_and_not_trusted() {
    let bench = Bench::project();
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
        bench.write("d.csv", format!("{header}\n{}\n", lines.join("\n")));
        for identifier in ["levenberg-marquardt", "least-squares"] {
            let call = format!("calibrate mechanisms/table5.toml d.csv -o c.toml --identifier {identifier}");
            let output = bench.run(&call);
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(3), "{name}, {identifier}: {errors}");
            assert!(bench.has("c.toml"), "{name}, {identifier}");
            std::fs::remove_file(bench.at("c.toml")).unwrap();
        }
    }
}
