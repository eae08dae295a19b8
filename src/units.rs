//! Units at the edges: the library computes in SI (m, rad, s, kg), files name their units.
//!
//! Temperatures are kept in °C, because effects act on differences and people read °C.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Physical dimension of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dimension {
    /// Metres inside.
    Length,
    /// Radians inside.
    Angle,
    /// Seconds inside.
    Time,
    /// Degrees Celsius inside.
    Temperature,
    /// Kilograms inside.
    Mass,
    /// Newtons inside.
    Force,
    /// Expansion per kelvin.
    PerKelvin,
    /// Length per kelvin.
    LengthPerKelvin,
    /// Angle per kelvin.
    AnglePerKelvin,
    /// Curvature: one over a length.
    PerLength,
    /// One over an angle.
    PerAngle,
    /// Metres per newton.
    Compliance,
    /// Length per angle.
    LengthPerAngle,
    /// A plain number.
    None,
}

impl Dimension {
    /// The unit used inside the library, as it is printed.
    pub fn si(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Angle => "rad",
            Self::Time => "s",
            Self::Temperature => "degC",
            Self::Mass => "kg",
            Self::Force => "N",
            Self::PerKelvin => "1/K",
            Self::LengthPerKelvin => "m/K",
            Self::AnglePerKelvin => "rad/K",
            Self::PerLength => "1/m",
            Self::PerAngle => "1/rad",
            Self::Compliance => "m/N",
            Self::LengthPerAngle => "m/rad",
            Self::None => "1",
        }
    }

    /// Noun for joints of this dimension: lengths, angles, or coordinates.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Length => "lengths",
            Self::Angle => "angles",
            _ => "coordinates",
        }
    }

    /// The unit of tables for people, and how many of it make one SI unit: mm and deg, otherwise SI.
    pub fn in_tables(self) -> (&'static str, f64) {
        match self {
            Self::Length => ("mm", 1e3),
            Self::Angle => ("deg", 180.0 / std::f64::consts::PI),
            _ => (self.si(), 1.0),
        }
    }

    /// The accepted units, for messages: `m | mm | um | in`.
    pub fn choices(self) -> String {
        UNITS.iter().filter(|u| u.dimension == self).map(|u| u.name).collect::<Vec<_>>().join(" | ")
    }
}

/// A unit by name, with its factor to SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// The name in files: `mm`, `deg`, …
    pub name: &'static str,
    /// Dimension that the unit measures.
    pub dimension: Dimension,
    /// SI value of one unit.
    pub factor: f64,
    /// SI value of zero (kelvin only).
    pub offset: f64,
}

const fn unit(name: &'static str, dimension: Dimension, factor: f64) -> Unit {
    Unit { name, dimension, factor, offset: 0.0 }
}

const UNITS: &[Unit] = &[
    unit("m", Dimension::Length, 1.0),
    unit("mm", Dimension::Length, 1e-3),
    unit("um", Dimension::Length, 1e-6),
    unit("in", Dimension::Length, 0.0254),
    unit("rad", Dimension::Angle, 1.0),
    unit("mrad", Dimension::Angle, 1e-3),
    unit("deg", Dimension::Angle, std::f64::consts::PI / 180.0),
    unit("arcsec", Dimension::Angle, std::f64::consts::PI / 648_000.0),
    unit("s", Dimension::Time, 1.0),
    unit("min", Dimension::Time, 60.0),
    unit("h", Dimension::Time, 3600.0),
    unit("degC", Dimension::Temperature, 1.0),
    Unit { name: "K", dimension: Dimension::Temperature, factor: 1.0, offset: -273.15 },
    unit("kg", Dimension::Mass, 1.0),
    unit("g", Dimension::Mass, 1e-3),
    unit("N", Dimension::Force, 1.0),
];

/// A unit or quantity that cannot be read.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum UnitError {
    /// The name is not a unit of the expected dimension.
    #[error("unknown unit '{found}'; use {choices}")]
    Unknown {
        /// Text that was found.
        found: String,
        /// The accepted names.
        choices: String,
    },
    /// A quantity such as `2um` has no number or no unit.
    #[error("'{found}' is not a quantity; write a number and a unit, such as {example}")]
    Quantity {
        /// Text that was found.
        found: String,
        /// How it should look.
        example: &'static str,
    },
}

impl Unit {
    /// The unit of that name, of any dimension.
    pub fn named(name: &str) -> Option<Self> {
        UNITS.iter().copied().find(|u| u.name == name)
    }

    /// The unit of that name and dimension.
    ///
    /// # Errors
    /// [`UnitError::Unknown`] with the accepted names.
    pub fn of(dimension: Dimension, name: &str) -> Result<Self, UnitError> {
        Self::named(name)
            .filter(|u| u.dimension == dimension)
            .ok_or_else(|| UnitError::Unknown { found: name.into(), choices: dimension.choices() })
    }

