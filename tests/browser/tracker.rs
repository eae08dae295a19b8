//! Data as they are: of a tracker on a tripod some metres from the machine, which sees a target on the platform.
//!
//! The rigid motions are applied here, to simulated data, with nothing of the library.

use std::path::{Path, PathBuf};
use std::process::Command;

use assert_cmd::cargo::cargo_bin;
use serde_json::Value;

use crate::devtools::Browser;

const HEXAPOD: &str = "examples/data/secondary-hexapod.toml";
/// The tolerance of the lengths of that file, mm.
const TOLERANCE: f64 = 0.3;
/// Base in the tracker's frame, and target on the platform: mm and degrees.
const BASE: [f64; 6] = [3300.0, -2200.0, 1100.0, 2.0, -3.0, 55.0];
const TARGET: [f64; 6] = [120.0, -60.0, 80.0, 0.5, -1.0, 20.0];

type Matrix = [[f64; 3]; 3];

/// `Rz Ry Rx` of angles in degrees.
fn rotation(angles: &[f64]) -> Matrix {
    let [(sx, cx), (sy, cy), (sz, cz)] = [0, 1, 2].map(|k| angles[k].to_radians().sin_cos());
    [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ]
}

/// The frame `inner` that is stated in the frame `outer`.
fn within(outer: &[f64], inner: &[f64]) -> [f64; 6] {
    let (a, b) = (rotation(&outer[3..]), rotation(&inner[3..]));
    let product = |i: usize, j: usize| (0..3).map(|k| a[i][k] * b[k][j]).sum::<f64>();
    let place = |i: usize| outer[i] + (0..3).map(|k| a[i][k] * inner[k]).sum::<f64>();
    let turn = [product(2, 1).atan2(product(2, 2)), (-product(2, 0)).asin(), product(1, 0).atan2(product(0, 0))];
    [place(0), place(1), place(2), turn[0].to_degrees(), turn[1].to_degrees(), turn[2].to_degrees()]
}

/// A measurement file as the tracker would have written it.
fn seen_by_tracker(text: &str) -> String {
    let mut place: Vec<usize> = Vec::new();
    let mut line = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if line.starts_with('#') {
            return line.to_owned();
        }
        if place.is_empty() {
            let at = |name: &str| cells.iter().position(|c| c == name).unwrap();
            place = ["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"].map(at).to_vec();
            return line.to_owned();
        }
        let pose: Vec<f64> = place.iter().map(|k| cells[*k].parse().unwrap()).collect();
        let measured = within(&within(&BASE, &pose), &TARGET);
        place.iter().zip(measured).for_each(|(k, v)| cells[*k] = format!("{v:.9}"));
        cells.join(",")
    };
    text.lines().map(|l| line(l) + "\n").collect()
}

