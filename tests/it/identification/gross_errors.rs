//! Gross errors are named by the data rows of the file, whichever of its samples are fitted.

use crate::common::campaign::campaign;
use crate::common::paper_noise;

use paracal::conditions::ConditionTable;
use paracal::identification::{CalibrationOptions, Robust, calibrate};
use paracal::measurement::{Dataset, Frames, PoseMeasurement, PoseReading};
use paracal::report::html::{self, Measured, ModelResiduals};
use paracal::report::json;
use std::sync::Arc;

#[test]
fn a_robust_calibration_of_a_subset_names_the_rows_of_the_file_everywhere() {
    const SPOILT: usize = 9;
    let c = campaign(30);
    let noise = paper_noise();
    let (p, r) = (noise.position, noise.rotation);
    let mut readings: Vec<PoseReading> = c
        .run
        .iter()
        .map(|s| PoseReading { values: s.measured, measured: [true; 6], sigma: [p, p, p, r, r, r] })
        .collect();
    readings[SPOILT].values[0] += 100e-6;
    let model = Arc::new(PoseMeasurement::new(c.space.convention, readings));
    let data = Dataset::new(c.samples.clone(), model, noise).subset(&(3..30).collect::<Vec<_>>());
    let mechanism = c.nominal.as_ref();
    let options = CalibrationOptions::default();
    let result = calibrate(mechanism, &data, Some(&c.space), &Robust::default(), &options).unwrap();
    // The spoilt row, at position 6 of the subset, and perhaps a row that chance put at the edge.
    let rows: Vec<usize> = result.identification.outliers.iter().map(|row| row.0).collect();
    assert!(rows.contains(&SPOILT) && !rows.contains(&(SPOILT - 3)) && rows.len() <= 2, "{rows:?}");
    let listed = rows.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");

    let said: Vec<&String> = result.verdict.warnings.iter().filter(|w| w.starts_with("gross errors")).collect();
    assert!(said.len() == 1 && said[0].starts_with(&format!("gross errors in data row {listed};")), "{said:?}");
    assert_eq!(json::calibration(&result, &[])["outlier_rows"], serde_json::json!(rows));

    let calibrated = result.mechanism.as_ref();
    let models = [ModelResiduals::new("calibrated", calibrated, &[], &data).unwrap()];
    let subject = html::Subject {
        mechanism: calibrated,
        frames: Frames::default(),
        convention: &c.space.convention,
        condition_kinds: &ConditionTable::standard(),
        noise: None,
        warnings: Vec::new(),
        settings: Vec::new(),
    };
    let page = html::calibration(&result, &subject, &Measured { data: &data, models: &models });
    let shown: Vec<&String> =
        page.numbers.iter().filter(|tile| tile.name.contains("gross")).map(|tile| &tile.value).collect();
    assert_eq!(shown, [&listed]);
}
