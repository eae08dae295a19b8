//! The findings of one run, and names that were probably meant.

use crate::files::finding::{Finding, FindingKind, KEPT};

/// Findings of one run.
#[derive(Debug, Default)]
pub(super) struct Findings {
    errors: Vec<Finding>,
    warnings: Vec<Finding>,
    /// Warnings that are only counted.
    dropped: usize,
}

impl Findings {
    /// Adds one.
    pub(super) fn add(
        &mut self,
        kind: FindingKind,
        element: impl Into<String>,
        line: impl Into<Option<usize>>,
        text: impl Into<String>,
    ) {
        self.push(Finding { kind, element: element.into(), line: line.into(), text: text.into() });
    }

    pub(super) fn push(&mut self, finding: Finding) {
        // Every error counts: a file is read only if there is none.
        if !finding.kind.is_warning() {
            self.errors.push(finding);
        } else if self.warnings.len() < KEPT {
            self.warnings.push(finding);
        } else {
            self.dropped += 1;
        }
    }

    /// Fails with the errors so far; warnings stay.
    pub(super) fn stop_on_errors(&mut self) -> Result<(), Vec<Finding>> {
        let errors = std::mem::take(&mut self.errors);
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }

    pub(super) fn any_error(&self) -> bool {
        !self.errors.is_empty()
    }

    /// The warnings, once the errors are out of the way.
    pub(super) fn into_warnings(mut self) -> Vec<Finding> {
        if self.dropped > 0 {
            let text = format!("{} more warnings are not shown; correct those that are", self.dropped);
            self.warnings.push(Finding { kind: FindingKind::Note, element: String::new(), line: None, text });
        }
        self.warnings
    }
}

/// The nearest of `names`, to ask "did you mean".
pub(super) fn nearest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // Long names and long lists are not searched: the answer is worth no wait.
    let short = |n: &&str| n.chars().count() <= 60;
    if !short(&name) {
        return None;
    }
    let scored = names.take(2000).filter(short).map(|n| (distance(name, n), n));
    scored.min_by_key(|(d, _)| *d).filter(|(d, _)| *d <= 1 + name.chars().count() / 4).map(|(_, n)| n)
}

/// `; did you mean '…'?`, or nothing.
pub(super) fn did_you_mean<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> String {
    nearest(name, names).map_or_else(String::new, |n| format!("; did you mean '{n}'?"))
}

/// Number of insertions, deletions and replacements from one word to another.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = corner + usize::from(x != *y);
            corner = row[j + 1];
            row[j + 1] = replaced.min(corner + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_and_a_far_one_is_not() {
        let names = ["platform", "base", "leg1_rod"];
        assert_eq!(nearest("platfrom", names.into_iter()), Some("platform"));
        assert_eq!(nearest("leg1_rot", names.into_iter()), Some("leg1_rod"));
        assert_eq!(nearest("wheel", names.into_iter()), None);
    }
}
