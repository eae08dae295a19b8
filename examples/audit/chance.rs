//! What chance alone makes of a stated error: where few directions dominate, one true machine in so many is far out.
//! Errors of the parameters are taken as normal, which those from noise with heavy tails are not quite.

use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector3};
use paracal::identification::Calibration;
use paracal::mechanism::motion_of_point;

use crate::answer::AGREES;
use crate::dice::Dice;
use crate::rigid::Rigid;
use crate::trial::Trial;

const DRAWS: usize = 2000;

/// Of a result whose covariance is true.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chance {
    /// Probability that one of the two errors exceeds what agrees.
    pub(crate) wrong: f64,
    /// Probability that one of the two exceeds what was found, if all that is stated is right.
    pub(crate) probability: f64,
    /// Median of true over stated error, position and rotation.
    pub(crate) medians: [f64; 2],
}

impl Chance {
    /// Draws parameters from the covariance of a result, and for each the errors over the fresh poses to first order;
    /// `found` are the true errors over the stated ones.
    pub(crate) fn of(trial: &Trial, result: &Calibration, found: [f64; 2], dice: &mut Dice) -> Option<Self> {
        let stated = result.predicted.as_ref()?;
        // Of what is mounted in frames that were found their uncertainty is in what is stated, and in no covariance.
        if result.mechanism.mounting().is_some() {
            return None;
        }
        let identified = &result.identification;
        let gains = gains(trial, result)?;
        let root = match gains[0].ncols() == identified.covariance.ncols() {
            true => root(&identified.covariance),
            false => root(&identified.mechanism_covariance()),
        };
        let gains = gains.map(|gain| root.transpose() * gain * &root);
        let mut ratios = [Vec::with_capacity(DRAWS), Vec::with_capacity(DRAWS)];
        let mut wrong = 0;
        for _ in 0..DRAWS {
            let z = DVector::from_fn(root.ncols(), |_, _| dice.normal());
            let errors = [0, 1].map(|k| (&gains[k] * &z).dot(&z).max(0.0).sqrt());
            let of = [errors[0] / stated.position_rms, errors[1] / stated.rotation_rms];
            wrong += usize::from(of.iter().any(|r| *r > AGREES));
            ratios.iter_mut().zip(of).for_each(|(all, ratio)| all.push(ratio));
        }
        let beyond = |k: usize| ratios[k].iter().filter(|r| **r >= found[k]).count() as f64 / DRAWS as f64;
        let probability = (2.0 * beyond(0).min(beyond(1))).min(1.0);
        let medians = ratios.map(|mut all| median(&mut all));
        Some(Self { wrong: wrong as f64 / DRAWS as f64, probability, medians })
    }
}

/// Mean over the fresh poses of `JᵀJ` for the position of the pivot and for the rotation; of all parameters where those of the
/// measurement say where the targets sit, and else of those of the mechanism.
fn gains(trial: &Trial, result: &Calibration) -> Option<[DMatrix<f64>; 2]> {
    let values = result.identification.mechanism_values();
    let drawing = trial.mechanism(&trial.drawing).ok()?;
    let aligned = drawing.with_values(&values, drawing.home()).ok()?;
    let frames = &result.registration.frames;
    let pivot = Rigid::of(&frames.target).place(&trial.convention.pivot);
    let own = result.identification.own_values();
    let n = values.len();
    let mut gains: Option<[DMatrix<f64>; 2]> = None;
    for stand in &trial.fresh {
        let pose = stand.pose.pose();
        let mut block = motion_of_point(aligned.as_ref(), &pose, &pivot).ok()?;
        if let Some(mut motion) = trial.data.model().platform_motion(&own, &pose, frames) {
            // The platform's motion, as it moves the pivot.
            let lever = stand.pose.turn * pivot;
            for mut column in motion.column_iter_mut() {
                let turn = Vector3::new(column[3], column[4], column[5]);
                let shift = turn.cross(&lever);
                (0..3).for_each(|k| column[k] += shift[k]);
            }
            block = block.resize_horizontally(n + motion.ncols(), 0.0);
            block.columns_mut(n, motion.ncols()).copy_from(&motion);
        }
        let size = block.ncols();
        let sums = gains.get_or_insert_with(|| [DMatrix::zeros(size, size), DMatrix::zeros(size, size)]);
        for (k, sum) in sums.iter_mut().enumerate() {
            let rows = block.rows(3 * k, 3);
            *sum += rows.transpose() * rows / trial.fresh.len() as f64;
        }
    }
    gains
}

/// `A` with `A Aᵀ` the covariance.
fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    // In units of its own widths, lest lengths and angles spoil the small eigenvalues.
    let widths: DVector<f64> = covariance.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
    let n = widths.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] / (widths[i] * widths[j]));
    let SymmetricEigen { eigenvectors, eigenvalues } = scaled.symmetric_eigen();
    DMatrix::from_fn(n, n, |i, j| widths[i] * eigenvectors[(i, j)] * eigenvalues[j].max(0.0).sqrt())
}

/// The middle one of some numbers; NaN of none.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}
