//! One case through the public interface: two files in, what was said out.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use paracal::diagnosis::{COORDINATES, Diagnosis, Question, Unknown, Verdict, diagnose};
use paracal::files::{Machine, read_measurement};

use crate::hidden::cases::{Case, Truth};
use crate::hidden::effects::named;

/// A cause that was named.
pub(crate) struct Named {
    pub(crate) effect: String,
    /// From 1.
    pub(crate) leg: Option<usize>,
    pub(crate) row: Option<usize>,
    pub(crate) values: Vec<f64>,
    pub(crate) tied_with: Vec<String>,
    pub(crate) evidence: f64,
}

/// What was said about something that no name explains.
pub(crate) struct Nameless {
    pub(crate) covariate: Option<String>,
    /// From 1.
    pub(crate) leg: Option<usize>,
    pub(crate) coordinate: Option<&'static str>,
    /// Which test found it, and the names that it made withdraw.
    detail: String,
}

/// What was said about a case, as far as it is scored.
pub(crate) struct Said {
    pub(crate) verdict: Verdict,
    pub(crate) causes: Vec<Named>,
    pub(crate) unknown: Option<Nameless>,
    pub(crate) reading: Option<(String, String)>,
    pub(crate) outlier_rows: Vec<usize>,
    pub(crate) noise_varies: Option<String>,
    /// Held-out position error after, over the noise floor.
    pub(crate) after_over_floor: Option<f64>,
}

/// A case that was answered, or was not.
pub(crate) struct Answer {
    pub(crate) truth: Truth,
    pub(crate) said: Result<Said, String>,
    pub(crate) seconds: f64,
}

/// Writes the two texts, reads them as a user's files and asks.
pub(crate) fn ask(case: Case, folder: &Path, noise_known: bool) -> Answer {
    let started = Instant::now();
    let said = answer(&case, folder, noise_known).map_err(|e| e.to_string());
    Answer { truth: case.truth, said, seconds: started.elapsed().as_secs_f64() }
}

fn answer(case: &Case, folder: &Path, noise_known: bool) -> Result<Said, Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let (mechanism, data) = (folder.join("mechanism.toml"), folder.join("data.csv"));
    std::fs::write(&mechanism, &case.mechanism)?;
    std::fs::write(&data, &case.data)?;
    let machine = Machine::read(&mechanism)?;
    let measurement = read_measurement(&data, &machine)?;
    let mut question = Question::of(&machine, &measurement.data);
    question.noise_known = noise_known;
    let diagnosis = diagnose(&question)?;
    Ok(Said::of(&diagnosis))
}

impl Nameless {
    fn of(unknown: &Unknown) -> Self {
        let test = format!("by {} p {:.0e}", unknown.test.word(), unknown.p_value);
        let withdrawn = unknown.withdrawn.join(" nor ");
        Self {
            covariate: unknown.covariate.clone(),
            leg: unknown.leg.map(|leg| leg + 1),
            coordinate: unknown.coordinate.and_then(|k| COORDINATES.get(k).copied()),
            detail: if withdrawn.is_empty() { test } else { format!("{test}, not {withdrawn}") },
        }
    }

    fn text(&self) -> String {
        let covariate = self.covariate.as_deref().unwrap_or("nothing");
        let leg = self.leg.map_or(String::new(), |leg| format!(" leg {leg}"));
        let coordinate = self.coordinate.map_or(String::new(), |coordinate| format!(" in {coordinate}"));
        format!("unknown over {covariate}{leg}{coordinate} {}", self.detail)
    }
}

