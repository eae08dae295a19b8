//! A mechanism from outside the crate by one function: six rods on vertical slides (6-PUS).
//!
//! The closure says when the rods fit; everything else (Jacobians by dual numbers, kinematics, choice of poses,
//! identification, judgement) comes from the library. Run with `cargo run --release --example own_mechanism`.

use std::error::Error;

use paracal::identification::{CalibrationOptions, LevenbergMarquardt, calibrate};
use paracal::measurement::Noise;
use paracal::mechanism::closure::{Closure, ClosureMechanism, Outline, Real, State, length};
use paracal::mechanism::{Mechanism, ParameterRole, Workspace};
use paracal::nalgebra::{Rotation3, Vector3};
use paracal::observability::{O1, Scaling};
use paracal::pose::{Pose, PoseConvention};
use paracal::selection::{Campaign, Exchange, Objective, SelectionTask, Sources, select};
use paracal::simulation::{as_dataset, draw_parameters, simulate};
use paracal::units::Dimension;
use rand::SeedableRng;

#[derive(Clone, Debug)]
struct VerticalSlides;

impl Closure for VerticalSlides {
    fn residual<T: Real>(&self, s: &State<'_, T>, out: &mut [T]) {
        for (leg, row) in out.iter_mut().enumerate() {
            // Carriages slide along z: |t + R a - b - h z| = s.
            let mut rod = s.place(&s.point(7 * leg)) - s.point(7 * leg + 3);
            rod.z -= s.joints[leg];
            *row = length(&rod) - s.parameters[7 * leg + 6];
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut outline = Outline::new("vertical slides", 6, Pose::from_coordinates(&[0.0; 6]));
    for leg in 0..6 {
        let (pair, side) = (120.0 * (leg / 2) as f64, if leg % 2 == 0 { -1.0 } else { 1.0 });
        let around = |radius: f64, degrees: f64| {
            Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians()) * Vector3::x() * radius
        };
        let (ball, foot) = (around(0.15, pair + 48.0 * side), around(0.35, pair + 15.0 * side));
        let (rod, above) = (0.5, f64::sqrt(0.25 - (ball - foot).norm_squared()));
        outline = outline
            .platform_point(leg, ball.into(), Some(2e-4))
            .base_point(leg, foot.into(), Some(2e-4))
            .parameter(format!("s{}", leg + 1), Dimension::Length, rod, Some(2e-4), ParameterRole::LegDimension { leg })
            .joint(Dimension::Length, above, None);
    }
    let nominal = ClosureMechanism::new(VerticalSlides, outline)?;
    let convention = PoseConvention::default();
    let centre = convention.coordinates(&nominal.home());
    let space = Workspace { convention, centre, half: [0.05, 0.05, 0.05, 0.15, 0.15, 0.15] };
    let noise = Noise::stated(5e-6, 2e-5);

    let campaign = Campaign::new(&nominal, &space, Some(&noise), Scaling::Whitened)?;
    let plan = SelectionTask {
        campaign: &campaign,
        forecaster: None,
        aim: Objective::Index(&O1),
        given: &[],
        seed: 0,
        watch: &|_| {},
    };
    let sources = Sources { random: 500, corners_and_grid: true, ..Sources::default() };
    let chosen = select(&plan, &Exchange::default(), &sources, 25)?;

    let mut rng = rand::rngs::ChaCha8Rng::seed_from_u64(1);
    let truth = nominal.with_values(&draw_parameters(&nominal, None, &mut rng), nominal.home())?;
    let measured = simulate(&nominal, truth.as_ref(), &chosen.poses, &convention, &noise, &mut rng)
        .map_err(|(row, cause)| format!("pose {row}: {cause}"))?;
    let data = as_dataset(&measured, &convention, &noise);
    let options = CalibrationOptions::default();
    let result = calibrate(&nominal, &data, Some(&space), &LevenbergMarquardt::default(), &options)?;
    print!("{}", paracal::report::text::calibration(&result));
    Ok(())
}
