//! Nothing of what stands in a measurement file is dropped in silence: it is read, named, or refused.

use paracal::files::{Machine, read_measurement, read_poses};

use super::read_table as read;
use crate::common::bench::{NOISY, TABLE_5, says};

/// The bundled data with other names of their columns.
fn renamed(names: &[(&str, &str)]) -> String {
    let (header, rows) = NOISY.split_once('\n').unwrap();
    let other = |name: &str| names.iter().find(|(from, _)| *from == name).map_or(name, |(_, to)| to).to_owned();
    header.split(',').map(other).collect::<Vec<_>>().join(",") + "\n" + rows
}

/// The bundled data with further columns, whose cells are those of `cell` for each row.
fn with(header: &str, cell: impl Fn(usize) -> String) -> String {
    let row = |(k, line): (usize, &str)| match k {
        0 => format!("{line},{header}\n"),
        _ => format!("{line},{}\n", cell(k - 1)),
    };
    NOISY.lines().filter(|line| !line.starts_with('#')).enumerate().map(row).collect()
}

fn refused(text: &str, parts: &[&str]) {
    says(&read(text).unwrap_err().to_string(), parts);
}

#[test]
fn coordinates_under_other_names_are_refused_with_the_right_one() {
    let angles = ["rx_deg", "ry_deg", "rz_deg"];
    for (names, first, meant) in [
        (["bank_roll_deg", "Pitch_deg", "Yaw_deg"], "Pitch_deg", "'ry_deg'"),
        (["rotation_x_deg", "rotation_y_deg", "rotation_z_deg"], "rotation_x_deg", "'rx_deg'"),
        (["phi_deg", "theta_deg", "psi_deg"], "phi_deg", "'rx_deg' or 'rz_deg'"),
        (["A_deg", "B_deg", "C_deg"], "A_deg", "'rx_deg' or 'rz_deg'"),
        (["Roll", "Pitch", "Yaw"], "Roll", "'rx_deg'"),
        (["RX", "RY", "RZ"], "RX", "'rx_deg'"),
        (["x_angle_deg", "y_angle_deg", "z_angle_deg"], "x_angle_deg", "'rx_deg'"),
        (["first_deg", "second_deg", "third_deg"], "first_deg", "'rx_deg', 'ry_deg', 'rz_deg'"),
    ] {
        let pairs: Vec<(&str, &str)> = angles.iter().copied().zip(names).collect();
        refused(&renamed(&pairs), &["d.csv: column '", first, meant]);
    }
    for (name, meant) in [("X", "'x_mm'"), ("Tx_mm", "'x_mm'"), ("pos_x_mm", "'x_mm'"), ("x_position_mm", "'x_mm'")] {
        refused(&renamed(&[("x_mm", name)]), &[&format!("column '{name}'"), meant]);
    }
    let lost = [("x_mm", "px_mm"), ("y_mm", "py_mm"), ("z_mm", "height_mm")];
    refused(&renamed(&lost), &["column 'px_mm'", "did you mean 'x_mm'"]);
    let lost = [("x_mm", "east_mm"), ("y_mm", "north_mm"), ("z_mm", "up_mm")];
    refused(&renamed(&lost), &["column 'east_mm'", "no coordinate of the position", "'x_mm'", "leave out its unit"]);
    refused(&renamed(&[("leg1_mm", "Leg1")]), &["column 'Leg1'", "names are lower case", "'leg1_mm'"]);
    for (k, name) in ["quat_w", "quat_x", "quat_y", "quat_z"].iter().enumerate() {
        let names = [("rx_deg", "a1"), ("ry_deg", "a2"), ("rz_deg", name)];
        refused(&renamed(&names), &[name, ["'qw'", "'qx'", "'qy'", "'qz'"][k]]);
    }
}

