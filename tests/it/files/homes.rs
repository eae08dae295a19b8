//! Where home is when the file does not say it, and where the base is when the root is another link.

use std::fs;
use std::path::Path;

use paracal::files::Machine;

use crate::common::bench::{TABLE_5, says};

fn warnings(text: &str) -> String {
    Machine::from_text(text, "m.toml".as_ref()).unwrap().warnings.join("\n")
}

#[test]
fn a_mirror_image_of_home_is_named() {
    says(
        &warnings(TABLE_5),
        &["[home] is not stated", "at z = 475.69", "z = -475.69", "below the base", "state [home]"],
    );
    // Points out of their planes, and a base above the origin: the mirror image is not quite one.
    let bent = TABLE_5.replacen("[1164.388, -977.037, 0.0]", "[1164.388, -977.037, 121.0]", 1).replacen(
        "platform = [-951.059, 951.059, 0.0]",
        "platform = [-951.059, 951.059, 14.0]",
        1,
    );
    says(&warnings(&bent), &["[home] is not stated", "z = -", "below the base"]);
    let home = "\n[home]\nposition = [0.0, 0.0, -475.7]\nrotation = [0.0, 0.0, 0.0]\n";
    assert!(!warnings(&format!("{TABLE_5}{home}")).contains("[home] is not stated"));
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
