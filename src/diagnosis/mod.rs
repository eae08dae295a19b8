//! From residuals to causes: what the model gets wrong, and why.
//!
//! Even the best-fit kinematic parameters leave a residual. [`diagnose`] always gives one of six answers:
//!
//! | verdict | meaning |
//! |---|---|
//! | clean | the residuals are noise |
//! | named | causes of the [catalogue](crate::effect::Catalogue) explain it |
//! | tied | they do, but the data do not exclude other names |
//! | unknown | an error depends on a covariate, or is at a leg, and no name explains it |
//! | undecided | the data cannot tell: too few rows, or an instrument that stands still |
//! | misread | the file was read wrongly: a sign, a unit, an order |
//!
//! The steps, with their files:
//!
//! 1. **Preflight** (`preflight`): would the file fit much better if it were read otherwise? Mistakes in the poses (signs,
//!    units, orders, frames), the columns of joints that go with them (one regression of the joints that the poses ask
//!    for), and pairs of these. Beside a strong effect it is asked again with effects in the model.
//! 2. **Baseline** (`hypotheses`, `design_matrix`): the parameters are identified with a prior of two tolerances, which
//!    keeps the two weak directions of each leg finite, and the columns of everything are computed once.
//! 3. **Outliers** (`outliers`): samples that fit nothing, judged again after every step.
//! 4. **Search** (`search`): all columns are projected off those of the parameters (`model`). Names are *detected*
//!    by a test at a family-wise level with all places of a scan counted, and *chosen* by their marginal likelihood
//!    with priors of physical size, heavy-tailed by a mixture of widths. One is added, all are tried in each other's
//!    places, and so on; then parameters and values are identified together and the columns computed anew.
//! 5. **Ties**: every other name within a factor of 20 in evidence is reported, and what a missing sensor leaves possible
//!    (`not_excluded`).
//! 6. **Remainder** (`remainder`): tests without a named cause. If one finds something, the answer is *unknown*, and if
//!    one covariate at one leg explains more than all names together the names are withdrawn.
//! 7. **Lags** (`lags`): do parts follow their sensors later than at once? If so the search is made again with time
//!    constants in its scans.
//! 8. **Gain** (`gain`): errors on rows that were not fitted, with the causes and without.
//!
//! Frames, targets and leg offsets are absorbed by the parameters; no effect is named for them. What parameters absorb
//! is not harmless: a shifting pivot looks right within the measured range and is wrong outside.

mod answer;
mod diagnose;
mod error;
mod linear;
mod planning;
mod preflight;
mod question;
mod search;

pub use answer::result::{
    AddedVariable, Alternative, Cause, CauseParameter, Diagnosis, Gain, JointResiduals, Misread, NoiseVaries, NotFound,
    NotTestable, Rival, Verdict,
};
pub use answer::unknown::{COORDINATES, Unknown, UnknownTest};
pub use diagnose::diagnose;
pub use error::DiagnoseError;
pub use planning::design::{detection_limits, planned};
pub use planning::settle::{MeasurementPlan, Separation, settle};
pub use question::Question;
pub use search::stepwise::TOLD_APART;
