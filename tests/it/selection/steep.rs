//! A machine on a wall: home at the singularity of the angles is as good as any other.

use paracal::mechanism::{Mechanism, SixHardpoint, Workspace};
use paracal::nalgebra::{Rotation3, Vector3};
use paracal::observability::{O1, Scaling};
use paracal::pose::{Pose, PoseConvention};
use paracal::selection::{Campaign, Exchange, Objective, SelectionTask, Sources, select};

use crate::common::machine;

/// O1 of 20 poses of the hexapod of Table 5, whose base was turned about the axis y.
fn value(degrees: f64) -> f64 {
    let machine = machine("table5");
    let upright = machine.mechanism.as_ref();
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), degrees.to_radians());
    let six = (upright as &dyn std::any::Any).downcast_ref::<SixHardpoint>().unwrap();
    let mut legs = six.to_legs();
    legs.iter_mut().for_each(|leg| leg.base = turn * leg.base);
    let home = Pose { position: turn * upright.home().position, rotation: turn };
    let turned = SixHardpoint::new("turned", &legs, Some(home), Some((5e-4, 5e-4))).unwrap();
    let convention = PoseConvention::default();
    let angle = 8_f64.to_radians();
    let workspace = Workspace {
        convention,
        centre: convention.coordinates(&turned.home()),
        half: [0.08, 0.08, 0.08, angle, angle, angle],
    };
    let campaign = Campaign::new(&turned, &workspace, None, Scaling::Paper).unwrap();
    let aim = Objective::Index(&O1);
    let task = SelectionTask { campaign: &campaign, forecaster: None, aim, given: &[], seed: 1, watch: &|_| {} };
    let sources = Sources { random: 500, corners_and_grid: true, ..Sources::default() };
    let set = select(&task, &Exchange::default(), &sources, 20).unwrap();
    for pose in &set.poses {
        assert!(workspace.excess(pose).iter().all(|e| *e < 1e-9), "{degrees}: {pose:?}");
    }
    set.value
}

#[test]
fn a_set_is_as_good_at_any_attitude_of_home() {
    let upright = value(0.0);
    for degrees in [90.0, -90.0, 84.0] {
        let turned = value(degrees);
        assert!((turned / upright - 1.0).abs() < 0.1, "{degrees}: {turned} against {upright}");
    }
}
