//! Two texts as a user's two files, and what the diagnosis says of them.

use paracal::diagnosis::{Cause, Diagnosis, Question, diagnose};
use paracal::files::{Machine, Measurement, read_measurement};

/// The files, read.
pub struct Files {
    pub machine: Machine,
    pub measurement: Measurement,
}

impl Files {
    pub fn new(mechanism: &str, data: &str) -> Self {
        let machine = Machine::from_text(mechanism, "mechanism.toml".as_ref()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data.csv");
        std::fs::write(&path, data).unwrap();
        let measurement = read_measurement(&path, &machine).unwrap();
        Self { machine, measurement }
    }

    pub fn question(&self) -> Question<'_> {
        Question::of(&self.machine, &self.measurement.data)
    }

    pub fn diagnosis(&self) -> Diagnosis {
        diagnose(&self.question()).unwrap()
    }
}

/// What is said of a mechanism and its data.
pub fn asked(mechanism: &str, data: &str) -> Diagnosis {
    Files::new(mechanism, data).diagnosis()
}

/// `thermal.leg.single leg 3 row 7`, legs from 1.
pub fn place(effect: &str, leg: Option<usize>, row: Option<usize>) -> String {
    let leg = leg.map_or(String::new(), |leg| format!(" leg {leg}"));
    let row = row.map_or(String::new(), |row| format!(" row {row}"));
    format!("{effect}{leg}{row}")
}

/// Everything that was said, on one line, for a message.
pub fn said(d: &Diagnosis) -> String {
    let one = |c: &Cause| {
        let named = place(&c.effect, c.leg.map(|leg| leg + 1), c.row);
        c.tied_with.iter().fold(named, |text, r| format!("{text} ~ {}", r.effect))
    };
    let mut parts: Vec<String> = d.causes.iter().map(one).collect();
    parts.extend(d.unknown.as_ref().map(|u| {
        let what = u.covariate.as_deref().unwrap_or("nothing recorded");
        format!("unknown over {}, by {}", place(what, u.leg.map(|leg| leg + 1), None), u.test.word())
    }));
    parts.extend(d.misread.as_ref().map(|m| format!("{}: {}", m.reading, m.detail)));
    parts.extend(d.noise_varies.as_ref().map(|n| format!("noise over {}", n.covariate)));
    if !d.outlier_rows.is_empty() {
        parts.push(format!("outliers {:?}", d.outlier_rows.iter().map(|row| row.0).collect::<Vec<_>>()));
    }
    format!("{}: {}", d.verdict.word(), parts.join("; "))
}
