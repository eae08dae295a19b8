//! `diagnose` on files that are not as they should be: a clear message or an honest verdict, and never a name where
//! nothing is wrong with the machine.

use crate::common::bench::{Bench, SEED, names, not_testable, verdict};
use crate::common::hidden::cases::{Kind, draw_in_run};
use crate::common::hidden::run::normal;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde_json::Value;

/// A measurement file as cells.
#[derive(Clone)]
pub struct Table {
    pub mechanism: String,
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A case in a run of so many rows.
    pub fn of(kind: Kind, rows: usize, number: usize) -> Self {
        let case = draw_in_run(kind, rows, SEED, number).unwrap();
        let mut lines = case.data.lines().map(|line| line.split(',').map(str::to_owned).collect());
        Self { mechanism: case.mechanism, header: lines.next().unwrap(), rows: lines.collect() }
    }

    /// Nothing is hidden in it.
    pub fn null() -> Self {
        Self::of(Kind::Null, 80, 0)
    }

    pub fn at(&self, column: &str) -> usize {
        self.header.iter().position(|name| name == column).unwrap()
    }

    /// With the cells of a column replaced, which are given by row and value.
    pub fn with(mut self, column: &str, cell: impl Fn(usize, f64) -> String) -> Self {
        let at = self.at(column);
        for (row, cells) in self.rows.iter_mut().enumerate() {
            cells[at] = cell(row, cells[at].parse().unwrap());
        }
        self
    }

    /// Without the columns whose names begin so.
    pub fn without(mut self, beginning: &str) -> Self {
        while let Some(at) = self.header.iter().position(|name| name.starts_with(beginning)) {
            self.header.remove(at);
            self.rows.iter_mut().for_each(|row| drop(row.remove(at)));
        }
        self
    }

    /// With a copy of a column under another name, which may be there already.
    fn copied(mut self, from: &str, to: &str) -> Self {
        let from = self.at(from);
        let at = self.header.iter().position(|name| name == to);
        for row in &mut self.rows {
            let cell = row[from].clone();
            match at {
                Some(at) => row[at] = cell,
                None => row.push(cell),
            }
        }
        if at.is_none() {
            self.header.push(to.into());
        }
        self
    }

    pub fn bench(&self) -> Bench {
        let lines = std::iter::once(&self.header).chain(&self.rows).map(|cells| cells.join(",") + "\n");
        Bench::new(&self.mechanism, lines.collect::<String>())
    }

    #[track_caller]
    pub fn diagnosed(&self) -> Value {
        self.bench().json("diagnose m.toml d.csv")
    }

    #[track_caller]
    fn refused(&self, parts: &[&str]) {
        self.bench().refuses("diagnose m.toml d.csv -o e.toml", parts);
    }

    /// Requires that nothing is found.
    #[track_caller]
    fn is_clean(&self) -> Value {
        let found = self.diagnosed();
        assert_eq!((verdict(&found), names(&found).len()), ("clean", 0), "{found}");
        found
    }
}

/// What a program does that did not panic.
#[track_caller]
fn ends(bench: &Bench, call: &str) -> (i32, Option<Value>) {
    let output = bench.run(call);
    let message = String::from_utf8_lossy(&output.stderr);
    let code = output.status.code().unwrap();
    assert!(!message.contains("panicked") && [0, 2, 3].contains(&code), "{call}: {code} {message}");
    assert!(code != 2 || message.starts_with("error: "), "{message}");
    let object: Option<Value> = serde_json::from_slice(&output.stdout).ok();
    (code, object.filter(|o| o.get("error").is_none()))
}

#[test]
fn few_rows() {
    let few = |rows: usize| {
        let mut table = Table::null();
        table.rows.truncate(rows);
        table
    };
    few(0).refused(&["d.csv"]);
    // From twelve degrees of freedom on there may be an answer, and a modest one.
    for rows in [1, 3, 5, 7, 8, 9, 10, 12, 20] {
        let (code, found) = ends(&few(rows).bench(), "diagnose m.toml d.csv -o e.toml --json");
        let found = found.unwrap();
        let honest = match verdict(&found) {
            "clean" => rows > 7 && code == 0 && found["undecided"].is_null(),
            "undecided" => {
                code == 3 && found["undecided"].as_str().unwrap().contains("measure more, and more varied, poses")
            }
            _ => false,
        };
        assert!(honest && names(&found).is_empty(), "{rows} rows: {code} {found}");
        assert!(rows > 3 || verdict(&found) == "undecided", "{rows} rows: {found}");
    }
}

