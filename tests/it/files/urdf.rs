//! Mechanisms from URDF: every convention of closed loops, what is refused, and the way there and back.

use crate::common::urdf_robots;

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::urdf_robots::{Expected, Robot, STYLES, Style, cad_export, expected, pairs, robot};
use nalgebra::Vector3;
use paracal::files::{
    FileError, FindingKind, HomeJoint, Machine, MechanismDocument, Outputs, ReadOptions, UrdfOptions, read_measurement,
};
use paracal::mechanism::{Leg, Mechanism, SixHardpoint};
use serde_json::Value;
use tempfile::TempDir;

fn legs(mechanism: &dyn Mechanism) -> Vec<Leg> {
    (mechanism as &dyn std::any::Any).downcast_ref::<SixHardpoint>().unwrap().to_legs()
}

fn folder_with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn options(close: Vec<[String; 2]>) -> UrdfOptions {
    UrdfOptions { close, ..UrdfOptions::default() }
}

/// Requires the numbers of the mechanism within `tolerance`.
fn agrees(machine: &Machine, e: &Expected, tolerance: f64, what: &str) {
    let found = legs(machine.mechanism.as_ref());
    for (k, leg) in found.iter().enumerate() {
        let off = (leg.platform - e.a[k]).norm().max((leg.base - e.b[k]).norm());
        assert!(off <= tolerance, "{what}: anchors of leg {}: {off:.1e}", k + 1);
        let stroke = leg.stroke.unwrap();
        for (found, wanted) in
            [leg.length, stroke[0], stroke[1]].iter().zip([e.length[k], e.range[k][0], e.range[k][1]])
        {
            assert!((found - wanted).abs() <= tolerance, "{what}: leg {}: {found} for {wanted}", k + 1);
        }
        let entry = &machine.document().legs[k];
        assert_eq!((entry.joint.as_ref(), entry.joint_reversed), (Some(&e.joint[k]), e.reversed[k]), "{what}");
    }
    let home = machine.mechanism.home();
    let turned = home.rotation.matrix() - e.home.rotation.to_rotation_matrix().matrix();
    let off = (home.position - e.home.translation.vector).norm().max(turned.norm());
    assert!(off <= tolerance, "{what}: home is off by {off:.1e}");
}

/// Reads a file with what it leaves open.
fn read_with(path: &Path, options: &UrdfOptions) -> Result<Machine, FileError> {
    Machine::read_with(path, &ReadOptions { urdf: options.clone(), ..ReadOptions::default() })
}

/// The kinds, elements and lines of the findings of a refused file.
fn refusal(text: &str, options: &UrdfOptions) -> Vec<(FindingKind, String, Option<usize>)> {
    let folder = folder_with(&[("r.urdf", text)]);
    match read_with(&folder.path().join("r.urdf"), options) {
        Err(FileError::Urdf { findings, .. }) => findings.into_iter().map(|f| (f.kind, f.element, f.line)).collect(),
        other => panic!("not refused as a URDF: {:?}", other.map(|m| m.warnings)),
    }
}

/// What is beside the robot of a style, so that its loops are closed.
fn read(style: Style) -> Machine {
    let folder = folder_with(&[("r.urdf", &robot(style).text())]);
    let close = match style {
        Style::Pairs => pairs(),
        Style::Mixed => vec![pairs()[4].clone()],
        _ => Vec::new(),
    };
    read_with(&folder.path().join("r.urdf"), &options(close)).unwrap_or_else(|e| panic!("{style:?}: {e}"))
}

#[test]
fn every_convention_gives_the_same_mechanism() {
    for style in STYLES {
        let machine = read(style);
        agrees(&machine, &expected(), 1e-12, &format!("{style:?}"));
        let quiet = machine.warnings.is_empty();
        assert!(quiet || style == Style::Gazebo, "{style:?}: {:?}", machine.warnings);
    }
}

