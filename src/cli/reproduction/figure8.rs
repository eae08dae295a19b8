//! Figure 8 and Table 7: convergence of the iteration, and the parameters that it ends at.

use nalgebra::DVector;
use rand::rngs::ChaCha8Rng;

use super::context::Purpose;
use super::exhibit::Listing;
use super::sets::{How, Place, Wanted, choose};
use super::{Comparison, Exhibit, ReproduceError, ReproductionContext, Spread, paper};
use crate::identification::{CalibrationProblem, Identifier, LeastSquares, PriorPolicy, Task, Weights};
use crate::measurement::{Dataset, Noise};
use crate::mechanism::Mechanism;
use crate::pose::Pose;
use crate::report::chart::{Axis, Figure, Panel, Series, Shape};
use crate::simulation::{RunningStats, as_dataset, simulate, stream, target_errors};
use crate::solve::{LeastSquaresMethod, LeastSquaresOptions, LinearMethod, SolveError, least_squares};

/// Iterations that the figure shows.
const ITERATIONS: usize = 5;

pub(super) fn exhibit(context: &ReproductionContext<'_>) -> Result<Exhibit, ReproduceError> {
    let place = Place::of_section_5()?;
    let poses = chosen_set(context, &place)?;
    let nominal = place.nominal();
    let truth = paper::with_table_6(nominal)?;
    let measure = |noise: &Noise| -> Result<Dataset, ReproduceError> {
        let convention = &place.space.convention;
        let mut rng = one_draw(context, 0);
        let samples = simulate(nominal, truth.as_ref(), &poses, convention, noise, &mut rng)
            .map_err(|(index, cause)| crate::simulation::TrialError::Pose { index, cause })?;
        Ok(as_dataset(&samples, convention, noise))
    };
    // Rows are not weighted, so that the noise of a dataset does not enter the estimate.
    let without_noise = measure(&Noise::stated(0.0, 0.0))?;
    let exact = trajectory(nominal, &without_noise, 1.0)?;
    let measured = measure(&paper::noise())?;
    let noisy = trajectory(nominal, &measured, 1.0)?;
    let task = task(nominal, &measured);
    let found = LeastSquares::default().identify(&task)?;
    let sigma: Vec<f64> = found.parameters.iter().map(|p| 1e3 * p.sigma.unwrap_or(f64::NAN)).collect();
    let identified: Vec<f64> = found.parameters.iter().map(|p| 1e3 * (p.value - p.start)).collect();
    let table_7 = Table7 { sigma, identified };

    let largest = |x: &DVector<f64>, end: &DVector<f64>| 1e3 * (x - end).amax();
    let true_values = DVector::from_column_slice(truth.values());
    let mut comparisons = Vec::new();
    for (k, x) in exact.iter().enumerate().skip(1).take(4) {
        let error = largest(x, &true_values);
        comparisons.push(Comparison::ours(
            format!("largest error without noise after iteration {k}"),
            "mm",
            Spread::exactly(error),
        ));
    }
    let needed = settled(&noisy);
    comparisons.push(Comparison::claim(
        "iterations until no value moves by 0.1 um, with noise",
        "After three iterations, the error value tends to be stable",
        Spread::exactly(needed as f64),
        needed <= 3,
    ));
    comparisons.extend(table_7.comparisons());
    let mut listing = Listing::new(
        "figure8",
        "Figure 8: parameter errors of hardpoint 1 (mm) after each iteration, with noise",
        &["iteration", "xA1", "yA1", "zA1", "xB1", "yB1", "zB1", "h1"],
    );
    for (k, x) in noisy.iter().enumerate() {
        listing.row(&[&k.to_string()], &leg_1(nominal, x));
    }
    // With the sign of eqs. (18) and (23) as printed each step goes the other way.
    let wrong: Vec<String> = trajectory(nominal, &without_noise, -1.0)?
        .iter()
        .skip(1)
        .take(4)
        .map(|x| format!("{:.1}", largest(x, &true_values)))
        .collect();
    let findings = vec![
        format!(
            "With the sign of eqs. (18) and (23) taken literally the largest error after iterations 1 to 4 is {} mm: it doubles.",
            wrong.join(", ")
        ),
        "Table 7 is printed transposed: its rows are xA, yA, zA, xB, yB, zB and its columns the hardpoints; the seventh column \
         repeats the first, and the identified dh are given nowhere."
            .into(),
        table_7.untransposed(),
        as_printed(context, &place, truth.as_ref())?,
    ];
    Ok(Exhibit {
        name: "figure8",
        title: "Convergence of the identification, and the identified parameters (Table 7)",
        comparisons,
        findings,
        listings: vec![listing, table_7.listing()],
        figure: figure(nominal, &noisy),
        took: None,
    })
}

