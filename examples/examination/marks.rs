//! Marks: what counts as right, paper by paper.

use paracal::diagnosis::Verdict;

use crate::hidden::cases::{Kind, Truth};
use crate::said::{Answer, Nameless, Said, size};
use crate::table::Rate;

/// A named rate.
pub(crate) type Mark = (String, Rate);

/// One question put to every answer; `None` where it does not apply.
fn rate(answers: &[&Answer], right: impl Fn(&Truth, &Said) -> Option<bool>) -> Rate {
    Rate::of(answers.iter().filter_map(|a| a.said.as_ref().ok().and_then(|said| right(&a.truth, said))))
}

/// The first hidden effect.
fn hidden(truth: &Truth) -> &str {
    truth.effects.first().map_or("", String::as_str)
}

fn alarmed(said: &Said) -> bool {
    said.verdict != Verdict::Clean || said.noise_varies.is_some()
}

pub(crate) fn first_right(truth: &Truth, said: &Said) -> bool {
    said.causes.first().is_some_and(|cause| cause.effect == hidden(truth))
}

/// Named alone, nothing tied, nothing unknown.
fn unique_right(truth: &Truth, said: &Said) -> bool {
    said.verdict == Verdict::Named && said.causes.len() == 1 && first_right(truth, said)
}

fn confidently_wrong(truth: &Truth, said: &Said) -> bool {
    said.verdict == Verdict::Named && truth.effects.iter().all(|effect| said.cause(effect).is_none())
}

/// Whether the size that was found for the first effect is within 15 % of the true one.
fn size_right(truth: &Truth, said: &Said) -> Option<bool> {
    let found = size(hidden(truth), &said.cause(hidden(truth))?.values)?;
    let hidden = size(hidden(truth), truth.parameters.first()?)?;
    Some((found / hidden - 1.0).abs() <= 0.15)
}

fn leg_right(truth: &Truth, said: &Said) -> Option<bool> {
    let leg = truth.legs.first().copied().flatten()?;
    Some(said.cause(hidden(truth))?.leg == Some(leg))
}

fn row_right(truth: &Truth, said: &Said) -> Option<bool> {
    let row = truth.rows.first().copied().flatten()?;
    Some(said.cause(hidden(truth))?.row.is_some_and(|found| found.abs_diff(row) <= 1))
}

/// The marks for one hidden effect.
pub(crate) fn one(answers: &[&Answer]) -> Vec<Mark> {
    vec![
        ("right name first".into(), rate(answers, |t, s| Some(first_right(t, s)))),
        ("right and unique".into(), rate(answers, |t, s| Some(unique_right(t, s)))),
        ("truth in the tie set".into(), rate(answers, |t, s| Some(s.mentions(hidden(t))))),
        ("confident wrong".into(), rate(answers, |t, s| Some(confidently_wrong(t, s)))),
        ("missed".into(), rate(answers, |_, s| Some(s.verdict == Verdict::Clean))),
        ("more causes than one".into(), rate(answers, |_, s| Some(s.causes.len() > 1))),
        ("called unknown".into(), rate(answers, |_, s| Some(s.verdict == Verdict::Unknown))),
        ("called misread".into(), rate(answers, |_, s| Some(s.verdict == Verdict::Misread))),
        ("noise said to vary".into(), rate(answers, |_, s| Some(s.noise_varies.is_some()))),
        ("size within 15 %, if named".into(), rate(answers, size_right)),
        ("leg right, if named".into(), rate(answers, leg_right)),
        ("row within one, if named".into(), rate(answers, row_right)),
        ("held-out after <= 1.10 x floor".into(), rate(answers, |_, s| Some(s.after_over_floor? <= 1.10))),
    ]
}

fn outliers(answers: &[&Answer]) -> Vec<Mark> {
    let all = |rows: &dyn Fn(&Truth, &Said) -> Vec<bool>| {
        Rate::of(answers.iter().flat_map(|a| a.said.as_ref().map(|said| rows(&a.truth, said)).unwrap_or_default()))
    };
    let found = all(&|t, s| t.outlier_rows.iter().map(|row| s.outlier_rows.contains(row)).collect());
    let flagged = all(&|t, s| {
        (0..crate::hidden::cases::ROWS)
            .filter(|row| !t.outlier_rows.contains(row))
            .map(|row| s.outlier_rows.contains(&row))
            .collect()
    });
    vec![("gross rows found".into(), found), ("good rows flagged".into(), flagged)]
}