#[test]
fn a_cad_export_is_read_to_its_own_digits() {
    let folder = folder_with(&[("cad.urdf", &cad_export())]);
    let machine = Machine::read(folder.path().join("cad.urdf")).unwrap();
    agrees(&machine, &expected(), 2e-5, "CAD");
}

#[test]
fn closures_are_read_from_side_files() {
    let text = robot(Style::Pairs).text();
    let list = |quote: &str| {
        let pair = |[a, b]: &[String; 2]| format!("[{quote}{a}{quote}, {quote}{b}{quote}]");
        pairs().iter().map(pair).collect::<Vec<_>>().join(", ")
    };
    let e = expected();
    let yaml = format!(
        "closed_loop: [{}]\ntype: ['3d', '3d', 3d, '3d', '3d', '3d']\nname_mot: [{}]\nsomething_else: 5\n",
        list(""),
        e.joint.join(", ")
    );
    let toml = format!("close = [{}]\nlength_unit = \"mm\"\n", list("\""));
    let kinds = toml.replace("\"]", "\", \"ball\"]");
    for (name, side) in [("r.yaml", &yaml), ("r.toml", &toml), ("r.toml", &kinds)] {
        let folder = folder_with(&[("r.urdf", &text), (name, side)]);
        let machine = Machine::read(folder.path().join("r.urdf")).unwrap_or_else(|e| panic!("{name}: {e}"));
        agrees(&machine, &e, 1e-12, name);
    }
    // A TOML may name the URDF instead, from another folder.
    let folder = folder_with(&[("own.toml", &format!("urdf = \"sub/r.urdf\"\n{toml}"))]);
    fs::create_dir(folder.path().join("sub")).unwrap();
    fs::write(folder.path().join("sub/r.urdf"), &text).unwrap();
    let machine = Machine::read(folder.path().join("own.toml")).unwrap();
    agrees(&machine, &e, 1e-12, "own.toml");
    assert_eq!(machine.inputs().len(), 2);
}

#[test]
fn the_side_file_states_what_urdf_cannot() {
    let side = "name = \"ours\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\npivot = [0.0, 0.0, 50.0]\n\
                length_offsets = [0.5, 0.0, -0.25, 0.0, 0.0, 0.0]\n[workspace]\nposition = [20.0, 20.0, 20.0]\n\
                rotation = [2.0, 2.0, 2.0]\n[noise]\nposition = 0.001\nrotation = 0.0001\n[tolerance]\nanchor = 0.5\n";
    let folder = folder_with(&[("r.urdf", &robot(Style::Frames).text()), ("r.toml", side)]);
    let machine = Machine::read(folder.path().join("r.urdf")).unwrap();
    let (found, e) = (legs(machine.mechanism.as_ref()), expected());
    assert_eq!((machine.mechanism.name(), machine.length_unit.name), ("ours", "mm"));
    assert!((found[0].length + 0.5e-3 - e.length[0]).abs() < 1e-12 && (found[0].length_offset - 0.5e-3).abs() < 1e-15);
    assert!((found[2].stroke.unwrap()[0] - 0.25e-3 - e.range[2][0]).abs() < 1e-12);
    assert!((machine.mechanism.home().position - e.home.translation.vector).norm() < 1e-12);
    assert!((machine.workspace.unwrap().half[0] - 0.02).abs() < 1e-15 && machine.noise.is_some());

    let own = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("mechanisms/table5.toml")).unwrap();
    fs::write(folder.path().join("r.toml"), own).unwrap();
    let machine = Machine::read(folder.path().join("r.urdf")).unwrap();
    assert!(machine.warnings[0].contains("legs of its own"), "{:?}", machine.warnings);
    assert!(machine.workspace.is_none());
}

