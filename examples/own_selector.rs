//! A selector from outside the crate: simulated annealing, compared with those of the crate.
//!
//! A member and a candidate that are drawn at random change places; a change for the worse is kept with a probability
//! that falls as the temperature does. The library gives the set with its index; the rest is below.
//!
//! Run with `cargo run --release --example own_selector`.

use std::error::Error;

use paracal::files::Machine;
use paracal::observability::{Goal, O1, Scaling};
use paracal::rand::rngs::ChaCha8Rng;
use paracal::rand::{RngExt, SeedableRng};
use paracal::selection::{
    Campaign, Candidates, Choice, Exchange, Objective, PoseSelector, Problem, Random, SelectionError, SelectionTask,
    Sources, select_among,
};

#[derive(Debug)]
struct Annealing {
    steps: usize,
}

impl PoseSelector for Annealing {
    fn name(&self) -> &str {
        "annealing"
    }

    fn select(&self, problem: &Problem<'_>) -> Result<Choice, SelectionError> {
        let mut rng = ChaCha8Rng::seed_from_u64(problem.seed);
        let mut set = problem.set(&problem.start(&mut rng)?);
        let mut value = set.quick_value();
        let mut best = (value, set.members().to_vec());
        let mut trace = vec![value];
        for step in 0..self.steps {
            let new = rng.random_range(0..problem.candidates.len());
            if set.members().contains(&new) {
                continue;
            }
            let old = set.remove(rng.random_range(0..problem.count));
            set.add(new);
            let next = set.quick_value();
            // The change in parts of the value, positive for the better; from 1 % down to nothing.
            let change = (next - value) / value.abs();
            let gain = if problem.index.goal() == Goal::Largest { change } else { -change };
            let temperature = 0.01 * (1.0 - step as f64 / self.steps as f64).powi(2);
            if gain >= 0.0 || rng.random::<f64>() < (gain / temperature).exp() {
                value = next;
            } else {
                set.remove(problem.count - 1);
                set.add(old);
            }
            trace.push(value);
            if set.better(value, best.0) {
                best = (value, set.members().to_vec());
            }
        }
        Ok(Choice { poses: problem.poses(&best.1), iterations: trace.len() - 1, trace })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Machine::read(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml"))?;
    let workspace = machine.workspace.ok_or("the file states a workspace")?;
    let mechanism = machine.mechanism.as_ref();
    let campaign = Campaign::new(mechanism, &workspace, machine.noise.as_ref(), Scaling::Whitened)?;
    let candidates = Candidates::collect(&campaign, &Sources { random: 1000, ..Sources::default() })?;
    let aim = Objective::Index(&O1);
    let plan = SelectionTask { campaign: &campaign, forecaster: None, aim, given: &[], seed: 1, watch: &|_| {} };

    println!("20 of {} poses       O1  of the bound  iterations", candidates.len());
    let own = Annealing { steps: 5000 };
    let exchange = Exchange { polish: false, ..Exchange::default() };
    let selectors: [&dyn PoseSelector; 3] = [&Random, &own, &exchange];
    for selector in selectors {
        let report = select_among(&plan, selector, &candidates, 20, true)?;
        let efficiency = 100.0 * report.efficiency.ok_or("O1 has a bound")?;
        println!("{:<14} {:>11.3} {efficiency:>11.2} % {:>11}", selector.name(), report.value, report.iterations);
    }

    // The public suite holds it to the same laws as the selectors of the crate.
    #[cfg(feature = "conformance")]
    {
        paracal::conformance::selector(&own, mechanism, &workspace)?;
        println!("conforms");
    }
    Ok(())
}
