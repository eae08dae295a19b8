//! Unknowns of an effect in addition to its parameters.

/// The values to try. Each place that is tried is paid for in the test (Bonferroni) and in the evidence.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Scan {
    /// Nothing.
    #[default]
    None,
    /// The leg.
    Legs,
    /// The row from which on the effect acts; it is zero before that row and as it is for row 0 from there on.
    Rows,
    /// Leg and row.
    LegsAndRows,
    /// The covariate.
    Covariates(Vec<String>),
}

/// One place in a scan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScanPoint {
    /// Leg, from 0.
    pub leg: Option<usize>,
    /// 0-based data row from which on the effect acts.
    pub row: Option<usize>,
    /// Name of the covariate.
    pub covariate: Option<String>,
    /// Time constant of the first-order lag with which the covariates act, s; `None` if they act at once.
    pub lag: Option<f64>,
}

impl ScanPoint {
    /// The place of an effect that has none.
    pub fn none() -> Self {
        Self::default()
    }

    /// A leg, from 0.
    pub fn leg(leg: usize) -> Self {
        Self { leg: Some(leg), ..Self::default() }
    }
}
