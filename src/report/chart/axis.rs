//! Ranges and ticks of an axis.

use super::number::{exponent, fixed, superscript, ten};
use super::{Axis, Scale};

/// A labelled tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub text: String,
}

/// The range of the data along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    log: bool,
    range: Option<(f64, f64)>,
}

impl Extent {
    pub(super) fn new(axis: &Axis) -> Self {
        let mut extent = Self { log: is_log(axis), range: None };
        axis.besides.iter().flat_map(|(a, b)| [*a, *b]).for_each(|v| extent.add(v));
        extent
    }

    /// Widens the range by a part of it to both sides.
    pub(super) fn pad(&mut self, part: f64) {
        if let Some((lo, hi)) = self.range.filter(|_| !self.log) {
            self.range = Some((lo - part * (hi - lo), hi + part * (hi - lo)));
        }
    }

    /// Takes in a value, if it can be drawn.
    pub(super) fn add(&mut self, v: f64) {
        if let Some(v) = usable(v, self.log) {
            self.range = Some(self.range.map_or((v, v), |(lo, hi)| (lo.min(v), hi.max(v))));
        }
    }

    /// Takes in the foot of a bar of height v: zero, or half the height on a log axis.
    pub(super) fn add_foot(&mut self, v: f64) {
        self.add(if self.log { v / 2.0 } else { 0.0 });
    }

    /// Whether a value can be drawn on this axis.
    pub(super) fn takes(&self, v: f64) -> bool {
        usable(v, self.log).is_some()
    }
}

/// An axis fitted to its data.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct View {
    pub lo: f64,
    pub hi: f64,
    pub log: bool,
    pub named: bool,
    pub ticks: Vec<Tick>,
    pub minor: Vec<f64>,
    /// The label, with a common factor of the tick labels.
    pub label: String,
}

impl View {
    /// Fits an axis to the data, with about `most` ticks at the most.
    pub(super) fn fit(axis: &Axis, extent: &Extent, most: usize) -> Self {
        let log = is_log(axis);
        let fixed_range = axis.range.and_then(|(a, b)| {
            let (a, b) = (usable(a, log)?, usable(b, log)?);
            let (lo, hi) = (a.min(b), a.max(b));
            (!is_constant(lo, hi)).then_some((lo, hi))
        });
        let mut view = Self {
            lo: 0.0,
            hi: 1.0,
            log,
            named: !axis.names.is_empty(),
            ticks: Vec::new(),
            minor: Vec::new(),
            label: axis.label.clone(),
        };
        if view.named {
            let auto = (-0.5, axis.names.len() as f64 - 0.5);
            (view.lo, view.hi) = fixed_range.unwrap_or(auto);
            let names = axis.names.iter().enumerate().map(|(i, name)| Tick { at: i as f64, text: name.clone() });
            view.ticks = names.filter(|t| (view.lo..=view.hi).contains(&t.at)).collect();
        } else if log {
            view.fit_log(fixed_range, extent.range, most.max(2));
        } else {
            view.fit_linear(fixed_range, extent.range, most.max(2));
        }
        view
    }

    fn fit_linear(&mut self, fixed_range: Option<(f64, f64)>, data: Option<(f64, f64)>, most: usize) {
        let (mut lo, mut hi) = fixed_range.or(data).unwrap_or((0.0, 1.0));
        if is_constant(lo, hi) {
            let margin = if lo == 0.0 { 1.0 } else { lo.abs() * 0.1 };
            (lo, hi) = (lo - margin, hi + margin);
        }
        let (step, e) = nice_step((hi - lo) / most as f64);
        if fixed_range.is_none() {
            lo = (lo / step + 1e-9).floor() * step;
            hi = (hi / step - 1e-9).ceil() * step;
        }
        (self.lo, self.hi) = (lo, hi);
        self.set_linear(&multiples(lo, hi, step), e);
    }

    fn fit_log(&mut self, fixed_range: Option<(f64, f64)>, data: Option<(f64, f64)>, most: usize) {
        let (mut lo, mut hi) = fixed_range.or(data).unwrap_or((1.0, 10.0));
        if is_constant(lo, hi) {
            (lo, hi) = (lo / 2.0, hi * 2.0);
        }
        if fixed_range.is_none() {
            (lo, hi) = (round_125(lo, false), round_125(hi, true));
            if hi <= lo * 1.001 {
                hi = lo * 2.0;
            }
        }
        (self.lo, self.hi) = (lo, hi);
        let decades = hi.log10() - lo.log10();
        let (first, last) = (exponent(lo), exponent(hi));
        let inside = |v: f64| v >= lo * (1.0 - 1e-9) && v <= hi * (1.0 + 1e-9);
        let step = [1, 2, 3, 5, 10, 20, 50, 100, 200].into_iter().find(|k| decades / f64::from(*k) <= most as f64);
        let step = step.unwrap_or(500);
        let whole: Vec<i32> = (first..=last).filter(|e| e % step == 0 && inside(ten(*e))).collect();
        let grid = |factors: &[f64]| -> Vec<(f64, i32)> {
            let all = (first..=last).flat_map(|e| factors.iter().map(move |f| (*f, e)));
            all.filter(|(f, e)| inside(f * ten(*e))).collect()
        };
        let digits = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        if decades <= 60.0 {
            // Between labelled decades their multiples, between sparser labels the decades.
            let minor = if step == 1 { grid(&digits) } else { grid(&[1.0]) };
            self.minor = minor.into_iter().map(|(f, e)| f * ten(e)).collect();
        }
        let few = grid(&[1.0, 2.0, 5.0]);
        // Two or three decades alone say little; their halves fit in between, if there is room.
        let sparse = whole.len() < 4 && few.len() <= 2 * most;
        if decades >= 1.5 && whole.len() >= 2 && !sparse {
            let plain = lo >= 0.0099 && hi <= 10_100.0;
            let label = |e: i32| if plain { plain_number(1.0, e) } else { power(1.0, e) };
            self.ticks = whole.into_iter().map(|e| Tick { at: ten(e), text: label(e) }).collect();
            return;
        }
        let plain = lo >= 0.00099 && hi <= 101_000.0;
        let chosen = if few.len() < 3 { grid(&digits) } else { few };
        let label = |f: f64, e: i32| if plain { plain_number(f, e) } else { power(f, e) };
        self.ticks = chosen.into_iter().map(|(f, e)| Tick { at: f * ten(e), text: label(f, e) }).collect();
        if self.ticks.len() < 3 {
            // A narrow range between two or three of these: the ticks of a linear axis.
            let (step, e) = nice_step((hi - lo) / most.min(5) as f64);
            self.minor.clear();
            self.set_linear(&multiples(lo, hi, step), e);
        }
    }

