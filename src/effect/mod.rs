//! Effects: influences on a mechanism beyond its kinematic parameters.
//!
//! An effect is a function of the operating state of a sample (temperatures, gravity, history, time) that perturbs
//! the parameters `C`, the joint coordinates `h`, or the measured pose:
//!
//! ```text
//! f(q, h + δh(θ), C + δC(θ)) = 0        effects on joints and on the geometry: they move the platform
//! q_measured = δq(θ) ∘ q + noise         effects on the measurement: they do not
//! ```
//!
//! Through `J_b` and the motion per joint each parameter `θₖ` becomes one column: the small motion of the measured pose
//! per unit of the parameter. That is all that [`crate::diagnosis`] needs, for any mechanism whose parameters
//! carry roles.
//!
//! | group | names | file |
//! |---|---|---|
//! | temperature | `thermal.*` | [`mod@catalogue`] |
//! | joints | `scale.*`, `length.quadratic`, `cyclic.pitch`, `backlash`, `hysteresis.play`, `joint.*` | |
//! | gravity | `compliance.*`, `sag.*` | |
//! | time | `drift.*`, `step.*` | |
//! | instrument | `instrument.*` | |
//! | axes of a pose | `axis.*` | |
//!
//! [`Effect`] is the trait; your own effects work like those of the crate in a [`Catalogue`]. [`Extended`] is a
//! mechanism with effects, and again a [`Mechanism`](crate::mechanism::Mechanism): identification, pose selection, compensation and files work with
//! it unchanged. Effects on the measurement are parameters of the measurement ([`WithInstrumentEffects`]).

pub mod catalogue;
mod compensator;
mod context;
mod extended;
mod instrument;
mod needs;
mod perturbation;
mod scan;

use std::fmt::Debug;

pub use catalogue::Catalogue;
pub use compensator::{Compensated, Compensator, Extrapolated};
#[cfg(feature = "files")]
pub(crate) use context::leg_directions;
pub use context::{AvailableData, EffectContext, Environment, Sensor, Site};
#[cfg(feature = "files")]
pub(crate) use extended::label;
pub use extended::{ActiveEffect, Extended, effects_of, without_effects};
pub use instrument::{WithInstrumentEffects, seen, to_be_seen_at};
pub use perturbation::Perturbation;
pub use scan::{Scan, ScanPoint};

use crate::units::Dimension;

/// One parameter of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectParameter {
    /// Its name in files and results: `expansion`, `scale3`.
    pub name: String,
    /// Dimension; values are in SI.
    pub dimension: Dimension,
    /// Size that it has in sound machines, SI: the scale of its prior. It decides between names and never shrinks a value.
    pub scale: f64,
    /// True if it cannot be below zero: bodies do not shrink as they get warmer.
    pub never_negative: bool,
}

/// Usual sizes beyond which a value is not plausible.
const PLAUSIBLE: f64 = 10.0;
/// σ below zero from which on a value is.
const BELOW: f64 = 2.0;

impl EffectParameter {
    /// A parameter by name, dimension and usual size.
    pub fn new(name: impl Into<String>, dimension: Dimension, scale: f64) -> Self {
        Self { name: name.into(), dimension, scale, never_negative: false }
    }

    /// The same, of which values below zero are not plausible.
    #[must_use]
    pub fn never_negative(self) -> Self {
        Self { never_negative: true, ..self }
    }

    /// True if a value with this 1σ is within ten times the usual size, and not below zero where that cannot be.
    pub fn is_plausible(&self, value: f64, sigma: f64) -> bool {
        let below = self.never_negative && value < -BELOW * sigma;
        value.abs() <= PLAUSIBLE * self.scale && !below
    }
}

/// Target of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActsOn {
    /// Joints or geometry: the platform moves, and commands can compensate it.
    Mechanism,
    /// The instrument or its frame: only the readings move.
    Measurement,
}

/// One named physical cause.
///
/// Implementations are linear in their parameters: [`perturb`](Self::perturb) of `2θ` is twice that of `θ`. They are
/// evaluated once for each unit parameter, and the columns follow.
pub trait Effect: Debug + Send + Sync {
    /// Its name in files and results, such as `thermal.legs.uniform`.
    fn name(&self) -> &str;

    /// The cause, in one sentence that a mechanic understands.
    fn cause(&self) -> &str;

    /// The remedy.
    fn remedy(&self) -> &str;

    /// Target of the effect.
    fn acts_on(&self) -> ActsOn {
        ActsOn::Mechanism
    }

    /// True if it tells what happened in one run and predicts nothing for another: no command compensates it.
    fn describes_one_run(&self) -> bool {
        false
    }

    /// Missing requirements for testing it: columns of the data, entries of the mechanism file, or a property of the
    /// mechanism. Empty if it can be tested.
    fn missing(&self, context: &EffectContext<'_>, available: &AvailableData) -> Vec<String>;

    /// Its parameters.
    fn parameters(&self, context: &EffectContext<'_>) -> Vec<EffectParameter>;

    /// Unknowns in addition to the parameters, which are scanned.
    fn scan(&self, _setting: &EffectContext<'_>, _recorded: &AvailableData) -> Scan {
        Scan::None
    }

    /// True if its temperatures may act with a lag, whose time constant is then scanned too.
    fn may_lag(&self) -> bool {
        false
    }

    /// Names of richer effects of which this one is a special case.
    fn special_case_of(&self) -> &[&str] {
        &[]
    }

    /// Directions of its parameters, each as long as [`parameters`](Self::parameters), along one of which it often acts
    /// alone, such as a single axis. Its evidence is shared between all parameters together and each direction, so that
    /// parameters that are zero are not held against it.
    fn often_alone(&self, _setting: &EffectContext<'_>) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Names that differ from it only by what tolerances say of the size of the machine. Where such a name explains as
    /// much they are reported as tied, whatever the evidence.
    fn twins(&self) -> &[&str] {
        &[]
    }

    /// Covariates that it depends on at a point of its scan, by the names of the
    /// [table of conditions](crate::conditions::ConditionTable) or of other columns: for the range in which it was fitted,
    /// and for measurements that vary them.
    fn covariates(&self, at: &ScanPoint) -> Vec<String>;

    /// Adds what the effect does at a site. `theta` has the length of [`parameters`](Self::parameters); `out` has been
    /// cleared. Where a condition is not known the effect does nothing.
    fn perturb(&self, theta: &[f64], at: &ScanPoint, site: &Site<'_>, out: &mut Perturbation);
}
