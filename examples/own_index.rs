//! An observability index from outside the crate: the mean of the three smallest singular values.
//!
//! O3 looks at the single worst direction of the parameters; this one also at the two next to it. One function of the
//! spectrum is all that an index needs. Without a fast form each candidate costs a singular value decomposition.
//!
//! Run with `cargo run --release --example own_index`.

use std::error::Error;

use paracal::files::Machine;
use paracal::observability::{O1, O3, ObservabilityIndex, Scaling, Spectrum};
use paracal::selection::{Campaign, Candidates, Exchange, Forecaster, Objective, SelectionTask, Sources, select_among};
use paracal::units::show_length;

#[derive(Debug)]
struct ThreeSmallest;

impl ObservabilityIndex for ThreeSmallest {
    fn name(&self) -> &str {
        "three smallest"
    }

    fn value(&self, spectrum: &Spectrum) -> f64 {
        // Singular values descend.
        spectrum.values.iter().rev().take(3).sum::<f64>() / 3.0
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Machine::read(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"))?;
    let workspace = machine.workspace.ok_or("the file states a workspace")?;
    let campaign = Campaign::new(machine.mechanism.as_ref(), &workspace, machine.noise.as_ref(), Scaling::Whitened)?;
    let forecaster = Forecaster::new(campaign.clone(), &[])?;
    let sources = Sources { random: 200, ..Sources::default() };
    let candidates = Candidates::collect(&campaign, &sources)?;

    let selector = Exchange { starts: 3, rounds: 4, polish: false };
    println!("12 of {} poses     smallest  three smallest  predicted error", candidates.len());
    let indices: [&dyn ObservabilityIndex; 3] = [&ThreeSmallest, &O3, &O1];
    for index in indices {
        let aim = Objective::Index(index);
        let plan = SelectionTask {
            campaign: &campaign,
            forecaster: Some(&forecaster),
            aim,
            given: &[],
            seed: 1,
            watch: &|_| {},
        };
        let report = select_among(&plan, &selector, &candidates, 12, false)?;
        let forecast = report.forecast.ok_or("the file states noise and tolerances")?;
        let smallest = O3.value(&forecast.spectrum);
        let mean = ThreeSmallest.value(&forecast.spectrum);
        let error = show_length(forecast.error.position_rms);
        println!("best {:<15} {smallest:>7.3} {mean:>15.3}  {error:>15}", report.index);
    }

    // The public suite holds it to the same laws as the indices of the crate.
    #[cfg(feature = "conformance")]
    {
        paracal::conformance::index(&ThreeSmallest, 42)?;
        println!("conforms");
    }
    Ok(())
}
