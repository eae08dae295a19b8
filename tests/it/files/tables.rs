//! One measurement, written as spreadsheets, scripts and instruments write it.

use paracal::files::{Machine, Measurement, read_poses};
use proptest::prelude::*;

use super::read_table as read;
use crate::common::bench::{NOISY, TABLE_5, says};

/// Joints and measured coordinates of every row.
fn content(read: &Measurement) -> Vec<(Vec<f64>, [f64; 6])> {
    let coordinates = |k: usize| {
        let (model, index) = read.data.reading(k);
        model.coordinates(index).unwrap()
    };
    (0..read.data.len()).map(|k| (read.data.sample(k).joints.clone(), coordinates(k))).collect()
}

fn cells() -> Vec<Vec<String>> {
    NOISY.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').map(str::to_owned).collect()).collect()
}

/// How a program may write a table.
#[derive(Clone, Debug)]
struct Habits {
    separator: &'static str,
    states_separator: bool,
    index: Option<i64>,
    blank_column: bool,
    blank_rows: usize,
    trailing: bool,
    comment: &'static str,
    units: Option<[&'static str; 2]>,
    quotes: bool,
    crlf: bool,
}

impl Habits {
    fn write(&self, cells: &[Vec<String>]) -> String {
        let end = if self.crlf { "\r\n" } else { "\n" };
        let mut rows: Vec<Vec<String>> = cells.to_vec();
        if let Some([open, close]) = self.units {
            let unit = |name: &String| name.rsplit_once('_').unwrap().1.to_owned();
            let units: Vec<String> = rows[0].iter().map(|n| format!("{open}{}{close}", unit(n))).collect();
            rows[0].iter_mut().for_each(|n| *n = n.rsplit_once('_').unwrap().0.to_owned());
            rows.insert(1, units);
        }
        let unnumbered = if self.units.is_some() { 2 } else { 1 };
        for (k, row) in rows.iter_mut().enumerate() {
            if self.quotes {
                row.iter_mut().for_each(|cell| *cell = format!("\"{cell}\""));
            }
            if self.blank_column {
                row.insert(6, String::new());
            }
            if let Some(first) = self.index {
                row.insert(0, if k < unnumbered { String::new() } else { (first + k as i64).to_string() });
            }
        }
        let mut text = String::new();
        if self.states_separator {
            text += &format!("sep={}{end}", self.separator);
        }
        text += &format!("{} written by a program, 2026{end}", self.comment);
        for (k, row) in rows.iter().enumerate() {
            let trailing = if self.trailing && k > 0 { self.separator } else { "" };
            text += &format!("{}{trailing}{end}", row.join(self.separator));
            for _ in 0..self.blank_rows {
                text += &format!("{}{end}", self.separator.repeat(row.len() - 1));
            }
        }
        text
    }
}

fn habits() -> impl Strategy<Value = Habits> {
    let separated = (
        prop::sample::select(vec![",", ";", "\t"]),
        any::<bool>(),
        prop::option::of(0..9i64),
        any::<bool>(),
        0..3usize,
        any::<bool>(),
    );
    let rest = (
        prop::sample::select(vec!["#", "//", "  # "]),
        prop::option::of(prop::sample::select(vec![["", ""], ["[", "]"], ["(", ")"]])),
        any::<bool>(),
        any::<bool>(),
    );
    (separated, rest).prop_map(|(a, b)| Habits {
        separator: a.0,
        states_separator: a.1,
        index: a.2,
        blank_column: a.3,
        blank_rows: a.4,
        trailing: a.5,
        comment: b.0,
        units: b.1,
        quotes: b.2,
        crlf: b.3,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn a_table_means_the_same_whoever_wrote_it(habits in habits()) {
        let found = read(&habits.write(&cells())).unwrap();
        prop_assert_eq!(content(&found), content(&read(NOISY).unwrap()));
        let said = |word: &str| found.warnings.iter().any(|w| w.contains(word));
        prop_assert_eq!(said("counts the rows"), habits.index.is_some());
        prop_assert_eq!(said("states units"), habits.units.is_some());
    }
}

#[test]
fn columns_may_be_separated_by_blanks() {
    let aligned: String =
        cells().iter().map(|row| row.iter().map(|c| format!("{c:>20} ")).collect::<String>() + "\n").collect();
    assert_eq!(content(&read(&aligned).unwrap()), content(&read(NOISY).unwrap()));
}

#[test]
fn what_other_programs_write_for_nothing_is_not_measured() {
    for word in ["nan", "NaN", "NA", "n/a", "null", ""] {
        let mut cells = cells();
        cells[3][11] = word.into();
        let text: String = cells.iter().map(|row| row.join(",") + "\n").collect();
        let found = read(&text).unwrap();
        assert_eq!(found.data.rows(2).len(), 5, "{word}");
        assert_eq!(found.data.row_of_each(2), [Some(0), Some(1), Some(2), Some(3), Some(4), None], "{word}");
        assert_eq!(found.data.row_count(), 119, "{word}");
        assert_eq!(found.warnings.iter().any(|w| w.contains("not measured")), !word.is_empty(), "{word}");
    }
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let refused = |change: &dyn Fn(&mut Vec<Vec<String>>), parts: &[&str]| {
        let mut cells = cells();
        change(&mut cells);
        let text: String = cells.iter().map(|row| row.join(",") + "\n").collect();
        says(&read(&text).unwrap_err().to_string(), parts);
    };
    let units = |unit: &'static str| move |cells: &mut Vec<Vec<String>>| cells.insert(1, vec![unit.into(); 12]);
    refused(&units("in"), &["d.csv: column 'leg1_mm'", "line 2 states another unit, 'in'", "correct one of them"]);
    let unnamed = |cells: &mut Vec<Vec<String>>| {
        for (k, row) in cells.iter_mut().enumerate() {
            row.push(if k == 0 { String::new() } else { format!("{k}") });
        }
    };
    refused(&unnamed, &["d.csv: column ''", "has no name", "name it or delete it"]);
    let falling = |cells: &mut Vec<Vec<String>>| {
        for (k, row) in cells.iter_mut().enumerate() {
            row.insert(0, if k == 0 { String::new() } else { format!("{}", 100 - k) });
        }
    };
    refused(&falling, &["d.csv: column ''", "has no name"]);
}

#[test]
fn lists_of_poses_are_read_alike() {
    let machine = Machine::from_text(TABLE_5, "m.toml".as_ref()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let read = |text: &str| {
        let path = folder.path().join("p.csv");
        std::fs::write(&path, text).unwrap();
        read_poses(&path, &machine).unwrap()
    };
    let plain = read("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n1,2,475,0.1,0.2,0.3\n4,5,480,0,0,0\n");
    let other =
        read("sep=;\n;x;y;z;rx;ry;rz\n;mm;mm;mm;deg;deg;deg\n\n0;1;2;475;0.1;0.2;0.3;\n1;4;5;480;0;0;0;\n;;;;;;\n");
    assert_eq!(plain, other);
}
