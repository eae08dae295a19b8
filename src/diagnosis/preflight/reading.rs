//! One way to read a file otherwise: mistakes in the readings, in the joints, or in both.

use crate::diagnosis::preflight::joint_columns::JointColumns;
use crate::diagnosis::preflight::mistakes::Mistake;
use crate::mechanism::Mechanism;

/// One way to read a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) mistakes: Vec<Mistake>,
    pub(crate) joints: JointColumns,
}

impl Reading {
    /// As it stands.
    pub(crate) fn stated(joints: usize) -> Self {
        Self { mistakes: Vec::new(), joints: JointColumns::stated(joints) }
    }

    pub(crate) fn is_as_stated(&self) -> bool {
        self.count() == 0
    }

    /// Mistakes that it undoes.
    pub(crate) fn count(&self) -> usize {
        self.mistakes.len() + self.joints.names().len()
    }

    /// Names in the format, in the order of the alphabet, joined by `+`; each stands once.
    pub(crate) fn name(&self) -> String {
        let mut names = self.joints.names();
        names.extend(self.mistakes.iter().map(Mistake::name));
        names.sort_unstable();
        names.dedup();
        names.join("+")
    }

    /// What is wrong, in words.
    pub(crate) fn detail(&self, mechanism: &dyn Mechanism) -> String {
        let mut details: Vec<String> = self.mistakes.iter().map(Mistake::detail).collect();
        details.extend(self.joints.details(mechanism));
        details.join("; ")
    }
}