#[test]
fn a_file_that_is_not_assembled_at_zero_keeps_its_anchors() {
    let e = expected();
    let mut off = e.clone();
    off.home.translation.vector += Vector3::new(0.04, -0.03, 0.02);
    let mut text = urdf_robots::robot_with(Style::Frames, &e, None).text();
    let (from, to) = (urdf_robots::pose(&e.home, None), urdf_robots::pose(&off.home, None));
    assert!(text.contains(&from));
    text = text.replace(&from, &to);
    let folder = folder_with(&[("r.urdf", &text)]);
    let machine = Machine::read(folder.path().join("r.urdf")).unwrap();
    agrees(&machine, &e, 1e-9, "not closed");
    assert!(machine.warnings.iter().any(|w| w.contains("HomeNotClosed")), "{:?}", machine.warnings);

    // Hung on the first leg, the platform goes where the joints of that leg are said to be.
    let folder = folder_with(&[("r.urdf", &robot(Style::Hung).text())]);
    let home = vec![HomeJoint { joint: "drive_a".into(), value: 0.03, dimension: None }];
    let machine = read_with(&folder.path().join("r.urdf"), &UrdfOptions { home, ..UrdfOptions::default() }).unwrap();
    let lengths = machine.mechanism.inverse(machine.mechanism.values(), &machine.mechanism.home(), &Default::default());
    let lengths = lengths.unwrap();
    assert!((lengths[0] - e.length[0] - 0.03).abs() < 1e-9, "{lengths:?} {:?}", machine.warnings);
    assert!(machine.warnings.iter().any(|w| w.contains("HomeNotClosed")), "{:?}", machine.warnings);
}

#[test]
fn two_roots_need_a_named_platform() {
    let mut two = robot(Style::Frames);
    two.joints.retain(|j| !j.contains("floating"));
    let kinds: Vec<_> = refusal(&two.text(), &UrdfOptions::default());
    assert_eq!(kinds[0].0, FindingKind::SeveralRoots);
    let folder = folder_with(&[("r.urdf", &two.text())]);
    let named = UrdfOptions { platform_link: Some("platform".into()), ..UrdfOptions::default() };
    let machine = read_with(&folder.path().join("r.urdf"), &named).unwrap();
    // Home is then sought from the lengths; the base frame is that of 'base' by its name.
    agrees(&machine, &expected(), 1e-9, "two roots");
}

