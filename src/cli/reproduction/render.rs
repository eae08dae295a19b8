//! An exhibit as text, as JSON, and all of them as one page.

use maud::{Markup, PreEscaped, html};
use serde_json::{Value, json};

use super::{Agreement, Comparison, Exhibit, Settings};
use crate::report::html::shell;
use crate::report::text::table;

/// A number of a table, four digits.
fn shown(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
        format!("{value:.*}", (3 - digits).clamp(0, 6) as usize)
    } else {
        format!("{value:.3e}")
    }
}

fn interval(c: &Comparison) -> String {
    if c.ours.low == c.ours.high { String::new() } else { format!("{} to {}", shown(c.ours.low), shown(c.ours.high)) }
}

fn cells(c: &Comparison) -> [String; 5] {
    let printed = c.paper.map(shown).or_else(|| c.claim.map(|_| "claim".into())).unwrap_or_default();
    let verdict = match (c.claim, c.verdict) {
        (Some(_), Some(v)) => if v == Agreement::Reproduced { "holds" } else { "does not hold" }.into(),
        (_, v) => v.map(|v| v.to_string()).unwrap_or_default(),
    };
    [printed, shown(c.ours.mean), interval(c), c.unit.to_owned(), verdict]
}

/// Columns of a text.
const WIDTH: usize = 100;

/// A paragraph in lines.
fn wrapped(paragraph: &str) -> String {
    let mut text = String::new();
    let mut column = 0;
    for word in paragraph.split_whitespace() {
        let long = word.chars().count();
        if column > 0 && column + 1 + long > WIDTH {
            text.push('\n');
            column = 0;
        } else if column > 0 {
            text.push(' ');
            column += 1;
        }
        text += word;
        column += long;
    }
    text + "\n"
}

const HEADER: [&str; 6] = ["quantity", "paper", "ours", "95 %", "unit", "verdict"];

impl Settings {
    /// Settings needed to repeat a run, in words.
    pub fn text(&self) -> String {
        let Self { draws, candidates, lists, seed } = self;
        format!("{draws} noise draws, {candidates} candidates, {lists} lists of candidates, seed {seed}")
    }
}

impl Exhibit {
    /// How many numbers of the paper have this verdict.
    pub fn count(&self, verdict: Agreement) -> usize {
        self.comparisons.iter().filter(|c| c.paper.is_some() && c.verdict == Some(verdict)).count()
    }

    /// How many statements of the paper are judged, and how many of them hold.
    pub fn claims(&self) -> (usize, usize) {
        let claims = || self.comparisons.iter().filter(|c| c.claim.is_some());
        (claims().count(), claims().filter(|c| c.verdict == Some(Agreement::Reproduced)).count())
    }

    /// The verdicts in one sentence.
    pub fn summary(&self) -> String {
        let [held, drawn, not] =
            [Agreement::Reproduced, Agreement::WithinOneDraw, Agreement::NotReproduced].map(|v| self.count(v));
        let (claims, hold) = self.claims();
        let numbers = (held + drawn + not > 0).then(|| {
            let all = held + drawn + not;
            format!("Of {all} numbers of the paper {held} are reproduced, {drawn} lie within one draw, {not} are not reproduced.")
        });
        let claims = (claims > 0).then(|| format!("Of {claims} statements of the paper {hold} hold."));
        let said: Vec<String> = numbers.into_iter().chain(claims).collect();
        if said.is_empty() { "The paper prints no number for it that could be judged.".into() } else { said.join(" ") }
    }

    /// The exhibit for a terminal: numbers, remarks, findings; the last line is the result.
    pub fn text(&self, settings: &Settings) -> String {
        let rows: Vec<Vec<String>> =
            self.comparisons.iter().map(|c| std::iter::once(c.quantity.clone()).chain(cells(c)).collect()).collect();
        let mut text = format!(
            "{}: {}\n{}\n(95 %: of single draws; of the mean, where means or ratios of means are compared)\n\n{}",
            self.name,
            self.title,
            settings.text(),
            table(&HEADER, &rows)
        );
        let mut remarks: Vec<(&str, Vec<&str>)> = Vec::new();
        for c in self.comparisons.iter().filter(|c| c.claim.is_some()) {
            text += &wrapped(&format!("\"{}\" is judged by: {}.", c.claim.unwrap_or_default(), c.quantity));
        }
        for c in self.comparisons.iter().filter(|c| !c.why.is_empty()) {
            match remarks.iter_mut().find(|(why, _)| *why == c.why) {
                Some((_, of)) => of.push(&c.quantity),
                None => remarks.push((&c.why, vec![&c.quantity])),
            }
        }
        if !remarks.is_empty() {
            text.push('\n');
        }
        for (why, of) in remarks {
            let of = if of.len() > 3 { format!("{} and {} more", of[0], of.len() - 1) } else { of.join("; ") };
            text += &wrapped(&format!("{of}: {why}."));
        }
        for finding in &self.findings {
            text += &format!("\n{}", wrapped(finding));
        }
        text + &format!("\n{}\n", self.summary())
    }

