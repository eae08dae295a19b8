//! Factors by which numbers are wrong whose unit is another one than stated.

use std::f64::consts::PI;

/// What numbers must be multiplied by, and of which units that is the ratio.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct UnitFactor {
    pub(crate) factor: f64,
    /// The unit that was meant.
    meant: &'static str,
    /// The unit that is stated.
    stated: &'static str,
}

const LENGTHS: [(&str, f64); 6] =
    [("mm", 1e-3), ("m", 1.0), ("in", 25.4e-3), ("cm", 1e-2), ("um", 1e-6), ("ft", 304.8e-3)];
const ANGLES: [(&str, f64); 6] = [
    ("deg", PI / 180.0),
    ("rad", 1.0),
    ("arcsec", PI / 180.0 / 3600.0),
    ("mrad", 1e-3),
    ("arcmin", PI / 180.0 / 60.0),
    ("grad", PI / 200.0),
];
/// Factors that differ by less are one.
const SAME: f64 = 1e-6;

impl UnitFactor {
    /// All ratios of two units of length.
    pub(crate) fn lengths() -> Vec<Self> {
        ratios(&LENGTHS)
    }

    /// All ratios of two units of angles.
    pub(crate) fn angles() -> Vec<Self> {
        ratios(&ANGLES)
    }

    /// `m where mm is stated, or larger by the same factor`.
    pub(crate) fn text(&self) -> String {
        let way = if self.factor > 1.0 { "larger" } else { "smaller" };
        format!("{} where {} is stated, or {way} by the same factor", self.meant, self.stated)
    }

    /// The same of the file that the numbers are compared with: it is in the unit that is stated here.
    pub(crate) fn text_of_other(&self) -> String {
        let way = if self.factor > 1.0 { "smaller" } else { "larger" };
        format!("{} where {} is stated, or {way} by the same factor", self.stated, self.meant)
    }
}

fn ratios(units: &[(&'static str, f64)]) -> Vec<UnitFactor> {
    let mut all: Vec<UnitFactor> = Vec::new();
    for (stated, b) in units {
        for (meant, a) in units {
            let factor = a / b;
            let near = |f: f64| (f - factor).abs() < SAME * factor;
            if !near(1.0) && !all.iter().any(|u| near(u.factor)) {
                all.push(UnitFactor { factor, meant, stated });
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ratio_is_there_once() {
        for all in [UnitFactor::lengths(), UnitFactor::angles()] {
            for one in &all {
                assert_eq!(all.iter().filter(|u| (u.factor / one.factor - 1.0).abs() < 1e-9).count(), 1);
                assert!(all.iter().any(|u| (u.factor * one.factor - 1.0).abs() < 1e-9));
            }
        }
        let degrees = UnitFactor::angles().into_iter().find(|u| (u.factor - PI / 180.0).abs() < 1e-12).unwrap();
        assert_eq!(degrees.text(), "deg where rad is stated, or smaller by the same factor");
    }
}
