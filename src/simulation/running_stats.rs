//! Statistics of numbers that come one by one.

use serde::{Deserialize, Serialize};

/// Count, mean, spread and extremes, without keeping the numbers.
///
/// The recurrences are those of Welford (Technometrics 4, 1962, 419) for one number and of Chan, Golub and LeVeque (The
/// American Statistician 37, 1983, 242) for two sets; neither subtracts large sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunningStats {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    squares: f64,
    least: f64,
    largest: f64,
}

impl RunningStats {
    /// Statistics of these numbers.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut all = Self::default();
        values.into_iter().for_each(|v| all.push(v));
        all
    }

    /// Adds a number.
    pub fn push(&mut self, value: f64) {
        let first = self.count == 0;
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.squares += deviation * (value - self.mean);
        self.least = if first { value } else { self.least.min(value) };
        self.largest = if first { value } else { self.largest.max(value) };
    }

    /// The statistics of both sets.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        if self.count == 0 || other.count == 0 {
            return if self.count == 0 { *other } else { *self };
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let deviation = other.mean - self.mean;
        Self {
            count: self.count + other.count,
            mean: self.mean + deviation * b / (a + b),
            squares: self.squares + other.squares + deviation * deviation * a * b / (a + b),
            least: self.least.min(other.least),
            largest: self.largest.max(other.largest),
        }
    }

    /// How many numbers there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; 0 if there are none.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Standard deviation of one number (divisor: count − 1); 0 for fewer than two.
    pub fn sd(&self) -> f64 {
        if self.count < 2 { 0.0 } else { (self.squares / (self.count - 1) as f64).max(0.0).sqrt() }
    }

    /// Standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sd() / (self.count as f64).sqrt() }
    }

    /// The smallest number; 0 if there are none.
    pub fn least(&self) -> f64 {
        self.least
    }

    /// The largest number; 0 if there are none.
    pub fn largest(&self) -> f64 {
        self.largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_joined_are_one_set() {
        let values: Vec<f64> = (0..1000).map(|k| 1e6 + f64::from(k * 7919 % 1009)).collect();
        let whole = RunningStats::of(values.iter().copied());
        for cut in [0, 1, 13, 999, 1000] {
            let (a, b) = values.split_at(cut);
            let joined = RunningStats::of(a.iter().copied()).joined(&RunningStats::of(b.iter().copied()));
            assert_eq!((joined.count(), joined.least(), joined.largest()), (1000, whole.least(), whole.largest()));
            assert!((joined.mean() - whole.mean()).abs() < 1e-9, "{cut}");
            assert!((joined.sd() / whole.sd() - 1.0).abs() < 1e-12, "{cut}");
        }
        // Two passes: mean first, then squares.
        let mean = values.iter().sum::<f64>() / 1000.0;
        let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 999.0).sqrt();
        assert!((whole.mean() - mean).abs() < 1e-9 && (whole.sd() / sd - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_and_one_number_have_no_spread() {
        assert_eq!(RunningStats::default().sd(), 0.0);
        let one = RunningStats::of([3.0]);
        assert_eq!((one.mean(), one.sd(), one.standard_error()), (3.0, 0.0, 0.0));
    }
}