/// What a calibration would leave that took Table 7 as it is printed.
fn as_printed(
    context: &ReproductionContext<'_>,
    place: &Place,
    truth: &dyn Mechanism,
) -> Result<String, ReproduceError> {
    let nominal = place.nominal();
    let targets = place.random(context.seed(Purpose::Targets, 0), paper::TARGETS.1);
    let left = |model: &dyn Mechanism| -> Result<(f64, f64), ReproduceError> {
        let e = target_errors(model, truth, &targets, &place.space.convention)?;
        let mean = |v: Vec<f64>| RunningStats::of(v).mean();
        Ok((1e3 * mean(e.positions), mean(e.rotations).to_degrees()))
    };
    let printed = paper::in_order(&paper::TABLE_7);
    let values: Vec<f64> = nominal.values().iter().zip(printed).map(|(v, mm)| v + 1e-3 * mm).collect();
    let model = nominal.with_values(&values, nominal.home())?;
    let (before, after) = (left(nominal)?, left(model.as_ref())?);
    Ok(format!(
        "Taken as printed, Table 7 would leave {:.2} mm and {:.3} deg at 150 targets (mean), more than the {:.2} mm and \
         {:.3} deg of the mechanism without calibration.",
        after.0, after.1, before.0, before.1
    ))
}

fn task<'a>(nominal: &'a dyn Mechanism, data: &'a Dataset) -> Task<'a> {
    Task { weights: Weights::MillimetresAndRadians, prior: PriorPolicy::None, ..Task::new(nominal, data) }
}

/// Parameter values after 0, 1, 2, … iterations of the paper's Gauss–Newton; each step is taken `by` times.
fn trajectory(nominal: &dyn Mechanism, data: &Dataset, by: f64) -> Result<Vec<DVector<f64>>, ReproduceError> {
    let mut problem = CalibrationProblem::new(&task(nominal, data))?;
    let options = LeastSquaresOptions { linear: LinearMethod::Qr, max_iterations: 1, ..Default::default() };
    let mut values = vec![problem.start()];
    let mut x = problem.start();
    for _ in 0..ITERATIONS {
        let next = match least_squares(&mut problem, x.clone(), LeastSquaresMethod::GaussNewton, &options) {
            Ok(solution) => solution.x,
            // That is how a run ends which may take a single step.
            Err(SolveError::NoConvergence { last, .. }) => last.x,
            Err(other) => return Err(other.into()),
        };
        x += (next - &x) * by;
        values.push(x.clone());
    }
    Ok(values)
}

/// The first iteration after which no value moves by more than a tenth of the last printed digit of Table 7.
fn settled(values: &[DVector<f64>]) -> usize {
    const DIGIT_MM: f64 = 0.001;
    let end = &values[values.len() - 1];
    values.iter().position(|x| 1e3 * (x - end).amax() < 0.1 * DIGIT_MM).unwrap_or(values.len())
}

/// Errors of the parameters of the first hardpoint, mm, in the order of Table 6.
fn leg_1(nominal: &dyn Mechanism, x: &DVector<f64>) -> Vec<f64> {
    let e = |k: usize| 1e3 * (x[k] - nominal.values()[k]);
    [0, 1, 2, 4, 5, 6, 3].map(e).to_vec()
}

/// Table 7 beside Table 6 and beside an identification of ours.
struct Table7 {
    /// Predicted standard deviation of each parameter with the paper's estimator, mm, in the order of eq. (15).
    sigma: Vec<f64>,
    /// Ours, mm.
    identified: Vec<f64>,
}

/// Place of a column of Table 6 within the seven parameters of a leg, eq. (15).
const PLACES: [usize; 7] = [0, 1, 2, 4, 5, 6, 3];

