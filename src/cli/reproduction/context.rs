//! Settings, seeds, and work that is kept.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use super::journal::{Journal, JournalError};
use crate::files::FileError;
use crate::identification::IdentifyError;
use crate::mechanism::GeometryError;
use crate::selection::SelectionError;
use crate::simulation::TrialError;
use crate::solve::SolveError;

/// How much is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Noise draws for each set of poses.
    pub draws: u64,
    /// Candidate poses per list.
    pub candidates: usize,
    /// Lists of candidates.
    pub lists: u64,
    /// Random seed.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { draws: 1000, candidates: 2000, lists: 5, seed: 0 }
    }
}

impl Settings {
    /// That something can be done with them, before anything is.
    ///
    /// # Errors
    /// [`ReproduceError::Settings`] for settings that leave nothing to compare (40 draws for percentiles, three lists for a
    /// spread, as many candidates as the largest set and a tabu list take), or no end.
    pub fn check(&self) -> Result<(), ReproduceError> {
        let Settings { draws, candidates, lists, .. } = *self;
        for (what, value, (least, most)) in [
            ("--draws: the number of draws", draws, (40, 1_000_000)),
            ("--candidates: the number of candidates", candidates as u64, (200, 100_000)),
            ("--lists: the number of lists", lists, (3, 1000)),
        ] {
            if !(least..=most).contains(&value) {
                return Err(ReproduceError::Settings { what, value, least, most });
            }
        }
        Ok(())
    }
}

/// How far the work has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// The work in progress.
    pub what: &'a str,
    /// Units done.
    pub done: usize,
    /// Units in all.
    pub total: usize,
}

/// Context in which exhibits are made.
pub struct ReproductionContext<'a> {
    /// How much is done.
    pub settings: Settings,
    /// Finished work.
    pub journal: &'a Journal,
    /// Told of progress, from any thread.
    pub watch: &'a (dyn Fn(Progress<'_>) + Sync),
}

/// Why an exhibit could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// There is no exhibit of this name.
    #[error("'{name}' is no table or figure that is reproduced; there are {}", super::EXHIBITS.join(", "))]
    Unknown {
        /// The name.
        name: String,
    },
    /// Settings that leave nothing to compare, or no end.
    #[error("{what} is {value}; it must be from {least} to {most}")]
    Settings {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: u64,
        /// The least that makes sense.
        least: u64,
        /// The most that can be done.
        most: u64,
    },
    /// More than half of the simulated calibrations failed.
    #[error("{failed} of {draws} calibrations of {what} failed: {cause}")]
    Failed {
        /// Which calibrations.
        what: String,
        /// How many failed.
        failed: u64,
        /// Of how many.
        draws: u64,
        /// The last reason.
        cause: String,
    },
    /// A mechanism file.
    #[error(transparent)]
    File(#[from] FileError),
    /// A mechanism.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The choice of poses.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// A simulated calibration.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// An identification.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// A least-squares run.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The journal.
    #[error(transparent)]
    Journal(#[from] JournalError),
}

impl<'a> ReproductionContext<'a> {
    /// A context with these settings.
    ///
    /// # Errors
    /// As [`Settings::check`].
    pub fn new(
        settings: Settings,
        journal: &'a Journal,
        watch: &'a (dyn Fn(Progress<'_>) + Sync),
    ) -> Result<Self, ReproduceError> {
        settings.check()?;
        Ok(Self { settings, journal, watch })
    }

    /// The results of units of work, in order: each from the journal, or computed, in parallel. Units with the same key
    /// are one.
    pub(super) fn units<U: Sync, T: Serialize + DeserializeOwned + Clone + Send>(
        &self,
        what: &str,
        units: &[U],
        key: impl Fn(&U) -> String,
        work: impl Fn(&U) -> Result<T, ReproduceError> + Sync,
    ) -> Result<Vec<T>, ReproduceError> {
        let keys: Vec<String> = units.iter().map(|u| self.key(&key(u))).collect();
        let mut places = HashMap::new();
        let mut different = Vec::new();
        for (key, unit) in keys.iter().zip(units) {
            places.entry(key).or_insert_with(|| {
                different.push((key, unit));
                different.len() - 1
            });
        }
        let (done, total) = (AtomicUsize::new(0), different.len());
        (self.watch)(Progress { what, done: 0, total });
        let unit = |(key, unit): &(&String, &U)| {
            let result = self.journal.unit(key, || work(unit));
            (self.watch)(Progress { what, done: done.fetch_add(1, Ordering::Relaxed) + 1, total });
            result
        };
        let results: Vec<T> = different.par_iter().map(unit).collect::<Result<_, _>>()?;
        Ok(keys.iter().map(|key| results[places[key]].clone()).collect())
    }

    /// Random sets that stand for measuring without choosing.
    pub(super) fn random_sets(&self) -> u64 {
        (self.settings.draws / 5).clamp(8, 200)
    }

    /// A key with the settings that every result depends on.
    fn key(&self, unit: &str) -> String {
        let Settings { draws, candidates, lists: _, seed } = self.settings;
        format!("{unit}; {draws} draws, {candidates} candidates, seed {seed}")
    }

    /// A seed of its own for a purpose and a number: seeds of users that lie side by side share nothing.
    pub(super) fn seed(&self, purpose: Purpose, number: u64) -> u64 {
        mixed(mixed(self.settings.seed) ^ mixed(((purpose as u64) << 32) | number))
    }
}

/// What a seed is for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    Candidates = 1,
    Search,
    Restarts,
    RandomSets,
    Draws,
    Targets,
    OneDraw,
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): every bit of the input moves every bit of the output.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
