//! Units of axes that fit the sizes on them.

/// The unit of an axis, and how many of it make one in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::report::html) struct AxisUnit {
    pub(in crate::report::html) name: &'static str,
    pub(in crate::report::html) per_si: f64,
}

impl AxisUnit {
    /// Millimetres.
    pub(in crate::report::html) const MILLIMETRES: Self = Self { name: "mm", per_si: 1e3 };

    /// For lengths in m.
    pub(in crate::report::html) fn of_lengths(values: impl IntoIterator<Item = f64>) -> Self {
        let (name, per_si) = match largest(values) {
            size if size < 1e-7 && size > 0.0 => ("nm", 1e9),
            size if size < 2e-3 => ("µm", 1e6),
            size if size < 2.0 => ("mm", 1e3),
            _ => ("m", 1.0),
        };
        Self { name, per_si }
    }

    /// For angles in rad.
    pub(in crate::report::html) fn of_angles(values: impl IntoIterator<Item = f64>) -> Self {
        let degrees = largest(values).to_degrees();
        match degrees < 0.2 {
            true => Self { name: "″", per_si: 3600.0 * 180.0 / std::f64::consts::PI },
            false => Self { name: "°", per_si: 180.0 / std::f64::consts::PI },
        }
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).filter(|v| v.is_finite()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::AxisUnit;

    #[test]
    fn sizes_have_units_in_which_numbers_are_short() {
        for (metres, name) in [(3e-9, "nm"), (9e-6, "µm"), (0.0, "µm"), (0.5e-3, "µm"), (0.04, "mm"), (4.2, "m")] {
            assert_eq!(AxisUnit::of_lengths([metres, -metres, f64::NAN]).name, name);
        }
        assert_eq!(AxisUnit::of_angles([1e-5]).name, "″");
        assert_eq!(AxisUnit::of_angles([1.3]).name, "°");
    }
}
