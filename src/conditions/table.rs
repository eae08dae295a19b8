//! The table of the kinds of conditions.

use std::sync::{Arc, LazyLock};

use super::covariate::{leg_number, of_leg};
use super::kind::{Commanded, ConditionKind, Extent, Role};
use super::standard::kinds;
use super::state::Conditions;

/// The kinds of conditions that columns may hold and effects may name. Copies share their entries.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionTable {
    kinds: Arc<[ConditionKind]>,
}

impl Default for ConditionTable {
    fn default() -> Self {
        Self::standard()
    }
}

impl ConditionTable {
    /// The kinds that the catalogue of effects knows.
    pub fn standard() -> Self {
        static STANDARD: LazyLock<ConditionTable> = LazyLock::new(|| ConditionTable { kinds: kinds().into() });
        STANDARD.clone()
    }

    /// One kind more; it replaces the one of its name.
    #[must_use]
    pub fn with(self, kind: ConditionKind) -> Self {
        let mut kinds: Vec<ConditionKind> =
            self.kinds.iter().filter(|other| other.name != kind.name).cloned().collect();
        kinds.push(kind);
        Self { kinds: kinds.into() }
    }

    /// The kinds, in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = &ConditionKind> {
        self.kinds.iter()
    }

    /// The kind of a covariate; of the families whose beginning fits, the one with the longest.
    pub fn of(&self, covariate: &str) -> Option<&ConditionKind> {
        let exact = |kind: &&ConditionKind| match kind.extent {
            Extent::Machine => kind.name == covariate,
            Extent::EachLeg => {
                covariate.strip_prefix(&*kind.name).is_some_and(|rest| rest == "s" || leg_number(rest).is_some())
            }
            Extent::Family => false,
        };
        let families = || self.kinds.iter().filter(|k| k.extent == Extent::Family && covariate.starts_with(&*k.name));
        self.kinds.iter().find(exact).or_else(|| families().max_by_key(|kind| kind.name.len()))
    }

    /// The leg of a covariate, from 0; `None` if it belongs to no single one.
    pub fn leg_of(&self, covariate: &str) -> Option<usize> {
        let kind = self.of(covariate).filter(|kind| kind.extent == Extent::EachLeg)?;
        leg_number(covariate.strip_prefix(&*kind.name)?)
    }

    /// True if a covariate is a temperature.
    pub fn is_temperature(&self, covariate: &str) -> bool {
        self.of(covariate).is_some_and(ConditionKind::is_temperature)
    }

    /// The covariates that are recorded on a machine with so many legs where everything is; families have no names.
    pub fn recorded(&self, legs: usize) -> impl Iterator<Item = String> {
        self.kinds.iter().filter(|kind| kind.is_recorded()).flat_map(move |kind| match kind.extent {
            Extent::Machine => vec![kind.name.to_string()],
            Extent::EachLeg => (0..legs).map(|leg| of_leg(&kind.name, leg)).chain([kind.of_all_legs()]).collect(),
            Extent::Family => Vec::new(),
        })
    }

    /// The value of a covariate at a sample, SI and °C: recorded, the mean of those of the legs, or what follows from the
    /// commanded `joints`.
    pub fn value(&self, covariate: &str, state: &Conditions, joints: &[f64]) -> Option<f64> {
        let kind = self.of(covariate).filter(|kind| kind.extent == Extent::EachLeg);
        let leg = || self.leg_of(covariate);
        match kind.map(|kind| (kind, kind.role, leg())) {
            Some((_, Role::Commanded(what), Some(leg))) => what.of(leg, state, joints),
            Some((kind, role, None)) if !matches!(role, Role::Commanded(_)) => state.mean_of_legs(&kind.name),
            _ => state.get(covariate),
        }
    }
}

impl Commanded {
    fn of(self, leg: usize, state: &Conditions, joints: &[f64]) -> Option<f64> {
        let now = *joints.get(leg)?;
        let travel = || Some(now - state.previous_joints.as_ref()?.get(leg)?);
        match self {
            Self::Coordinate => Some(now),
            Self::Travel => travel(),
            Self::Approach => travel().map(f64::signum),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::{TEMP_BASE, TEMP_LEG, TEMP_LEGS};
    use crate::units::Dimension;

    #[test]
    fn names_find_their_kind() {
        let table = ConditionTable::standard();
        let name = |covariate: &str| table.of(covariate).map(|kind| kind.name.to_string());
        assert_eq!(name("temp_leg12").as_deref(), Some(TEMP_LEG));
        assert_eq!(name(TEMP_LEGS).as_deref(), Some(TEMP_LEG));
        assert_eq!(name(TEMP_BASE).as_deref(), Some(TEMP_BASE));
        for of_family in ["temp_base1", "temp_leg0", "temp_leg_near_motor"] {
            assert_eq!(name(of_family).as_deref(), Some("temp_"), "{of_family}");
        }
        assert_eq!((name("temp"), name("payload_kg"), name("leg1")), (None, None, None));
        assert_eq!(
            (table.leg_of("temp_leg3"), table.leg_of(TEMP_LEGS), table.leg_of("payload")),
            (Some(2), None, None)
        );
    }

    #[test]
    fn a_kind_replaces_the_one_of_its_name() {
        let table = ConditionTable::standard().with(ConditionKind::new("payload", Dimension::Force, "payload"));
        assert_eq!(table.of("payload").map(|kind| kind.dimension), Some(Dimension::Force));
        assert_eq!(table.iter().count(), ConditionTable::standard().iter().count());
        assert_ne!(table, ConditionTable::standard());
    }

    #[test]
    fn values_are_recorded_or_follow() {
        let table = ConditionTable::standard();
        let mut state = Conditions { previous_joints: Some(vec![1.0, 2.0]), ..Conditions::unknown() };
        state.covariates.extend([("temp_leg1".to_owned(), 20.0), ("temp_leg2".to_owned(), 24.0)]);
        let value = |name: &str| table.value(name, &state, &[1.5, 1.0]);
        assert_eq!((value("temp_leg2"), value(TEMP_LEGS), value("payload")), (Some(24.0), Some(22.0), None));
        assert_eq!(
            (value("length_leg1"), value("travel_leg1"), value("approach_leg2")),
            (Some(1.5), Some(0.5), Some(-1.0))
        );
        assert_eq!(value("length_leg3"), None);
    }
}
