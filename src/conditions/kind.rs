//! One kind of condition: an entry of the table.

use std::borrow::Cow;

use super::covariate::mean_of_legs;
use crate::units::{Dimension, Unit, fixed};

/// What the covariates of one kind are called, measure and mean.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConditionKind {
    /// The covariate, its stem if there is one for each leg, or the beginning of the names of a family.
    pub name: Cow<'static, str>,
    /// How many covariates there are.
    pub extent: Extent,
    /// What it measures; values are in SI, temperatures in °C.
    pub dimension: Dimension,
    /// True if a column without a unit of the dimension is refused. Otherwise it is read as it stands.
    pub needs_unit: bool,
    /// The quantity as people call it, for axes and sentences: `elevation`.
    pub label: Cow<'static, str>,
    /// The same with its article, for titles: `the elevation`.
    pub title: Cow<'static, str>,
    /// How it acts.
    pub role: Role,
    /// How a campaign may vary it.
    pub variation: Variation,
    /// True if residuals are searched for waves in it.
    pub repeats: bool,
    /// True if residuals are always drawn over it; otherwise only where a finding names it.
    pub pictured: bool,
}

/// How many covariates a kind has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// One, of that name.
    Machine,
    /// One for each leg, `{name}1`, `{name}2`, …; `{name}s` is one for all, or their mean.
    EachLeg,
    /// Every covariate whose name begins so and that no other kind has.
    Family,
}

/// How a condition acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// By its value.
    Reading,
    /// By its difference from a reference temperature.
    Temperature(Part),
    /// As the direction of gravity.
    Direction,
    /// By its weight, in the direction of gravity.
    Load,
    /// As the time that has passed in the run.
    Clock,
    /// It is not recorded but follows from the commanded joints, leg by leg.
    Commanded(Commanded),
}

/// Whose temperature it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A leg.
    Leg,
    /// The platform.
    Platform,
    /// The base.
    Base,
    /// Something else, which has no place in a planned campaign unless the mechanism file names a sensor there.
    Other,
}

/// What follows from the commanded joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Commanded {
    /// The coordinate of the joint.
    Coordinate,
    /// Its change from the row before.
    Travel,
    /// The sign of that change.
    Approach,
}

/// How a campaign may vary a condition, in the [unit](ConditionKind::unit) of the kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Variation {
    /// It does not by itself. Further measurements may take it to the ends of what was recorded.
    Unplanned,
    /// With the air around the machine, as temperatures do.
    Air,
    /// Evenly between two values.
    Evenly([f64; 2]),
    /// At these values.
    Steps(Vec<f64>),
}

impl ConditionKind {
    /// A kind of which one covariate is recorded and acts by its value. Its column must state a unit if the dimension has
    /// one; residuals are drawn over it.
    pub fn new(name: impl Into<Cow<'static, str>>, dimension: Dimension, label: impl Into<Cow<'static, str>>) -> Self {
        let label = label.into();
        Self {
            name: name.into(),
            extent: Extent::Machine,
            dimension,
            needs_unit: dimension != Dimension::None,
            title: format!("the {label}").into(),
            label,
            role: Role::Reading,
            variation: Variation::Unplanned,
            repeats: false,
            pictured: true,
        }
    }

    /// One covariate for each leg.
    #[must_use]
    pub fn each_leg(self) -> Self {
        Self { title: format!("{} of the leg", self.title).into(), extent: Extent::EachLeg, ..self }
    }

    /// Every covariate whose name begins so.
    #[must_use]
    pub fn family(self) -> Self {
        Self { extent: Extent::Family, ..self }
    }

    /// Acts in this way.
    #[must_use]
    pub fn acting(self, role: Role) -> Self {
        Self { role, ..self }
    }

    /// Is varied in this way, in the [unit](Self::unit) of the kind.
    #[must_use]
    pub fn varied(self, variation: Variation) -> Self {
        Self { variation, ..self }
    }

    /// A column without a unit is read as it stands.
    #[must_use]
    pub fn unit_optional(self) -> Self {
        Self { needs_unit: false, ..self }
    }

    /// Residuals are searched for waves in it.
    #[must_use]
    pub fn repeating(self) -> Self {
        Self { repeats: true, ..self }
    }

    /// Residuals are drawn over it only where a finding names it.
    #[must_use]
    pub fn drawn_if_named(self) -> Self {
        Self { pictured: false, ..self }
    }

    /// The unit in which tables write it: mm, deg, otherwise SI.
    pub fn unit(&self) -> Unit {
        Unit::named(self.dimension.in_tables().0).unwrap_or_else(|| Unit::si(self.dimension))
    }

    /// True if it is a temperature.
    pub fn is_temperature(&self) -> bool {
        matches!(self.role, Role::Temperature(_))
    }

    /// True if it is recorded, and does not follow from the commands.
    pub fn is_recorded(&self) -> bool {
        !matches!(self.role, Role::Commanded(_))
    }

    /// The covariate of all legs together, of a kind that is recorded leg by leg.
    pub fn of_all_legs(&self) -> String {
        mean_of_legs(&self.name)
    }

    /// The column of a value of a covariate of this kind: `payload_kg`.
    pub fn column(&self, covariate: &str) -> String {
        match self.dimension {
            Dimension::None => covariate.to_owned(),
            _ => format!("{covariate}_{}", self.unit().name),
        }
    }

    /// A value in SI as people read it: `100 kg`.
    pub(crate) fn shown(&self, value: f64) -> String {
        let unit = self.unit();
        let number = fixed(unit.from_si(value), 3);
        let number = number.trim_end_matches('0').trim_end_matches('.');
        match self.dimension {
            Dimension::None => number.to_owned(),
            _ => format!("{number} {}", unit.name),
        }
    }

    /// The ends of the planned variation, SI; `None` where nothing is planned.
    pub(crate) fn ends(&self) -> Option<[f64; 2]> {
        let ends = match &self.variation {
            Variation::Unplanned | Variation::Air => None,
            Variation::Evenly(ends) => Some(*ends),
            Variation::Steps(values) => Some([*values.first()?, *values.last()?]),
        };
        ends.map(|ends| ends.map(|v| self.unit().to_si(v)))
    }
}
