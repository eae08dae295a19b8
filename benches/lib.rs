//! What the benches share.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// Times two things in turn, `passes` calls of each at a time, `batches` times: the shortest time of each, and the median
/// of the ratios of neighbours.
pub fn interleaved<A, B>(
    batches: usize,
    passes: usize,
    mut first: impl FnMut() -> A,
    mut second: impl FnMut() -> B,
) -> (Duration, Duration, f64) {
    let times: Vec<_> = (0..batches).map(|_| (timed(passes, &mut first), timed(passes, &mut second))).collect();
    let mut ratios: Vec<f64> = times.iter().map(|(a, b)| a.as_secs_f64() / b.as_secs_f64()).collect();
    ratios.sort_by(f64::total_cmp);
    let (a, b) = times.iter().fold((Duration::MAX, Duration::MAX), |(a, b), t| (a.min(t.0), b.min(t.1)));
    (a, b, ratios[ratios.len() / 2])
}

fn timed<T>(passes: usize, f: &mut impl FnMut() -> T) -> Duration {
    let start = Instant::now();
    for _ in 0..passes {
        black_box(f());
    }
    start.elapsed()
}