    /// The SI unit of a dimension.
    pub fn si(dimension: Dimension) -> Self {
        unit(dimension.si(), dimension, 1.0)
    }

    /// SI value of `value` in this unit.
    pub fn to_si(self, value: f64) -> f64 {
        value * self.factor + self.offset
    }

    /// The value in this unit of an SI value.
    pub fn from_si(self, value: f64) -> f64 {
        (value - self.offset) / self.factor
    }
}

/// Reads a quantity such as `2um` or `0.5 arcsec` into SI.
///
/// # Errors
/// [`UnitError`] if the number or the unit cannot be read, or the unit measures something else.
pub fn parse_quantity(text: &str, dimension: Dimension) -> Result<f64, UnitError> {
    let example = match dimension {
        Dimension::Angle => "0.5arcsec",
        Dimension::Mass => "50kg",
        Dimension::Temperature => "20degC",
        Dimension::Time => "5s",
        Dimension::Force => "10N",
        _ => "2um",
    };
    let bad = || UnitError::Quantity { found: text.into(), example };
    let text = text.trim();
    // The unit is the trailing run of letters; an exponent's `e` is always followed by a digit or a sign.
    let split = text.trim_end_matches(|c: char| c.is_ascii_alphabetic()).len();
    let (number, name) = text.split_at(split);
    let value: f64 = number.trim().parse().map_err(|_| bad())?;
    if name.is_empty() || !value.is_finite() {
        return Err(bad());
    }
    Ok(Unit::of(dimension, name)?.to_si(value))
}

/// A probability as `= 0.038` or, where it is too small to mean anything, `< 1e-300`.
pub fn show_probability(p: f64) -> String {
    if p < 1e-300 { "< 1e-300".into() } else { format!("= {}", three_digits(p)) }
}

/// A length as people read it: `1.25 mm`, `0.83 um`.
pub fn show_length(metres: f64) -> String {
    let size = metres.abs();
    if size > 0.0 && size < 1e-12 {
        return "< 0.001 nm".into();
    }
    let (factor, name) = match size {
        s if s >= 1.0 => (1.0, "m"),
        s if s >= 1e-4 => (1e3, "mm"),
        s if s >= 1e-8 || s == 0.0 => (1e6, "um"),
        _ => (1e9, "nm"),
    };
    format!("{} {name}", three_digits(metres * factor))
}

/// An angle as people read it: `1.25 deg`, `0.36 arcsec`.
pub fn show_angle(radians: f64) -> String {
    let degrees = radians.to_degrees();
    if degrees.abs() >= 0.01 {
        format!("{} deg", three_digits(degrees))
    } else if degrees != 0.0 && degrees.abs() < 1e-10 {
        "< 1e-6 arcsec".into()
    } else {
        format!("{} arcsec", three_digits(degrees * 3600.0))
    }
}

/// A quantity as people read it: [`show_length`], [`show_angle`], `0.171 ppm/K`, `0.581 nm/N`, `49.9 ppm`, or the number
/// with its SI unit.
pub fn show_quantity(value: f64, dimension: Dimension) -> String {
    match dimension {
        Dimension::Length => show_length(value),
        Dimension::Angle => show_angle(value),
        Dimension::None => show_part(value, ""),
        Dimension::PerKelvin => show_part(value, "/K"),
        Dimension::PerAngle => show_part(value, "/rad"),
        Dimension::AnglePerKelvin => format!("{}/K", show_angle(value)),
        Dimension::LengthPerKelvin => show_lengths_per(value, "K"),
        Dimension::LengthPerAngle => show_lengths_per(value, "rad"),
        Dimension::Compliance => show_lengths_per(value, "N"),
        // The same number as in 1/m: a deviation over the square of a travel.
        Dimension::PerLength => format!("{} um/mm2", three_digits(value)),
        _ => format!("{} {}", three_digits(value), dimension.si()),
    }
}

/// A part of a whole, in parts per million below a hundredth; `per` follows the unit.
fn show_part(value: f64, per: &str) -> String {
    if value != 0.0 && value.abs() < 1e-2 {
        return format!("{} ppm{per}", three_digits(1e6 * value));
    }
    let unit = if per.is_empty() { String::new() } else { format!(" 1{per}") };
    format!("{}{unit}", three_digits(value))
}

