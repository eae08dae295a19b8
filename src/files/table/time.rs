//! Clock times of measurement files.

use jiff::civil::Date;
use jiff::fmt::strtime::BrokenDownTime;
use jiff::tz::Offset;

/// Seconds of `YYYY-MM-DDTHH:MM:SS[.s][Z|±HH:MM]` since 1970, or of `HH:MM:SS[.s]` since midnight; a blank may
/// stand for the `T`. `None` if it is neither, or no day of the calendar.
pub(crate) fn parse_time(text: &str) -> Option<f64> {
    let text = text.trim();
    let Some((date, clock)) = text.split_once(['T', ' ']) else { return seconds_of_day(text) };
    let date: Date = BrokenDownTime::parse("%Y-%m-%d", date).ok()?.to_date().ok().filter(|d| d.year() >= 0)?;
    let (clock, offset) = split_zone(clock)?;
    let midnight = offset.to_timestamp(date.at(0, 0, 0, 0)).ok()?;
    Some(midnight.as_second() as f64 + seconds_of_day(clock)?)
}

/// True for a time without a date.
pub(crate) fn is_dateless(text: &str) -> bool {
    !text.trim().contains(['T', ' '])
}

/// The clock and how far it is ahead of UTC; without a zone it is taken as UTC.
fn split_zone(clock: &str) -> Option<(&str, Offset)> {
    if let Some(clock) = clock.strip_suffix('Z') {
        return Some((clock, Offset::UTC));
    }
    let Some(at) = clock.rfind(['+', '-']) else { return Some((clock, Offset::UTC)) };
    let (clock, zone) = clock.split_at(at);
    Some((clock, BrokenDownTime::parse("%:z", zone).ok()?.offset()?))
}

/// Seconds since midnight. They are kept as they are written, with any number of digits and with leap seconds.
fn seconds_of_day(clock: &str) -> Option<f64> {
    let (time, seconds) = BrokenDownTime::parse_prefix("%H:%M", clock).ok()?;
    let seconds = match clock.get(seconds..)? {
        "" => 0.0,
        rest => rest.strip_prefix(':')?.parse().ok().filter(|s| (0.0..61.0).contains(s))?,
    };
    Some(f64::from(3600 * i32::from(time.hour()?) + 60 * i32::from(time.minute()?)) + seconds)
}

#[cfg(test)]
mod tests {
    use super::parse_time;

    #[test]
    fn times_are_read() {
        assert_eq!(parse_time("1970-01-02T00:00:01Z"), Some(86_401.0));
        assert_eq!(parse_time("2024-02-29 12:00:00"), Some(1_709_208_000.0));
        assert_eq!(parse_time("2024-03-01T01:00:00.5+01:00"), Some(1_709_251_200.5));
        assert_eq!(parse_time("2024-03-01T00:00:00-05:30"), Some(1_709_271_000.0));
        assert_eq!(parse_time("2016-12-31 23:59:60"), Some(1_483_228_800.0));
        assert_eq!(parse_time("0000-03-01T00:00"), Some(-62_162_035_200.0));
        assert_eq!(parse_time("23:59:59"), Some(86_399.0));
        assert_eq!(parse_time(" 8:05:00.1250000000000 "), Some(29_100.125));
        let far = "9223372036854775807-01-01T00:00:00";
        for bad in ["", "noon", "25:00:00", "2024-13-01T00:00:00", "12", far, "2024-03-01T01:00+4294967295:00"] {
            assert_eq!(parse_time(bad), None, "{bad}");
        }
    }

    #[test]
    fn days_that_no_calendar_has_are_none() {
        for (bad, good) in [("2023-02-29", "2023-02-28"), ("2023-02-30", "2024-02-29"), ("2023-04-31", "2023-04-30")] {
            assert_eq!(parse_time(&format!("{bad}T12:00:00")), None, "{bad}");
            assert!(parse_time(&format!("{good}T12:00:00")).is_some(), "{good}");
        }
        assert_eq!(parse_time("1900-02-29 00:00:00"), None);
        assert!(parse_time("2000-02-29 00:00:00").is_some());
    }
}
