//! The operating state of one sample: what was true while it was measured, and what kinds of conditions there are.
//!
//! A plain mechanism ignores its state. Effects such as thermal growth, gravity or backlash act on it, and the
//! diagnosis searches it for what the residuals depend on. [`Conditions`] is the state; [`ConditionTable`] says what its
//! covariates mean. Readers of files, effects, planned campaigns, pictures and `settle` take everything that they know
//! of a condition from its entry ([`ConditionKind`]):
//!
//! | name | recorded | dimension | what it is |
//! |---|---|---|---|
//! | `temp_leg1` …, `temp_legs` | per leg | temperature | of the legs; their mean where no column states it |
//! | `temp_platform`, `temp_base` | once | temperature | of the bodies |
//! | `temp_…` | once | temperature | of anything else, such as a sensor of the mechanism file |
//! | `elevation` | once | angle | from which the direction of gravity follows |
//! | `azimuth` | once | angle | about the vertical |
//! | `payload` | once | mass | a load that gravity acts on |
//! | `time` | once | time | since the first row, also from the clock in `time_utc` |
//! | `length_leg1` …, `travel_leg1` …, `approach_leg1` … | never | as the joint | follow from the commands |
//!
//! Any other numeric column is a covariate that an effect may name, too; a kind of its own gives it a unit that is checked,
//! a label, and a way to be varied. A new kind is one entry in `standard.rs` and one line above, or, from outside,
//! [`ConditionTable::with`]:
//!
//! ```
//! use paracal::conditions::{ConditionKind, ConditionTable, Variation};
//! use paracal::units::Dimension;
//!
//! let force = ConditionKind::new("force_leg", Dimension::Force, "force").each_leg();
//! let table = ConditionTable::standard().with(force.varied(Variation::Evenly([0.0, 200.0])));
//! assert_eq!(table.of("force_leg3").map(|kind| kind.unit().name), Some("N"));
//! ```

mod covariate;
mod history;
mod kind;
mod standard;
mod state;
mod table;

pub use covariate::of_leg;
pub use history::History;
pub use kind::{Commanded, ConditionKind, Extent, Part, Role, Variation};
pub use standard::{
    APPROACH_LEG, AZIMUTH, ELEVATION, LENGTH_LEG, PAYLOAD, TEMP_BASE, TEMP_LEG, TEMP_LEGS, TEMP_PLATFORM, TIME,
    TRAVEL_LEG,
};
pub use state::{Conditions, Run};
pub use table::ConditionTable;