#[test]
fn what_is_wrong_is_named_with_its_element_and_line() {
    use FindingKind as K;
    type Change = fn(&mut Robot);
    let cases: Vec<(K, &str, Change)> = vec![
        (K::DuplicateLink, "platform", |r| r.links.push("<link name=\"platform\"/>".into())),
        (K::UnknownLink, "drive_b", |r| replace(r, "drive_b", "strut_B_rod", "strut_B_rot")),
        (K::ZeroAxis, "drive_c", |r| replace(r, "drive_c", "0 0 0.5", "0 0 0")),
        (K::BadNumber, "drive_c", |r| replace(r, "drive_c", "0 0 0.5", "0 0 1 junk")),
        (K::NotFinite, "strut_D_u2", |r| replace(r, "strut_D_u2", "xyz=\"0.0", "xyz=\"inf")),
        (K::UnsupportedJointType, "strut_D_u1", |r| replace(r, "strut_D_u1", "revolute", "universal")),
        (K::UnpairedClosingFrame, "closing_A_1", |r| {
            r.links.retain(|l| !l.contains("closing_A_2"));
            r.joints.retain(|j| !j.contains("closing_A_2"));
        }),
        (K::NoLimit, "drive_d", |r| {
            let j = r.joints.iter_mut().find(|j| j.contains("\"drive_d\"")).unwrap();
            *j = j[..j.find("<limit").unwrap()].to_owned() + "</joint>";
        }),
        (K::EmptyRange, "drive_a", |r| replace(r, "drive_a", "upper=\"0.1", "upper=\"-5.1")),
        (K::MimicSlide, "drive_e", |r| replace(r, "drive_e", "</joint>", "<mimic joint=\"drive_a\"/></joint>")),
        (K::LegWithoutSlide, "strut_F_u1", |r| replace(r, "drive_f", "prismatic", "fixed")),
        (K::AnchorUndetermined, "drive_b", |r| replace(r, "strut_B_u2", "0 2 0", "1 0 0")),
        (K::LegMobility, "drive_b", |r| replace(r, "strut_B_u2", "continuous", "fixed")),
        (K::JointAxesDoNotMeet, "drive_b", |r| replace(r, "strut_B_u2", "xyz=\"0.0 0.0 0.0", "xyz=\"0 0 0.04")),
        (K::CyclicParents, "x", |r| {
            r.links.extend(["x", "y"].map(|n| format!("<link name=\"{n}\"/>")));
            r.joint("xy", "fixed", ["x", "y"], &urdf_robots::Frame::identity(), "");
            r.joint("yx", "fixed", ["y", "x"], &urdf_robots::Frame::identity(), "");
        }),
        (K::UnknownClosureLink, "c", |r| {
            r.tags.push(
                "<loop_joint name=\"c\" type=\"fixed\"><link1 link=\"a\"/><link2 link=\"base\"/></loop_joint>".into(),
            );
        }),
        (K::UnknownClosureType, "c", |r| {
            r.tags.push(
                "<loop_joint name=\"c\" type=\"rope\"><link1 link=\"base\"/><link2 link=\"base\"/></loop_joint>".into(),
            );
        }),
        (K::ClosureWithinOneBody, "c", |r| {
            r.tags.push(
                "<loop_joint name=\"c\" type=\"spherical\"><link1 link=\"closing_A_2\"/><link2 link=\"platform\"/></loop_joint>"
                    .into(),
            );
        }),
        (K::ConflictingClosures, "closing_A", |r| {
            r.tags.push(
                "<loop_joint name=\"c\" type=\"spherical\"><link1 link=\"strut_A_rod\"/><link2 link=\"platform\"/></loop_joint>"
                    .into(),
            );
        }),
    ];
    for (kind, element, change) in cases {
        let mut r = robot(Style::Frames);
        change(&mut r);
        let text = r.text();
        let found = refusal(&text, &UrdfOptions::default());
        let Some((_, _, line)) = found.iter().find(|(k, e, _)| (*k, e.as_str()) == (kind, element)) else {
            panic!("{kind:?} '{element}' is not among {found:?}");
        };
        if let Some(line) = line {
            let text = text.lines().nth(line - 1).unwrap();
            assert!(text.contains(&format!("\"{element}")), "{kind:?}: line {line} is {text}");
        }
    }
}

/// Replaces a part of the joint of that name.
fn replace(r: &mut Robot, joint: &str, from: &str, to: &str) {
    let found = r.joints.iter_mut().find(|j| j.contains(&format!("joint name=\"{joint}\""))).unwrap();
    assert!(found.contains(from), "{found}");
    *found = found.replacen(from, to, 1);
}

#[test]
fn what_is_no_urdf_is_said_to_be_none() {
    use FindingKind as K;
    let good = robot(Style::Frames).text();
    let cases = [
        (K::NotUrdf, "<sdf version=\"1.7\"/>".to_owned()),
        (K::NotUrdf, "<mujoco/>".into()),
        (K::UnexpandedXacro, good.replacen("<link", "<xacro:macro name=\"x\"/><link", 1)),
        (K::UnexpandedXacro, good.replacen("name=\"floor\"", "name=\"${prefix}floor\"", 1)),
        (K::Xml, good.replacen("</robot>", "", 1)),
        (K::Xml, good.replacen("<link ", "<link x=5 ", 1)),
        (K::TooLarge, format!("{}{}", "<robot name=\"deep\">", "<a>".repeat(200_000))),
        (
            K::SerialChain,
            "<robot name=\"arm\"><link name=\"a\"/><link name=\"b\"/><joint name=\"j\" type=\"revolute\">\
          <parent link=\"a\"/><child link=\"b\"/></joint></robot>"
                .into(),
        ),
        (K::NoLoopClosures, robot(Style::Pairs).text()),
        (K::MissingPart, "<robot name=\"empty\"/>".into()),
    ];
    for (kind, text) in cases {
        let found = refusal(&text, &UrdfOptions::default());
        assert_eq!(found[0].0, kind, "{found:?}");
    }
    let wrong = refusal(&robot(Style::Pairs).text(), &options(vec![["strut_A_tip".into(), "nowhere".into()]]));
    assert_eq!((wrong[0].0, wrong[0].1.as_str()), (FindingKind::UnknownClosureLink, "nowhere"));
}

