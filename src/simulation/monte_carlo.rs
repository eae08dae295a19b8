//! Draws by the thousand, on all threads.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use super::RunningStats;

/// Draws that are summed up one after the other, whatever the number of threads.
const BLOCK: u64 = 32;

/// The random stream of draw `k`: it knows nothing of those of other draws.
pub fn stream(seed: u64, k: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(k);
    rng
}

/// Runs `draw` for each number below `draws`, in parallel, each with a random stream of its own; results come in
/// order.
pub fn monte_carlo<T: Send>(draws: u64, seed: u64, draw: impl Fn(u64, &mut ChaCha8Rng) -> T + Sync) -> Vec<T> {
    (0..draws).into_par_iter().map(|k| draw(k, &mut stream(seed, k))).collect()
}

/// Monte Carlo without keeping the results: statistics of `N` numbers from each draw, and how many draws gave none.
pub fn summarise<const N: usize>(
    draws: u64,
    seed: u64,
    draw: impl Fn(u64, &mut ChaCha8Rng) -> Option<[f64; N]> + Sync,
) -> ([RunningStats; N], u64) {
    let block = |b: u64| {
        let mut of_block = [RunningStats::default(); N];
        let mut failed = 0;
        for k in b * BLOCK..draws.min((b + 1) * BLOCK) {
            match draw(k, &mut stream(seed, k)) {
                Some(values) => of_block.iter_mut().zip(values).for_each(|(r, v)| r.push(v)),
                None => failed += 1,
            }
        }
        (of_block, failed)
    };
    let blocks: Vec<([RunningStats; N], u64)> = (0..draws.div_ceil(BLOCK)).into_par_iter().map(block).collect();
    blocks.iter().fold(([RunningStats::default(); N], 0), |(sum, failed), (next, more)| {
        (std::array::from_fn(|k| sum[k].joined(&next[k])), failed + more)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn summaries_do_not_depend_on_the_number_of_threads() {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                summarise(1000, 7, |k, rng| (k % 10 != 3).then(|| [rng.random::<f64>(), rng.random::<f64>()]))
            })
        };
        let (one, failed) = run(1);
        assert_eq!(failed, 100);
        assert_eq!(one[0].count(), 900);
        // Uniform numbers: mean 1/2, variance 1/12.
        assert!((one[0].mean() - 0.5).abs() < 4.0 * one[0].standard_error());
        assert!((one[0].sd() - 12_f64.sqrt().recip()).abs() < 0.02);
        for threads in [2, 3, 7] {
            assert_eq!(run(threads), (one, failed));
        }
    }
}
