//! Operating states from data columns: gravity, runs, clock times, and cells that are no numbers.

use paracal::conditions::Conditions;
use paracal::files::{FileError, Machine, Measurement, read_measurement, read_poses};
use paracal::nalgebra::Vector3;

const TABLE5: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"));

/// A measurement file whose rows are at home, with further columns.
fn measurement(further: &str, rows: &[&str], mechanism: &str) -> Result<Measurement, FileError> {
    let machine = Machine::from_text(mechanism, "m.toml".as_ref()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let mut text: String = (1..=6).map(|leg| format!("leg{leg}_mm,")).collect();
    text += &format!("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,{further}\n");
    for (k, row) in rows.iter().enumerate() {
        text += &format!("{},800,800,800,800,800,0,0,475.7,0,0,0,{row}\n", 800 + k);
    }
    std::fs::write(&path, text).unwrap();
    read_measurement(&path, &machine)
}

fn states(further: &str, rows: &[&str], mechanism: &str) -> Vec<Conditions> {
    let read = measurement(further, rows, mechanism).unwrap();
    read.data.iter().map(|s| s.conditions.clone()).collect()
}

fn refusal(further: &str, rows: &[&str]) -> String {
    measurement(further, rows, TABLE5).unwrap_err().to_string()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

fn gravity(state: &Conditions) -> Vector3<f64> {
    state.gravity.unwrap()
}

#[test]
fn gravity_follows_from_the_elevation_along_the_axis_of_the_mechanism() {
    let rows = ["90", "0", "30", ""];
    let along_x = states("elevation_deg", &rows, TABLE5);
    assert!((gravity(&along_x[0]) - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-15);
    assert!((gravity(&along_x[1]) - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-15);
    assert!((gravity(&along_x[2]) - Vector3::new(0.75_f64.sqrt(), 0.0, -0.5)).norm() < 1e-15);
    assert_eq!(along_x[3].gravity, None);
    let y = TABLE5.replacen("angle_unit", "gravity_axis = \"y\"\nangle_unit", 1);
    let along_y = states("zenith_distance_deg", &["60"], &y);
    assert!((gravity(&along_y[0]) - Vector3::new(0.0, 0.75_f64.sqrt(), -0.5)).norm() < 1e-15);
    assert!((along_y[0].get("elevation").unwrap() - 30_f64.to_radians()).abs() < 1e-15);
    assert_eq!(along_y[0].get("zenith_distance"), None);
}

#[test]
fn gravity_columns_come_before_the_elevation() {
    let rows = ["0,0,-1.0005,10", ",,,90"];
    let read = states("gravity_x,gravity_y,gravity_z,elevation_deg", &rows, TABLE5);
    assert_eq!(gravity(&read[0]), Vector3::new(0.0, 0.0, -1.0));
    assert!((gravity(&read[1]) - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-15);
}

#[test]
fn what_is_wrong_with_gravity_is_named() {
    let three = "gravity_x,gravity_y,gravity_z";
    says(&refusal(three, &["0,0,-1", "0.6,0,0.7"]), &["data row 1 (line 3)", "gravity_x", "length 0.92", "must be 1"]);
    says(&refusal(three, &["0,,-1"]), &["data row 0", "only partly filled"]);
    says(&refusal("gravity_x,gravity_z", &["0,-1"]), &["needs gravity_y too"]);
    says(&refusal("gravity_x_m,gravity_y,gravity_z", &["0,0,-1"]), &["gravity_x_m", "has no unit"]);
    says(&refusal("elevation_deg,zenith_distance_deg", &["0,90"]), &["zenith_distance_deg", "keep one of them"]);
    let read = measurement("elevation", &["45"], TABLE5).unwrap();
    assert_eq!(read.data.sample(0).conditions.gravity, None);
    says(&read.warnings.join("\n"), &["'elevation'", "no unit of angle", "elevation_deg"]);
}

#[test]
fn cells_that_are_no_finite_numbers_are_named() {
    for (column, cell) in
        [("temp_legs_degC", "infinity"), ("payload_kg", "inf"), ("free", "-inf"), ("elevation_deg", "1e999")]
    {
        let good = ["20", cell];
        says(&refusal(column, &good), &["data row 1 (line 3)", column, cell, "not a finite number"]);
    }
    says(&refusal("temp_legs_degC", &["20", "warm"]), &["data row 1 (line 3)", "'warm' is not a number"]);
}

#[test]
fn rows_are_a_run() {
    let read = states("time_s", &["5", "6", "9"], TABLE5);
    let parts: Vec<f64> = read.iter().map(|s| s.run.as_ref().unwrap().part).collect();
    assert_eq!(parts, [0.0, 0.25, 1.0]);
    let run = read[2].run.as_ref().unwrap();
    assert_eq!((run.row, run.joints.len()), (2, 3));
    assert!((run.joints[2][0] - 0.802).abs() < 1e-15);
    assert_eq!(read[1].previous_joints.as_ref(), Some(&run.joints[0]));
    let home = read[0].previous_joints.as_ref().unwrap();
    assert!(home.iter().all(|h| (h - 0.8).abs() < 1e-3), "{home:?}");
    assert_eq!(states("free", &["1"], TABLE5)[0].run.as_ref().unwrap().part, 0.0);
}

#[test]
fn clocks_pass_midnight() {
    let times = |rows: &[&str]| -> Vec<f64> {
        states("time_utc", rows, TABLE5).iter().map(|s| s.get("time").unwrap()).collect()
    };
    assert_eq!(times(&["23:50:00", "00:10:00", "23:59:00", "00:09:00"]), [0.0, 1200.0, 86_940.0, 87_540.0]);
    assert_eq!(times(&["11:50:00", "00:10:00"]), [0.0, 44_400.0]);
    // Rows that stand a little out of order have not waited for a day.
    assert_eq!(times(&["12:00:05", "12:00:00"]), [0.0, -5.0]);
    // A date is meant as it stands.
    assert_eq!(times(&["2026-03-02T00:00:00", "2026-03-01T00:00:00"]), [0.0, -86_400.0]);
}

#[test]
fn days_that_the_calendar_does_not_have_are_refused() {
    for day in ["2023-02-29", "2023-02-30", "2023-02-31", "2026-04-31"] {
        let time = format!("{day}T12:00:00");
        let message = refusal("time_utc", &["2023-02-28T12:00:00", &time]);
        says(&message, &["data row 1 (line 3), column 'time_utc'", &time, "write 2026-03-01T12:30:00"]);
    }
    assert_eq!(states("time_utc", &["2024-02-28T12:00:00", "2024-02-29T12:00:00"], TABLE5).len(), 2);
}

#[test]
fn lists_of_poses_have_conditions_too() {
    let machine = Machine::from_text(TABLE5, "m.toml".as_ref()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    let header = "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,temp_legs_K,elevation_deg,payload_g,time_utc,note";
    std::fs::write(&path, format!("{header}\n0,0,475.7,0,0,0,293.15,90,500,12:00:00,first\n")).unwrap();
    let listed = read_poses(&path, &machine).unwrap();
    let state = &listed[0].conditions;
    assert!((state.get("temp_legs").unwrap() - 20.0).abs() < 1e-12);
    assert_eq!((state.get("payload"), state.get("time"), state.get("note")), (Some(0.5), Some(0.0), None));
    assert!((gravity(state).z + 1.0).abs() < 1e-15);
    assert!(state.run.is_none() && state.previous_joints.is_none());
    std::fs::write(&path, format!("{header}\n0,0,475.7,0,0,0,293.15,90,heavy,12:00:00,first\n")).unwrap();
    says(&read_poses(&path, &machine).unwrap_err().to_string(), &["data row 0 (line 2)", "payload_g", "'heavy'"]);
}
