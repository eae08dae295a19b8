//! Results as an HTML page: one self-contained file, without scripts and without external resources.
//!
//! A [`Page`] begins with the verdict in one sentence, the few numbers that matter and what to do; then it shows charts
//! and tables, and ends with what is needed to repeat it. It is readable on dark screens, phones and paper.
//! [`calibration`], [`diagnosis`], [`evaluation`] and [`selection`] make the pages of these commands; their charts are
//! in `pictures`.

mod calibration;
mod deviations;
mod diagnosis;
mod evaluation;
mod frames;
mod page;
mod pictures;
mod selection;
mod style;
mod typeset;

pub use calibration::calibration;
pub use diagnosis::diagnosis;
pub use evaluation::evaluation;
pub use frames::frames_of;
pub use page::Page;
#[cfg(feature = "cli")]
pub(crate) use page::shell;
#[doc(hidden)]
pub use page::{Part, Section, Tile, Tone};
pub use pictures::ModelResiduals;
pub use selection::selection;

use pictures::{Displacements, Standing, by_row, drawing, histograms, maps};

use crate::conditions::ConditionTable;
use crate::measurement::{DataRow, Dataset, Frames, RowKind};
use crate::mechanism::Mechanism;
use crate::pose::{Pose, PoseConvention};

/// The subject of a page.
#[derive(Clone, Debug)]
pub struct Subject<'a> {
    /// The mechanism of the drawing: calibrated if it was calibrated.
    pub mechanism: &'a dyn Mechanism,
    /// Where its base stands and the target sits in the frames of its poses, as [`frames_of`] finds it.
    pub frames: Frames,
    /// How poses are written.
    pub convention: &'a PoseConvention,
    /// What the covariates of the data mean.
    pub condition_kinds: &'a ConditionTable,
    /// Stated noise of one component of a position and of one angle, m and rad.
    pub noise: Option<[f64; 2]>,
    /// Warnings of the command.
    pub warnings: Vec<String>,
    /// Everything needed to repeat the command, by name.
    pub settings: Vec<(String, String)>,
}

impl Subject<'_> {
    /// Paragraphs, and the warnings that are not among them. Another frame is nothing to be warned of; a page states where
    /// it is.
    fn lead(&self, mut paragraphs: Vec<String>) -> Vec<String> {
        for warning in self.warnings.iter() {
            if !paragraphs.contains(warning) {
                paragraphs.push(warning.clone());
            }
        }
        paragraphs
    }
}

impl Measured<'_> {
    /// Where the models are wrong and by how much; `marked` rows look like gross errors.
    fn pictures(&self, subject: &Subject<'_>, marked: &[DataRow]) -> Vec<Part> {
        let models: Vec<&ModelResiduals> = self.models.iter().collect();
        let noise = self.noise(subject.noise);
        let mut pictures = vec![
            Part::picture(by_row(&models, noise, marked)),
            Part::picture(maps(&models, subject.convention, marked)),
            Part::picture(histograms(&models, noise, marked)),
        ];
        let standing = Standing::of(subject.mechanism, &subject.frames);
        let draw = |seen: &ModelResiduals| {
            let poses: Vec<Pose> = seen.deviations.iter().map(|d| d.pose).collect();
            let arrows = Displacements::of(seen, &standing, marked);
            drawing(subject.mechanism, &standing, &poses, Some(&arrows), &[]).map(Part::drawing)
        };
        let mut drawings: Vec<Part> = models.into_iter().filter_map(draw).collect();
        match drawings.len() {
            0 | 1 => pictures.append(&mut drawings),
            _ => pictures.push(Part::Row(drawings)),
        }
        pictures
    }

    /// The noise of one component, where every reading has just the one that is stated.
    fn noise(&self, stated: Option<[f64; 2]>) -> Option<[f64; 2]> {
        let stated = stated?;
        let as_stated = |k: usize| {
            let covariance = self.data.covariance(k);
            let sigma = |kind: &RowKind| stated[usize::from(*kind == RowKind::Rotation)];
            let rows = self.data.rows(k);
            rows.iter().enumerate().all(|(i, kind)| (covariance[(i, i)].sqrt() / sigma(kind) - 1.0).abs() < 1e-6)
        };
        (0..self.data.len()).all(as_stated).then_some(stated)
    }
}

/// The measured data of a page.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// The samples.
    pub data: &'a Dataset,
    /// The samples through each model, the best one first.
    pub models: &'a [ModelResiduals],
}
