//! Draws the picture of the README: position errors at 150 targets before and after calibration.
//!
//! Run with `cargo run --release --example picture -- docs/targets.svg`; without an argument it goes to the
//! standard output.

use std::error::Error;

use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, ModelErrors, calibrate, evaluate};
use paracal::report::chart::{Axis, Figure, Panel, Series, Shape};
use paracal::units::show_length;

fn main() -> Result<(), Box<dyn Error>> {
    let root = env!("CARGO_MANIFEST_DIR");
    let machine = Machine::read(format!("{root}/mechanisms/table5.toml"))?;
    let read = |name: &str| read_measurement(format!("{root}/examples/data/{name}.csv"), &machine);
    let (measured, targets) = (read("hardpoint-noisy")?.data, read("hardpoint-targets")?.data);
    let nominal = machine.mechanism.as_ref();
    let options = CalibrationOptions::default();
    let result = calibrate(nominal, &measured, machine.workspace.as_ref(), &LevenbergMarquardt::default(), &options)?;
    let before = evaluate(nominal, &[], &targets)?;
    let after = evaluate(result.mechanism.as_ref(), &[], &targets)?;
    let svg = draw(&before, &after).svg();
    match std::env::args().nth(1) {
        Some(path) => std::fs::write(path, svg)?,
        None => println!("{svg}"),
    }
    Ok(())
}

fn draw(before: &ModelErrors, after: &ModelErrors) -> Figure {
    let dots = |(colour, (errors, name)): (usize, (&ModelErrors, &str))| {
        let positions: Vec<f64> = errors.samples.iter().filter_map(|s| s.position).collect();
        let mean = positions.iter().sum::<f64>() / positions.len() as f64;
        let points = positions.iter().enumerate().map(|(k, e)| [k as f64 + 1.0, 1e6 * e]).collect();
        Series::new(format!("{name}, mean {}", show_length(mean)), colour, Shape::Dots, points)
    };
    let both = [(after, "calibrated"), (before, "nominal geometry")];
    let panel = Panel {
        x: Axis::linear("target"),
        y: Axis::log("position error (um)"),
        series: both.into_iter().enumerate().map(dots).collect(),
        ..Panel::default()
    };
    Figure {
        title: "Position error before and after calibration".into(),
        description: format!(
            "Position errors at {} targets on a logarithmic axis: with the nominal geometry about a millimetre, after the \
             calibration about a micrometre.",
            after.samples.len()
        ),
        columns: 1,
        panels: vec![panel],
    }
}
