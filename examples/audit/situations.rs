//! The situations that are audited.

/// What is wrong, or out of the ordinary, beside tolerances and noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    Nothing,
    /// One coordinate of all points of one body has the wrong sign in the drawing.
    Signs,
    /// Joints count from elsewhere than the drawing says.
    Zeros,
    /// The noise is not stated.
    NoiseUnknown,
    /// So many rows are grossly wrong, and whether the user has been told to use the robust identifier.
    Gross {
        rows: usize,
        robust: bool,
    },
    /// The machine works near a singularity.
    Singular,
    /// The noise has heavy tails.
    Student,
    /// An effect of the catalogue acts, and the model has it.
    Extended,
}

/// A situation.
#[derive(Debug)]
pub(crate) struct Situation {
    pub(crate) key: &'static str,
    pub(crate) title: &'static str,
    pub(crate) flaw: Flaw,
    /// Stated tolerance over the true spread.
    pub(crate) tolerance: f64,
    /// True noise over the stated one.
    pub(crate) noise: f64,
}

impl Situation {
    const fn new(key: &'static str, title: &'static str, flaw: Flaw) -> Self {
        Self { key, title, flaw, tolerance: 1.0, noise: 1.0 }
    }

    const fn tolerance(key: &'static str, title: &'static str, tolerance: f64) -> Self {
        Self { tolerance, ..Self::new(key, title, Flaw::Nothing) }
    }

    const fn noise(key: &'static str, title: &'static str, noise: f64) -> Self {
        Self { noise, ..Self::new(key, title, Flaw::Nothing) }
    }

    const fn gross(key: &'static str, title: &'static str, rows: usize, robust: bool) -> Self {
        Self::new(key, title, Flaw::Gross { rows, robust })
    }

    /// True if the model holds something false, so that a refusal is right whatever the data decide. Tolerances and
    /// zeros of joints are not held against the data, and gross rows are left to the robust identifier.
    pub(crate) fn is_false(&self) -> bool {
        self.noise > 1.0 || matches!(self.flaw, Flaw::Signs | Flaw::Gross { robust: false, .. })
    }
}

pub(crate) const SITUATIONS: [Situation; 16] = [
    Situation::new("well", "all is well", Flaw::Nothing),
    Situation::tolerance("tolerance-0.1", "the stated tolerance is a tenth of the true spread", 0.1),
    Situation::tolerance("tolerance-0.01", "the stated tolerance is a hundredth of the true spread", 0.01),
    Situation::tolerance("tolerance-10", "the stated tolerance is ten times the true spread", 10.0),
    Situation::new("signs", "one coordinate of all points of a body has the wrong sign in the drawing", Flaw::Signs),
    Situation::new("zeros", "the joints count from elsewhere", Flaw::Zeros),
    Situation::noise("noise-0.5", "the true noise is half of what is stated", 0.5),
    Situation::noise("noise-2", "the true noise is twice what is stated", 2.0),
    Situation::new("no-noise", "no noise is stated", Flaw::NoiseUnknown),
    Situation::gross("gross-1", "one row is grossly wrong, robust identifier", 1, true),
    Situation::gross("gross-3", "three rows are grossly wrong, robust identifier", 3, true),
    Situation::gross("gross-1-default", "one row is grossly wrong, default identifier", 1, false),
    Situation::gross("gross-3-default", "three rows are grossly wrong, default identifier", 3, false),
    Situation::new("singular", "the machine works near a singularity", Flaw::Singular),
    Situation::new("student", "the noise has heavy tails", Flaw::Student),
    Situation::new("extended", "an effect of the catalogue acts, and the model has it", Flaw::Extended),
];
