//! Mechanism files to start from: one of each kind that a file can describe, with a comment on every key.
//!
//! What is optional and would change the machine, or needs a number that only its owner knows, is a comment: a line
//! `# key = …` or `# [section]`, which becomes a line of the file without its `# `.

use super::kinds::KINDS;

/// A mechanism file to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ExampleFile {
    /// Its `type`.
    pub kind: &'static str,
    /// What that is, for people.
    pub label: &'static str,
    /// The text of the file.
    pub text: &'static str,
}

/// A file of each kind, in the order in which errors list them; there is none of a mechanism that a program defines.
pub fn example_files() -> impl Iterator<Item = ExampleFile> {
    KINDS.into_iter().filter_map(|kind| Some(ExampleFile { kind: kind.name, label: kind.label, text: kind.example? }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::mechanism::kinds::own;
    use crate::files::{Machine, MechanismDocument};

    fn read(example: &ExampleFile, text: &str) -> Machine {
        Machine::from_text(text, "example.toml".as_ref()).unwrap_or_else(|e| panic!("{}: {e}\n{text}", example.kind))
    }

    /// The file with everything that is optional.
    fn complete(text: &str) -> String {
        let key = |line: &&str| {
            let word = line.split([' ', '=']).next().unwrap_or_default();
            let is_key = !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            line.starts_with('[') || is_key && line[word.len()..].starts_with(" = ")
        };
        text.lines().map(|line| line.strip_prefix("# ").filter(key).unwrap_or(line)).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn every_kind_has_a_file_that_is_read_without_a_warning() {
        let without: Vec<&str> = KINDS.iter().filter(|kind| kind.example.is_none()).map(|kind| kind.name).collect();
        assert_eq!(without, [own::KIND.name]);
        for example in example_files() {
            let machine = read(&example, example.text);
            assert_eq!(machine.document().kind, example.kind);
            assert!(machine.warnings.is_empty(), "{}: {:?}", example.kind, machine.warnings);
            assert!(machine.workspace.is_some() && machine.noise.is_some(), "{}", example.kind);
            assert!(example.text.is_ascii() && example.text.lines().all(|l| l.len() <= 125), "{}", example.kind);
        }
    }

    #[test]
    fn what_is_commented_out_is_read_as_well() {
        for example in example_files() {
            let text = complete(example.text);
            let stated = |text: &str| text.lines().filter(|l| !l.starts_with('#') && !l.is_empty()).count();
            assert!(stated(&text) > stated(example.text) + 4, "{}: nothing was commented out", example.kind);
            let MechanismDocument { reference_temperature, targets, .. } = read(&example, &text).document().clone();
            assert!(reference_temperature.is_some() && targets.len() == 1, "{}", example.kind);
        }
    }

    #[test]
    fn each_option_is_read_alone() {
        // A key of the file or of a leg; sections belong to their keys.
        for example in example_files() {
            let all = complete(example.text);
            for (k, (commented, plain)) in example.text.lines().zip(all.lines()).enumerate() {
                if commented == plain || plain.starts_with('[') || plain.starts_with("joint_reversed") {
                    continue;
                }
                let before: Vec<&str> = example.text.lines().take(k).collect();
                let block = before.iter().rposition(|l| l.is_empty()).map_or(0, |blank| blank + 1);
                if before[block..].iter().any(|l| l.starts_with("# [")) {
                    continue;
                }
                let lines = example.text.lines().enumerate().map(|(i, line)| if i == k { plain } else { line });
                read(&example, &lines.collect::<Vec<_>>().join("\n"));
            }
        }
    }
}