fn shared(name: &str) -> Option<PathBuf> {
    let found = std::env::var_os("PARACAL_DATA").map(|root| PathBuf::from(root).join("urdf-examples").join(name));
    let found = found.filter(|p| p.is_dir());
    if found.is_none() {
        eprintln!("skipped: PARACAL_DATA does not lead to urdf-examples/{name}");
    }
    found
}

#[test]
fn the_shared_examples_are_met() {
    for style in ["closing_frames", "hung", "loop_joint"] {
        let Some(folder) = shared(style) else { return };
        let wanted: Value = serde_json::from_str(&fs::read_to_string(folder.join("expected.json")).unwrap()).unwrap();
        let machine = Machine::read(folder.join("robot.urdf")).unwrap();
        let number = |v: &Value| v.as_f64().unwrap();
        for (leg, (found, wanted)) in
            legs(machine.mechanism.as_ref()).iter().zip(wanted["legs"].as_array().unwrap()).enumerate()
        {
            for k in 0..3 {
                assert!((found.platform[k] - number(&wanted["a"][k])).abs() < 1e-12, "{style}, leg {leg}");
                assert!((found.base[k] - number(&wanted["b"][k])).abs() < 1e-12, "{style}, leg {leg}");
            }
            assert!((found.length - number(&wanted["L0"])).abs() < 1e-12);
            let stroke = found.stroke.unwrap();
            assert!((0..2).all(|k| (stroke[k] - number(&wanted["length_range"][k])).abs() < 1e-12));
            let entry = &machine.document().legs[leg];
            assert_eq!(entry.joint.as_deref(), wanted["prismatic"].as_str());
            assert_eq!(entry.joint_reversed, number(&wanted["sign"]) < 0.0);
        }
        let home = machine.mechanism.home();
        let pose = &wanted["platform_in_base"];
        for i in 0..3 {
            assert!((home.position[i] - number(&pose[i][3])).abs() < 1e-12, "{style}");
            assert!((0..3).all(|j| (home.rotation[(i, j)] - number(&pose[i][j])).abs() < 1e-12), "{style}");
        }
    }
}

#[test]
fn the_shared_bad_examples_are_named() {
    let Some(folder) = shared("bad") else { return };
    let wanted: Value = serde_json::from_str(&fs::read_to_string(folder.join("expected.json")).unwrap()).unwrap();
    for (name, text) in wanted.as_object().unwrap() {
        let kind = text.as_str().unwrap().split([':', ' ']).next().unwrap();
        let read = Machine::read(folder.join(format!("{name}.urdf")));
        if name == "home_not_closed" {
            assert!(read.unwrap().warnings.iter().any(|w| w.contains(kind)));
            continue;
        }
        let message = read.unwrap_err().to_string();
        assert!(message.contains(&format!("{name}.urdf")) && message.contains(&format!("{kind}: ")), "{message}");
    }
}

/// Requires that two machines are the same to 1e-12.
fn same(first: &Machine, second: &Machine, what: &str) {
    for (k, (a, b)) in legs(first.mechanism.as_ref()).iter().zip(legs(second.mechanism.as_ref())).enumerate() {
        let off = (a.platform - b.platform).norm().max((a.base - b.base).norm()).max((a.length - b.length).abs());
        assert!(off.max((a.length_offset - b.length_offset).abs()) < 1e-12, "{what}: leg {}: {off:.1e}", k + 1);
        match (a.stroke, b.stroke) {
            (None, None) => {}
            (Some(a), Some(b)) => assert!((0..2).all(|k| (a[k] - b[k]).abs() < 1e-12), "{what}"),
            (a, b) => panic!("{what}: stroke {a:?} became {b:?}"),
        }
    }
    let step = first.mechanism.home().motion_to(&second.mechanism.home());
    assert!(step.norm() < 1e-12, "{what}: home {step:?}");
    // As written: a number may differ in its last digit.
    let rest = |m: &Machine| {
        let document = MechanismDocument { legs: Vec::new(), home: None, nominal_home: None, ..m.document().clone() };
        document.to_text()
    };
    assert_eq!(rest(first), rest(second), "{what}");
}

