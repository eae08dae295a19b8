//! Errors that sit at no leg and have no name: in the frame of the instrument, in its readings, in the noise. The disturbances
//! are added to the cells of files in which nothing is hidden, by arithmetic that knows no model.

use serde_json::Value;

use super::bad_data::Table;
use crate::common::bench::{SEED, names, verdict};
use crate::common::hidden::cases::Kind;
use crate::common::hidden::run::normal;
use paracal::rand::rngs::ChaCha8Rng;
use paracal::rand::{RngExt, SeedableRng};

const FEW: usize = 12;

/// Files without anything in them, of a number.
fn null(number: usize) -> Table {
    Table::of(Kind::Null, 120, number)
}

/// With a column of one number per row.
fn with_column(mut table: Table, name: &str, values: &[f64]) -> Table {
    table.header.push(name.into());
    table.rows.iter_mut().zip(values).for_each(|(row, v)| row.push(format!("{v:.6}")));
    table
}

/// Numbers between -1 and 1, one for each row.
fn wandering(number: usize, rows: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED + number as u64);
    (0..rows).map(|_| rng.random_range(-1.0..1.0)).collect()
}

fn unknown(found: &Value) -> &Value {
    assert_eq!(verdict(found), "unknown", "{found}");
    &found["unknown"]
}

fn close(value: &Value, wanted: f64, part: f64) -> bool {
    value.as_f64().is_some_and(|v| (v / wanted - 1.0).abs() < part)
}

#[test]
fn a_coordinate_that_follows_a_column_is_found_in_that_coordinate() {
    for number in 0..FEW {
        let follows = wandering(number, 120);
        let (column, k) = (["humidity", "pressure", "current_A"][number % 3], number % 6);
        let coordinate = ["x", "y", "z", "rx", "ry", "rz"][k];
        let (cell, size) = [(format!("{coordinate}_mm"), 0.02), (format!("{coordinate}_deg"), 0.002)][k / 3].clone();
        let table = with_column(null(number), column, &follows);
        let found = table.with(&cell, |row, v| format!("{:.9}", v + size * follows[row].powi(2))).diagnosed();
        let unknown = unknown(&found);
        assert_eq!(unknown["covariate"], column, "{number}: {found}");
        assert_eq!((unknown["coordinate"].as_str(), unknown["leg"].as_u64()), (Some(coordinate), None), "{found}");
        // Half of the range of a parabola from 0 to `size`.
        let si = if k < 3 { 1e-3 } else { 1f64.to_radians() };
        assert!(close(&unknown["size"], 0.5 * size * si, 0.2), "{number}: {unknown}");
        assert!(names(&found).is_empty() && unknown["curve"].as_array().unwrap().len() == 120, "{found}");
    }
}

#[test]
fn a_jump_of_the_frame_at_a_value_of_a_column_has_its_place_and_leaves_no_row_out() {
    for number in 0..FEW {
        let at = 0.3 - 0.05 * number as f64;
        let column = wandering(number, 120);
        let table = with_column(null(number), "humidity", &column);
        let found =
            table.with("y_mm", |row, v| format!("{:.9}", v + if column[row] > at { 0.06 } else { 0.0 })).diagnosed();
        let unknown = unknown(&found);
        assert_eq!(
            (unknown["covariate"].as_str(), unknown["coordinate"].as_str()),
            (Some("humidity"), Some("y")),
            "{found}"
        );
        assert!(found["outlier_rows"].as_array().unwrap().is_empty(), "{found}");
        if unknown["test"] == "jump" {
            assert!((unknown["place"].as_f64().unwrap() - at).abs() < 0.1, "{at}: {unknown}");
            assert!(close(&unknown["size"], 6e-5, 0.1), "{unknown}");
        }
    }
}

#[test]
fn noise_beyond_the_stated_one_is_not_clean_and_noise_below_it_is() {
    for number in 0..FEW {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED + number as u64);
        let mut noisy = null(number);
        for (column, sigma) in
            [("x_mm", 1e-3), ("y_mm", 1e-3), ("z_mm", 1e-3), ("rx_deg", 1e-4), ("ry_deg", 1e-4), ("rz_deg", 1e-4)]
        {
            // With what is there already, twice the stated noise.
            let more: Vec<f64> = (0..120).map(|_| 3f64.sqrt() * sigma * normal(&mut rng)).collect();
            noisy = noisy.with(column, |row, v| format!("{:.9}", v + more[row]));
        }
        let found = noisy.diagnosed();
        let unknown = unknown(&found);
        assert!(unknown["kind"] == "noise" && close(&unknown["size"], 2.0, 0.15), "{found}");
        assert!(names(&found).is_empty(), "{found}");
        let found = null(number).diagnosed();
        assert_eq!(verdict(&found), "clean", "{found}");
    }
}

#[test]
fn an_instrument_that_stands_still_is_said_and_nothing_is_named() {
    for columns in
        [&["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"][..], &["z_mm"], &["rx_deg", "ry_deg", "rz_deg"]]
    {
        let mut table = null(0);
        for column in columns {
            table = table.with(column, |_, _| if *column == "z_mm" { "475.7".into() } else { "0.01".into() });
        }
        let output = table.bench().run("diagnose m.toml d.csv -o e.toml --json");
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((output.status.code(), verdict(&found)), (Some(3), "undecided"), "{found}");
        assert!(found["undecided"].as_str().unwrap().contains("never change"), "{found}");
        assert!(names(&found).is_empty(), "{found}");
    }
}

#[test]
fn samples_that_repeat_are_the_noise() {
    // Thirty poses four times: scatter as stated around a bow in a coordinate of the pose that no effect has.
    for number in 0..4 {
        let mut table = null(number);
        let (first, poses) = (table.rows.clone(), 30);
        let mut rng = ChaCha8Rng::seed_from_u64(SEED + number as u64);
        table.rows = (0..120).map(|k| first[k % poses].clone()).collect();
        for (column, sigma) in
            [("x_mm", 1e-3), ("y_mm", 1e-3), ("z_mm", 1e-3), ("rx_deg", 1e-4), ("ry_deg", 1e-4), ("rz_deg", 1e-4)]
        {
            let more: Vec<f64> = (0..120).map(|_| sigma * normal(&mut rng)).collect();
            let bent: Vec<f64> = wandering(number, poses);
            let bend = if column == "x_mm" { 0.02 } else { 0.0 };
            table = table.with(column, |row, v| format!("{:.9}", v + more[row] + bend * bent[row % poses]));
        }
        let found = table.diagnosed();
        // Something is left that the repeated samples do not scatter by.
        assert_eq!(verdict(&found), "unknown", "{found}");
        assert!(names(&found).is_empty(), "{found}");
    }
}
