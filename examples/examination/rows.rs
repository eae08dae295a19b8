//! The papers of the examination: what is drawn, and how often.

use crate::hidden::cases::Kind;

/// A kind of question, asked many times.
pub(crate) struct Paper {
    /// For `--only`.
    pub(crate) key: &'static str,
    pub(crate) title: &'static str,
    pub(crate) kind: Kind,
    /// Only on request.
    pub(crate) extra: bool,
}

const fn paper(key: &'static str, title: &'static str, kind: Kind, extra: bool) -> Paper {
    Paper { key, title, kind, extra }
}

pub(crate) const PAPERS: [Paper; 16] = [
    paper("one", "one effect, 3 x its detection limit", Kind::One(3.0), false),
    paper("tenfold", "one effect, 10 x its detection limit", Kind::One(10.0), false),
    paper("one-outliers", "one effect, 3 x its limit, with 5 % outliers", Kind::OneWithOutliers(3.0), false),
    paper("two", "two effects, each 3 x its detection limit", Kind::Two(3.0), false),
    paper("null", "no effect", Kind::Null, false),
    paper("outliers", "no effect, 5 % outliers of 8 to 60 sigma", Kind::Outliers(0.05), false),
    paper("outside", "an effect outside the catalogue, 3 x the limit of four parameters", Kind::Outside(3.0), false),
    paper("outside-6x", "an effect outside the catalogue, 6 x the limit of four parameters", Kind::Outside(6.0), false),
    paper(
        "instrument",
        "a frame that follows a temperature, or wrong readings, 6 x the limit",
        Kind::Instrument(6.0),
        false,
    ),
    paper("warm-up", "time and temperatures rise together, 3 x the limit", Kind::WarmUp(3.0), false),
    paper("misread", "a file that is read wrongly", Kind::Misread, false),
    paper("noise", "no effect, sigma grows by a factor 3", Kind::Noise(3.0), false),
    paper("one-1x", "one effect at its detection limit", Kind::One(1.0), true),
    paper("one-2x", "one effect, 2 x its detection limit", Kind::One(2.0), true),
    paper("one-30x", "one effect, 30 x its detection limit", Kind::One(30.0), true),
    paper("one-100x", "one effect, 100 x its detection limit", Kind::One(100.0), true),
];