fn there_and_back(machine: &Machine, what: &str) -> Machine {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.urdf");
    let mut outputs = Outputs::default();
    let written = outputs.add_mechanism(&path, machine.document()).unwrap_or_else(|e| panic!("{what}: {e}"));
    outputs.write().unwrap();
    assert_eq!(written.side, Some(path.with_extension("toml")));
    // A stock parser reads it, all of it.
    assert_eq!(urdf_rs::read_file(&path).unwrap().joints.len(), 1 + 6 * 5);
    let back = Machine::read(&path).unwrap_or_else(|e| panic!("{what}: {e}"));
    let own = |w: &&String| !machine.warnings.contains(w) && !w.contains("HomeOutsideLimits");
    assert_eq!(back.warnings.iter().filter(own).count(), 0, "{what}: {:?}", back.warnings);
    back
}

#[test]
fn every_bundled_mechanism_survives_the_way_to_urdf_and_back() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("mechanisms");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        if path.extension().is_none_or(|e| e != "toml") || !text.contains("[[leg]]") || !text.contains("six-hardpoint")
        {
            continue;
        }
        let machine = Machine::read(&path).unwrap();
        let what = path.display().to_string();
        same(&machine, &there_and_back(&machine, &what), &what);
        count += 1;
    }
    assert!(count >= 5);
    for style in STYLES {
        let machine = read(style);
        let back = there_and_back(&machine, "fixture");
        same(&machine, &back, &format!("{style:?}"));
        for (a, b) in machine.document().legs.iter().zip(&back.document().legs) {
            assert_eq!((&a.joint, a.joint_reversed), (&b.joint, b.joint_reversed));
        }
    }
}

#[test]
fn a_home_off_the_lengths_survives_too() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("mechanisms/table5.toml")).unwrap();
    let text = text.replacen("length = 800.0", "length = 800.0\nlength_offset = 1.5\nstroke = [700.0, 900.0]", 1)
        + "\n[home]\nposition = [1.0, 2.0, 480.0]\nrotation = [0.1, 0.2, 0.3]\n";
    let machine = Machine::from_text(&text, Path::new("m.toml")).unwrap();
    same(&machine, &there_and_back(&machine, "home"), "home");
}

#[test]
fn data_columns_may_be_named_after_the_joints() {
    let machine = read(Style::Frames);
    let e = expected();
    let pose = "x_m,y_m,z_m,rx_rad,ry_rad,rz_rad";
    let read = |header: &str, row: &str| {
        let folder = folder_with(&[("d.csv", &format!("{header},{pose}\n{row},0,0,0.7,0,0,0\n"))]);
        read_measurement(folder.path().join("d.csv"), &machine).map_err(Box::new)
    };
    let named = e.joint.iter().map(|j| format!("{j}_mm")).collect::<Vec<_>>().join(",");
    let found = read(&named, "1,2,3,4,5,6").unwrap();
    let joints = &found.data.iter().next().unwrap().joints;
    for (k, joint) in joints.iter().enumerate() {
        let sign = if e.reversed[k] { -1.0 } else { 1.0 };
        assert!((joint - e.length[k] - sign * 1e-3 * (k + 1) as f64).abs() < 1e-12);
    }
    let mixed = read("leg1_mm,drive_b_m,leg3_m,leg4_m,drive_e_um,leg6_m", "700,0.001,0.7,0.7,-5,0.7").unwrap();
    let joints = &mixed.data.iter().next().unwrap().joints;
    assert!((joints[0] - 0.7).abs() < 1e-12 && (joints[4] - e.length[4] - 5e-6).abs() < 1e-12);
    let twice = read(&format!("leg1_mm,{named}"), "1,1,2,3,4,5,6").unwrap_err().to_string();
    assert!(twice.contains("means the same"), "{twice}");
    let unit = read(&named.replace("drive_a_mm", "drive_a"), "1,2,3,4,5,6").unwrap_err().to_string();
    assert!(unit.contains("drive_a_mm"), "{unit}");
}