impl Said {
    fn of(diagnosis: &Diagnosis) -> Self {
        let causes = diagnosis.causes.iter().map(|cause| Named {
            effect: cause.effect.clone(),
            leg: cause.leg.map(|leg| leg + 1),
            row: cause.row,
            values: cause.parameters.iter().map(|p| p.value).collect(),
            tied_with: cause.tied_with.iter().map(|rival| rival.effect.clone()).collect(),
            evidence: cause.evidence,
        });
        let gain = &diagnosis.gain;
        Self {
            verdict: diagnosis.verdict,
            causes: causes.collect(),
            unknown: diagnosis.unknown.as_ref().map(Nameless::of),
            reading: diagnosis.misread.as_ref().map(|m| (m.reading.clone(), m.detail.clone())),
            outlier_rows: diagnosis.outlier_rows.iter().map(|row| row.0).collect(),
            noise_varies: diagnosis.noise_varies.as_ref().map(|n| n.covariate.clone()),
            after_over_floor: gain.position_after.zip(gain.noise_floor_position).map(|(after, floor)| after / floor),
        }
    }

    /// The cause of this name.
    pub(crate) fn cause(&self, effect: &str) -> Option<&Named> {
        self.causes.iter().find(|cause| cause.effect == effect)
    }

    /// Whether an effect is named, or tied with one that is.
    pub(crate) fn mentions(&self, effect: &str) -> bool {
        self.causes.iter().any(|c| c.effect == effect || c.tied_with.iter().any(|name| name == effect))
    }

    /// Compactly, for a list.
    pub(crate) fn text(&self) -> String {
        let place = |leg: Option<usize>| leg.map_or(String::new(), |leg| format!(" leg {leg}"));
        let cause = |c: &Named| {
            let row = c.row.map_or(String::new(), |row| format!(" row {row}"));
            let ties = if c.tied_with.is_empty() { String::new() } else { format!(" ~ {}", c.tied_with.join(" ~ ")) };
            format!("{}{}{row} ({:.1}){ties}", c.effect, place(c.leg), c.evidence)
        };
        let mut parts: Vec<String> = self.causes.iter().map(cause).collect();
        parts.extend(self.unknown.iter().map(Nameless::text));
        parts.extend(self.reading.iter().map(|(reading, detail)| format!("misread {reading} {detail}")));
        parts.extend(self.noise_varies.iter().map(|covariate| format!("noise over {covariate}")));
        if !self.outlier_rows.is_empty() {
            parts.push(format!("{} outliers", self.outlier_rows.len()));
        }
        format!("{:?}: {}", self.verdict, if parts.is_empty() { "nothing".to_owned() } else { parts.join("; ") })
    }
}

/// Norm of an effect's parameters, each in its usual size.
pub(crate) fn size(effect: &str, values: &[f64]) -> Option<f64> {
    let scale = named(effect)?.scale;
    (scale.len() == values.len()).then(|| values.iter().zip(scale).map(|(v, s)| (v / s).powi(2)).sum::<f64>().sqrt())
}

/// What was hidden, compactly.
pub(crate) fn hidden_text(truth: &Truth) -> String {
    let place = |k: usize| {
        let leg = truth.legs.get(k).copied().flatten().map_or(String::new(), |leg| format!(" leg {leg}"));
        let row = truth.rows.get(k).copied().flatten().map_or(String::new(), |row| format!(" row {row}"));
        format!("{leg}{row}")
    };
    let mut parts: Vec<String> = truth.effects.iter().enumerate().map(|(k, e)| format!("{e}{}", place(k))).collect();
    if truth.effects.is_empty() && !truth.detail.is_empty() {
        let reading = truth.reading.as_ref().map_or(String::new(), |reading| format!("{reading} "));
        parts.push(format!("{reading}{}{}", truth.detail, place(0)));
    }
    if !truth.covariates.is_empty() {
        parts.push(format!("[{}]", truth.covariates.join(" or ")));
    }
    if !truth.coordinates.is_empty() {
        parts.push(format!("in {}", truth.coordinates.join(" or ")));
    }
    if !truth.also.is_empty() {
        parts.push(format!("also {}", truth.also.join(" or ")));
    }
    if !truth.outlier_rows.is_empty() {
        parts.push(format!("{} outliers", truth.outlier_rows.len()));
    }
    if parts.is_empty() { "nothing".to_owned() } else { parts.join(" + ") }
}
