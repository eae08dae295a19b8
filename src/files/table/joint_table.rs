//! Tables of commanded joints, and of the poses that belong to them.

use crate::files::machine::Machine;
use crate::files::readings::pose::pose_columns;
use crate::files::table::writer::{CsvTable, number};

/// A row of a table of joints and poses, SI.
pub struct JointsAndPose {
    /// Label.
    pub id: Option<String>,
    /// Joint coordinates.
    pub joints: Vec<f64>,
    /// Pose in the coordinates of the machine's convention.
    pub pose: [f64; 6],
}

/// A table of joints and poses in the units of the mechanism file.
pub fn joints_and_poses(machine: &Machine, comment: String, rows: &[JointsAndPose]) -> CsvTable {
    let mut table = labelled_joints(machine, comment, rows);
    table.append(&pose_columns(machine, rows.iter().map(|r| &r.pose)));
    table
}

/// A table of joints alone, in the units of the mechanism file.
pub fn labelled_joints(machine: &Machine, comment: String, rows: &[JointsAndPose]) -> CsvTable {
    let joints = machine.mechanism.joints();
    let labelled = rows.iter().any(|r| r.id.is_some());
    let mut header: Vec<String> = if labelled { vec!["id".into()] } else { Vec::new() };
    header.extend(joints.iter().map(|j| format!("{}_{}", j.name, machine.unit(j.dimension).name)));
    let row = |r: &JointsAndPose| {
        let mut cells: Vec<String> = if labelled { vec![r.id.clone().unwrap_or_default()] } else { Vec::new() };
        cells.extend(r.joints.iter().zip(joints).map(|(v, j)| number(machine.unit(j.dimension).from_si(*v))));
        cells
    };
    CsvTable { comments: vec![comment], header, rows: rows.iter().map(row).collect() }
}
