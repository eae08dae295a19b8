//! The stroke of a real hardpoint beside the paper's: what can still be told.

use super::calibrations::{Draws, Fit, Study, Truth, calibrate};
use super::context::Purpose;
use super::exhibit::Listing;
use super::sets::{How, Place, Wanted, choose};
use super::{ReproduceError, ReproductionContext, paper};
use crate::simulation::RunningStats;

/// Half-ranges of a hardpoint that moves a mirror, mm and degrees.
const SMALL: (f64, f64) = (10.0, 0.5);

/// The estimators that are compared.
const FITS: [Fit; 3] = [Fit::Paper, Fit::Weighted, Fit::WithPrior];

/// One calibration in one workspace.
struct Row {
    space: &'static str,
    fit: Fit,
    draws: Draws,
    /// Draws that this estimator did not come through.
    failed: usize,
}

/// Both workspaces side by side.
pub(super) struct SmallStroke {
    rows: Vec<Row>,
}

/// Calibrations with 20 improved poses in both workspaces, by three estimators; errors are drawn anew each time.
pub(super) fn compare(context: &ReproductionContext<'_>) -> Result<SmallStroke, ReproduceError> {
    let places = [
        ("100 mm, 10 deg", Place::of_section_5()?),
        ("10 mm, 0.5 deg", Place::new("Table 5", paper::table_5()?, SMALL)),
    ];
    let targets = places.each_ref().map(|(_, place)| place.random(context.seed(Purpose::Targets, 2), paper::TARGETS.0));
    let mut rows = Vec::new();
    let mut studies = Vec::new();
    for ((space, place), targets) in places.iter().zip(&targets) {
        let chosen = choose(context, place, "a small stroke", &Wanted::over(context, How::Improved, paper::POSES, 1))?;
        for fit in FITS {
            rows.push((*space, fit));
            studies.push(Study {
                place,
                set: "improved 20".into(),
                poses: chosen[0].poses(),
                targets,
                at: "30 targets of the small stroke".into(),
                noise: paper::noise(),
                truth: Truth::Drawn,
                fit,
                draws: context.settings.draws,
                seed: context.seed(Purpose::Draws, 0x20_0000),
            });
        }
    }
    let mut all = calibrate(context, "a small stroke", &studies)?;
    let failed: Vec<usize> = all.iter().map(Draws::failed).collect();
    // Estimators are compared over the draws that all of them came through.
    for of_place in all.chunks_mut(FITS.len()) {
        for k in 0..of_place[0].draws.len() {
            if of_place.iter().any(|d| d.draws[k].is_none()) {
                of_place.iter_mut().for_each(|d| d.draws[k] = None);
            }
        }
    }
    let rows = rows.into_iter().zip(all).zip(failed);
    Ok(SmallStroke { rows: rows.map(|(((space, fit), draws), failed)| Row { space, fit, draws, failed }).collect() })
}

impl Row {
    /// Root mean square error of a parameter, mm.
    fn parameters(&self) -> f64 {
        RunningStats::of(self.draws.each(|d| d.parameters.powi(2))).mean().sqrt()
    }

    /// Mean position error at the targets, mm, and mean attitude error, degrees.
    fn pose(&self) -> (f64, f64) {
        let mean = |k: usize| RunningStats::of(self.draws.each(|d| d.table_8[k])).mean();
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
                       parameters (they are 0.5 mm), mean errors at 30 targets, over draws that no estimator failed; calibrations that failed";
        let header =
            ["workspace", "estimator", "parameter_error_mm", "position_error_mm", "attitude_error_deg", "failed"];
        let mut listing = Listing::new("figure10-small-stroke", comment, &header);
        for row in &self.rows {
            let (position, attitude) = row.pose();
            let failed = row.failed as f64;
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
        let failed = |row: &Row| format!("{} of {}", row.failed, row.draws.draws.len());
        let mut said = vec![format!(
            "A real hardpoint moves by about 10 mm and 0.5 degrees. There weighted rows calibrate the poses as well as in the \
             paper's workspace, but not the parameters; unweighted rows lose the attitude too. {}.",
            self.rows.iter().map(one).collect::<Vec<_>>().join("; ")
        )];
        if self.rows.iter().any(|row| row.failed > 0) {
            said.push(format!(
                "Left out are draws in which an estimator failed ({}): in the large workspace corners come so near to a \
                 singularity that some mechanisms with errors of 0.5 mm have no pose for the commanded lengths, or that full \
                 Gauss-Newton steps lead beyond it.",
                self.rows.iter().map(failed).collect::<Vec<_>>().join(", ")
            ));
        }
        said
    }
}