fn read_text(text: &str, options: &UrdfOptions) -> Result<Machine, FileError> {
    let folder = folder_with(&[("r.urdf", text)]);
    read_with(&folder.path().join("r.urdf"), options)
}

/// The machine of a changed robot.
fn changed(style: Style, change: impl FnOnce(&mut Robot)) -> Machine {
    let mut r = robot(style);
    change(&mut r);
    read_text(&r.text(), &UrdfOptions::default()).unwrap_or_else(|e| panic!("{style:?}: {e}"))
}

fn refused(style: Style, options: &UrdfOptions, change: impl FnOnce(&mut Robot)) -> Vec<(FindingKind, String)> {
    let mut r = robot(style);
    change(&mut r);
    refusal(&r.text(), options).into_iter().map(|(kind, element, _)| (kind, element)).collect()
}

fn warns(machine: &Machine, parts: &[&str]) {
    let told = machine.warnings.iter().any(|w| parts.iter().all(|p| w.contains(p)));
    assert!(told, "{parts:?}: {:?}", machine.warnings);
}

#[test]
fn errors_count_however_many_findings_there_are() {
    let mut r = robot(Style::Frames);
    for k in 0..150 {
        r.links.push(format!("<link name=\"x{k}\"/>"));
        r.joint(&format!("j{k}"), "prismatic", ["base", &format!("x{k}")], &urdf_robots::Frame::identity(), "");
    }
    let machine = read_text(&r.text(), &UrdfOptions::default()).unwrap();
    assert_eq!(machine.warnings.len(), 101);
    assert!(machine.warnings[100].contains("50 more warnings"), "{}", machine.warnings[100]);
    replace(&mut r, "drive_a", "lower=\"", "lower=\"99\" was=\"");
    assert_eq!(refusal(&r.text(), &UrdfOptions::default())[0].0, FindingKind::EmptyRange);
    (0..150).for_each(|k| r.links.push(format!("<link name=\"x{k}\"/>")));
    let message = read_text(&r.text(), &UrdfOptions::default()).unwrap_err().to_string();
    assert_eq!(message.lines().count(), 101);
    assert!(message.contains("50 more errors"), "{message}");
}

#[test]
fn a_place_that_is_only_known_at_home_is_said_to_be_so() {
    let machine = read(Style::Gazebo);
    assert_eq!(machine.warnings.len(), 1, "{:?}", machine.warnings);
    warns(&machine, &["line ", "PlaceTakenAtHome", "--home"]);
    // Without a pose of the platform it is known nowhere.
    let named = UrdfOptions { platform_link: Some("platform".into()), ..UrdfOptions::default() };
    let found = refused(Style::Gazebo, &named, |r| r.joints.retain(|j| !j.contains("floating")));
    assert_eq!(found[0], (FindingKind::MissingPart, "close_A".into()));
}

#[test]
fn a_tree_rooted_in_its_platform_does_not_swap_the_bodies() {
    let mut r = robot(Style::Frames);
    r.joints.retain(|j| !j.contains("floating"));
    let ground = urdf_robots::frame([0.3, -0.2, 0.1], [0.0, 0.1, 0.7]);
    r.joint("free", "floating", ["platform", "floor"], &(ground * expected().home).inverse(), "");
    assert_eq!(refusal(&r.text(), &UrdfOptions::default())[0].0, FindingKind::AmbiguousPlatform);
    let based = UrdfOptions { base_link: Some("base".into()), ..UrdfOptions::default() };
    agrees(&read_text(&r.text(), &based).unwrap(), &expected(), 1e-9, "rooted in the platform");
    let renamed = r.text().replace("\"platform\"", "\"plate\"");
    let machine = read_text(&renamed, &UrdfOptions::default()).unwrap();
    warns(&machine, &["line ", "SwappedNames", "--base-link base"]);
    warns(&machine, &["Note", "'plate' is taken as the base frame"]);
}

