//! Where home is when the file does not say it, and where the base is when the root is another link.

use std::fs;
use std::path::Path;

use paracal::files::{Machine, read_measurement};

use crate::common::bench::{NOISY, TABLE_5, says};

fn machine(text: &str) -> Machine {
    Machine::from_text(text, "m.toml".as_ref()).unwrap()
}

#[test]
fn a_mirror_image_of_home_is_named() {
    let note = |text: &str| machine(text).note_on_home();
    let stated = ["[home] is not stated", "z = 475.696 mm, which is taken", "z = -475.696 mm", "state [home]"];
    says(&note(TABLE_5).unwrap(), &stated);
    // Points out of their planes, and a base above the origin: the mirror image is not quite one.
    let bent = TABLE_5.replacen("[1164.388, -977.037, 0.0]", "[1164.388, -977.037, 121.0]", 1).replacen(
        "platform = [-951.059, 951.059, 0.0]",
        "platform = [-951.059, 951.059, 14.0]",
        1,
    );
    says(&note(&bent).unwrap(), &["[home] is not stated", "z = -", "the other side of the base"]);
    let home = "\n[home]\nposition = [0.0, 0.0, -475.7]\nrotation = [0.0, 0.0, 0.0]\n";
    assert_eq!(note(&format!("{TABLE_5}{home}")), None);
}

#[test]
fn poses_that_were_measured_below_the_base_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let mut text: String =
        (1..=6).map(|leg| format!("leg{leg}_mm,")).collect::<String>() + "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n";
    for z in [-480.0, -470.0, 471.0] {
        text += &format!("800,800,800,800,800,800,0,0,{z},0,0,0\n");
    }
    fs::write(&path, text).unwrap();
    let said = read_measurement(&path, &machine(TABLE_5)).unwrap().warnings.join("\n");
    says(&said, &["2 of 3 measured poses lie on the other side", "[home] is not stated", "z = -475.696 mm"]);
    fs::write(&path, NOISY).unwrap();
    assert!(read_measurement(&path, &machine(TABLE_5)).unwrap().warnings.is_empty());
}

#[test]
fn a_base_that_hangs_on_a_joint_is_named() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("mechanisms/desk-hexapod.urdf")).unwrap();
    for joint in ["revolute", "continuous", "prismatic"] {
        let gantry = format!(
            "<link name=\"gantry\"/><joint name=\"carrier\" type=\"{joint}\"><parent link=\"gantry\"/><child link=\"base\"/>\
             <origin xyz=\"0.1 -0.3 0.7\" rpy=\"0 0 0.5\"/><axis xyz=\"1 0 0\"/>\
             <limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint>\n  <link name=\"base\">"
        );
        let text = text.replacen("<link name=\"base\">", &gantry, 1);
        let message = Machine::from_text(&text, "r.urdf".as_ref()).unwrap_err().to_string();
        says(&message, &["'gantry'", "six join 'base' and 'platform'", "--base-link base"]);
    }
}
