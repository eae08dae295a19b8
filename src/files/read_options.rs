//! What reading a mechanism file starts from, other than the file.

use std::sync::Arc;

use crate::conditions::{ConditionKind, ConditionTable};
use crate::effect::{Catalogue, Effect};
use crate::files::urdf_options::UrdfOptions;
use crate::mechanism::Mechanism;

/// The effects that a mechanism file may state, the conditions that its data may hold, and what a URDF file leaves open.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The effects that an `[[effect]]` may name.
    pub catalogue: Catalogue,
    /// What the covariates of data mean.
    pub condition_kinds: ConditionTable,
    /// The mechanism that files of type "own" mean: one that this program defines.
    pub mechanism: Option<Arc<dyn Mechanism>>,
    /// What a URDF file leaves open; must be empty for other files.
    pub urdf: UrdfOptions,
}

impl ReadOptions {
    /// One effect more; it replaces the one of its name.
    #[must_use]
    pub fn with_effect(self, effect: impl Effect + 'static) -> Self {
        Self { catalogue: self.catalogue.with(effect), ..self }
    }

    /// For files about this mechanism, which have the type "own".
    #[must_use]
    pub fn with_mechanism(self, mechanism: impl Mechanism) -> Self {
        Self { mechanism: Some(Arc::new(mechanism)), ..self }
    }

    /// One kind of condition more; it replaces the one of its name.
    #[must_use]
    pub fn with_condition(self, kind: ConditionKind) -> Self {
        Self { condition_kinds: self.condition_kinds.with(kind), ..self }
    }
}
