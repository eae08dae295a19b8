//! What `mechanisms/README.md` must say of files: every key and every column that the code knows.

use paracal::conditions::{ConditionKind, ConditionTable, Extent, Role, of_leg};
use paracal::effect::{Catalogue, ScanPoint};
use paracal::files::example_files;

use crate::common::text;

/// The rows of the table of conditions that begin with a column, and what they say of it.
fn rows(readme: &str) -> Vec<&str> {
    let section = readme.split("\n## Conditions\n").nth(1).unwrap().split("\n## ").next().unwrap();
    section.lines().filter(|line| line.starts_with("| `")).collect()
}

/// The names under which a kind must have a row.
fn names(kind: &ConditionKind) -> Vec<String> {
    match (kind.extent, kind.role) {
        (Extent::Family, _) => vec![format!("{}…", kind.name)],
        (Extent::EachLeg, Role::Commanded(_)) => vec![of_leg(&kind.name, 0)],
        (Extent::EachLeg, _) => vec![kind.column(&of_leg(&kind.name, 0)), kind.column(&kind.of_all_legs())],
        (Extent::Machine, _) => vec![kind.column(&kind.name)],
    }
}

fn row<'a>(rows: &[&'a str], name: &str) -> &'a str {
    let first_cell = |line: &&&str| line.split(" | ").next().is_some_and(|cell| cell.contains(&format!("`{name}")));
    rows.iter().find(first_cell).unwrap_or_else(|| panic!("mechanisms/README.md has no row of {name}"))
}

#[test]
fn every_condition_has_a_row_with_its_units() {
    let readme = text("mechanisms/README.md");
    let rows = rows(&readme);
    for kind in ConditionTable::standard().iter() {
        for name in names(kind) {
            let said = row(&rows, &name);
            let units = kind.dimension.choices();
            let missing = units.split(" | ").find(|unit| kind.is_recorded() && !said.contains(unit));
            assert_eq!(missing, None, "{said}");
            assert_eq!(said.contains("required"), kind.needs_unit && kind.is_recorded(), "{said}");
        }
    }
    for other in ["gravity_x gravity_y gravity_z", "zenith_distance_deg", "time_utc"] {
        row(&rows, other);
    }
}

#[test]
fn every_effect_stands_in_the_rows_of_its_conditions() {
    let readme = text("mechanisms/README.md");
    let (rows, table) = (rows(&readme), ConditionTable::standard());
    for effect in &Catalogue::standard() {
        assert!(readme.contains(&format!("`{}`", effect.name())), "{}", effect.name());
        let at = ScanPoint { leg: Some(0), ..ScanPoint::default() };
        for covariate in effect.covariates(&at) {
            let kind = table.of(&covariate).unwrap();
            // The mean of the legs has a row of its own.
            let name = if covariate == kind.of_all_legs() { kind.column(&covariate) } else { names(kind).remove(0) };
            let said = row(&rows, &name);
            assert!(said.contains(&format!("`{}`", effect.name())), "{}: {said}", effect.name());
        }
    }
}

#[test]
fn every_key_of_the_examples_is_explained() {
    let readme = text("mechanisms/README.md");
    for example in example_files() {
        for line in example.text.lines().map(|line| line.strip_prefix("# ").unwrap_or(line)) {
            let key = match line.split_once(" = ") {
                Some((key, _)) if key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') => key,
                _ if line.starts_with('[') => line,
                _ => continue,
            };
            let words = readme.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '[' || c == ']'));
            assert!(words.clone().any(|word| word == key), "{}: `{key}` is not in mechanisms/README.md", example.kind);
        }
    }
}