    /// Sets linear ticks whose last digit has the exponent e, and adds their common factor to the label.
    fn set_linear(&mut self, ticks: &[f64], e: i32) {
        let (ticks, factor) = label_linear(ticks, e);
        self.ticks = ticks;
        if factor != 0 {
            let blank = if self.label.is_empty() { "" } else { " " };
            self.label.push_str(&format!("{blank}×10{}", superscript(factor)));
        }
    }

    /// The place of a value along the axis: 0 at the lower end, 1 at the upper end.
    pub(super) fn place(&self, v: f64) -> f64 {
        let at = if self.log {
            if v <= 0.0 {
                return 0.0;
            }
            (v.log10() - self.lo.log10()) / (self.hi.log10() - self.lo.log10())
        } else {
            (v - self.lo) / (self.hi - self.lo)
        };
        if at.is_finite() { at.clamp(-50.0, 50.0) } else { 0.0 }
    }

    /// Whether a value can be drawn on this axis (inside the range or not).
    pub(super) fn draws(&self, v: f64) -> bool {
        usable(v, self.log).is_some()
    }

    /// Whether a value can be drawn and lies in the range.
    pub(super) fn contains(&self, v: f64) -> bool {
        self.draws(v) && (-1e-6..=1.0 + 1e-6).contains(&self.place(v))
    }
}

fn is_log(axis: &Axis) -> bool {
    axis.scale == Scale::Log && axis.names.is_empty()
}

/// The value, if it can be drawn: finite, not beyond 1e300, on a log axis positive.
fn usable(v: f64, log: bool) -> Option<f64> {
    if !v.is_finite() || v.abs() > 1e300 {
        None
    } else if v.abs() < 1e-290 {
        (!log).then_some(0.0)
    } else {
        (!log || v > 0.0).then_some(v)
    }
}

/// Whether two ends are the same but for rounding.
fn is_constant(lo: f64, hi: f64) -> bool {
    hi - lo <= 1e-12 * lo.abs().max(hi.abs())
}

/// The smallest of 1, 2, 5 × 10^k that is not below the given step, and the exponent of its last digit.
pub(super) fn nice_step(raw: f64) -> (f64, i32) {
    let e = exponent(raw);
    let f = raw / ten(e);
    for nice in [1.0, 2.0, 5.0] {
        if f <= nice * (1.0 + 1e-9) {
            return (nice * ten(e), e);
        }
    }
    (ten(e + 1), e + 1)
}

/// The multiples of the step in a range.
pub(super) fn multiples(lo: f64, hi: f64, step: f64) -> Vec<f64> {
    let first = (lo / step - 1e-6).ceil();
    let count = ((hi / step + 1e-6).floor() - first).clamp(-1.0, 200.0);
    (0..(count + 1.0) as usize).map(|i| (first + i as f64) * step).collect()
}

/// Labels of linear ticks whose last digit has the given exponent, and the exponent of their common factor.
pub(super) fn label_linear(ticks: &[f64], last: i32) -> (Vec<Tick>, i32) {
    let largest = ticks.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
    let mut factor = 0;
    if largest > 0.0 && !(1e-2..1e5).contains(&largest) {
        factor = exponent(largest);
        if factor > 0 && factor <= 9 && factor - last > 5 {
            factor = 0;
        }
    }
    let decimals = (factor - last).clamp(0, 15) as usize;
    let text = |t: f64| fixed(t / ten(factor), decimals);
    (ticks.iter().map(|t| Tick { at: *t, text: text(*t) }).collect(), factor)
}

/// The next of 1, 2, 5 × 10^k above or below.
fn round_125(v: f64, up: bool) -> f64 {
    let e = exponent(v);
    let f = v / ten(e);
    if up {
        [1.0, 2.0, 5.0].into_iter().find(|n| f <= n * (1.0 + 1e-12)).unwrap_or(10.0) * ten(e)
    } else {
        [5.0, 2.0].into_iter().find(|n| f >= n * (1.0 - 1e-12)).unwrap_or(1.0) * ten(e)
    }
}

fn plain_number(f: f64, e: i32) -> String {
    fixed(f * ten(e), (-e).max(0) as usize)
}

fn power(f: f64, e: i32) -> String {
    match (f as i32, e) {
        (1, 0) => "1".to_owned(),
        (1, e) => format!("10{}", superscript(e)),
        (f, 0) => format!("{f}"),
        (f, e) => format!("{f}×10{}", superscript(e)),
    }
}