/// Runs the program in the project; what it prints.
fn run(out: &Path, call: &str) -> String {
    let mut command = Command::new(cargo_bin!("paracal"));
    let call = call.replace("{out}", out.to_str().unwrap()).replace("{hexapod}", HEXAPOD);
    let output = command.args(call.split(' ')).arg("--quiet").current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{call}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Pages of such data, by all commands that take some.
pub struct Pages {
    pub calibrate: PathBuf,
    pub diagnose: PathBuf,
    pub evaluate: PathBuf,
    pub select: PathBuf,
    calibration: Value,
}

impl Pages {
    pub fn make(out: &Path) -> Self {
        let measure = |poses: &str, name: &str, errors: &str| {
            run(
                out,
                &format!("simulate {{hexapod}} --poses {poses} -o {{out}}/{name}-base.csv --error-sd 0.3mm {errors}"),
            );
            let text = std::fs::read_to_string(out.join(format!("{name}-base.csv"))).unwrap();
            std::fs::write(out.join(format!("{name}.csv")), seen_by_tracker(&text)).unwrap();
        };
        run(out, "select {hexapod} -n 40 --candidates 60 --selector random -o {out}/tracker-poses.csv");
        measure("{out}/tracker-poses.csv", "day", "--seed 5");
        let effects = "--seed 3 --effect thermal.legs.uniform=1.17e-5 --effect thermal.leg.single[leg=2]=1.35e-5";
        measure("examples/data/secondary-night.csv", "night", effects);
        let page = |name: &str| out.join(format!("tracker-{name}.html"));
        let report = |call: &str, name: &str| run(out, &format!("{call} --report {{out}}/tracker-{name}.html"));
        let printed = report("calibrate {hexapod} {out}/day.csv -o {out}/day.toml --json", "calibrate");
        report("diagnose {hexapod} {out}/night.csv", "diagnose");
        report("evaluate {out}/day.toml {out}/day.csv", "evaluate");
        report("select {out}/day.toml -n 20 --candidates 60 --selector detmax -o {out}/next.csv", "select");
        let [calibrate, diagnose, evaluate, select] = ["calibrate", "diagnose", "evaluate", "select"].map(page);
        Self { calibrate, diagnose, evaluate, select, calibration: serde_json::from_str(&printed).unwrap() }
    }

    pub fn all(&self) -> [PathBuf; 4] {
        [&self.calibrate, &self.diagnose, &self.evaluate, &self.select].map(Clone::clone)
    }

    /// What such pages must say, and must not.
    pub fn check(&self, browser: &mut Browser) {
        let distance = BASE[..3].iter().map(|v| v * v).sum::<f64>().sqrt() / 1e3;
        for page in self.all() {
            browser.open(&format!("file://{}", page.display()));
            let text = seen(browser, "document.body.innerText");
            let name = page.file_stem().unwrap().to_str().unwrap();
            // Names of units of files and terminals appear in what repeats the run only.
            let said = text.split("How to repeat it").next().unwrap();
            for no in [" um", "arcsec", "another frame", "different frame"] {
                assert!(!said.contains(no), "{name}: {no}");
            }
            let pictures = seen(browser, "[...document.querySelectorAll('svg')].map(s => s.textContent).join('\\n')");
            assert!(pictures.contains(&format!("tracker, {distance:.2} m away")), "{name}");
            // The machine is 1.2 m across, and the picture is of it.
            let squares = pictures.split("Squares on the ground are ").nth(1).unwrap().split('\u{a0}').next().unwrap();
            assert!(squares.parse::<f64>().unwrap() <= 200.0, "{name}: {squares} mm");
        }
        self.parameters(browser);
        browser.open(&format!("file://{}", self.diagnose.display()));
        let headline = seen(browser, "document.querySelector('.verdict').innerText");
        assert!(headline.contains("Leg 2 grows with its temperature by 1"), "{headline}");
        assert!(headline.contains("ppm/K more than the others: look at its material or its sensor"), "{headline}");
    }

    /// The picture of the parameters shows those of the machine, and not the place of the tracker.
    fn parameters(&self, browser: &mut Browser) {
        browser.open(&format!("file://{}", self.calibrate.display()));
        let own = "[...document.querySelectorAll('svg')].find(s => s.querySelector('title').textContent.startsWith('Deviations'))";
        let texts = browser.evaluate(&format!("[...{own}.querySelectorAll('text')].map(t => t.textContent)"));
        let texts: Vec<&str> = texts.as_array().unwrap().iter().map(|t| t.as_str().unwrap()).collect();
        assert!(texts.contains(&"deviation (mm)"), "{texts:?}");
        let ticks = texts.iter().filter_map(|t| t.replace('−', "-").parse::<f64>().ok());
        let end = ticks.map(f64::abs).fold(0.0, f64::max);
        let all = self.calibration["parameters"].as_array().unwrap();
        let sigma = all.iter().map(|p| 1e3 * p["sigma"].as_f64().unwrap()).fold(0.0, f64::max);
        assert!(end > 0.0 && end <= (10.0 * sigma).max(5.0 * TOLERANCE), "{end} mm");
        // So does the table: drawing, deviation and sum.
        let rows = "[...document.querySelectorAll('#parameters table')].find(t => t.textContent.includes('xA1'))\
                    .querySelectorAll('tbody tr')";
        let cells = browser.evaluate(&format!("[...{rows}].map(r => [...r.cells].map(c => c.textContent))"));
        let number = |cell: &Value| cell.as_str().unwrap().parse::<f64>().unwrap();
        for row in cells.as_array().unwrap() {
            let [drawing, identified, deviation] = [1, 2, 3].map(|k| number(&row[k]));
            assert!((drawing + deviation - identified).abs() < 2e-4 && deviation.abs() < 5.0 * TOLERANCE, "{row}");
        }
        // The frames are those of the tracker.
        let frames = browser.evaluate(
            "[...document.querySelectorAll('#frames tbody tr')].map(r => [...r.cells].map(c => c.textContent))",
        );
        for (row, stated) in [(0, BASE), (1, TARGET)] {
            for (k, wanted) in stated.iter().enumerate() {
                let found = number(&frames[row][k + 1]);
                // Where the frame of a body with errors lies is known to its tolerance, over its radius for angles.
                assert!((found - wanted).abs() < if k < 3 { 3.0 * TOLERANCE } else { 0.15 }, "{row} {k}: {found}");
            }
        }
    }
}

fn seen(browser: &mut Browser, expression: &str) -> String {
    browser.evaluate(expression).as_str().unwrap().to_owned()
}