#[test]
fn the_freedoms_of_a_leg_are_ranked_and_not_counted() {
    let at_base = refused(Style::Frames, &UrdfOptions::default(), |r| replace(r, "strut_B_u2", "0 2 0", "0 0 1"));
    assert_eq!(at_base, [(FindingKind::AnchorUndetermined, "drive_b".into())]);
    let parallel = |r: &mut Robot| r.tags[0] = r.tags[0].replace("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 1 0\"/>");
    let found = refused(Style::UrdfPlus, &UrdfOptions::default(), parallel);
    assert_eq!(found, [(FindingKind::LegMobility, "drive_a".into())]);
    let machine = changed(Style::UrdfPlus, |r| r.tags[0] = r.tags[0].replace("<axis xyz=\"0 0 1\"/>", ""));
    warns(&machine, &["DefaultAxis", "<loop> 'close_A'"]);
    // A pan and a tilt are two axes across the leg, though the first is along it at zero.
    changed(Style::Frames, |r| replace(r, "strut_B_u1", "1 0 0", "0 0 1"));
}

#[test]
fn statements_that_contradict_one_another_are_refused() {
    let frame = urdf_robots::frame([0.1, 0.0, 0.0], [0.0; 3]);
    let found = refused(Style::Frames, &UrdfOptions::default(), |r| {
        r.joint("second", "fixed", ["platform", "closing_A_2"], &frame, "");
    });
    assert_eq!(found, [(FindingKind::ConflictingClosures, "second".into())]);
    let again = |axis: &'static str| {
        move |r: &mut Robot| {
            let second = r.tags[0].replace("close_A", "again").replace("<axis xyz=\"0 0 1\"/>", axis);
            r.tags.push(second);
        }
    };
    changed(Style::UrdfPlus, again("<axis xyz=\"0 0 -2\"/>"));
    let found = refused(Style::UrdfPlus, &UrdfOptions::default(), again("<axis xyz=\"1 0 0\"/>"));
    assert_eq!(found, [(FindingKind::ConflictingClosures, "again".into())]);
    // Anchors that are swapped leave a gap at home, at these two legs.
    let text = robot(Style::Frames).text().replace("closing_A_2", "X").replace("closing_B_2", "closing_A_2");
    let machine = read_text(&text.replace("\"X", "\"closing_B_2"), &UrdfOptions::default()).unwrap();
    warns(&machine, &["line ", "HomeNotClosed", "only these: drive_a, drive_b"]);
}

#[test]
fn what_hangs_on_a_leg_is_passed_over() {
    for mimic in ["", "<mimic joint=\"drive_a\"/>"] {
        let machine = changed(Style::Frames, |r| {
            r.links.push("<link name=\"cover\"/>".into());
            let more = format!("<axis xyz=\"1 0 0\"/>{mimic}");
            r.joint("lid", "prismatic", ["strut_A_rod", "cover"], &urdf_robots::Frame::identity(), &more);
        });
        agrees(&machine, &expected(), 1e-12, "cover");
        warns(&machine, &["line ", "Note", "'lid'", "leads to nothing"]);
    }
}

#[test]
fn misspelt_attributes_are_told() {
    let machine = changed(Style::Frames, |r| {
        replace(r, "strut_A_u1", "<axis xyz=", "<axis xyx=");
        replace(r, "strut_A_u2", "<origin ", "<origin rp=\"0 0 1\" ");
    });
    warns(&machine, &["line ", "UnknownAttribute", "'strut_A_u1' axis", "'xyx'", "did you mean 'xyz'"]);
    warns(&machine, &["DefaultAxis", "'strut_A_u1'"]);
    warns(&machine, &["line ", "UnknownAttribute", "'strut_A_u2' origin", "'rp'", "did you mean 'rpy'"]);
}
