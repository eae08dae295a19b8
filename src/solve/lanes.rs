//! Numbers side by side: vectors of the machine, whatever their width.

use pulp::Simd;

/// Numbers in a row.
pub(crate) const LANES: usize = 16;

/// One number of each of so many things.
pub(crate) type Lanes = [f64; LANES];

/// Vectors in a row.
#[inline(always)]
pub(crate) fn vectors<S: Simd>() -> usize {
    LANES / (size_of::<S::f64s>() / size_of::<f64>())
}

/// One vector of a row.
#[inline(always)]
pub(crate) fn load<S: Simd>(row: &Lanes, vector: usize) -> S::f64s {
    S::as_simd_f64s(row).0[vector]
}

/// Sets one vector of a row.
#[inline(always)]
pub(crate) fn store<S: Simd>(row: &mut Lanes, vector: usize, value: S::f64s) {
    S::as_mut_simd_f64s(row).0[vector] = value;
}
