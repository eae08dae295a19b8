//! The whole way through the library: nominal geometry, simulated measurements, calibration, lengths to command.
//!
//! Run with `cargo run --release --example hardpoint`.

use std::error::Error;

use paracal::conditions::Conditions;
use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::Noise;
use paracal::mechanism::{Leg, Mechanism, SixHardpoint, Workspace};
use paracal::nalgebra::Vector3;
use paracal::pose::{Pose, PoseConvention};
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use paracal::units::{show_angle, show_length};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// Table 5 of Yu, Wu, Wang 2023, mm: platform x, y and base x, y of each leg; all z are 0, all lengths 800.
const TABLE_5: [[f64; 4]; 6] = [
    [1299.170, -348.112, 1164.388, -977.037],
    [1299.170, 348.112, 1164.388, 977.037],
    [-348.112, 1299.170, 263.945, 1496.908],
    [-951.059, 951.059, -1428.333, 519.871],
    [-951.059, -951.059, -1428.333, -519.871],
    [-348.112, -1299.170, 263.945, -1496.908],
];

fn main() -> Result<(), Box<dyn Error>> {
    // 1. The nominal mechanism, in metres; home is solved from the lengths. Tolerance 0.5 mm.
    let leg = |[ax, ay, bx, by]: [f64; 4]| Leg {
        platform: Vector3::new(ax, ay, 0.0) * 1e-3,
        base: Vector3::new(bx, by, 0.0) * 1e-3,
        length: 0.8,
        length_offset: 0.0,
        stroke: None,
    };
    let nominal = SixHardpoint::new("Table 5", &TABLE_5.map(leg), None, Some((0.5e-3, 0.5e-3)))?;
    let at = Conditions::unknown();

    // 2. A mechanism as it was built: every parameter is off by its tolerance.
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let truth = nominal.with_values(&draw_parameters(&nominal, None, &mut rng), nominal.home())?;

    // 3. Thirty corners of the workspace are commanded and measured to 1 um and 0.36 arcsec.
    let convention = PoseConvention::default();
    let (travel, tilt) = (0.1, 10_f64.to_radians());
    let half = [travel, travel, travel, tilt, tilt, tilt];
    let workspace = Workspace { convention, centre: convention.coordinates(&nominal.home()), half };
    let corners = workspace.corners();
    let poses: Vec<Pose> = (0..30).map(|k| corners[37 * k % corners.len()]).collect();
    let noise = Noise::stated(1e-6, 1e-4_f64.to_radians());
    let measured = simulate(&nominal, truth.as_ref(), &poses, &convention, &noise, &mut rng)
        .map_err(|(k, cause)| format!("pose {k}: {cause}"))?;
    let data = as_dataset(&measured, &convention, &noise);

    // 4. Calibrate.
    let options = CalibrationOptions::default();
    let result = calibrate(&nominal, &data, Some(&workspace), &LevenbergMarquardt::default(), &options)?;
    println!("{}", paracal::report::text::calibration(&result));

    // 5. Command a pose with either model, and see where the platform really goes.
    let wanted = Pose::from_coordinates(&[0.02, -0.03, 0.49, 0.01, 0.02, -0.03]);
    println!("\nWhere a commanded pose ends:");
    for (name, model) in [("nominal", &nominal as &dyn Mechanism), ("calibrated", result.mechanism.as_ref())] {
        let lengths = model.inverse(model.values(), &wanted, &at)?;
        let reached = truth.forward(truth.values(), &lengths, &at, &wanted)?;
        let miss = wanted.motion_to(&reached);
        let (shift, turn) = (miss.fixed_rows::<3>(0).norm(), miss.fixed_rows::<3>(3).norm());
        println!("  {name:<11} {:>9} and {:>12} off", show_length(shift), show_angle(turn));
    }
    Ok(())
}