fn null(answers: &[&Answer]) -> Vec<Mark> {
    let mut marks = vec![
        ("false alarm of any kind".into(), rate(answers, |_, s| Some(alarmed(s)))),
        ("  a name".into(), rate(answers, |_, s| Some(!s.causes.is_empty()))),
        ("  unknown".into(), rate(answers, |_, s| Some(s.unknown.is_some()))),
        ("  misread".into(), rate(answers, |_, s| Some(s.reading.is_some()))),
        ("  noise varies".into(), rate(answers, |_, s| Some(s.noise_varies.is_some()))),
    ];
    marks.extend(outliers(answers));
    marks
}

fn two(answers: &[&Answer]) -> Vec<Mark> {
    let count = |t: &Truth, s: &Said| t.effects.iter().filter(|effect| s.cause(effect).is_some()).count();
    let mentioned = |t: &Truth, s: &Said| t.effects.iter().filter(|effect| s.mentions(effect)).count();
    let family = |name: &str| match name {
        "sag.frame" | "compliance.gravity" => "gravity".to_owned(),
        "thermal.leg.single" | "thermal.legs.uniform" | "thermal.legs.individual" => "thermal.legs".to_owned(),
        _ => name.split('.').next().unwrap_or(name).to_owned(),
    };
    // Nested effects and twins share a family.
    let apart = |t: &Truth| {
        let [first, second] = [family(&t.effects[0]), family(&t.effects[1])];
        first != second || first == "thermal"
    };
    vec![
        ("both named".into(), rate(answers, |t, s| Some(count(t, s) == 2))),
        ("both named, no relatives".into(), rate(answers, |t, s| apart(t).then(|| count(t, s) == 2))),
        ("exactly the pair".into(), rate(answers, |t, s| Some(count(t, s) == 2 && s.causes.len() == 2))),
        ("both named or tied".into(), rate(answers, |t, s| Some(mentioned(t, s) == 2))),
        ("one at least".into(), rate(answers, |t, s| Some(count(t, s) >= 1))),
        ("confident wrong".into(), rate(answers, |t, s| Some(confidently_wrong(t, s)))),
        ("called unknown".into(), rate(answers, |_, s| Some(s.verdict == Verdict::Unknown))),
        ("called misread".into(), rate(answers, |_, s| Some(s.verdict == Verdict::Misread))),
    ]
}

/// Whether one of the accepted words was said.
fn among(accepted: &[String], said: Option<&str>) -> bool {
    said.is_some_and(|said| accepted.iter().any(|word| word == said))
}

/// Whether a place was said for a stranger that is right, or none for one that has none.
fn place_right(truth: &Truth, place: &Nameless) -> bool {
    let (covariate, coordinate) = (place.covariate.as_deref(), place.coordinate);
    let leg = truth.legs.first().copied().flatten();
    let nowhere = covariate.is_none() && coordinate.is_none() && place.leg.is_none();
    let has_none = truth.covariates.is_empty() && truth.coordinates.is_empty();
    among(&truth.covariates, covariate)
        || among(&truth.coordinates, coordinate)
        || (leg.is_some() && place.leg == leg)
        || (nowhere && has_none)
}

/// Whether a covariate was said for a stranger that has others.
fn strayed(truth: &Truth, said: &Said) -> bool {
    let covariate = said.unknown.as_ref().and_then(|place| place.covariate.as_deref());
    covariate.is_some() && !truth.covariates.is_empty() && !among(&truth.covariates, covariate)
}

/// Whether a leg or a coordinate was said that is not the stranger's.
fn misplaced(truth: &Truth, said: &Said) -> bool {
    said.unknown.as_ref().is_some_and(|place| {
        let leg = truth.legs.first().copied().flatten();
        (place.leg.is_some() && place.leg != leg)
            || (place.coordinate.is_some() && !among(&truth.coordinates, place.coordinate))
    })
}

/// Whether a name was said, or tied, that is physically right for a stranger.
fn also_right(truth: &Truth, said: &Said) -> bool {
    truth.also.iter().any(|effect| said.mentions(effect))
}

/// Whether a stranger was said to be unknown at a place of its own, or got a name that is right as well.
fn honest(truth: &Truth, said: &Said) -> bool {
    match said.verdict {
        Verdict::Unknown => also_right(truth, said) || said.unknown.as_ref().is_some_and(|u| place_right(truth, u)),
        Verdict::Named | Verdict::Tied => also_right(truth, said),
        Verdict::Clean | Verdict::Undecided | Verdict::Misread => false,
    }
}

