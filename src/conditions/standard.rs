//! The conditions that the catalogue of effects knows.

use std::f64::consts::TAU;

use super::kind::{Commanded, ConditionKind, Part, Role, Variation};
use crate::units::Dimension;

/// Temperature of a leg; [`of_leg`](super::of_leg) gives the covariate of one.
pub const TEMP_LEG: &str = "temp_leg";
/// Temperature of all legs: a column, or the mean of those of the legs.
pub const TEMP_LEGS: &str = "temp_legs";
/// Temperature of the platform.
pub const TEMP_PLATFORM: &str = "temp_platform";
/// Temperature of the base.
pub const TEMP_BASE: &str = "temp_base";
/// Angle between the horizon and where the machine points to.
pub const ELEVATION: &str = "elevation";
/// Angle about the vertical.
pub const AZIMUTH: &str = "azimuth";
/// Mass on the platform.
pub const PAYLOAD: &str = "payload";
/// Time since the first row.
pub const TIME: &str = "time";
/// Commanded coordinate of a joint.
pub const LENGTH_LEG: &str = "length_leg";
/// Change of the commanded coordinate from the row before.
pub const TRAVEL_LEG: &str = "travel_leg";
/// Sign of that change.
pub const APPROACH_LEG: &str = "approach_leg";

/// How the names of all temperatures begin.
const TEMPERATURES: &str = "temp_";

/// The entries. A planned campaign takes sequences for what it varies in this order, so that new ones go to the end.
pub(super) fn kinds() -> Vec<ConditionKind> {
    let temperature = |name: &'static str, part| {
        let kind = ConditionKind::new(name, Dimension::Temperature, "temperature");
        kind.acting(Role::Temperature(part)).varied(Variation::Air)
    };
    let commanded = |name: &'static str, dimension, label: &'static str, role| {
        ConditionKind::new(name, dimension, label).each_leg().acting(Role::Commanded(role)).drawn_if_named()
    };
    vec![
        temperature(TEMP_LEG, Part::Leg).each_leg(),
        temperature(TEMP_PLATFORM, Part::Platform).drawn_if_named(),
        temperature(TEMP_BASE, Part::Base).drawn_if_named(),
        temperature(TEMPERATURES, Part::Other).family().drawn_if_named(),
        ConditionKind::new(ELEVATION, Dimension::Angle, "elevation")
            .unit_optional()
            .acting(Role::Direction)
            .varied(Variation::Evenly([20.0, 90.0])),
        ConditionKind::new(AZIMUTH, Dimension::Angle, "azimuth")
            .unit_optional()
            .varied(Variation::Evenly([0.0, TAU.to_degrees()]))
            .repeating()
            .drawn_if_named(),
        ConditionKind::new(PAYLOAD, Dimension::Mass, "payload")
            .unit_optional()
            .acting(Role::Load)
            .varied(Variation::Steps(vec![0.0, 50.0, 100.0])),
        ConditionKind::new(TIME, Dimension::Time, "time")
            .unit_optional()
            .acting(Role::Clock)
            .repeating()
            .drawn_if_named(),
        commanded(LENGTH_LEG, Dimension::Length, "length", Commanded::Coordinate).repeating(),
        commanded(TRAVEL_LEG, Dimension::Length, "travel", Commanded::Travel),
        commanded(APPROACH_LEG, Dimension::None, "direction of approach", Commanded::Approach),
    ]
}