/// A length for each of something else, in the largest unit that leaves a digit before the point; nanometres at least.
fn show_lengths_per(value: f64, of: &str) -> String {
    const UNITS: [(f64, &str); 4] = [(1.0, "m"), (1e3, "mm"), (1e6, "um"), (1e9, "nm")];
    let fits = |u: &&(f64, &str)| value == 0.0 || (value * u.0).abs() >= 1.0;
    let (factor, unit) = UNITS.iter().find(fits).unwrap_or(&UNITS[3]);
    format!("{} {unit}/{of}", three_digits(value * factor))
}

/// A number with that many decimals, and no minus before zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| matches!(b, b'0' | b'.')) => rest.to_owned(),
        _ => text,
    }
}

/// A number with three significant digits and no exponent where it can be avoided.
pub fn three_digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if !(1e-4..1e6).contains(&size) {
        format!("{value:.2e}")
    } else {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    }
}

/// A list that fits a line: the first eight, and how many more.
pub fn shortened(items: &[String]) -> String {
    const SHOWN: usize = 8;
    let more = items.len().saturating_sub(SHOWN);
    let shown = items[..items.len().min(SHOWN)].join(", ");
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

/// Data rows in words: `data row 3`, or `data rows 3, 5, 7 and 12 more`.
pub fn data_rows(rows: &[usize]) -> String {
    const SHOWN: usize = 3;
    let noun = if rows.len() == 1 { "data row" } else { "data rows" };
    // One more is as short as to say so.
    let count = if rows.len() <= SHOWN + 1 { rows.len() } else { SHOWN };
    let shown: Vec<String> = rows[..count].iter().map(usize::to_string).collect();
    match (rows.len() - count, shown.split_last()) {
        (0, Some((last, before))) if !before.is_empty() => format!("{noun} {} and {last}", before.join(", ")),
        (0, _) => format!("{noun} {}", shown.join(", ")),
        (more, _) => format!("{noun} {} and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_named_in_short() {
        assert_eq!(data_rows(&[3]), "data row 3");
        assert_eq!(data_rows(&[3, 8]), "data rows 3 and 8");
        assert_eq!(data_rows(&[3, 5, 7, 8]), "data rows 3, 5, 7 and 8");
        assert_eq!(data_rows(&[3, 5, 7, 8, 9]), "data rows 3, 5, 7 and 2 more");
    }

    #[test]
    fn quantities_are_read_with_their_unit() {
        assert_eq!(parse_quantity("2um", Dimension::Length), Ok(2e-6));
        assert_eq!(parse_quantity(" -1.5e-3 m", Dimension::Length), Ok(-1.5e-3));
        assert!((parse_quantity("1arcsec", Dimension::Angle).unwrap() - 4.848_136_811e-6).abs() < 1e-14);
        assert!((parse_quantity("293.15K", Dimension::Temperature).unwrap() - 20.0).abs() < 1e-12);
        for bad in ["", "um", "2", "2 furlong", "2deg", "NaNmm", "1e3", "1µm", "µ"] {
            assert!(parse_quantity(bad, Dimension::Length).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_are_shown_in_a_unit_that_fits() {
        assert_eq!(show_length(0.000_000_83), "0.830 um");
        assert_eq!(show_length(0.0125), "12.5 mm");
        assert_eq!((fixed(-1e-9, 3), fixed(-0.25, 1)), ("0.000".into(), "-0.2".into()));
        assert_eq!(show_angle(1e-4_f64.to_radians()), "0.360 arcsec");
    }

    #[test]
    fn coefficients_are_shown_as_their_data_sheets_state_them() {
        let shown = [
            (1.71e-7, Dimension::PerKelvin, "0.171 ppm/K"),
            (-1.17e-5, Dimension::PerKelvin, "-11.7 ppm/K"),
            (0.25, Dimension::PerKelvin, "0.250 1/K"),
            (0.0, Dimension::PerKelvin, "0 1/K"),
            (4.99e-5, Dimension::None, "49.9 ppm"),
            (0.5, Dimension::None, "0.500"),
            (0.0, Dimension::None, "0"),
            (5.81e-10, Dimension::Compliance, "0.581 nm/N"),
            (-1.2e-8, Dimension::Compliance, "-12.0 nm/N"),
            (3.5e-6, Dimension::LengthPerKelvin, "3.50 um/K"),
            (0.0, Dimension::LengthPerKelvin, "0 m/K"),
            (8.6e-4, Dimension::LengthPerAngle, "860 um/rad"),
            (1e-4_f64.to_radians(), Dimension::AnglePerKelvin, "0.360 arcsec/K"),
            (0.0098, Dimension::PerLength, "0.00980 um/mm2"),
            (-3.4e-5, Dimension::PerAngle, "-34.0 ppm/rad"),
        ];
        for (value, dimension, text) in shown {
            assert_eq!(show_quantity(value, dimension), text);
        }
    }
}