    /// The exhibit as a JSON object.
    pub fn json(&self) -> Value {
        let comparison = |c: &Comparison| {
            json!({
                "quantity": c.quantity, "unit": c.unit, "paper": c.paper, "ours": c.ours.mean,
                "standard_error": c.ours.error, "low": c.ours.low, "high": c.ours.high,
                "verdict": c.verdict.map(|v| v.to_string()), "claim": c.claim, "why": c.why,
            })
        };
        json!({
            "name": self.name, "title": self.title, "findings": self.findings, "summary": self.summary(),
            "comparisons": self.comparisons.iter().map(comparison).collect::<Vec<Value>>(),
        })
    }

    fn section(&self) -> Markup {
        let row = |c: &Comparison| {
            let class = match c.verdict {
                Some(Agreement::Reproduced) => "held",
                Some(Agreement::WithinOneDraw) => "drawn",
                Some(Agreement::NotReproduced) => "not",
                None => "",
            };
            html! {
                tr {
                    th scope="row" {
                        (c.quantity)
                        @if let Some(claim) = c.claim { small { "“" (claim) "”" } }
                        @if !c.why.is_empty() { small { (c.why) } }
                    }
                    @for (k, cell) in cells(c).iter().enumerate() {
                        td class=(if k == 4 { format!("number {class}") } else { "number".to_owned() }) { (cell) }
                    }
                }
            }
        };
        html! {
            section id=(self.name) {
                h2 { (self.name) ": " (self.title) }
                p { strong { (self.summary()) } }
                figure { (PreEscaped(self.figure.html_with_id(&format!("{}-picture", self.name)))) }
                @for finding in &self.findings { p { (finding) } }
                div.wide { table {
                    thead { tr { @for h in HEADER { th scope="col" { (h) } } } }
                    tbody { @for c in &self.comparisons { (row(c)) } }
                } }
            }
        }
    }
}

/// All exhibits on one page: HTML without scripts and without anything from elsewhere.
pub fn page(exhibits: &[Exhibit], settings: &Settings) -> String {
    let count = |v: Agreement| exhibits.iter().map(|e| e.count(v)).sum::<usize>();
    let [held, drawn, not] = [Agreement::Reproduced, Agreement::WithinOneDraw, Agreement::NotReproduced].map(count);
    let claims = exhibits.iter().map(Exhibit::claims).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let body = html! {
        h1 { "Kinematic calibration of six hardpoints: the paper reproduced" }
        p {
            "Yu, Wu, Wang, “Kinematic Calibration Method for Six-Hardpoint Positioning Mechanisms Using Optimal \
             Measurement Pose”, Appl. Sci. 13 (2023) 4824. The paper prints single draws of a simulation; here each \
             number stands among many draws."
        }
        @if exhibits.len() > 1 {
            p { strong {
                "Of " (held + drawn + not) " numbers " (held) " are reproduced, " (drawn) " lie within one draw, " (not)
                " are not reproduced. Of " (claims.0) " statements " (claims.1) " hold."
            } }
            nav { ul { @for e in exhibits {
                li { a href=(format!("#{}", e.name)) { (e.name) } " " (e.title) ". " (e.summary()) }
            } } }
        }
        @for e in exhibits { (e.section()) }
        p { small { "paracal " (env!("CARGO_PKG_VERSION")) "; " (settings.text()) "." } }
    };
    shell("Yu, Wu, Wang 2023, reproduced", &body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::reproduction::Spread;

    #[test]
    fn numbers_have_four_digits() {
        for (value, text) in
            [(0.0347, "0.03470"), (219.0, "219.0"), (2.459e-4, "2.459e-4"), (0.0, "0.000"), (-1.5, "-1.500")]
        {
            assert_eq!(shown(value), text);
        }
        let c = Comparison::ours("a", "mm", Spread::exactly(1.0));
        assert_eq!(interval(&c), "");
    }
}
