//! The stroke of a real hardpoint beside the paper's: what can still be told.

use super::calibrations::{Draws, Fit, Study, Truth, calibrate};
use super::exhibit::Listing;
use super::lab::Purpose;
use super::sets::{How, Place, Wanted, choose};
use super::{Lab, ReproduceError, paper};
use crate::simulation::Running;

/// Half-ranges of a hardpoint that moves a mirror, mm and degrees.
const SMALL: (f64, f64) = (10.0, 0.5);

/// One calibration in one workspace.
struct Row {
    space: &'static str,
    fit: Fit,
    draws: Draws,
}

/// Both workspaces side by side.
pub(super) struct SmallStroke {
    rows: Vec<Row>,
}

/// Calibrations with 20 improved poses in both workspaces, by three estimators; errors are drawn anew each time.
pub(super) fn compare(lab: &Lab<'_>) -> Result<SmallStroke, ReproduceError> {
    let places = [
        ("100 mm, 10 deg", Place::of_section_5()?),
        ("10 mm, 0.5 deg", Place::new("Table 5", paper::table_5()?, SMALL)),
    ];
    let targets = places.each_ref().map(|(_, place)| place.random(lab.seed(Purpose::Targets, 2), paper::TARGETS.0));
    let mut rows = Vec::new();
    let mut studies = Vec::new();
    for ((space, place), targets) in places.iter().zip(&targets) {
        let wanted = Wanted { how: How::Improved, n: paper::POSES, list: 0, candidates: lab.settings.candidates };
        let chosen = choose(lab, place, "a small stroke", &[wanted])?;
        for fit in [Fit::Paper, Fit::Weighted, Fit::WithPrior] {
            rows.push((*space, fit));
            studies.push(Study {
                place,
                set: "improved 20".into(),
                poses: chosen[0].poses(),
                targets,
                at: "30 targets of the small stroke",
                noise: paper::noise(),
                truth: Truth::Drawn,
                fit,
                draws: lab.settings.draws,
                seed: lab.seed(Purpose::Draws, 0x20_0000),
            });
        }
    }
    let draws = calibrate(lab, "a small stroke", &studies)?;
    let rows = rows.into_iter().zip(draws).map(|((space, fit), draws)| Row { space, fit, draws }).collect();
    Ok(SmallStroke { rows })
}

impl Row {
    /// Root mean square error of a parameter, mm.
    fn parameters(&self) -> f64 {
        Running::of(self.draws.each(|d| d.parameters.powi(2))).mean().sqrt()
    }

    /// Mean position error at the targets, mm, and mean attitude error, degrees.
    fn pose(&self) -> (f64, f64) {
        let mean = |k: usize| Running::of(self.draws.each(|d| d.table_8[k])).mean();
        (mean(1), mean(3))
    }

    fn estimator(&self) -> &'static str {
        match self.fit {
            Fit::Paper => "paper",
            Fit::Weighted => "weighted",
            Fit::WithPrior => "weighted, tolerance as prior",
        }
    }
}

impl SmallStroke {
    pub(super) fn listing(&self) -> Listing {
        let comment = "20 improved poses in the paper's workspace and in that of a real hardpoint: root mean square error of the \
                       parameters (they are 0.5 mm), mean errors at 30 targets, calibrations that failed";
        let header =
            ["workspace", "estimator", "parameter_error_mm", "position_error_mm", "attitude_error_deg", "failed"];
        let mut listing = Listing::new("figure10-small-stroke", comment, &header);
        for row in &self.rows {
            let (position, attitude) = row.pose();
            let failed = row.draws.failed() as f64;
            listing.row(&[row.space, row.estimator()], &[row.parameters(), position, attitude, failed]);
        }
        listing
    }

    pub(super) fn findings(&self) -> Vec<String> {
        let one = |row: &Row| {
            let (position, attitude) = row.pose();
            format!(
                "{}, {}: parameters {:.3} mm, position {position:.5} mm, attitude {attitude:.6} deg",
                row.space,
                row.estimator(),
                row.parameters()
            )
        };
        let failed = |row: &Row| format!("{} of {}", row.draws.failed(), row.draws.draws.len());
        let mut said = vec![format!(
            "A real hardpoint moves by about 10 mm and 0.5 degrees. There the poses are calibrated as well as before, the \
             parameters are not. {}.",
            self.rows.iter().map(one).collect::<Vec<_>>().join("; ")
        )];
        if self.rows.iter().any(|row| row.draws.failed() > 0) {
            said.push(format!(
                "Left out are calibrations that failed (by estimator: {}): in the large workspace corners come so near to a \
                 singularity that some mechanisms with errors of 0.5 mm have no pose for the commanded lengths, or that full \
                 Gauss-Newton steps lead beyond it.",
                self.rows.iter().map(failed).collect::<Vec<_>>().join(", ")
            ));
        }
        said
    }
}
