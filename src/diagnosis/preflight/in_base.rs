//! Readings of a file in the base frame: the poses of each are asked which columns of joints go with them.

use crate::diagnosis::preflight::joint_columns::JointColumns;
use crate::diagnosis::preflight::mistakes::Mistake;
use crate::diagnosis::preflight::reading::Reading;
use crate::diagnosis::preflight::trial::Trial;
use crate::measurement::Frames;

/// Readings that are worth a fit.
const MOST: usize = 48;
/// Readings that leave this many times what the best one does are not.
const WORSE: f64 = 4.0;
/// Single mistakes to which a second one is added.
const FIRST: usize = 14;
/// What another mistake must make smaller to be worth a fit.
const PER_MISTAKE: f64 = 1.25;

/// A reading and the part of the joints that it leaves unexplained before anything is fitted.
#[derive(Clone, Debug)]
pub(crate) struct Screened {
    pub(crate) reading: Reading,
    pub(crate) left: f64,
}

impl Screened {
    fn rank(&self) -> f64 {
        self.left * PER_MISTAKE.powi(self.reading.count() as i32)
    }
}

/// The readings of the base frame by one mistake in the poses, with the columns of joints that go with them.
pub(crate) struct InBase<'a> {
    trial: &'a Trial<'a>,
    mistakes: Vec<Mistake>,
    singles: Vec<Screened>,
}

impl<'a> InBase<'a> {
    pub(crate) fn new(trial: &'a Trial<'a>) -> Self {
        let mistakes = trial.mistakes();
        let mut singles = screened(trial, Vec::new());
        for mistake in &mistakes {
            singles.extend(screened(trial, vec![mistake.clone()]));
        }
        singles.sort_by(|a, b| a.left.total_cmp(&b.left));
        Self { trial, mistakes, singles }
    }

    /// Those that are worth a fit, the best first.
    pub(crate) fn singles(&self) -> Vec<Screened> {
        best(self.singles.clone())
    }

    /// The best of them with a second mistake in the poses, where that is worth a fit.
    pub(crate) fn pairs(&self) -> Vec<Screened> {
        let mut first: Vec<&Mistake> = Vec::new();
        for found in &self.singles {
            match &found.reading.mistakes[..] {
                [one] if !first.contains(&one) => first.push(one),
                _ => {}
            }
        }
        first.truncate(FIRST);
        let mut all = Vec::new();
        for (k, one) in first.iter().enumerate() {
            let others = self.mistakes.iter().filter(|m| m.goes_with(one) && !first[..k].contains(m));
            for other in others {
                all.extend(screened(self.trial, vec![(*one).clone(), other.clone()]));
            }
        }
        best(all)
    }
}

/// A reading with its joints as stated, and with the columns that go with its poses.
fn screened(trial: &Trial<'_>, mistakes: Vec<Mistake>) -> Vec<Screened> {
    let reading = Reading { mistakes, joints: JointColumns::stated(trial.mechanism.joints().len()) };
    let Some(found) = trial.regression(&reading, &Frames::default()) else { return Vec::new() };
    let file_unit = reading.mistakes.iter().any(|m| matches!(m, Mistake::FileUnit(_)));
    let mut all = Vec::new();
    // In another unit everything is nearly proportional, so that the zeros must agree too.
    if !(file_unit && found.stated_from_elsewhere) {
        all.push(Screened { reading: reading.clone(), left: found.left_as_stated });
    }
    let odd = file_unit && (found.columns.counted_from_elsewhere || found.columns.unit.is_some());
    if !found.columns.is_as_stated() && !odd {
        all.push(Screened { reading: Reading { joints: found.columns, ..reading }, left: found.left });
    }
    all
}

/// Those that leave little, the best first.
fn best(mut all: Vec<Screened>) -> Vec<Screened> {
    all.retain(|s| s.left.is_finite() && !s.reading.is_as_stated());
    all.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
    let least = all.first().map_or(0.0, Screened::rank);
    // A few of each count, so that pairs cannot crowd out what is simple.
    let mut taken = [0; 8];
    all.retain(|s| {
        let taken = &mut taken[s.reading.count().min(7)];
        *taken += 1;
        *taken <= MOST / 2 && s.rank() <= WORSE * least.max(1e-4)
    });
    all.truncate(MOST);
    all
}
