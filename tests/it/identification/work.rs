//! How much work a calibration is, counted.

use crate::common::wrapped::Wrapped;
use crate::common::{data, machine};
use paracal::identification::{CalibrationOptions, Holdout, Identifier, LevenbergMarquardt, Robust, calibrate};

/// Forward kinematics per sample of one calibration.
fn forwards(identifier: &dyn Identifier, holdout: Holdout) -> f64 {
    let machine = machine("table5");
    let data = data("hardpoint-noisy", &machine).data;
    let plain = machine.plain();
    let wrapped = Wrapped::around(plain.with_values(plain.values(), plain.home()).unwrap());
    let options = CalibrationOptions { holdout, ..Default::default() };
    let found = calibrate(&wrapped, &data, machine.workspace.as_ref(), identifier, &options).unwrap();
    assert!(found.verdict.trusted);
    wrapped.forwards() as f64 / data.len() as f64
}

#[test]
fn samples_are_solved_for_once_where_nothing_has_moved() {
    let levenberg = LevenbergMarquardt::default();
    let (alone, folds) = (forwards(&levenberg, Holdout::None), forwards(&levenberg, Holdout::Folds(5)));
    // The start, one for each of four steps and the end of the iteration, and the calibrated model from its own home.
    assert!(alone <= 7.0, "{alone} without folds");
    // Each fold begins at the fit of all samples and takes two steps.
    assert!(folds <= 20.0, "{folds} with five folds");
    // Some thirty rounds of reweighting with two or three steps each.
    let robust = forwards(&Robust::default(), Holdout::None);
    assert!(robust <= 90.0, "{robust} with the robust identifier");
}
