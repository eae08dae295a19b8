//! Which poses to measure, and how good the choice is.
//!
//! Measuring time is dear; twenty poses chosen well tell as much as a hundred chosen at random. [`Candidates`] are
//! feasible poses with their blocks, a [`PoseSelector`] takes some of them, and [`relax`] proves a bound that no set of
//! them can pass.
//!
//! | selector | how | use |
//! |---|---|---|
//! | [`Random`] | draws | the comparison |
//! | [`Detmax`] | adds the best pose, removes the worst, until both are the same (section 3.2) | the paper's reference |
//! | [`TabuDetmax`] | the same with a list of poses that may not come back (section 3.2) | the paper's method |
//! | [`Exchange`] | exchanges each member for the best candidate from many starts, then moves poses freely | the default |
//!
//! What Mitchell (1974) called DETMAX makes longer excursions; the paper's version, kept here under that name, is a
//! one-point exchange. The corners of the workspace matter more than the selector: most coordinates of good poses are
//! at their limits, and a list of random poses has no such pose.
//!
//! Of a long list [`Exchange`] searches the part that would do most for a set that was found quickly, and looks at all
//! of it once more at the end; the bound holds for all of it whatever was searched.
//!
//! [`select`] is the whole job: candidates, choice, bound, and a [`Forecast`] of what the calibration will be worth.
//! [`how_many`] repeats it over the number of poses.

mod campaign;
mod candidates;
mod criterion;
mod detmax;
mod error;
mod exchange;
mod forecast;
mod how_many;
mod job;
mod polish;
mod preview;
mod problem;
mod random;
mod relaxation;
mod screening;
mod support;

pub use campaign::{Campaign, Infeasible};
pub use candidates::{Candidates, Origin, Sources};
pub use detmax::{Detmax, TabuDetmax};
pub use error::SelectionError;
pub use exchange::Exchange;
pub use forecast::{Forecast, Forecaster};
pub use how_many::{MOST_POSES, Requirement, how_many, smallest_number};
pub use job::{ChosenSet, Objective, SelectionTask, select, select_among};
pub use preview::{Preview, preview};
pub use problem::{Choice, Numbered, PoseSelector, Problem, Step};
pub use random::Random;
pub use relaxation::{Relaxation, relax};

/// Names of the built-in selectors.
pub const SELECTORS: [&str; 4] = ["random", "detmax", "tabu-detmax", "exchange"];

/// A built-in selector by name, with its defaults.
pub fn selector(name: &str) -> Option<Box<dyn PoseSelector>> {
    Some(match name {
        "random" => Box::new(Random),
        "detmax" => Box::new(Detmax::default()),
        "tabu-detmax" => Box::new(TabuDetmax::default()),
        "exchange" => Box::new(Exchange::default()),
        _ => return None,
    })
}
