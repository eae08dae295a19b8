//! Names of covariates of which there is one for each leg.

/// The covariate of a leg, from 0: `temp_leg3` for `temp_leg` and 2.
pub fn of_leg(stem: &str, leg: usize) -> String {
    format!("{stem}{}", leg + 1)
}

/// The covariate of all legs together.
pub(super) fn mean_of_legs(stem: &str) -> String {
    format!("{stem}s")
}

/// A leg from 0 for its number from 1.
pub(super) fn leg_number(text: &str) -> Option<usize> {
    text.parse::<usize>().ok()?.checked_sub(1)
}
