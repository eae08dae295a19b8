//! Rates with their intervals, and tables of them.

/// How often something was so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rate {
    pub(crate) hits: usize,
    pub(crate) of: usize,
}

impl Rate {
    pub(crate) fn of(cases: impl IntoIterator<Item = bool>) -> Self {
        let mut rate = Self::default();
        for hit in cases {
            rate.hits += usize::from(hit);
            rate.of += 1;
        }
        rate
    }

    /// Wilson's 95 % interval: sensible also at 0 and at n of n.
    pub(crate) fn interval(&self) -> (f64, f64) {
        const Z: f64 = 1.959_963_984_540_054;
        let n = self.of as f64;
        let p = self.hits as f64 / n;
        let spread = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        let (centre, shrink) = (p + Z * Z / (2.0 * n), 1.0 + Z * Z / n);
        ((centre - spread) / shrink, (centre + spread) / shrink)
    }

    /// `97.5 % (91.3 to 99.3)  78 of 80`
    pub(crate) fn text(&self) -> String {
        if self.of == 0 {
            return "     -".to_owned();
        }
        let (low, high) = self.interval();
        let share = 100.0 * self.hits as f64 / self.of as f64;
        let (low, high) = (100.0 * low.max(0.0), 100.0 * high.min(1.0));
        format!("{share:5.1} %  ({low:4.1} to {high:5.1})  {} of {}", self.hits, self.of)
    }

    /// `78/80`
    pub(crate) fn short(&self) -> String {
        if self.of == 0 { "-".to_owned() } else { format!("{}/{}", self.hits, self.of) }
    }
}

/// A table of short cells with a head, columns as wide as they need.
pub(crate) fn print(head: &[String], lines: &[Vec<String>]) {
    let width = |k: usize| {
        lines
            .iter()
            .chain([&head.to_vec()])
            .filter_map(|l| l.get(k))
            .map(|cell| cell.chars().count())
            .max()
            .unwrap_or(0)
    };
    for line in [head.to_vec()].iter().chain(lines) {
        let cells = line.iter().enumerate().map(|(k, cell)| {
            let pad = " ".repeat(width(k) - cell.chars().count());
            if k == 0 { format!("{cell}{pad}") } else { format!("{pad}{cell}") }
        });
        println!("    {}", cells.collect::<Vec<_>>().join("  "));
    }
}
