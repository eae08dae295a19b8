//! Mechanisms in the frames of a measurement, with what acts on them.

use paracal::conditions::Conditions;
use paracal::conformance;
use paracal::files::Machine;
use paracal::mechanism::{Workspace, mount};
use paracal::nalgebra::Vector3;
use paracal::pose::{Pose, PoseConvention};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::common::bench::{Bench, TABLE_5, number};
use crate::common::{machine, text};

fn random_pose(rng: &mut ChaCha8Rng, reach: f64) -> Pose {
    let mut draw = |half: f64| rng.random_range(-half..half);
    let position = Vector3::new(draw(reach), draw(reach), draw(reach));
    let turn = [draw(3.0), draw(1.4), draw(3.0)];
    Pose::from_coordinates(&[position.x, position.y, position.z, turn[0], turn[1], turn[2]])
}

#[test]
fn a_mounted_mechanism_conforms_and_sees_its_own_poses_elsewhere() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for kind in ["table5", "rubin-m2-hexapod", "rotary-stewart"] {
        let own = machine(kind);
        let plain = own.mechanism.as_ref();
        let (base, target) = (random_pose(&mut rng, 4.0), random_pose(&mut rng, 0.3));
        let again = plain.with_values(plain.values(), plain.home()).unwrap();
        let seen = mount(again, &base, &target);
        let convention = PoseConvention::default();
        let half = own.workspace.unwrap().half.map(|h| 0.3 * h);
        let space = Workspace { convention, centre: convention.coordinates(&seen.home()), half };
        conformance::mechanism(seen.as_ref(), &space).unwrap_or_else(|v| panic!("{kind}: {v}"));
        for _ in 0..20 {
            let pose = own.workspace.unwrap().random(&mut rng);
            let at = Conditions::unknown();
            let measured = base.compose(&pose).compose(&target);
            let joints = plain.inverse(plain.values(), &pose, &at).unwrap();
            let found = seen.inverse(seen.values(), &measured, &at).unwrap();
            let off = joints.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{kind}: {off:e}");
            let reached = seen.forward(seen.values(), &joints, &at, &seen.home()).unwrap();
            assert!(reached.motion_to(&measured).amax() < 1e-9, "{kind}");
        }
    }
}

/// A measurement file with its poses as a tracker elsewhere sees them.
fn seen_elsewhere(table: &str, base: &Pose, target: &Pose) -> String {
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().unwrap();
    let names: Vec<&str> = header.split(',').collect();
    let first = names.iter().position(|name| *name == "x_mm").unwrap();
    let mut text = format!("{header}\n");
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let value = |k: usize| cells[first + k].parse::<f64>().unwrap();
        let q: [f64; 6] = std::array::from_fn(|k| if k < 3 { 1e-3 * value(k) } else { value(k).to_radians() });
        let seen = base.compose(&Pose::from_coordinates(&q)).compose(target).coordinates();
        for k in 0..6 {
            cells[first + k] = if k < 3 { 1e3 * seen[k] } else { seen[k].to_degrees() }.to_string();
        }
        text += &format!("{}\n", cells.join(","));
    }
    text
}

/// What is written is what was printed: evaluating the calibrated file on the data that were fitted gives the printed errors,
/// for models with effects in any frame.
#[test]
fn a_file_of_an_extended_model_says_what_was_found_in_any_frame() {
    let further =
        "\n[platform]\nmass_kg = 500.0\ncentre_of_mass = [0.0, 0.0, 150.0]\npayload_centre = [0.0, 0.0, 300.0]\n";
    let gravity = "\n[[effect]]\nname = \"sag.platform\"\nparameters = { cos = 0.0, sin = 0.0 }\n";
    let heat = "\n[[effect]]\nname = \"thermal.legs.uniform\"\nparameters = { expansion = 0.0 }\n\
                reference = { temp_legs = 18.0 }\n";
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    for (k, (file, effect, truth)) in [
        (TABLE_5.to_owned(), gravity, "sag.platform=40e-6,-30e-6"),
        (TABLE_5.to_owned(), heat, "thermal.legs.uniform=12e-6"),
        (text("mechanisms/rotary-stewart.toml"), gravity, "sag.platform=40e-6,-30e-6"),
    ]
    .into_iter()
    .enumerate()
    {
        let file = if file.contains("[platform]") { file } else { format!("{file}{further}") };
        let bench = Bench::empty().with("plain.toml", &file).with("m.toml", format!("{file}{effect}"));
        let state = |row: usize| format!("{},{}\n", 12.0 + 0.4 * row as f64, 20.0 + (37.0 * row as f64) % 70.0);
        bench.write("k.csv", "temp_legs_degC,elevation_deg\n".to_owned() + &(0..30).map(state).collect::<String>());
        bench.done("select plain.toml -n 30 --candidates 200 --no-polish --conditions k.csv -o poses.csv");
        bench.done(&format!("simulate plain.toml --poses poses.csv --error-sd 0.2mm --effect {truth} -o own.csv"));
        let (base, target) = (random_pose(&mut rng, 4.0), random_pose(&mut rng, 0.2));
        bench.write("d.csv", seen_elsewhere(&bench.text("own.csv"), &base, &target));
        let found = bench.json("calibrate m.toml d.csv -o c.toml");
        assert_eq!(found["trusted"], true, "{k}: {}", found["reasons"]);
        let written = bench.json("evaluate c.toml d.csv");
        for key in ["position_m", "rotation_rad"] {
            let (printed, again) = (number(&found, &["rms_after", key]), number(&written, &["rms", key]));
            assert!((again - printed).abs() <= 1e-9 * printed + 1e-12, "{k}: {again:e} for {printed:e}");
        }
        assert!(bench.text("c.toml").contains("[mounting]"), "{k}");
        // And it can be calibrated again, commanded and diagnosed where it was measured.
        let again = Machine::read(bench.at("c.toml")).unwrap();
        assert!(again.plain().mounting().is_some());
        bench.done("compensate c.toml d.csv -o lengths.csv");
        let refined = bench.json("calibrate c.toml d.csv -o c2.toml");
        let (a, b) = (number(&found, &["rms_after", "position_m"]), number(&refined, &["rms_after", "position_m"]));
        assert!((a / b - 1.0).abs() < 0.05, "{k}: {a:e}, {b:e}");
    }
}