#[test]
fn a_temperature_that_does_not_change() {
    let found = Table::null().with("temp_platform_degC", |_, _| "20.5".into()).is_clean();
    assert!(not_testable(&found, "thermal.platform").contains("temp_platform"), "{}", found["not_testable"]);
    // All of them, and every effect of temperature with them.
    let mut table = Table::null();
    for column in table.header.clone().iter().filter(|name| name.starts_with("temp_")) {
        table = table.with(column, |_, _| "20.5".into());
    }
    let found = table.is_clean();
    for effect in ["thermal.legs.uniform", "thermal.legs.individual", "thermal.leg.single", "thermal.base"] {
        assert!(not_testable(&found, effect).contains("temp_"), "{effect}: {}", found["not_testable"]);
    }
}

#[test]
fn conditions_that_were_not_recorded() {
    let found = Table::null().without("elevation").is_clean();
    for effect in ["compliance.gravity", "sag.frame", "sag.platform", "compliance.payload"] {
        assert!(!not_testable(&found, effect).is_empty(), "{effect}: {}", found["not_testable"]);
    }
    let found = Table::null().without("temp_").without("time").without("payload").without("azimuth").is_clean();
    for effect in ["thermal.base", "thermal.platform", "thermal.legs.uniform", "compliance.payload"] {
        assert!(!not_testable(&found, effect).is_empty(), "{effect}: {}", found["not_testable"]);
    }
    assert!(not_testable(&found, "drift.leg").is_empty(), "rows are in order: {}", found["not_testable"]);
}

#[test]
fn cells_without_a_number() {
    for cell in ["", "nan", "NaN"] {
        let table = Table::null().with("temp_base_degC", |row, t| if row == 7 { cell.into() } else { t.to_string() });
        let (code, found) = ends(&table.bench(), "diagnose m.toml d.csv --json");
        let Some(found) = found else {
            assert_eq!(code, 2, "'{cell}'");
            continue;
        };
        assert_eq!(verdict(&found), "clean", "'{cell}': {found}");
        let warned = found["warnings"].to_string();
        assert!(warned.contains("data rows 7 are left out") && warned.contains("temp_base"), "'{cell}': {warned}");
    }
    // A hole in what truly acts costs its row, and not the name.
    let hot = Table::of(Kind::One(4.0), 120, 4);
    assert_eq!(names(&hot.diagnosed()), ["thermal.base"]);
    let holed = hot.with("temp_base_degC", |row, t| if row == 30 { String::new() } else { t.to_string() });
    let found = holed.diagnosed();
    assert_eq!(names(&found), ["thermal.base"], "{found}");
}

#[test]
fn two_columns_that_are_the_same() {
    Table::null().copied("temp_base_degC", "temp_platform_degC").is_clean();
    Table::null().copied("temp_base_degC", "temp_other_degC").copied("time_s", "counter").is_clean();
    // Legs that have one temperature: growth by the mean is then growth of each.
    let mut table = Table::of(Kind::Null, 80, 1);
    for leg in 2..=6 {
        table = table.copied("temp_leg1_degC", &format!("temp_leg{leg}_degC"));
    }
    table.is_clean();
    // With an effect in one of two equal columns its parts are told apart by what they move, not by their temperature.
    let hot = Table::of(Kind::One(4.0), 120, 4).copied("temp_base_degC", "temp_platform_degC");
    let found = hot.diagnosed();
    println!("same: {} {:?}", verdict(&found), names(&found));
    assert_eq!(names(&found), ["thermal.base"], "{found}");
}

