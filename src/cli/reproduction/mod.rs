//! The paper, table by table and figure by figure: Yu, Wu, Wang, "Kinematic Calibration Method for Six-Hardpoint
//! Positioning Mechanisms Using Optimal Measurement Pose", Appl. Sci. 13 (2023) 4824.
//!
//! The paper prints single random draws of a simulation whose settings it states in part. The others were recovered by
//! fitting ([`paper`]). Each exhibit repeats the simulation many times, with new candidate poses and new noise, and
//! says where the printed number lies among ours:
//!
//! | verdict | the printed number |
//! |---|---|
//! | [`Agreement::Reproduced`] | lies in the central 95 % of single draws, which is narrow, or within 1 % of the mean |
//! | [`Agreement::WithinOneDraw`] | lies in the central 95 % of single draws, which is so wide that this says little |
//! | [`Agreement::NotReproduced`] | lies outside; the exhibit says why |
//!
//! | name | shows |
//! |---|---|
//! | `table1` | the five indices for 20, 30, 40 poses, by tabu DETMAX and by DETMAX; restarts at equal effort |
//! | `table4`, `figure5` | which index makes the calibration most accurate, under four conditions |
//! | `figure6`, `figure7` | the search for 20 poses; the index of random sets |
//! | `figure8` | convergence, and the identified parameters (Table 7) |
//! | `table8`, `figure9` | errors at 150 targets for chosen and for random poses |
//! | `figure10` | error against the number of poses; what weighting and better poses gain; a small stroke |
//!
//! Tables 2, 3, 5 and 6 are inputs. [`reproduce`] makes exhibits, [`ReproductionContext`] holds settings and keeps finished work.

mod calibrations;
mod comparison;
mod conditions;
mod context;
mod exhibit;
mod figure10;
mod figure5;
mod figure6;
mod figure7;
mod figure8;
mod figure9;
mod journal;
pub mod paper;
mod ranking;
mod render;
mod sets;
mod small_stroke;
mod table1;
mod table4;
mod table8;

pub use comparison::{Agreement, Comparison, Spread};
pub use context::{Progress, ReproduceError, ReproductionContext, Settings};
pub use exhibit::{Exhibit, Listing};
pub use journal::{Journal, JournalError};
pub use render::page;

/// Names of the exhibits in the order of the paper.
pub const EXHIBITS: [&str; 9] =
    ["table1", "table4", "figure5", "figure6", "figure7", "figure8", "table8", "figure9", "figure10"];

/// Makes one exhibit.
///
/// # Errors
/// [`ReproduceError`]; [`ReproduceError::Unknown`] for a name that is not in [`EXHIBITS`].
pub fn reproduce(name: &str, context: &ReproductionContext<'_>) -> Result<Exhibit, ReproduceError> {
    match name {
        "table1" => table1::exhibit(context),
        "table4" => table4::exhibit(context),
        "figure5" => figure5::exhibit(context),
        "figure6" => figure6::exhibit(context),
        "figure7" => figure7::exhibit(context),
        "figure8" => figure8::exhibit(context),
        "table8" => table8::exhibit(context),
        "figure9" => figure9::exhibit(context),
        "figure10" => figure10::exhibit(context),
        _ => Err(ReproduceError::Unknown { name: name.to_owned() }),
    }
}
