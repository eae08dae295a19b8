//! What the integration tests share: the bundled case and small helpers.

pub mod asked;
#[cfg(feature = "cli")]
pub mod bench;
pub mod campaign;
pub mod effects;
pub mod hidden;
pub mod kinds;
pub mod mutations;
pub mod planar;
pub mod ranges;
pub mod rotary;
pub mod urdf_robots;
pub mod wrapped;

use paracal::files::{Machine, Measurement, read_measurement};
use paracal::measurement::{Dataset, Noise};
use paracal::mechanism::{Mechanism, Workspace};
use paracal::pose::PoseConvention;

pub fn path(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A file of `mechanisms/`.
pub fn machine(name: &str) -> Machine {
    Machine::read(path(&format!("mechanisms/{name}.toml"))).unwrap()
}

/// A file of `examples/data/`.
pub fn data(name: &str, machine: &Machine) -> Measurement {
    read_measurement(path(&format!("examples/data/{name}.csv")), machine).unwrap()
}

/// The text of a file of the project.
pub fn text(name: &str) -> String {
    std::fs::read_to_string(path(name)).unwrap()
}

/// Table 6 of the paper in the order of the parameters (eq. 15), m.
pub fn table_6(mechanism: &dyn Mechanism) -> Vec<f64> {
    paracal::files::read_parameter_errors(path("examples/data/hardpoint-errors.csv"), mechanism).unwrap()
}

/// The mechanism of Table 5 with the errors of Table 6.
pub fn true_mechanism(nominal: &dyn Mechanism) -> Box<dyn Mechanism> {
    let values: Vec<f64> = nominal.values().iter().zip(table_6(nominal)).map(|(v, e)| v + e).collect();
    nominal.with_values(&values, nominal.home()).unwrap()
}

/// A box about home: ± mm in position, ± degrees in rotation.
pub fn workspace(mechanism: &dyn Mechanism, mm: f64, degrees: f64) -> Workspace {
    let convention = PoseConvention::default();
    let (p, r) = (1e-3 * mm, degrees.to_radians());
    Workspace { convention, centre: convention.coordinates(&mechanism.home()), half: [p, p, p, r, r, r] }
}

/// The noise of the paper's section 5: 1 µm and 1e-4°.
pub fn paper_noise() -> Noise {
    Noise::stated(1e-6, 1e-4_f64.to_radians())
}

pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for v in values {
        sum += v * v;
        count += 1.0;
    }
    f64::sqrt(sum / count)
}

/// RMS over the samples of a dataset, position (m) and rotation (rad).
pub fn errors_of(model: &dyn Mechanism, data: &Dataset) -> (f64, f64) {
    let e = paracal::identification::evaluate(model, &[], data).unwrap().rms();
    (e.position.unwrap_or(f64::NAN), e.rotation.unwrap_or(f64::NAN))
}
