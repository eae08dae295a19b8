//! The entries of a list of a file, each number with its place.

use nalgebra::Vector3;

use crate::files::error::FileError;
use crate::files::mechanism::reader::Reader;
use crate::files::mechanism::sections::LegEntry;
use crate::units::Dimension;

/// One entry of a list of a file.
pub(super) struct Row<'a> {
    pub(super) r: &'a Reader<'a>,
    pub(super) section: &'static str,
    /// From 1.
    pub(super) row: usize,
}

/// Reads every leg.
pub(super) fn each<T>(
    r: &Reader<'_>,
    legs: &[LegEntry],
    read: impl Fn(&Row<'_>, &LegEntry) -> Result<T, FileError>,
) -> Result<Vec<T>, FileError> {
    legs.iter().enumerate().map(|(i, l)| read(&Row { r, section: "leg", row: i + 1 }, l)).collect()
}

impl Row<'_> {
    pub(super) fn place(&self, key: &str) -> String {
        format!("{} {}, `{key}`", self.section, self.row)
    }

    pub(super) fn finite(&self, key: &str, v: f64) -> Result<f64, FileError> {
        self.r.finite(&self.place(key), v)
    }

    pub(super) fn point(&self, key: &str, p: &[f64; 3]) -> Result<Vector3<f64>, FileError> {
        self.r.point(&self.place(key), p)
    }

    /// A length that must be stated.
    pub(super) fn positive(&self, key: &str, v: Option<f64>) -> Result<f64, FileError> {
        Ok(self.r.units.length.to_si(self.r.positive(&self.place(key), v.unwrap_or(f64::NAN))?))
    }

    /// A direction that must be stated; it has no unit.
    pub(super) fn direction(&self, key: &str, v: Option<[f64; 3]>) -> Result<Vector3<f64>, FileError> {
        let v = v.unwrap_or([0.0; 3]);
        v.iter().try_for_each(|x| self.finite(key, *x).map(drop))?;
        if v == [0.0; 3] {
            return Err(self.r.value(self.place(key), "[0, 0, 0] is not a direction; write a vector of any length"));
        }
        Ok(v.into())
    }

    /// A number from 1 to `most` that must be stated; the same from 0.
    pub(super) fn number(&self, key: &str, v: Option<usize>, most: usize) -> Result<usize, FileError> {
        let stated = v.unwrap_or(0);
        if (1..=most).contains(&stated) {
            return Ok(stated - 1);
        }
        let words = if most == 3 { "1, 2 or 3".to_owned() } else { format!("a number from 1 to {most}") };
        Err(self.r.value(self.place(key), format!("{stated} is not {words}")))
    }

    pub(super) fn stroke(&self, stroke: Option<[f64; 2]>, dimension: Dimension) -> Result<Option<[f64; 2]>, FileError> {
        let Some([from, to]) = stroke else { return Ok(None) };
        if !(from < to && from.is_finite() && to.is_finite()) {
            return Err(self
                .r
                .value(self.place("stroke"), format!("[{from}, {to}] is not an interval; write [from, to]")));
        }
        let unit = self.r.units.of(dimension);
        Ok(Some([unit.to_si(from), unit.to_si(to)]))
    }
}
