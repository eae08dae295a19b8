//! Clock times of measurement files.

/// Seconds of `YYYY-MM-DDTHH:MM:SS[.s][Z|±HH:MM]` since 1970, or of `HH:MM:SS[.s]` since midnight; a blank may
/// stand for the `T`. `None` if it is neither.
pub(crate) fn parse_time(text: &str) -> Option<f64> {
    let text = text.trim();
    let Some((date, clock)) = text.split_once(['T', ' ']) else { return seconds_of_day(text) };
    let mut parts = date.split('-');
    let (y, m, d) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
    if parts.next().is_some() || !(0..10_000).contains(&y) || !(1..=12).contains(&m) || !(1..=31).contains(&d) {
        return None;
    }
    let (clock, offset) = split_zone(clock)?;
    Some(days_since_1970(y, m, d) as f64 * 86_400.0 + seconds_of_day(clock)? - offset)
}

/// True for a time without a date.
pub(crate) fn is_dateless(text: &str) -> bool {
    !text.trim().contains(['T', ' '])
}

fn split_zone(clock: &str) -> Option<(&str, f64)> {
    if let Some(clock) = clock.strip_suffix('Z') {
        return Some((clock, 0.0));
    }
    let Some(at) = clock.rfind(['+', '-']) else { return Some((clock, 0.0)) };
    let (clock, zone) = clock.split_at(at);
    let sign = if zone.starts_with('-') { -1.0 } else { 1.0 };
    let (h, m) = zone[1..].split_once(':')?;
    let (h, m): (u32, u32) = (h.parse().ok()?, m.parse().ok()?);
    (h < 24 && m < 60).then(|| (clock, sign * 60.0 * f64::from(60 * h + m)))
}

fn seconds_of_day(clock: &str) -> Option<f64> {
    let mut parts = clock.split(':');
    let (h, m): (u32, u32) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
    let s: f64 = parts.next().unwrap_or("0").parse().ok()?;
    let valid = h < 24 && m < 60 && (0.0..61.0).contains(&s) && parts.next().is_none();
    valid.then(|| f64::from(h * 3600 + m * 60) + s)
}

/// Days from 1970-01-01 in the Gregorian calendar; years are counted from March, so that a leap day ends one.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let y = if month <= 2 { year - 1 } else { year };
    let shifted = (month + 9) % 12;
    let leap_days = y.div_euclid(4) - y.div_euclid(100) + y.div_euclid(400);
    365 * y + leap_days + (153 * shifted + 2) / 5 + day - 1 - 719_468
}

#[cfg(test)]
mod tests {
    use super::parse_time;

    #[test]
    fn times_are_read() {
        assert_eq!(parse_time("1970-01-02T00:00:01Z"), Some(86_401.0));
        assert_eq!(parse_time("2024-02-29 12:00:00"), Some(1_709_208_000.0));
        assert_eq!(parse_time("2024-03-01T01:00:00.5+01:00"), Some(1_709_251_200.5));
        assert_eq!(parse_time("23:59:59"), Some(86_399.0));
        let far = "9223372036854775807-01-01T00:00:00";
        for bad in ["", "noon", "25:00:00", "2024-13-01T00:00:00", "12", far, "2024-03-01T01:00+4294967295:00"] {
            assert_eq!(parse_time(bad), None, "{bad}");
        }
    }
}
