//! Laws of an [`ObservabilityIndex`].

use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::blocks::{Structure, orthogonal, spectrum};
use super::{Violation, violation};
use crate::observability::{Block, Goal, ObservabilityIndex, Pool, PoseSet, Spectrum};

/// Spectra on which values are looked at.
const SPECTRA: usize = 20;
/// Candidates of a pool: two batches of the scans and a part of a third.
const CANDIDATES: usize = 36;
/// How many of the best candidates have to come in the right order.
const RANKS: usize = 3;
/// Values of the index closer than this part of themselves are a tie.
const NEAR_TIE: f64 = 1e-9;
/// Agreement of the value through the factors of the scans with the value through singular values.
const QUICK: f64 = 1e-6;
/// Additions and removals after which the factors still have to be right; more than go without a fresh start.
const UPDATES: usize = 80;

/// Checks an index over `directions` parameter directions: the size that it was made for, or any size for an index
/// that reads singular values alone; with 42 also on blocks of six legs, which have scans of their own.
///
/// * a regular spectrum gives a finite number, and the same bits twice;
/// * directions are read only if the index says so, and neither their signs nor the choice of axes among equal
///   singular values matters: the index is a function of `JᵀJ`;
/// * rows twice as strong are not worse: the goal is not swapped;
/// * `fast()` is an equivalent form: the best additions and removals are those of brute force over singular values,
///   `quick_value` agrees with `value`, also after many updates.
///
/// An index need not grow with every pose added (O2 may fall), nor keep its order when all singular values are scaled
/// (a regularised volume does not), so that neither is a law.
///
/// # Errors
/// The first [`Violation`].
pub fn index(index: &dyn ObservabilityIndex, directions: usize) -> Result<(), Violation> {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for _ in 0..SPECTRA {
        values(index, &spectrum(directions, &mut rng), &mut rng)?;
    }
    let structures: &[Structure] = match directions {
        Structure::OF_SIX_LEGS => &[Structure::Dense, Structure::SixLegs],
        _ => &[Structure::Dense],
    };
    for structure in structures {
        let bench = Bench::new(index, *structure, directions, &mut rng)?;
        // As few poses as determine everything after a removal, and then ample ones beside given ones.
        let least = directions.div_ceil(6) + 1;
        for (count, given) in [(least, 0), (least + 4, 2)] {
            bench.set(count, given)?;
        }
    }
    Ok(())
}

fn values(index: &dyn ObservabilityIndex, full: &Spectrum, rng: &mut ChaCha8Rng) -> Result<(), Violation> {
    let n = full.values.len();
    let value = index.value(full);
    if !value.is_finite() {
        let detail = format!("{value} for singular values from {:.3e} to {:.3e}", full.values[n - 1], full.values[0]);
        return Err(violation("a regular spectrum has a finite value", detail));
    }
    let again = index.value(full);
    if value.to_bits() != again.to_bits() {
        return Err(violation("the same spectrum gives the same bits", format!("{value} and then {again}")));
    }
    let scaled = |factor: f64| full.values.iter().map(|v| factor * v).collect();
    let stronger = index.value(&Spectrum { values: scaled(2.0), ..full.clone() });
    if !(loss(index.goal(), stronger, value) <= NEAR_TIE * value.abs()) {
        let detail = format!("{value:.9e}, with rows twice as strong {stronger:.9e}, goal {:?}", index.goal());
        return Err(violation("stronger rows are not worse", detail));
    }
    if index.needs_directions() {
        return axes(index, full);
    }
    const LAW: &str = "directions are read only if the index needs them";
    // The empty matrix, which is what such an index meets, comes last: reading it would panic.
    for directions in [orthogonal(n, rng), DMatrix::zeros(n, 0)] {
        let other = index.value(&Spectrum { directions, ..full.clone() });
        if value.to_bits() != other.to_bits() {
            return Err(violation(LAW, format!("{value:.9e}, with other directions {other:.9e}")));
        }
    }
    Ok(())
}

/// What a singular value decomposition leaves open must not matter.
fn axes(index: &dyn ObservabilityIndex, full: &Spectrum) -> Result<(), Violation> {
    let compare = |law: &'static str, a: &Spectrum, b: &Spectrum| {
        let (a, b) = (index.value(a), index.value(b));
        let close = (a - b).abs() <= NEAR_TIE * a.abs().max(b.abs());
        if close { Ok(()) } else { Err(violation(law, format!("{a:.12e} and {b:.12e}"))) }
    };
    let mut turned = full.clone();
    turned.directions.column_iter_mut().step_by(2).for_each(|mut column| column.neg_mut());
    compare("signs of directions do not matter", full, &turned)?;
    if full.values.len() < 2 {
        return Ok(());
    }
    let mut equal = full.clone();
    equal.values[1] = equal.values[0];
    let mut rotated = equal.clone();
    let (sine, cosine) = 0.7_f64.sin_cos();
    let (first, second) = (equal.directions.column(0), equal.directions.column(1));
    rotated.directions.set_column(0, &(first * cosine + second * sine));
    rotated.directions.set_column(1, &(second * cosine - first * sine));
    compare("axes among equal singular values do not matter", &equal, &rotated)
}

/// By how much `a` is worse than `b`.
fn loss(goal: Goal, a: f64, b: f64) -> f64 {
    match goal {
        Goal::Largest => b - a,
        Goal::Smallest => a - b,
    }
}

/// A pool, and the rows of its blocks as they were before any scan scaled them.
struct Bench<'a> {
    index: &'a dyn ObservabilityIndex,
    structure: Structure,
    pool: Pool,
    rows: Vec<DMatrix<f64>>,
}

