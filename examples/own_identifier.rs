//! An identifier from outside the crate: Gauss-Newton steps through a truncated SVD.
//!
//! Directions of the parameters that the rows hardly see are left where they are instead of being damped or
//! held by a prior. The library gives the whitened residual and Jacobian; the rest is below.
//!
//! Run with `cargo run --release --example own_identifier`.

use std::error::Error;

use paracal::files::{Machine, read_measurement};
use paracal::identification::{CalibrationOptions, CalibrationProblem, Fit, Identifier, IdentifyError, calibrate};
use paracal::nalgebra::{DMatrix, DVector};
use paracal::solve::{Convergence, IterationRecord, LeastSquaresProblem};

struct TruncatedSvd {
    /// Singular values below this part of the largest are left out.
    part: f64,
}

impl Identifier for TruncatedSvd {
    fn name(&self) -> &str {
        "truncated-svd"
    }

    fn estimate(&self, problem: &mut CalibrationProblem<'_>) -> Result<Fit, IdentifyError> {
        // The prior that the task asks for, or an error if the rows are too few.
        problem.choose_prior(1.0)?;
        let (m, n) = problem.shape();
        let (mut residual, mut jacobian) = (DVector::zeros(m), DMatrix::zeros(m, n));
        let mut values = problem.guess();
        let mut history = Vec::new();
        for _ in 0..20 {
            problem
                .linearize(&values, &mut residual, &mut jacobian)
                .map_err(|e| IdentifyError::Other(e.to_string()))?;
            let svd = jacobian.clone().svd(true, true);
            let limit = self.part * svd.singular_values.max();
            let step = svd.solve(&residual, limit).map_err(|e| IdentifyError::Other(e.into()))?;
            values -= &step;
            let cost = 0.5 * residual.norm_squared();
            history.push(IterationRecord { cost, step: step.amax(), damping: 0.0 });
            if step.amax() < 1e-13 {
                break;
            }
        }
        let weights = vec![1.0; problem.data().len()];
        Ok(Fit { values, weights, gross: Vec::new(), history, convergence: Convergence::SmallStep })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let root = env!("CARGO_MANIFEST_DIR");
    let machine = Machine::read(format!("{root}/mechanisms/table5.toml"))?;
    let measured = read_measurement(format!("{root}/examples/data/hardpoint-noisy.csv"), &machine)?;
    let own = TruncatedSvd { part: 1e-9 };
    let options = CalibrationOptions::default();
    let result = calibrate(machine.mechanism.as_ref(), &measured.data, machine.workspace.as_ref(), &own, &options)?;
    println!("{}", paracal::report::text::calibration(&result));

    // The public suite holds it to the same laws as the identifiers of the crate.
    #[cfg(feature = "conformance")]
    {
        let workspace = machine.workspace.as_ref().ok_or("the file states a workspace")?;
        let noise = machine.noise.as_ref().ok_or("the file states its noise")?;
        paracal::conformance::identifier(&own, machine.mechanism.as_ref(), workspace, noise, 30)?;
        println!("conforms");
    }
    Ok(())
}
