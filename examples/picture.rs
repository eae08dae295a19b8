//! Draws the picture of the README: position errors at 150 targets before and after calibration.
//!
//! Run with `cargo run --release --example picture -- docs/targets.svg`; without an argument it goes to the
//! standard output.

use std::error::Error;
use std::fmt::Write;

use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, ModelErrors, calibrate, evaluate};

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 80.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = 46.0;
/// Powers of ten at the ends of the error axis, m.
const DECADES: (i32, i32) = (-7, -2);

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
    let svg = draw(&before, &after)?;
    match std::env::args().nth(1) {
        Some(path) => std::fs::write(path, svg)?,
        None => println!("{svg}"),
    }
    Ok(())
}

fn draw(before: &ModelErrors, after: &ModelErrors) -> Result<String, std::fmt::Error> {
    let (low, high) = (f64::from(DECADES.0), f64::from(DECADES.1));
    let y = |e: f64| TOP + (high - e.log10()) / (high - low) * (HEIGHT - TOP - BOTTOM);
    let n = before.samples.len() as f64;
    let x = |k: usize| LEFT + (k as f64 + 0.5) / n * (WIDTH - LEFT - RIGHT);
    let mut svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" font-family="sans-serif" font-size="13">
<title>Position error at {n} targets before and after calibration</title>
<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>
"#
    );
    for decade in DECADES.0..=DECADES.1 {
        let (at, label) = (y(10_f64.powi(decade)), decade_label(decade));
        let end = WIDTH - RIGHT;
        writeln!(svg, r##"<path d="M{LEFT} {at:.1}H{end}" stroke="#ddd"/>"##)?;
        writeln!(
            svg,
            r##"<text x="{}" y="{:.1}" text-anchor="end" fill="#333">{label}</text>"##,
            LEFT - 8.0,
            at + 4.0
        )?;
    }
    for (errors, colour, name) in [(before, "#b3541e", "nominal geometry"), (after, "#1e5fb3", "calibrated")] {
        let positions: Vec<f64> = errors.samples.iter().filter_map(|s| s.position).collect();
        for (k, e) in positions.iter().enumerate() {
            writeln!(svg, r#"<circle cx="{:.1}" cy="{:.1}" r="2.5" fill="{colour}"/>"#, x(k), y(*e))?;
        }
        let mean = positions.iter().sum::<f64>() / positions.len() as f64;
        let text = format!("{name}, mean {}", paracal::units::show_length(mean));
        // Below its points, where the chart is empty.
        let lowest = positions.iter().copied().fold(f64::INFINITY, f64::min);
        let (place, line) = (LEFT + 10.0, y(lowest) + 18.0);
        writeln!(
            svg,
            r#"<text x="{place}" y="{line:.1}" fill="{colour}" stroke="white" stroke-width="5" paint-order="stroke">{text}</text>"#
        )?;
    }
    let (middle, foot) = (0.5 * (LEFT + WIDTH - RIGHT), HEIGHT - 14.0);
    writeln!(svg, r##"<text x="{middle}" y="{foot}" text-anchor="middle" fill="#333">target, 1 to {n}</text>"##)?;
    svg.push_str("</svg>");
    Ok(svg)
}

fn decade_label(decade: i32) -> String {
    match decade {
        -9..=-7 => format!("{} um", 10_f64.powi(decade + 6)),
        -6..=-4 => format!("{} um", 10_i32.pow((decade + 6) as u32)),
        _ => format!("{} mm", 10_i32.pow((decade + 3) as u32)),
    }
}
