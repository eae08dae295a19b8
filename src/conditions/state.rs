//! The operating state of one sample, and its place in the run.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Vector3;

use super::covariate::mean_of_legs;
use super::history::History;
use super::standard::TIME;

/// Covariates of one sample by name, and the joints of the samples before.
///
/// Covariates are named by their column without the unit: `temp_leg3`, `elevation`, `time`, `payload`, or
/// any other numeric column of the measurement file. Values are in SI, temperatures in °C.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Conditions {
    /// Value of each covariate that is known.
    pub covariates: BTreeMap<String, f64>,
    /// Joint coordinates of the sample that was measured before, in file order; home for the first one.
    pub previous_joints: Option<Vec<f64>>,
    /// Direction of gravity in the base frame, length one.
    pub gravity: Option<Vector3<f64>>,
    /// Place of the sample in its run; `None` outside of one.
    pub run: Option<Run>,
}

/// Place of a sample in the run in which it was measured.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Run {
    /// 0-based data row.
    pub row: usize,
    /// Part of the run that has passed: 0 at the first time, 1 at the last, or by rows without times.
    pub part: f64,
    /// Joint coordinates of all rows of the run, in file order.
    pub joints: Arc<[Vec<f64>]>,
    /// Covariates of all rows of the run.
    pub history: Arc<History>,
}

impl Conditions {
    /// Conditions of which nothing is known.
    pub fn unknown() -> Self {
        Self::default()
    }

    /// Puts states into the run in which they were measured: row, part, and the joints and covariates of all rows. The joints before are
    /// those of the row before; the first row is approached from `home`.
    ///
    /// The part is that of the time if every state has one and they differ, whatever the order of the rows; else that of the rows.
    pub fn put_in_run(states: &mut [Self], joints: Vec<Vec<f64>>, home: Option<&[f64]>) {
        let parts = parts(states);
        let joints: Arc<[Vec<f64>]> = joints.into();
        let history = Arc::new(History::of(states));
        for (row, (state, part)) in states.iter_mut().zip(parts).enumerate() {
            let before = row.checked_sub(1).and_then(|row| joints.get(row)).cloned();
            state.previous_joints = before.or_else(|| home.map(<[f64]>::to_vec));
            state.run = Some(Run { row, part, joints: Arc::clone(&joints), history: Arc::clone(&history) });
        }
    }

    /// The value of a covariate, if it is known.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.covariates.get(name).copied()
    }

    /// One number for a condition that is recorded leg by leg: the covariate `{stem}s` if there is one, else the mean of
    /// `{stem}1`, `{stem}2`, …; `None` without any of them. `temp_leg` gives the mean temperature of the legs, °C.
    pub fn mean_of_legs(&self, stem: &str) -> Option<f64> {
        if let Some(common) = self.get(&mean_of_legs(stem)) {
            return Some(common);
        }
        let own = self.covariates.range(stem.to_owned()..).take_while(|(name, _)| name.starts_with(stem));
        let (sum, count) = own
            .filter(|(name, _)| name[stem.len()..].parse::<usize>().is_ok())
            .fold((0.0, 0), |(sum, count), (_, value)| (sum + value, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }
}

/// How much of a run has passed at each of its states.
fn parts(states: &[Conditions]) -> Vec<f64> {
    let times: Option<Vec<f64>> = states.iter().map(|s| s.get(TIME)).collect();
    let extent = times.as_deref().and_then(extent);
    if let (Some(times), Some((first, last))) = (times, extent) {
        return times.iter().map(|t| (t - first) / (last - first)).collect();
    }
    let last = states.len().saturating_sub(1).max(1) as f64;
    (0..states.len()).map(|row| row as f64 / last).collect()
}

/// The first and the last time of a run; `None` where time stands still, or where rows are in no order and one clock is far off.
fn extent(times: &[f64]) -> Option<(f64, f64)> {
    let (first, last) = (*times.first()?, *times.last()?);
    if first < last && times.iter().all(|t| (first..=last).contains(t)) {
        return Some((first, last));
    }
    let mut ordered = times.to_vec();
    ordered.sort_by(f64::total_cmp);
    let (first, last) = (ordered[0], ordered[ordered.len() - 1]);
    let far = |gap: f64| gap > 0.5 * (last - first);
    let alone = ordered.len() < 4 || far(ordered[1] - first) || far(last - ordered[ordered.len() - 2]);
    (first < last && !alone).then_some((first, last))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run_at(times: &[Option<f64>]) -> Vec<f64> {
        let state = |time: &Option<f64>| {
            let mut state = Conditions::unknown();
            state.covariates.extend(time.map(|t| (TIME.to_owned(), t)));
            state
        };
        let mut states: Vec<Conditions> = times.iter().map(state).collect();
        let joints = (0..states.len()).map(|row| vec![row as f64]).collect();
        Conditions::put_in_run(&mut states, joints, Some(&[-1.0]));
        for (row, state) in states.iter().enumerate() {
            assert_eq!(state.previous_joints, Some(vec![row as f64 - 1.0]));
        }
        states.iter().map(|s| s.run.as_ref().map_or(f64::NAN, |run| run.part)).collect()
    }

    #[test]
    fn a_run_passes_by_time_where_all_rows_have_one_that_increases() {
        assert_eq!(run_at(&[Some(10.0), Some(11.0), Some(14.0)]), [0.0, 0.25, 1.0]);
        assert_eq!(run_at(&[Some(10.0), None, Some(14.0)]), [0.0, 0.5, 1.0]);
        assert_eq!(run_at(&[Some(10.0), Some(10.0), Some(10.0)]), [0.0, 0.5, 1.0]);
        // One clock that is far off must not stretch the others together.
        assert_eq!(run_at(&[Some(10.0), Some(1e6), Some(14.0)]), [0.0, 0.5, 1.0]);
        // Rows in another order have their times still.
        assert_eq!(run_at(&[Some(12.0), Some(14.0), Some(10.0), Some(11.0)]), [0.5, 1.0, 0.0, 0.25]);
        assert_eq!(run_at(&[None]), [0.0]);
        assert_eq!(run_at(&[]), [0.0; 0]);
    }
}
