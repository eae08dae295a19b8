//! The result of a diagnosis. Text, JSON and charts are views of it.

use crate::diagnosis::answer::unknown::Unknown;
use crate::effect::{ActiveEffect, ActsOn, Environment, ScanPoint};
use crate::identification::ErrorSummary;
use crate::measurement::{DataRow, Frames};
use crate::units::Dimension;

/// One of six answers, always.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The residuals are noise.
    Clean,
    /// Named causes explain what is left.
    Named,
    /// Named, but the data do not exclude another name.
    Tied,
    /// Something is left that no name explains.
    Unknown,
    /// The data cannot tell.
    Undecided,
    /// The file was read wrongly.
    Misread,
}

impl Verdict {
    /// The word of the format.
    pub fn word(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Named => "named",
            Self::Tied => "tied",
            Self::Unknown => "unknown",
            Self::Undecided => "undecided",
            Self::Misread => "misread",
        }
    }
}

/// A value of an effect that was found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CauseParameter {
    /// Name.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// 1σ, with the estimated noise; `None` if the data do not see the parameter.
    pub sigma: Option<f64>,
    /// Dimension.
    pub dimension: Dimension,
    /// Usual size in sound machines.
    pub scale: f64,
}

/// Another name that the data do not exclude.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rival {
    /// Its name.
    pub effect: String,
    /// Its leg, from 0.
    pub leg: Option<usize>,
    /// Data row from which on it acts.
    pub row: Option<usize>,
    /// Covariate or place of its scan.
    pub of: Option<String>,
    /// Time constant with which its temperatures act, s.
    pub lag: Option<f64>,
    /// Values that its parameters would have, SI.
    pub values: Vec<f64>,
    /// The effect that takes the place of the named one only together with this one.
    pub together_with: Option<Box<Rival>>,
    /// How much less evidence it has, nats; below zero if it has more.
    pub log_bayes_factor: f64,
    /// `λ`: the part of the named effect, squared and in units of the noise, that the rival cannot imitate in these data.
    /// About 10 is needed to tell them apart.
    pub separability: f64,
}

/// A named cause.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Cause {
    /// Name of the effect.
    pub effect: String,
    /// The cause in a sentence.
    pub cause: String,
    /// The remedy.
    pub remedy: String,
    /// Target of the effect.
    pub acts_on: ActsOn,
    /// Leg, from 0.
    pub leg: Option<usize>,
    /// Data row from which on it acts.
    pub row: Option<usize>,
    /// Covariate or place of its scan.
    pub of: Option<String>,
    /// Time constant with which its temperatures act, s; `None` if at once.
    pub lag: Option<f64>,
    /// Values, in the order of the effect's parameters.
    pub parameters: Vec<CauseParameter>,
    /// Probability of such a gain by chance, all places that were tried counted.
    pub p_value: f64,
    /// Evidence against no effect at all beside the other causes, nats.
    pub evidence: f64,
    /// Names that the data do not exclude.
    pub tied_with: Vec<Rival>,
    /// Effects that could not be tested, because a sensor is missing, and could look alike.
    pub not_excluded: Vec<String>,
    /// Size in multiples of the detection limit.
    pub size_over_limit: f64,
    /// True below twice the limit, and where another effect is not excluded because its sensor is missing.
    pub tentative: bool,
    /// True if every value is within ten times its usual size, and none is below zero that cannot be.
    pub plausible: bool,
    /// Residual without the cause over the part that nothing else imitates.
    pub added_variable: AddedVariable,
}

impl Cause {
    /// All effects that may be in its place, alone or together with another one.
    pub fn rivals(&self) -> impl Iterator<Item = &Rival> {
        self.tied_with.iter().flat_map(Rival::parts)
    }

    /// Where in its scan the effect is, but for the row.
    pub(crate) fn place(&self) -> ScanPoint {
        ScanPoint { leg: self.leg, covariate: self.of.clone(), lag: self.lag, row: None }
    }
}

impl Rival {
    /// The effect, and the one that belongs to it.
    pub fn parts(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(Some(self), |r| r.together_with.as_deref())
    }

    /// The name, or the names that stand in the place of one together.
    pub fn label(&self) -> String {
        self.parts().map(|part| part.effect.as_str()).collect::<Vec<_>>().join(" together with ")
    }

    /// Where in its scan the effect is, but for the row.
    pub(crate) fn place(&self) -> ScanPoint {
        ScanPoint { leg: self.leg, covariate: self.of.clone(), lag: self.lag, row: None }
    }
}

/// An added-variable plot: a cause that is one lies along the diagonal, and its slope over its scatter is its evidence.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct AddedVariable {
    /// For each row of the readings the share of the cause that nothing else imitates, and what is left without the cause
    /// (measured minus predicted), both over the estimated noise of the row.
    pub points: Vec<[f64; 2]>,
}