impl<'a> Bench<'a> {
    fn new(
        index: &'a dyn ObservabilityIndex,
        structure: Structure,
        directions: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, Violation> {
        let blocks: Vec<Block> = (0..CANDIDATES).map(|_| structure.block(directions, rng)).collect();
        let pool = Pool::new(blocks.len(), |k| blocks[k].clone()).filter(|p| p.directions() == directions);
        let unusable = || violation("the number of directions can be tried", format!("{directions} directions"));
        let pool = pool.ok_or_else(unusable)?;
        let rows = blocks.iter().map(|b| Some(b.rows()? * pool.visible())).collect::<Option<_>>();
        Ok(Self { index, structure, rows: rows.ok_or_else(unusable)?, pool })
    }

    /// The index of some blocks and of its prior, without anything that makes it fast.
    fn brute(&self, members: &[usize]) -> f64 {
        let directions = self.pool.directions();
        let prior = if self.index.prior() { directions } else { 0 };
        let mut rows = DMatrix::zeros(6 * members.len() + prior, directions);
        for (slot, k) in members.iter().enumerate() {
            rows.rows_mut(6 * slot, 6).copy_from(&self.rows[*k]);
        }
        rows.rows_mut(6 * members.len(), prior).fill_with_identity();
        self.index.value(&Spectrum::of(&rows, members.len(), self.index.needs_directions()))
    }

    /// The first `given` candidates are given poses, the next `count` members.
    fn set(&self, count: usize, given: usize) -> Result<(), Violation> {
        let fixed: Vec<usize> = (0..given).collect();
        let members: Vec<usize> = (given..given + count).collect();
        let mut set = PoseSet::new(&self.pool, self.index, &self.rows[..given], &members);
        fixed.iter().for_each(|k| set.close(*k));
        let context = format!("{}, {} poses", self.structure.name(), set.poses());
        self.agreement(&mut set, &fixed, &context)?;
        self.additions(&mut set, &fixed, &context)?;
        self.removals(&mut set, &fixed, &context)?;
        for step in 0..UPDATES {
            let oldest = set.remove(0);
            let next = (oldest + 1 + step) % CANDIDATES;
            set.add(if fixed.contains(&next) || set.members().contains(&next) { oldest } else { next });
            // The factors are updated only while they are in use.
            let _ = set.quick_value();
        }
        self.agreement(&mut set, &fixed, &format!("{context}, after {UPDATES} updates"))
    }

    fn agreement(&self, set: &mut PoseSet<'_>, fixed: &[usize], context: &str) -> Result<(), Violation> {
        let exact = self.brute(&[fixed, set.members()].concat());
        let checks = [
            ("the value of a set is that of its rows", set.value(), NEAR_TIE),
            ("the quick value is the value", set.quick_value(), QUICK),
        ];
        for (law, found, allowed) in checks {
            if !((found - exact).abs() <= allowed * exact.abs()) {
                return Err(violation(law, format!("{found:.12e}, by brute force {exact:.12e} ({context})")));
            }
        }
        Ok(())
    }

    /// The best few candidates in turn, each kept out after it was found.
    fn additions(&self, set: &mut PoseSet<'_>, fixed: &[usize], context: &str) -> Result<(), Violation> {
        const LAW: &str = "the best addition is that of brute force";
        let known = [fixed, set.members()].concat();
        let value = |k: usize| if known.contains(&k) { None } else { Some(self.brute(&[&known[..], &[k]].concat())) };
        let mut left: Vec<Option<f64>> = (0..CANDIDATES).map(value).collect();
        let mut seen = Vec::new();
        for rank in 1..=RANKS {
            let best = set.best_addition().ok_or_else(|| violation(LAW, format!("none was found ({context})")))?;
            self.compare(LAW, best.which, &left, &format!("rank {rank}, {context}"))?;
            left[best.which] = None;
            set.close(best.which);
            seen.push(best.which);
        }
        seen.into_iter().for_each(|k| set.reopen(k));
        Ok(())
    }

    fn removals(&self, set: &mut PoseSet<'_>, fixed: &[usize], context: &str) -> Result<(), Violation> {
        const LAW: &str = "the best removal is that of brute force";
        let members = set.members().to_vec();
        let without = |position: usize| {
            let mut kept = members.clone();
            kept.remove(position);
            Some(self.brute(&[fixed, &kept[..]].concat()))
        };
        let values: Vec<Option<f64>> = (0..members.len()).map(without).collect();
        let best = set.best_removal().ok_or_else(|| violation(LAW, format!("none was found ({context})")))?;
        self.compare(LAW, best.which, &values, context)
    }

    /// That no value is better than the one that was found.
    fn compare(&self, law: &'static str, found: usize, values: &[Option<f64>], context: &str) -> Result<(), Violation> {
        let Some(Some(value)) = values.get(found) else {
            return Err(violation(law, format!("candidate {found} was not open ({context})")));
        };
        let finite = || values.iter().enumerate().filter_map(|(k, v)| v.filter(|v| v.is_finite()).map(|v| (k, v)));
        let losses = finite().map(|(k, other)| (k, other, loss(self.index.goal(), *value, other)));
        let Some((k, other, lost)) = losses.max_by(|a, b| a.2.total_cmp(&b.2)) else { return Ok(()) };
        // An index such as a logarithm passes through zero: ties are then in parts of its range.
        let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (_, v)| (l.min(v), h.max(v)));
        if lost <= NEAR_TIE * (value.abs() + high - low) {
            return Ok(());
        }
        let name = self.index.name();
        let detail = format!("{name} found number {found} with {value:.9e}, number {k} has {other:.9e} ({context})");
        Err(violation(law, detail))
    }
}
