//! What is written is what was printed: a calibrated file, read by anyone, makes of the data that it was fitted to the errors
//! that were printed with it. The law holds for every kind of machine, reading, frame, effect, pivot, order of rotations and
//! unit; here combinations of all of them are drawn.

mod base_frame;
mod combination;

use std::path::Path;

use paracal::files::{Machine, read_measurement};
use paracal::identification::{
    Calibration, CalibrationOptions, ErrorSummary, Holdout, LevenbergMarquardt, calibrate, evaluate,
};
use paracal::mechanism::characteristic_length;
use paracal::simulation::monte_carlo;

use combination::Combination;

/// A calibration and its file as text.
struct Calibrated {
    result: Calibration,
    text: String,
}

/// Calibrates the machine of a file with data of a file.
fn calibrated(text: &str, data: &Path) -> Result<Calibrated, String> {
    let mut machine = Machine::from_text(text, "m.toml".as_ref()).map_err(|e| e.to_string())?;
    let measurement = read_measurement(data, &machine).map_err(|e| e.to_string())?;
    machine.refer_to(measurement.data.iter().map(|s| &s.conditions), "the data");
    let options = CalibrationOptions {
        holdout: Holdout::Fraction(0.2),
        convention: machine.convention,
        ..CalibrationOptions::default()
    };
    let (mechanism, workspace) = (machine.mechanism.as_ref(), machine.workspace.as_ref());
    let result = calibrate(mechanism, &measurement.data, workspace, &LevenbergMarquardt::default(), &options);
    let result = result.map_err(|e| e.to_string())?;
    let text = machine.calibrated_document(&result, &measurement).map_err(|e| e.to_string())?.to_text();
    Ok(Calibrated { result, text })
}

/// The machine of a written file, as a command reads it beside these data.
fn read_beside(text: &str, data: &Path) -> Result<Machine, String> {
    let mut machine = Machine::from_text(text, "calibrated.toml".as_ref()).map_err(|e| e.to_string())?;
    let measurement = read_measurement(data, &machine).map_err(|e| e.to_string())?;
    machine.refer_to(measurement.data.iter().map(|s| &s.conditions), "the data");
    Ok(machine)
}

/// The errors of a written file on the data that it was fitted to, and the size of its machine.
fn errors_as_written(text: &str, data: &Path) -> Result<(ErrorSummary, f64), String> {
    let machine = read_beside(text, data)?;
    let again = read_measurement(data, &machine).map_err(|e| e.to_string())?;
    let errors = evaluate(machine.mechanism.as_ref(), &[], &again.data).map_err(|e| e.to_string())?;
    Ok((errors.rms(), characteristic_length(machine.plain()) + machine.plain().home().position.norm()))
}

/// True beyond 1e-9 of the printed value, and 1e-8 of one that is not trusted and may be metres, and what forward kinematics
/// leaves of rounding in a machine of this size.
fn differs(written: Option<f64>, printed: Option<f64>, size: f64, trusted: bool) -> bool {
    let part = if trusted { 1e-9 } else { 1e-8 };
    match (written, printed) {
        (Some(written), Some(printed)) => !((written - printed).abs() <= part * printed + 1e-12 * size),
        (written, printed) => written.is_some() || printed.is_some(),
    }
}

/// Why a combination breaks the law; `None` where there is no calibration.
fn verdict(seed: u64) -> (Combination, Result<Option<String>, String>) {
    let combination = Combination::draw(seed);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.csv");
    let told = combination.write(&path).and_then(|text| {
        let found = calibrated(&text, &path)?;
        let (written, size) = match errors_as_written(&found.text, &path) {
            Ok(errors) => errors,
            // Of what is not trusted nobody commands a machine.
            Err(cause) if found.result.verdict.trusted => return Ok(Some(format!("the written file: {cause}"))),
            Err(cause) => return Err(cause),
        };
        let printed = found.result.after;
        let trusted = found.result.verdict.trusted;
        let broken = differs(written.position, printed.position, size, trusted)
            || differs(written.rotation, printed.rotation, 1.0, trusted);
        let effects: Vec<&str> = found.text.lines().filter(|l| l.starts_with("name = ") && l.contains('.')).collect();
        Ok(broken.then(|| format!("{effects:?}: printed {printed:?}, written {written:?}")))
    });
    (combination, told)
}

#[test]
fn what_is_written_is_what_was_printed() {
    let drawn = 2_300;
    let told = monte_carlo(drawn, 0, |seed, _| verdict(seed));
    let broken: Vec<String> =
        told.iter().filter_map(|(what, told)| Some(format!("{what}: {}", told.as_ref().ok()?.as_ref()?))).collect();
    let refused: Vec<String> =
        told.iter().filter_map(|(what, told)| Some(format!("{what}: {}", told.as_ref().err()?))).collect();
    assert!(broken.is_empty(), "{} of {drawn}:\n{}", broken.len(), broken.join("\n"));
    let held = told.len() - refused.len();
    assert!(held >= 2_000, "{held} of {drawn} were calibrated:\n{}", refused.join("\n"));
}
