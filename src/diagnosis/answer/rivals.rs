//! Other names that the data do not exclude: one effect in the place of another, or two together in the place of one that
//! has several parameters.

use crate::diagnosis::answer::result::Rival;
use crate::diagnosis::error::DiagnoseError;
use crate::diagnosis::linear::hypotheses::Hypotheses;
use crate::diagnosis::linear::hypothesis::Hypothesis;
use crate::diagnosis::linear::model::Model;
use crate::diagnosis::search::iteration::SearchState;
use crate::diagnosis::search::pairs::pairs;
use crate::diagnosis::search::stepwise::{Score, TIED, TOLD_APART, related, separability, twins};
use crate::measurement::DataRow;

/// A twin that takes at least this part of the gain explains as much.
const AS_MUCH: f64 = 0.9;

/// A name whose rivals are looked for.
pub(super) struct Named<'a> {
    pub(super) subject: &'a Hypotheses<'a>,
    pub(super) state: &'a SearchState,
    /// The model of the other names.
    pub(super) without: &'a Model,
    pub(super) others: &'a [Hypothesis],
    /// The catalogue beside it.
    pub(super) scores: &'a [Score],
    pub(super) name: &'a Hypothesis,
    pub(super) values: &'a [f64],
    pub(super) variance: f64,
}

impl Named<'_> {
    /// Every rival, the one with the most evidence first.
    pub(super) fn rivals(&self) -> Result<Vec<Rival>, DiagnoseError> {
        let mut tied = self.single();
        tied.extend(self.pairs()?);
        tied.sort_by(|a, b| a.log_bayes_factor.total_cmp(&b.log_bayes_factor));
        Ok(tied)
    }

    fn own(&self) -> &Score {
        &self.scores[self.name.group]
    }

    /// The effects that may stand in the place of the name.
    fn candidates(&self) -> impl Iterator<Item = &Score> {
        let may =
            |s: &&Score| s.rank > 0 && s.candidate.group != self.name.group && !self.others.contains(&s.candidate);
        self.scores.iter().filter(may)
    }

    fn separability(&self, rival: &[Hypothesis]) -> f64 {
        let groups = &self.subject.groups;
        separability(self.without, groups, std::slice::from_ref(self.name), self.values, rival, self.variance)
    }

    /// Names within a factor of 20 in evidence, and within a factor of 400 those that the data can hardly tell from the named
    /// one, unless one is a special case of the other.
    fn single(&self) -> Vec<Rival> {
        let groups = &self.subject.groups;
        let mut tied = Vec::new();
        for s in self.candidates() {
            let behind = self.own().evidence - s.evidence;
            // What the data can hardly tell apart is not told apart by the sizes that are usual.
            let reach = if related(groups, self.name, &s.candidate) { TIED } else { 2.0 * TIED };
            // Only tolerances tell a twin, and they are no measurement.
            let twin = twins(groups, self.name, &s.candidate) && s.gain > AS_MUCH * self.own().gain;
            if behind > reach && !twin {
                continue;
            }
            let separability = self.separability(std::slice::from_ref(&s.candidate));
            if twin || behind <= TIED || separability < TOLD_APART {
                tied.extend(self.rival(std::slice::from_ref(&s.candidate), behind, separability));
            }
        }
        tied
    }

    /// Two names together, by the same measure.
    fn pairs(&self) -> Result<Vec<Rival>, DiagnoseError> {
        let fit = |names| self.state.with_names(self.subject, names);
        let mut tied = Vec::new();
        for pair in pairs(&self.subject.groups, self.name, self.others, self.scores, fit)? {
            let behind = self.own().evidence - pair.evidence;
            if behind > 2.0 * TIED {
                continue;
            }
            let separability = self.separability(&pair.names);
            if behind <= TIED || separability < TOLD_APART {
                tied.extend(self.rival(&pair.names, behind, separability));
            }
        }
        Ok(tied)
    }

    /// The answer's view of effects that stand in the place of the name together; `None` for no effect.
    fn rival(&self, names: &[Hypothesis], log_bayes_factor: f64, separability: f64) -> Option<Rival> {
        let groups = &self.subject.groups;
        let rows: Vec<DataRow> = self.subject.data.iter().map(|s| s.row).collect();
        let all = self.without.ask_all(groups, names).values();
        let mut end = all.len();
        let mut rival = None;
        for name in names.iter().rev() {
            let group = &groups[name.group];
            let first = end - group.parameters.len();
            let at = name.at(groups, &rows);
            rival = Some(Rival {
                effect: group.effect.name().into(),
                leg: at.leg,
                row: at.row,
                of: at.covariate,
                lag: at.lag,
                values: all[first..end].to_vec(),
                together_with: rival.map(Box::new),
                log_bayes_factor,
                separability,
            });
            end = first;
        }
        rival
    }
}
