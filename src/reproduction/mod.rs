//! The paper, table by table and figure by figure: Yu, Wu, Wang, "Kinematic Calibration Method for Six-Hardpoint
//! Positioning Mechanisms Using Optimal Measurement Pose", Appl. Sci. 13 (2023) 4824.
//!
//! The paper prints single random draws of a simulation whose settings it states in part. The others were recovered by
//! fitting ([`paper`]). Each exhibit repeats the simulation many times, with new candidate poses and new noise, and
//! says where the printed number lies among ours:
//!
//! | verdict | the printed number |
//! |---|---|
//! | [`Verdict::Reproduced`] | lies in the central 95 % of single draws, which is narrow, or within 1 % of the mean |
//! | [`Verdict::WithinOneDraw`] | lies in the central 95 % of single draws, which is so wide that this says little |
//! | [`Verdict::NotReproduced`] | lies outside; the exhibit says why |
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
//! Tables 2, 3, 5 and 6 are inputs. [`reproduce`] makes exhibits, [`Lab`] holds settings and keeps finished work.

mod calibrations;
mod comparison;
mod conditions;
mod exhibit;
mod figure10;
mod figure5;
mod figure6;
mod figure7;
mod figure8;
mod figure9;
mod lab;
pub mod paper;
mod ranking;
mod render;
mod sets;
mod small_stroke;
mod table1;
mod table4;
mod table8;

pub use comparison::{Comparison, Spread, Verdict};
pub use exhibit::{Exhibit, Listing};
pub use lab::{Lab, Progress, ReproduceError, Settings};
pub use render::page;

/// Names of the exhibits in the order of the paper.
pub const EXHIBITS: [&str; 9] =
    ["table1", "table4", "figure5", "figure6", "figure7", "figure8", "table8", "figure9", "figure10"];

/// Makes one exhibit.
///
/// # Errors
/// [`ReproduceError`]; [`ReproduceError::Unknown`] for a name that is not in [`EXHIBITS`].
pub fn reproduce(name: &str, lab: &Lab<'_>) -> Result<Exhibit, ReproduceError> {
    match name {
        "table1" => table1::exhibit(lab),
        "table4" => table4::exhibit(lab),
        "figure5" => figure5::exhibit(lab),
        "figure6" => figure6::exhibit(lab),
        "figure7" => figure7::exhibit(lab),
        "figure8" => figure8::exhibit(lab),
        "table8" => table8::exhibit(lab),
        "figure9" => figure9::exhibit(lab),
        "figure10" => figure10::exhibit(lab),
        _ => Err(ReproduceError::Unknown { name: name.to_owned() }),
    }
}
