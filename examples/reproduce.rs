//! The paper's Figure 7 and Table 7 from a program of one's own, with fewer draws than `paracal reproduce` takes.
//!
//! Run with `cargo run --release --example reproduce`.

use std::error::Error;

use paracal::reproduction::{ReproductionContext, Settings, reproduce};
use paracal::simulation::Journal;

fn main() -> Result<(), Box<dyn Error>> {
    let settings = Settings { draws: 100, lists: 3, ..Settings::default() };
    // A journal in a file would let a run that is stopped go on.
    let journal = Journal::in_memory();
    let context =
        ReproductionContext::new(settings, &journal, &|progress| eprintln!("{}: {}", progress.what, progress.done))?;
    for name in ["figure7", "figure8"] {
        let exhibit = reproduce(name, &context)?;
        println!("{}", exhibit.text(&settings));
        for c in exhibit.comparisons.iter().filter(|c| c.verdict.is_some()) {
            println!("{}: {:e} in the paper, {:e} here", c.quantity, c.paper.unwrap_or(f64::NAN), c.ours.mean);
        }
    }
    Ok(())
}
