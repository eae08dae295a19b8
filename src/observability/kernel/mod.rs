//! Scores of many candidates at once: the inner loops of pose selection.
//!
//! Adding a pose with the block `J` (6 × L) to a set with information `M` multiplies the determinant by
//! `det(I + J M⁻¹ Jᵀ)`, and everything else that an index needs is likewise a function of a 6 × 6 matrix. A block is
//! kept as `J = K U`, where `K⁻¹ K⁻ᵀ = P` (6 × 6) is the covariance of the closure residual and `U` its derivatives
//! along the parameters, because in a mechanism with six legs row `i` of `U` involves only the seven parameters of leg
//! `i`. With `S(A) = U A Uᵀ`
//!
//! | index | adding (+) or removing (−) a pose | scan |
//! |---|---|---|
//! | O1 | `det(P ± S(M⁻¹)) / det P` | [`determinant`] |
//! | O2, O3, O4 | eigenvalues of `M ± JᵀJ` below `b`: `#(λᵢ < b) ∓ #neg(P ± S((M - bI)⁻¹))` (inertia of Schur complements) | [`extremes`] |
//! | O5 | `tr (M ± JᵀJ)^-½ - tr M^-½ = 1/π ∫ [h(e²ˣ) - h(0)] e⁻ˣ dx`, `h(t) = ln det(I ± J (M + tI)⁻¹ Jᵀ)` | [`harmonic`] |
//! | pose error | `tr[(P ± S(M⁻¹))⁻¹ S(M⁻¹ G M⁻¹)]` | [`trace`] |
//! | the bound | `tr(Φ JᵀJ) = tr[P⁻¹ S(Φ)]` | [`gradient`] |
//!
//! Candidates lie in batches of [`LANES`], each number of a batch as one row of lanes, so that one instruction works
//! on many of them; `pulp` selects the instruction set at run time. [`legs`] is the layout of six legs,
//! [`dense`] serves every other mechanism (there `P = I`, `U = J`). Every candidate is scored in its own lane, so that
//! the best one does not depend on the batch or the thread; how far [`extremes`] evaluates the others depends on the
//! candidates before them.

mod dense;
mod determinant;
mod eigenvalues;
mod extremes;
mod harmonic;
mod lanes;
mod legs;
mod trace;
mod update;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

pub(super) use dense::Dense;
pub(super) use determinant::determinant;
pub use extremes::Extremes;
pub(super) use extremes::extremes;
pub(super) use harmonic::harmonic;
pub(super) use lanes::{LANES, Lanes};
pub(super) use legs::{Legs, PER_LEG, SLOTS};
pub(super) use trace::{gradient, trace};
pub(super) use update::{LegBlock, update_legs};

use lanes::{Sym, Two};

/// How the blocks of a batch lie in memory, and the two products that every scan is made of.
pub(super) trait Layout: Sync {
    /// Rows of lanes of one batch.
    fn rows(&self) -> usize;

    /// Number `L` of parameters.
    fn parameters(&self) -> usize;

    /// All batches.
    fn batches(&self) -> &[Lanes];

    /// A symmetric matrix (row-major, L × L) in the order in which [`quadratic`](Self::quadratic) reads it.
    fn pack(&self, a: &nalgebra::DMatrix<f64>) -> Vec<f64>;

    /// `U A Uᵀ` for two neighbouring vectors of lanes, the `at`-th and the next.
    fn quadratic<S: Simd>(&self, simd: S, batch: &[Lanes], at: usize, packed: &[f64]) -> Sym<Two<S>>;

    /// `P` for one vector of lanes.
    fn noise<S: Simd>(&self, simd: S, batch: &[Lanes], at: usize) -> Sym<S::f64s>;

    /// `U Q` for one vector of lanes: `y[6 i + r]` is row `r` along column `i` of `Q` (column-major, L × L).
    fn rotate<S: Simd>(&self, simd: S, batch: &[Lanes], at: usize, q: &[f64], y: &mut Vec<S::f64s>);
}

/// From this number of batches on a scan is spread over the threads.
const WORTH_SPREADING: usize = 512;
/// Batches that one thread takes at a time.
const CHUNK: usize = 128;

/// What is done with each batch.
trait Scan<L: Layout>: Sync {
    /// What is kept from batch to batch.
    type Memory<S: Simd>;

    fn start<S: Simd>(&self, simd: S, layout: &L) -> Self::Memory<S>;

    /// Writes the scores of a batch; `open` is 0 where no score is wanted.
    fn batch<S: Simd>(
        &self,
        simd: S,
        layout: &L,
        batch: &[Lanes],
        open: &Lanes,
        out: &mut Lanes,
        memory: &mut Self::Memory<S>,
    );
}

struct Run<'a, L, F> {
    layout: &'a L,
    scan: &'a F,
    batches: &'a [Lanes],
    open: &'a [Lanes],
    out: &'a mut [Lanes],
}

impl<L: Layout, F: Scan<L>> WithSimd for Run<'_, L, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut memory = self.scan.start(simd, self.layout);
        let rows = self.layout.rows();
        for ((batch, open), out) in self.batches.chunks_exact(rows).zip(self.open).zip(self.out) {
            self.scan.batch(simd, self.layout, batch, open, out, &mut memory);
        }
    }
}

/// Scores of all batches. Masks and scores are padded to whole batches.
fn run<L: Layout, F: Scan<L>>(layout: &L, scan: &F, open: &[Lanes], out: &mut [Lanes]) {
    let arch = Arch::new();
    let batches = layout.batches();
    if out.len() < WORTH_SPREADING {
        arch.dispatch(Run { layout, scan, batches, open, out });
        return;
    }
    let parts = batches.par_chunks(CHUNK * layout.rows()).zip(open.par_chunks(CHUNK)).zip(out.par_chunks_mut(CHUNK));
    parts.for_each(|((batches, open), out)| arch.dispatch(Run { layout, scan, batches, open, out }));
}
