//! What no name explains: where it is, how large, and what it depends on.

use crate::units::Dimension;

/// A test that knows no cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnknownTest {
    /// A polynomial in a covariate, at one leg or in one coordinate.
    Smooth,
    /// A step at one value of a covariate, at one leg or in one coordinate.
    Jump,
    /// A sine in a covariate, at one leg or in one coordinate.
    Wave,
    /// The variance along one leg against the others.
    Scatter,
    /// The length of the residual where the noise is stated.
    Size,
    /// Samples of the same commands in the same conditions, which agree with each other far better than with the model.
    Repeats,
    /// Names that fit and make rows that were not fitted worse.
    Extrapolation,
    /// Jumps and drifts that are stacked on each other and only trace something that changes with time.
    Patchwork,
    /// Residuals far above the stated noise, as of another mechanism.
    Misfit,
}

impl UnknownTest {
    /// The word of the format.
    pub fn word(self) -> &'static str {
        match self {
            Self::Smooth => "smooth",
            Self::Jump => "jump",
            Self::Wave => "wave",
            Self::Scatter => "scatter",
            Self::Size => "size",
            Self::Repeats => "repeats",
            Self::Extrapolation => "extrapolation",
            Self::Patchwork => "patchwork",
            Self::Misfit => "misfit",
        }
    }
}

/// Something that no name explains.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Unknown {
    /// Covariate that it depends on, if it was recorded.
    pub covariate: Option<String>,
    /// Where, leg from 0.
    pub leg: Option<usize>,
    /// Where, if it moves the platform as it is seen and no leg: 0 to 5 for the shifts along the axes of the base and the turns
    /// about them ([`COORDINATES`]).
    pub coordinate: Option<usize>,
    /// How large it is where it acts, SI: half of the range of its course, the height of a jump, the residual over the noise.
    pub size: Option<f64>,
    /// Its dimension.
    pub dimension: Dimension,
    /// The value of the covariate at a jump, SI.
    pub from: Option<f64>,
    /// Values of the covariate and what acts there, SI, in the order of the covariate; empty where nothing was recorded.
    pub course: Vec<[f64; 2]>,
    /// Which test found it.
    pub test: UnknownTest,
    /// Its probability by chance, all tests of its kind counted.
    pub p_value: f64,
    /// Period in the covariate, SI, if it repeats.
    pub period: Option<f64>,
    /// The next covariate that explains it nearly as well.
    pub runner_up: Option<String>,
    /// Names that were withdrawn because this explains the data better than all of them.
    pub withdrawn: Vec<String>,
}

/// Names of the coordinates of a pose.
pub const COORDINATES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

impl Unknown {
    /// Found by a test, and depending on nothing.
    pub(crate) fn by(test: UnknownTest, p_value: f64) -> Self {
        Self {
            covariate: None,
            leg: None,
            coordinate: None,
            size: None,
            dimension: Dimension::None,
            from: None,
            course: Vec::new(),
            test,
            p_value,
            period: None,
            runner_up: None,
            withdrawn: Vec::new(),
        }
    }

    /// The word of the format for what it is: `covariate` depends on something that was recorded, `noise` exceeds the stated
    /// noise or that of repeated samples, `misfit` fits the mechanism not at all.
    pub fn kind(&self) -> &'static str {
        match (self.test, &self.covariate) {
            (UnknownTest::Misfit | UnknownTest::Extrapolation, _) => "misfit",
            (_, Some(_)) => "covariate",
            (_, None) => "noise",
        }
    }
}