#[test]
fn every_row_twice() {
    let mut table = Table::null();
    table.rows = table.rows.iter().flat_map(|row| [row.clone(), row.clone()]).collect();
    let found = table.diagnosed();
    println!("twice: {} {:?} {} {}", verdict(&found), names(&found), found["unknown"], found["row_correlation"]);
    assert!(names(&found).is_empty(), "{found}");
    // One file behind the other.
    let mut table = Table::null();
    table.rows.extend(table.rows.clone());
    let found = table.diagnosed();
    println!("again: {} {:?} {} {}", verdict(&found), names(&found), found["unknown"], found["row_correlation"]);
    assert!(names(&found).is_empty(), "{found}");
}

#[test]
fn poses_that_have_nothing_to_do_with_the_legs() {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    for spread in [1.0, 100.0] {
        let mut table = Table::null();
        let first = table.at("x_mm");
        let home = [0.0, 0.0, 475.7, 0.0, 0.0, 0.0];
        for row in &mut table.rows {
            for k in 0..6 {
                let half = if k < 3 { 10.0 } else { 0.5 } * spread;
                row[first + k] = format!("{:.6}", home[k] + half * rng.random_range(-1.0..1.0));
            }
        }
        let (code, found) = ends(&table.bench(), "diagnose m.toml d.csv -o e.toml --json");
        println!(
            "garbage: {code} {:?}",
            found.as_ref().map(|f| (verdict(f), names(f), f["unknown"].clone(), f["misread"].clone()))
        );
        if let Some(found) = found {
            assert!(["unknown", "misread"].contains(&verdict(&found)) && names(&found).is_empty(), "{found}");
        }
    }
}

#[test]
fn gross_errors_everywhere() {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut table = Table::null();
    let first = table.at("x_mm");
    for row in &mut table.rows {
        for k in 0..6 {
            let sigma = if k < 3 { 0.001 } else { 0.0001 };
            let value: f64 = row[first + k].parse().unwrap();
            row[first + k] = format!("{:.9}", value + 50.0 * sigma * normal(&mut rng));
        }
    }
    // The data say how large the noise is; that it is fifty times the stated one is said, and no name is given.
    for call in ["diagnose m.toml d.csv", "diagnose m.toml d.csv --noise-known"] {
        let found = table.bench().json(call);
        assert!((found["noise_scale"].as_f64().unwrap() / 50.0 - 1.0).abs() < 0.15 || call.len() > 25, "{found}");
        assert_eq!(verdict(&found), "unknown", "{found}");
        let unknown = &found["unknown"];
        assert!(names(&found).is_empty() && unknown["covariate"].is_null() && unknown["kind"] == "noise", "{found}");
    }
}

#[test]
fn a_jump_before_the_last_row_and_one_after_the_first() {
    for jumped in [0, 79] {
        let table = Table::null().with("x_mm", |row, x| format!("{:.9}", x + if row == jumped { 0.2 } else { 0.0 }));
        let found = table.is_clean();
        assert_eq!(found["outlier_rows"], serde_json::json!([jumped]), "{found}");
    }
    // Two rows are a step that cannot be told from two gross errors.
    let table = Table::null().with("x_mm", |row, x| format!("{:.9}", x + if row >= 78 { 0.2 } else { 0.0 }));
    let found = table.diagnosed();
    println!("two: {} {:?} {}", verdict(&found), names(&found), found["outlier_rows"]);
    assert!(names(&found).iter().all(|name| name.starts_with("step.")), "{found}");
}

#[test]
fn temperatures_that_cannot_be() {
    let table = Table::null().with("temp_base_degC", |row, t| if row == 4 { "-300.0".into() } else { t.to_string() });
    table.refused(&["d.csv", "temp_base"]);
    let mut table = Table::null().with("temp_base_degC", |_, t| format!("{}", t + 273.15));
    let at = table.at("temp_base_degC");
    table.header[at] = "temp_base_K".into();
    let found = table.is_clean();
    assert_eq!(not_testable(&found, "thermal.base"), "");
    table.rows[3][at] = "-4.0".into();
    table.refused(&["d.csv", "temp_base"]);
}

#[test]
fn time_that_stands_still_or_runs_backwards() {
    Table::null().with("time_s", |_, _| "5.0".into()).is_clean();
    Table::null().with("time_s", |row, _| format!("{}", 1000.0 - row as f64)).is_clean();
}