#[test]
fn a_whole_pose_leaves_such_names_to_conditions() {
    let found = read(&with("roll_deg,U,humidity,note", |row| format!("{row},1.5,{},calm", 40 + row))).unwrap();
    assert_eq!(found.columns_not_used, ["roll_deg", "U", "humidity", "note"]);
    assert_eq!(found.data.sample(3).conditions.get("humidity"), Some(43.0));
    let known = read(&with("temp_legs_degC,elevation_deg,gravity_x,gravity_y,gravity_z", |_| "20,90,0,0,-1".into()));
    assert!(known.unwrap().columns_not_used.is_empty());
    let found = read(&with("cmd_x_mm,sigma_leg2_mm", |_| "0,0.01".into())).unwrap();
    assert_eq!(found.columns_not_used, ["cmd_x_mm", "sigma_leg2_mm"]);
}

#[test]
fn lists_of_poses_are_held_to_the_same_names() {
    let machine = Machine::from_text(TABLE_5, "m.toml".as_ref()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    std::fs::write(&path, "x_mm,y_mm,z_mm,roll_deg,pitch_deg,yaw_deg,check\n0,0,480,1,2,3,ok\n").unwrap();
    let message = read_poses(&path, &machine).unwrap_err().to_string();
    says(&message, &["p.csv: column 'roll_deg'", "did you mean 'rx_deg'?"]);
}

#[test]
fn a_sigma_belongs_to_a_column() {
    let one = |_: usize| "0.01".to_owned();
    refused(&with("sigma_p2y_mm", one), &["column 'sigma_p2y_mm'", "no column 'p2y_…'", "delete this"]);
    refused(&with("sigma_contact_mm", one), &["column 'sigma_contact_mm'", "no column 'contact_…'"]);
    refused(&with("sigma_wind", one), &["column 'sigma_wind'", "no column 'wind_…'"]);
    let (partial, column) = (renamed(&[("y_mm", "sigma_y_mm")]), "column 'sigma_y_mm'");
    refused(&partial, &[column, "no column 'y_…'"]);
}

#[test]
fn targets_may_have_a_sigma_each() {
    let header = "leg1_mm,leg2_mm,leg3_mm,leg4_mm,leg5_mm,leg6_mm,p1x_mm,p1y_mm,p1z_mm,p2x_mm,p2y_mm,p2z_mm";
    let row = "800,800,800,800,800,800,1,2,3,4,,6";
    let text = format!("{header},sigma_p2x_mm,sigma_p1z_mm,sigma_x_mm\n{row},0.05,,0.02\n{row},,0.03,\n");
    let found = read(&text).unwrap();
    let sigma = |sample: usize| -> Vec<f64> {
        let (model, index) = found.data.reading(sample);
        let covariance = model.covariance(index, &paracal::measurement::Frames::default());
        covariance.diagonal().iter().map(|v| (1e6 * v.sqrt()).round()).collect()
    };
    // The noise of the mechanism file is 1 um; an empty cell states nothing.
    assert_eq!(sigma(0), [20.0, 1.0, 1.0, 50.0, 1.0]);
    assert_eq!(sigma(1), [1.0, 1.0, 30.0, 1.0, 1.0]);
}

#[test]
fn conditions_state_their_own_unit() {
    let two = |_: usize| "2".to_owned();
    for (name, parts) in [
        ("payload_um", ["'um' is not a unit for it", "kg | g"]),
        ("payload_lbs", ["must end in a unit (kg | g)", "'payload_kg'"]),
        ("time_ms", ["(s | min | h)", "'time_s'"]),
        ("azimuth_degC", ["'degC' is not a unit for it", "deg"]),
        ("elevation_kg", ["'kg' is not a unit for it", "rename the column"]),
        ("Azimuth_rad", ["names are lower case", "'azimuth_rad'"]),
        ("Payload_kg", ["names are lower case", "'payload_kg'"]),
        ("Temp_legs", ["names are lower case", "'temp_legs_degC'"]),
        ("temp_base", ["must end in a unit", "'temp_base_degC'"]),
        ("temp_leg9_K", ["legs 1 to 6", "delete the column"]),
        ("rx", ["must end in a unit", "'rx_deg'"]),
    ] {
        let text = if name == "rx" { renamed(&[("rx_deg", "rx")]) } else { with(name, two) };
        refused(&text, &[&format!("column '{name}'"), parts[0], parts[1]]);
    }
    let found = read(&with("payload_kg,payload_rate", |_| "2,3".into())).unwrap();
    assert_eq!(found.columns_not_used, ["payload_rate"]);
    assert!(read(&with("payload", two)).unwrap().columns_not_used.is_empty());
}

#[test]
fn clocks_run_forwards_and_are_of_one_kind() {
    let said = |text: &str| read(text).unwrap().warnings.join("\n");
    let shuffled = with("time_min", |row| format!("{}", if row % 5 == 3 { 0 } else { row }));
    says(&said(&shuffled), &["time runs backwards at data rows 3, 8, 13 and 18;", "sort them by time"]);
    let back = with("time_utc", |row| format!("08:{:02}:00", if row == 7 { 2 } else { 10 + row }));
    says(&said(&back), &["time runs backwards at data row 7;"]);
    assert!(!said(&with("time_s", |row| row.to_string())).contains("backwards"));
    let mixed = with("time_utc", |row| if row < 4 { "2026-03-01T08:00:00".into() } else { "08:30:00".into() });
    refused(&mixed, &["data row 4", "'08:30:00' has no date", "write all with a date"]);
    let mixed = with("time_utc", |row| if row > 5 { "2026-03-01 08:00".into() } else { "08:30:00".into() });
    refused(&mixed, &["data row 6", "has a date", "or none"]);
    let both = read(&with("time_utc,time_s", |row| format!("10:00:{row:02},{}", 2 * row))).unwrap();
    assert_eq!(both.columns_not_used, ["time_utc"]);
    assert_eq!(both.data.sample(3).conditions.get("time"), Some(6.0));
}

#[test]
fn rows_that_stand_twice_are_counted() {
    let once = read(NOISY).unwrap();
    assert!(once.warnings.iter().all(|w| !w.contains("copies")));
    let rows: String = NOISY.lines().filter(|l| !l.starts_with('#')).skip(1).map(|l| l.to_owned() + "\n").collect();
    let twice = read(&(NOISY.to_owned() + &rows)).unwrap();
    let message = twice.warnings.join("\n");
    says(&message, &["20 rows are copies of earlier ones", "data rows 20, 21, 22 and 17 more", "count as independent"]);
    let first = rows.lines().next().unwrap();
    let message = read(&format!("{NOISY}{first}\n")).unwrap().warnings.join("\n");
    says(&message, &["1 row is a copy", "(data row 20)", "it counts as"]);
}

#[test]
fn an_extended_model_has_its_conditions() {
    let effect =
        "\n[[effect]]\nname = \"thermal.base\"\nparameters = { expansion = 1e-5 }\nreference = { temp_base = 20.0 }\n";
    let machine = Machine::from_text(&format!("{TABLE_5}{effect}"), "m.toml".as_ref()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let read = |text: &str| {
        std::fs::write(&path, text).unwrap();
        read_measurement(&path, &machine)
    };
    let message = read(NOISY).unwrap().warnings.join("\n");
    says(&message, &["the effect thermal.base", "needs temp_base, which no row has", "delete the effect"]);
    let gaps = read(&with("temp_base_degC", |row| if row % 4 == 1 { String::new() } else { "21".into() })).unwrap();
    let message = gaps.warnings.join("\n");
    says(&message, &["data rows 1, 5, 9 and 2 more: the effect thermal.base does nothing", "temp_base", "fill in"]);
    let whole = read(&with("temp_base_degC", |_| "21".into())).unwrap();
    assert!(whole.warnings.iter().all(|w| !w.contains("thermal.base")), "{:?}", whole.warnings);
}
