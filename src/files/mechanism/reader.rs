//! Numbers of one file, read into SI; what is wrong with them is said with the place.

use std::path::Path;

use nalgebra::Vector3;

use crate::files::error::FileError;
use crate::files::mechanism::document::MechanismDocument;
use crate::files::mechanism::sections::ToleranceSection;
use crate::files::mechanism::units::FileUnits;
use crate::mechanism::GeometryError;
use crate::units::{Dimension, Unit};

/// Largest number of a file, far beyond any machine in any unit: products of several of them must not overflow.
pub(crate) const MOST: f64 = 1e30;

/// Reads numbers of one file into SI and names what is wrong with them.
pub(crate) struct Reader<'a> {
    pub(crate) path: &'a Path,
    pub(crate) units: FileUnits,
}

impl<'a> Reader<'a> {
    /// A reader in the units of a document.
    pub(crate) fn of(path: &'a Path, document: &MechanismDocument) -> Result<Self, FileError> {
        let unit = |dimension, name: &str, place| {
            Unit::of(dimension, name).map_err(|cause| FileError::Unit { path: path.into(), place, cause })
        };
        let length = unit(Dimension::Length, &document.length_unit, "length_unit")?;
        let angle = unit(Dimension::Angle, &document.angle_unit, "angle_unit")?;
        Ok(Self { path, units: FileUnits { length, angle } })
    }
}

impl Reader<'_> {
    pub(crate) fn value(&self, place: impl Into<String>, problem: impl Into<String>) -> FileError {
        FileError::Value { path: self.path.into(), place: place.into(), problem: problem.into() }
    }

    pub(crate) fn geometry(&self, cause: GeometryError) -> FileError {
        FileError::Geometry { path: self.path.into(), cause }
    }

    pub(crate) fn finite(&self, place: &str, v: f64) -> Result<f64, FileError> {
        match v {
            _ if !v.is_finite() => Err(self.value(place, format!("{v} is not a finite number; write a number"))),
            _ if v.abs() > MOST => {
                Err(self.value(place, format!("{v:e} is beyond {MOST:e}; correct the number or its unit")))
            }
            _ => Ok(v),
        }
    }

    pub(crate) fn not_negative(&self, place: &str, v: f64) -> Result<f64, FileError> {
        self.finite(place, v)?;
        if v < 0.0 { Err(self.value(place, format!("must not be negative, found {v}"))) } else { Ok(v) }
    }

    pub(crate) fn positive(&self, place: &str, v: f64) -> Result<f64, FileError> {
        self.finite(place, v)?;
        if v <= 0.0 { Err(self.value(place, format!("must be positive, found {v}"))) } else { Ok(v) }
    }

    /// A number of a section that may be left out.
    pub(crate) fn known(&self, place: &str, v: f64) -> Result<f64, FileError> {
        self.finite(place, v)?;
        match v {
            _ if v <= 0.0 => {
                let problem = format!("must be positive, found {v}; leave the section out if it is not known");
                Err(self.value(place, problem))
            }
            // Its reciprocal is a weight.
            _ if v < 1.0 / MOST => {
                let least = 1.0 / MOST;
                let problem = format!("{v:e} is below {least:e}; correct the number, or leave the section out");
                Err(self.value(place, problem))
            }
            _ => Ok(v),
        }
    }

    pub(crate) fn point(&self, place: &str, p: &[f64; 3]) -> Result<Vector3<f64>, FileError> {
        for v in p {
            self.finite(place, *v)?;
        }
        Ok(Vector3::from_column_slice(p).map(|v| self.units.length.to_si(v)))
    }

    /// Tolerance of an anchor and of a length; that of an anchor where none is stated.
    pub(crate) fn tolerance(&self, t: &ToleranceSection) -> Result<(f64, f64), FileError> {
        let anchor = self.units.length.to_si(self.known("[tolerance] anchor", t.anchor)?);
        let length = t.length.map(|v| self.known("[tolerance] length", v)).transpose()?;
        Ok((anchor, length.map_or(anchor, |v| self.units.length.to_si(v))))
    }

    pub(crate) fn six(&self, place: &str, position: &[f64; 3], rotation: &[f64; 3]) -> Result<[f64; 6], FileError> {
        let p = self.point(place, position)?;
        for v in rotation {
            self.finite(place, *v)?;
        }
        let r = rotation.map(|v| self.units.angle.to_si(v));
        Ok([p.x, p.y, p.z, r[0], r[1], r[2]])
    }
}
