//! What reading a mechanism file starts from, other than the file.

use crate::conditions::{ConditionKind, ConditionTable};
use crate::effect::{Catalogue, Effect};
use crate::files::urdf::options::UrdfOptions;

/// The effects that a mechanism file may state, the conditions that its data may hold, and what a URDF file leaves open.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The effects that an `[[effect]]` may name.
    pub catalogue: Catalogue,
    /// What the covariates of data mean.
    pub condition_kinds: ConditionTable,
    /// What a URDF file leaves open; must be empty for other files.
    pub urdf: UrdfOptions,
}

impl ReadOptions {
    /// One effect more; it replaces the one of its name.
    #[must_use]
    pub fn with_effect(self, effect: impl Effect + 'static) -> Self {
        Self { catalogue: self.catalogue.with(effect), ..self }
    }

    /// One kind of condition more; it replaces the one of its name.
    #[must_use]
    pub fn with_condition(self, kind: ConditionKind) -> Self {
        Self { condition_kinds: self.condition_kinds.with(kind), ..self }
    }
}