/// The marks for an effect outside the catalogue. The first six exclude each other and are all that can be; the
/// others are of answers that say unknown.
pub(crate) fn outside(answers: &[&Answer]) -> Vec<Mark> {
    let verdict = |wanted: Verdict| rate(answers, move |_, s| Some(s.verdict == wanted));
    let elsewhere = |t: &Truth, s: &Said| Some(s.verdict == Verdict::Unknown && !honest(t, s));
    let false_name = |t: &Truth, s: &Said| Some(matches!(s.verdict, Verdict::Named | Verdict::Tied) && !honest(t, s));
    let covariate = |t: &Truth, s: &Said| {
        let said = s.unknown.as_ref().filter(|_| !t.covariates.is_empty())?;
        Some(among(&t.covariates, said.covariate.as_deref()))
    };
    let leg = |t: &Truth, s: &Said| {
        let (leg, said) = (t.legs.first().copied().flatten()?, s.unknown.as_ref()?);
        Some(said.leg == Some(leg))
    };
    let coordinate = |t: &Truth, s: &Said| {
        let said = s.unknown.as_ref().filter(|_| !t.coordinates.is_empty())?;
        Some(among(&t.coordinates, said.coordinate))
    };
    vec![
        ("honest".into(), rate(answers, |t, s| Some(honest(t, s)))),
        ("unknown, elsewhere".into(), rate(answers, elsewhere)),
        ("false name, not flagged".into(), rate(answers, false_name)),
        ("missed".into(), verdict(Verdict::Clean)),
        ("undecided".into(), verdict(Verdict::Undecided)),
        ("called misread".into(), verdict(Verdict::Misread)),
        ("covariate right, if unknown".into(), rate(answers, covariate)),
        ("leg right, if unknown".into(), rate(answers, leg)),
        ("coordinate right, if unknown".into(), rate(answers, coordinate)),
        ("wrong place, if unknown".into(), rate(answers, |t, s| s.unknown.as_ref().map(|_| misplaced(t, s)))),
    ]
}

/// The marks for files that are read wrongly.
pub(crate) fn misread(answers: &[&Answer]) -> Vec<Mark> {
    vec![
        ("called misread".into(), rate(answers, |_, s| Some(s.verdict == Verdict::Misread))),
        ("reading right".into(), rate(answers, |t, s| Some(reading_right(t, s)))),
    ]
}

fn reading_right(truth: &Truth, said: &Said) -> bool {
    truth.reading.as_ref() == said.reading.as_ref().map(|(reading, _)| reading)
}

fn noise(answers: &[&Answer]) -> Vec<Mark> {
    let right = |t: &Truth, s: &Said| s.noise_varies.as_ref().is_some_and(|c| t.covariates.contains(c));
    vec![
        ("noise said to vary".into(), rate(answers, |_, s| Some(s.noise_varies.is_some()))),
        ("covariate right".into(), rate(answers, |t, s| Some(right(t, s)))),
        ("false name".into(), rate(answers, |_, s| Some(!s.causes.is_empty()))),
        ("false unknown".into(), rate(answers, |_, s| Some(s.unknown.is_some()))),
    ]
}

/// The marks of a paper.
pub(crate) fn marks(kind: Kind, answers: &[&Answer]) -> Vec<Mark> {
    match kind {
        Kind::One(_) | Kind::WarmUp(_) | Kind::Instrument(_) => one(answers),
        Kind::OneWithOutliers(_) => [one(answers), outliers(answers)].concat(),
        Kind::Two(_) | Kind::Three(_) => two(answers),
        Kind::Null | Kind::Outliers(_) => null(answers),
        Kind::Outside(_) => outside(answers),
        Kind::Misread => misread(answers),
        Kind::Noise(_) => noise(answers),
    }
}

/// Whether an answer is worth a line in the list of mistakes.
pub(crate) fn wrong(kind: Kind, answer: &Answer) -> bool {
    let Ok(said) = &answer.said else { return true };
    let truth = &answer.truth;
    match kind {
        Kind::One(_) | Kind::OneWithOutliers(_) | Kind::WarmUp(_) | Kind::Instrument(_) => {
            !first_right(truth, said)
                || said.causes.len() > 1
                || matches!(said.verdict, Verdict::Unknown | Verdict::Misread)
                || size_right(truth, said) == Some(false)
                || leg_right(truth, said) == Some(false)
        }
        Kind::Two(_) | Kind::Three(_) => {
            truth.effects.iter().any(|effect| said.cause(effect).is_none()) || said.causes.len() > 2
        }
        Kind::Null | Kind::Outliers(_) => alarmed(said) || said.outlier_rows != truth.outlier_rows,
        Kind::Outside(_) => !honest(truth, said) || strayed(truth, said) || misplaced(truth, said),
        Kind::Misread => !reading_right(truth, said),
        Kind::Noise(_) => {
            let right = said.noise_varies.as_ref().is_some_and(|c| truth.covariates.contains(c));
            !right || said.verdict != Verdict::Clean
        }
    }
}

/// A word for a kind, in names of folders.
pub(crate) fn word(kind: Kind) -> String {
    format!("{kind:?}").replace(['(', ')', '.'], "-").to_lowercase()
}