impl Table7 {
    /// Printed errors, the right way round, and their difference from Table 6: column of Table 6, leg, printed, preset, σ.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, f64, f64, f64)> {
        (0..6).flat_map(move |column| {
            (0..6).map(move |leg| {
                let sigma = self.sigma[7 * leg + PLACES[column]];
                (column, leg, paper::TABLE_7[column][leg], paper::TABLE_6[leg][column], sigma)
            })
        })
    }

    fn comparisons(&self) -> Vec<Comparison> {
        let worst =
            self.entries().map(|(.., printed, preset, sigma)| (printed - preset).abs() / sigma).fold(0.0, f64::max);
        let rounded = self
            .entries()
            .filter(|(.., printed, preset, _)| (10.0 * printed).round() == (10.0 * preset).round())
            .count();
        let rms = |errors: Vec<f64>| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        let truth = paper::in_order(&paper::TABLE_6);
        let ours: Vec<f64> = self.identified.iter().zip(&truth).map(|(v, t)| v - t).collect();
        let mut rows = Vec::new();
        for (column, name) in paper::COLUMNS.iter().enumerate() {
            let predicted = rms((0..6).map(|leg| self.sigma[7 * leg + PLACES[column]]).collect());
            // The root mean square of six errors lies within these bounds in 95 of 100 draws (χ², six degrees of freedom).
            let spread = Spread { mean: predicted, error: 0.0, low: 0.454 * predicted, high: 1.552 * predicted };
            let quantity = format!("error of the identified {name}, root mean square of six");
            rows.push(match column {
                6 => Comparison::ours(quantity, "mm", spread).because("predicted; the paper does not give its dh"),
                _ => {
                    let printed = rms(self.entries().filter(|e| e.0 == column).map(|e| e.2 - e.3).collect());
                    Comparison::new(quantity, "mm", printed, spread)
                        .because("predicted spread against Table 7 - Table 6")
                }
            });
        }
        rows.push(Comparison::ours(
            "largest |Table 7 - Table 6| over its predicted standard deviation",
            "",
            Spread::exactly(worst),
        ));
        rows.push(Comparison::ours(
            "entries of Table 7 that round to Table 6, of 36",
            "",
            Spread::exactly(rounded as f64),
        ));
        rows.push(Comparison::ours(
            "our own identified parameters - Table 6, root mean square",
            "mm",
            Spread::exactly(rms(ours)),
        ));
        rows
    }

    fn listing(&self) -> Listing {
        let comment = "Table 7 the right way round, beside the preset values of Table 6 and an identification of ours; mm. The \
                       paper does not give its dh";
        let header = ["leg", "parameter", "preset", "paper", "ours", "predicted_sigma"];
        let mut listing = Listing::new("table7", comment, &header);
        for leg in 0..6 {
            for (column, name) in paper::COLUMNS.iter().enumerate() {
                let k = 7 * leg + PLACES[column];
                let printed = if column < 6 { paper::TABLE_7[column][leg] } else { f64::NAN };
                let numbers = [paper::TABLE_6[leg][column], printed, self.identified[k], self.sigma[k]];
                listing.row(&[&(leg + 1).to_string(), name], &numbers);
            }
        }
        listing
    }

    fn untransposed(&self) -> String {
        let transposed = RunningStats::of(self.entries().map(|e| (e.2 - e.3).powi(2))).mean().sqrt();
        let literal = |leg: usize| (0..7).map(move |c| (paper::TABLE_7[leg][c] - paper::TABLE_6[leg][c]).powi(2));
        let as_printed = RunningStats::of((0..6).flat_map(literal)).mean().sqrt();
        let before = RunningStats::of(paper::TABLE_6.iter().flatten().map(|e| e * e)).mean().sqrt();
        format!(
            "Root mean square of Table 7 - Table 6: {transposed:.4} mm transposed, {as_printed:.2} mm as printed; the errors \
             themselves are {before:.2} mm."
        )
    }
}

fn figure(nominal: &dyn Mechanism, values: &[DVector<f64>]) -> Figure {
    let curve = |(column, name): (usize, &&str)| {
        let points = values.iter().enumerate().map(|(k, x)| [k as f64, leg_1(nominal, x)[column]]).collect();
        Series::new(format!("d{name}1"), column, Shape::LineWithDots, points)
    };
    let panel = Panel {
        x: Axis::named("iteration", (0..values.len()).map(|k| k.to_string()).collect()),
        y: Axis::linear("identified error of hardpoint 1 (mm)"),
        series: paper::COLUMNS.iter().enumerate().map(curve).collect(),
        ..Panel::default()
    };
    Figure {
        title: "Figure 8: convergence of the identification".into(),
        description:
            "The seven parameter errors of the first hardpoint after each iteration: they stand after two to three."
                .into(),
        columns: 1,
        panels: vec![panel],
    }
}

/// The noise of the one calibration that figures show.
pub(super) fn one_draw(context: &ReproductionContext<'_>, number: u64) -> ChaCha8Rng {
    stream(context.seed(Purpose::OneDraw, 0), number)
}

/// The 20 poses of section 5.
pub(super) fn chosen_set(context: &ReproductionContext<'_>, place: &Place) -> Result<Vec<Pose>, ReproduceError> {
    Ok(choose(context, place, "20 poses", &Wanted::over(context, How::Tabu("o1"), paper::POSES, 1))?[0].poses())
}