/// Residual of one sample, measured minus predicted, as a change of each joint, SI.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JointResiduals {
    /// The sample.
    pub row: DataRow,
    /// True if the sample was left out as a gross error.
    pub left_out: bool,
    /// Beside the kinematic parameters alone.
    pub before: Vec<f64>,
    /// Beside the causes too.
    pub after: Vec<f64>,
}

/// A file that was read wrongly.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Misread {
    /// Name of the reading; of two mistakes at once both names, joined by `+`.
    pub reading: String,
    /// Which axis, which unit, which order.
    pub detail: String,
    /// Misfit as read over that of the reading.
    pub factor: f64,
    /// Other readings that fit as well.
    pub tied_with: Vec<String>,
    /// The same, with their names apart from what is wrong.
    pub alternatives: Vec<Alternative>,
    /// Rows that the mechanism does not fit as the file stands.
    pub rows_failing: usize,
}

/// A reading that fits as well as the best one.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Alternative {
    /// Name of the reading.
    pub reading: String,
    /// Which axis, which unit, which order.
    pub detail: String,
}

/// Noise that is not the same in all rows.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NoiseVaries {
    /// Covariate that it depends on.
    pub covariate: String,
    /// σ at the end of the range over σ at its beginning.
    pub ratio: f64,
    /// Probability by chance.
    pub p_value: f64,
}

/// Held-out errors with and without the causes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Gain {
    /// RMS length of the position error without causes, random folds, m.
    pub position_before: Option<f64>,
    /// RMS length of the position error with the causes, m.
    pub position_after: Option<f64>,
    /// RMS length of the angle errors without causes, rad.
    pub rotation_before: Option<f64>,
    /// RMS length of the angle errors with the causes, rad.
    pub rotation_after: Option<f64>,
    /// Position error without causes where contiguous blocks were held out, m.
    pub blocked_position_before: Option<f64>,
    /// Position error with the causes where contiguous blocks were held out, m.
    pub blocked_position_after: Option<f64>,
    /// Angle error without causes where contiguous blocks were held out, rad.
    pub blocked_rotation_before: Option<f64>,
    /// Angle error with the causes where contiguous blocks were held out, rad.
    pub blocked_rotation_after: Option<f64>,
    /// √3 σ of the stated noise, m.
    pub noise_floor_position: Option<f64>,
    /// √3 σ of the stated noise of the angles, rad.
    pub noise_floor_rotation: Option<f64>,
}

impl Gain {
    /// The same where no cause is kept.
    pub(crate) fn without_causes(self) -> Self {
        Self {
            position_after: self.position_before,
            rotation_after: self.rotation_before,
            blocked_position_after: self.blocked_position_before,
            blocked_rotation_after: self.blocked_rotation_before,
            ..self
        }
    }
}

/// An effect that was tested and not found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NotFound {
    /// Name.
    pub effect: String,
    /// Name of its first parameter.
    pub parameter: String,
    /// Size of its first parameter that would have been seen with 95 % probability, SI.
    pub limit: f64,
    /// Dimension of the parameter.
    pub dimension: Dimension,
}

/// An effect that could not be tested.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NotTestable {
    /// Name.
    pub effect: String,
    /// Missing data or entries of the mechanism file.
    pub missing: Vec<String>,
}

/// The answer.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Diagnosis {
    /// One of six answers.
    pub verdict: Verdict,
    /// Why the data cannot tell, if they cannot.
    pub undecided: Option<String>,
    /// Named causes, by evidence.
    pub causes: Vec<Cause>,
    /// The error that no name explains.
    pub unknown: Option<Unknown>,
    /// How the file should have been read.
    pub misread: Option<Misread>,
    /// Data rows that were left out as gross errors.
    pub outlier_rows: Vec<DataRow>,
    /// What is left in the joints, sample by sample.
    pub residuals: Vec<JointResiduals>,
    /// Noise that varies.
    pub noise_varies: Option<NoiseVaries>,
    /// Correlation of each row with the one before, if it is more than chance.
    pub correlation: Option<f64>,
    /// Held-out errors.
    pub gain: Gain,
    /// Effects that were not found, with their limits.
    pub not_found: Vec<NotFound>,
    /// Effects that could not be tested.
    pub not_testable: Vec<NotTestable>,
    /// RMS residual after the kinematic parameters alone, outliers left out.
    pub before: ErrorSummary,
    /// RMS residual after causes.
    pub after: ErrorSummary,
    /// Estimated σ of the readings over the stated one.
    pub noise_scale: f64,
    /// Number of samples.
    pub samples: usize,
    /// Names of the joints, which causes and findings count as legs.
    pub joints: Vec<String>,
    /// Values of the parameters of the mechanism without effects, in the frames of its drawing; empty if the file was
    /// misread.
    pub values: Vec<f64>,
    /// Values of the measurement's own parameters, without those of effects.
    pub own: Vec<f64>,
    /// The causes with their values and the ranges of their covariates, ready for an extended model.
    pub effects: Vec<ActiveEffect>,
    /// Surroundings of the mechanism, with the reference temperatures that were used.
    pub environment: Environment,
    /// Where tracker and target were found.
    pub frames: Frames,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}
