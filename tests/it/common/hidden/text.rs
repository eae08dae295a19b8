//! The two files of a case, as text.

use std::fmt::Write;

use super::effects::{CENTRE_OF_MASS, MASS, PAYLOAD_CENTRE, PITCH};
use super::hexapod::{HOME_LENGTH, TABLE_5};
use super::run::Run;

/// The columns of a measurement file, SI: the run, and what was written down as lengths and as poses.
#[derive(Clone, Debug)]
pub struct Sheet {
    pub run: Run,
    pub legs: Vec<[f64; 6]>,
    pub poses: Vec<[f64; 6]>,
}

impl Sheet {
    pub fn of(run: Run, poses: Vec<[f64; 6]>) -> Self {
        let legs = run.rows.iter().map(|row| row.commanded).collect();
        Self { run, legs, poses }
    }

    /// Takes rows off the front of everything but the poses, and off the front of the poses; ends are cut even.
    pub fn shift(&mut self, rows: usize, poses: usize) {
        self.run.rows.drain(..rows);
        self.legs.drain(..rows);
        self.poses.drain(..poses);
        let n = self.poses.len().min(self.legs.len());
        self.run.rows.truncate(n);
        self.legs.truncate(n);
        self.poses.truncate(n);
    }

    /// CSV with millimetres, degrees, seconds, degrees Celsius and kilograms.
    pub fn csv(&self) -> String {
        let legs = |head: &str, tail: &str| (1..=6).map(|i| format!("{head}{i}_{tail},")).collect::<String>();
        let mut text = format!(
            "time_s,{}x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,{}temp_platform_degC,temp_base_degC,elevation_deg,azimuth_deg,payload_kg\n",
            legs("leg", "mm"),
            legs("temp_leg", "degC"),
        );
        for ((row, legs), pose) in self.run.rows.iter().zip(&self.legs).zip(&self.poses) {
            let mm = |v: &[f64]| v.iter().map(|v| 1e3 * v).collect::<Vec<_>>();
            let cells = [
                vec![row.time],
                mm(legs),
                mm(&pose[..3]),
                pose[3..].iter().map(|v| v.to_degrees()).collect(),
                row.temp_legs.to_vec(),
                vec![row.temp_platform, row.temp_base],
                vec![row.elevation.to_degrees(), row.azimuth.to_degrees(), row.payload],
            ]
            .concat();
            let cells: Vec<String> = cells.iter().map(|v| format!("{v:.9}")).collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }
}

/// The mechanism file of every case.
pub fn mechanism() -> String {
    let mut text = String::from(
        "name = \"Six-hardpoint positioner, Table 5\"\ntype = \"six-hardpoint\"\nlength_unit = \"mm\"\nangle_unit = \"deg\"\n",
    );
    for [ax, ay, bx, by] in TABLE_5 {
        let length = 1e3 * HOME_LENGTH;
        // Writing to a string cannot fail.
        let _ = write!(text, "[[leg]]\nplatform = [{ax}, {ay}, 0.0]\nbase = [{bx}, {by}, 0.0]\nlength = {length:.1}\n");
    }
    let _ = write!(
        text,
        "\n[workspace]\nposition = [10.0, 10.0, 10.0]\nrotation = [0.5, 0.5, 0.5]\n[tolerance]\nanchor = 0.5\nlength = 0.5\n\
         [noise]\nposition = 0.001\nrotation = 0.0001\n[platform]\nmass_kg = {MASS:.1}\n\
         centre_of_mass = [0.0, 0.0, {:.1}]\npayload_centre = [0.0, 0.0, {:.1}]\n[actuator]\nscrew_pitch = {:.1}\n",
        1e3 * CENTRE_OF_MASS,
        1e3 * PAYLOAD_CENTRE,
        1e3 * PITCH,
    );
    text
}
