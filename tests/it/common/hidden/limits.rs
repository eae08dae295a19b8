//! How large an effect must be to be seen: Currie's detection limit, from a run alone.
//!
//! Columns are differences of measured poses, whitened by the noise. What the 42 parameters can take up, held by a
//! prior of 1 mm, is projected off; `λ = θᵀ S θ` is what remains of an effect. Its limit is the λ at which a χ² test at
//! the family-wise level, shared out over the catalogue and over the scan, finds it 95 times of 100.

use nalgebra::{DMatrix, DVector, Rotation3, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF, Discrete, Poisson};

use super::effects::{CATALOGUE, Influence, Known, Planted, Scan, measured};
use super::hexapod::Pose;
use super::run::Run;

/// Noise of one measured coordinate, m and rad.
pub const NOISE: [f64; 2] = [1e-6, 1e-4 * std::f64::consts::PI / 180.0];
/// Level of the whole catalogue.
const LEVEL: f64 = 0.004;
const POWER: f64 = 0.95;
/// Prior of a parameter of the machine, m.
const PRIOR: f64 = 1e-3;
/// Errors of the reference machine, m.
const ERROR: f64 = 0.5e-3;
/// Step of the differences, m: its square over a metre is far below a nanometre.
const STEP: f64 = 1e-5;

/// A run, prepared for limits: what the 42 parameters do to it, as an orthonormal basis, and what it looks like
/// undisturbed.
pub struct Limits<'a> {
    run: &'a Run,
    undisturbed: Vec<[f64; 6]>,
    absorbed: DMatrix<f64>,
}

impl<'a> Limits<'a> {
    pub fn of(run: &'a Run) -> Option<Self> {
        let nominal = &run.stage.design.geometry;
        let undisturbed = measured(nominal, run, &[])?;
        let rows = run.stage.noise().len() * run.len();
        let frames = if run.stage.frames.is_some() { 12 } else { 0 };
        let prior = PRIOR * run.stage.design.error / ERROR;
        let mut columns = DMatrix::zeros(rows + 42, 42 + frames);
        for j in 0..42 {
            let mut by = [0.0; 42];
            by[j] = STEP;
            let moved = measured(&nominal.changed(&by), run, &[])?;
            columns.view_mut((0, j), (rows, 1)).copy_from(&whitened(run, &moved, &undisturbed, prior / STEP));
            columns[(rows + j, j)] = 1.0;
        }
        // A small motion of the tracker and one of the target on the platform.
        for j in 0..frames {
            let along = |first: usize| Vector3::from_fn(|i, _| if j % 6 == first + i { STEP } else { 0.0 });
            let carried = |q: &[f64; 6]| {
                let pose = Pose::of(*q);
                let moved = match j < 6 {
                    true => pose.carried(along(0), along(3)),
                    false => Pose { t: pose.t + pose.r * along(0), r: pose.r * Rotation3::new(along(3)).into_inner() },
                };
                moved.coordinates()
            };
            let moved: Vec<[f64; 6]> = undisturbed.iter().map(carried).collect();
            let column = whitened(run, &moved, &undisturbed, 1.0 / STEP);
            columns.view_mut((0, 42 + j), (rows, 1)).copy_from(&column);
        }
        let absorbed = match frames {
            0 => columns.qr().q(),
            // Points do not see how the target turns.
            _ => seen_directions(columns),
        };
        Some(Self { run, undisturbed, absorbed })
    }

    /// The whitened change that an influence makes, times `factor`, without what the 42 take up.
    fn column(&self, influence: &dyn Influence, factor: f64) -> Option<DVector<f64>> {
        let moved = measured(&self.run.stage.design.geometry, self.run, &[influence])?;
        let change =
            whitened(self.run, &moved, &self.undisturbed, factor).resize_vertically(self.absorbed.nrows(), 0.0);
        let taken = &self.absorbed * self.absorbed.tr_mul(&change);
        Some(change - taken)
    }

    /// S of an effect at a place of its scan, for parameters in their usual sizes.
    pub fn information(&self, known: &Known, leg: Option<usize>, row: Option<usize>) -> Option<DMatrix<f64>> {
        let p = known.scale.len();
        let columns: Option<Vec<DVector<f64>>> = (0..p)
            .map(|j| {
                let mut theta = vec![0.0; p];
                theta[j] = 0.1 * known.scale[j];
                self.column(&Planted { name: known.name, leg, row, theta }, 10.0)
            })
            .collect();
        let x = DMatrix::from_columns(&columns?);
        Some(x.tr_mul(&x))
    }

    /// √λ of an influence of any kind: how many σ of it stand out.
    pub fn prominence(&self, influence: &dyn Influence) -> Option<f64> {
        self.column(influence, 1.0).map(|c| c.norm())
    }

    /// Number of places at which an effect is looked for.
    fn places(&self, scan: Scan) -> f64 {
        let rows = self.run.len() as f64 - 2.0;
        match scan {
            Scan::None => 1.0,
            Scan::Leg => 6.0,
            Scan::Row => rows,
            Scan::LegAndRow => 6.0 * rows,
        }
    }

    /// √λ at the detection limit of an effect.
    pub fn at_limit(&self, known: &Known) -> f64 {
        noncentrality(known.scale.len(), LEVEL / CATALOGUE.len() as f64 / self.places(known.scan)).sqrt()
    }

    /// √λ at the limit of a test with four parameters and no scan: the measure for what no catalogue lists.
    pub fn at_limit_of_strangers() -> f64 {
        noncentrality(4, LEVEL / CATALOGUE.len() as f64).sqrt()
    }
}

/// What the instrument sees of a change, in units of the noise.
fn whitened(run: &Run, moved: &[[f64; 6]], from: &[[f64; 6]], factor: f64) -> DVector<f64> {
    let noise = run.stage.noise();
    let values = moved.iter().zip(from).flat_map(|(m, f)| {
        let (m, f) = (run.stage.seen(&Pose::of(*m)), run.stage.seen(&Pose::of(*f)));
        noise.iter().zip(m.iter().zip(&f)).map(|(noise, (m, f))| factor * (m - f) / noise).collect::<Vec<f64>>()
    });
    DVector::from_iterator(noise.len() * moved.len(), values)
}

/// An orthonormal basis of what columns span.
fn seen_directions(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in columns.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column.unscale_mut(norm);
        }
    }
    let svd = columns.svd(true, false);
    let count = svd.singular_values.iter().filter(|s| **s > 1e-9).count();
    svd.u.map_or_else(|| DMatrix::zeros(0, 0), |u| u.columns(0, count).into_owned())
}

/// The non-centrality λ at which χ² with `p` degrees of freedom passes its critical value with the wanted power.
pub fn noncentrality(p: usize, level: f64) -> f64 {
    let tail = |dof: f64, x: f64| ChiSquared::new(dof).map_or(f64::NAN, |d| d.sf(x));
    let critical = bisected(0.0, 1e3, |x| tail(p as f64, x) < level);
    // Non-central χ² is a mixture of central ones with two more degrees of freedom each, Poisson weighted.
    let power = |lambda: f64| {
        let most = (lambda + 12.0 * lambda.sqrt() + 30.0) as u64;
        let weight = Poisson::new(lambda / 2.0).ok();
        (0..most)
            .map(|j| weight.map_or(f64::NAN, |w| w.pmf(j)) * tail((p as u64 + 2 * j) as f64, critical))
            .sum::<f64>()
    };
    bisected(1e-6, 1e3, |lambda| power(lambda) > POWER)
}

/// Where a test that is false below and true above turns.
fn bisected(mut low: f64, mut high: f64, above: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if above(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}
