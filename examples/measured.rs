//! Measured machines: what the program says of data that nobody simulated.
//!
//! The sets are under `examples/data`, each with its licence; `docs/measured.md` tells where they come from and what their
//! builders found. Run with `cargo run --release --example measured`.

use std::error::Error;
use std::path::Path;

use paracal::diagnosis::{Diagnosis, Question, diagnose};
use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate, evaluate};

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    println!("Mirrors of a telescope, four corners by laser tracker against elevation");
    for name in ["primary", "secondary"] {
        let found = mirror(name)?;
        let names: Vec<&str> = found.causes.iter().map(|c| c.effect.as_str()).collect();
        print!("  {name}: {}", names.join(", "));
        if let Some((unknown, place)) = found.unknown.as_ref().and_then(|u| Some((u, u.from?))) {
            let (size, covariate) =
                (1e3 * unknown.size.unwrap_or(f64::NAN), unknown.covariate.as_deref().unwrap_or(""));
            print!(", and a jump of {size:.2} mm at {covariate} {:.0} deg", place.to_degrees());
        }
        println!();
    }
    println!("A cable robot of four lines, motor angles and camera positions");
    let [before, after, held_out] = winches()?;
    println!("  all positions: {before:.1} mm -> {after:.1} mm, held out {held_out:.1} mm");
    println!("  nine positions: the others are missed by {:.1} mm", nine_positions()?);
    Ok(())
}

fn folder(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data").join(name)
}

/// What a diagnosis says of a mirror.
pub fn mirror(name: &str) -> Outcome<Diagnosis> {
    let machine = Machine::read(folder("so-lat/mirror.toml"))?;
    let measured = read_measurement(folder("so-lat").join(format!("{name}.csv")), &machine)?;
    Ok(diagnose(&Question::of(&machine, &measured.data))?)
}

/// RMS of the positions of the cable robot as drawn, with its anchors and winches identified, and of those then held out, mm.
pub fn winches() -> Outcome<[f64; 3]> {
    let machine = Machine::read(folder("hangprinter/winches.toml"))?;
    let measured = read_measurement(folder("hangprinter/lines.csv"), &machine)?;
    let options = CalibrationOptions { convention: machine.convention, ..CalibrationOptions::default() };
    let identifier = LevenbergMarquardt::default();
    let found =
        calibrate(machine.mechanism.as_ref(), &measured.data, machine.workspace.as_ref(), &identifier, &options)?;
    let mm = |v: Option<f64>| 1e3 * v.unwrap_or(f64::NAN);
    let held_out = found.held_out.as_ref().and_then(|held| held.rms.position);
    Ok([mm(found.before.position), mm(found.after.position), mm(held_out)])
}

/// RMS of the positions that were not used where nine were, beside the motor angles of all rows, mm.
pub fn nine_positions() -> Outcome<f64> {
    let machine = Machine::read(folder("hangprinter/winches.toml"))?;
    let few = read_measurement(folder("hangprinter/nine-positions.csv"), &machine)?;
    let others = read_measurement(folder("hangprinter/other-positions.csv"), &machine)?;
    let options = CalibrationOptions { convention: machine.convention, ..CalibrationOptions::default() };
    let identifier = LevenbergMarquardt::default();
    let found = calibrate(machine.mechanism.as_ref(), &few.data, None, &identifier, &options)?;
    let data = others.data.with_frames(found.registration.frames);
    let errors = evaluate(found.mechanism.as_ref(), &[], &data)?;
    Ok(1e3 * errors.rms().position.unwrap_or(f64::NAN))
}
