//! A dual number with eight derivatives.
//!
//! num-dual's own vector types keep the derivatives behind an `Option` and cost about three times as much in a closure
//! of square roots and products (`benches/closure.rs`). This one is a plain array that the compiler keeps in vector
//! registers. Its functions ([`functions`]) are the chain rule `f(x) + f'(x) ε`; [`numbers`] makes it a number to
//! generic code.

mod functions;
mod numbers;

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

/// Derivatives that travel in one number.
pub(super) const LANES: usize = 8;

/// `re + Σ eps_k ε_k` with `ε_i ε_k = 0`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes {
    pub(super) re: f64,
    pub(super) eps: [f64; LANES],
}

impl Lanes {
    /// A constant.
    #[inline(always)]
    pub(super) fn constant(re: f64) -> Self {
        Self { re, eps: [0.0; LANES] }
    }

    /// `f(x)` for `f(re) = value` and `f'(re) = slope`.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { re: value, eps: self.eps.map(|e| e * slope) }
    }

    #[inline(always)]
    fn zip(self, other: &Self, re: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut eps = self.eps;
        for (a, b) in eps.iter_mut().zip(&other.eps) {
            *a = f(*a, *b);
        }
        Self { re, eps }
    }

    #[inline(always)]
    fn plus(self, o: &Self) -> Self {
        self.zip(o, self.re + o.re, |a, b| a + b)
    }

    #[inline(always)]
    fn minus(self, o: &Self) -> Self {
        self.zip(o, self.re - o.re, |a, b| a - b)
    }

    #[inline(always)]
    fn times(self, o: &Self) -> Self {
        self.zip(o, self.re * o.re, |a, b| a * o.re + b * self.re)
    }

    #[inline(always)]
    fn over(self, o: &Self) -> Self {
        let (inverse, quotient) = (1.0 / o.re, self.re / o.re);
        self.zip(o, quotient, |a, b| (a - b * quotient) * inverse)
    }

    /// `a % b = a - ⌊a/b⌋ b`, with the quotient towards zero.
    #[inline(always)]
    fn remainder(self, o: &Self) -> Self {
        let whole = (self.re / o.re).trunc();
        self.zip(o, self.re % o.re, |a, b| a - whole * b)
    }
}

/// The operators for every combination of values and references, and for `f64` on the right.
macro_rules! operators {
    ($($trait:ident $method:ident $assign:ident $assign_method:ident $by:ident),*) => {$(
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                self.$by(&o)
            }
        }
        impl $trait<&Self> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: &Self) -> Self {
                self.$by(o)
            }
        }
        impl $assign for Lanes {
            #[inline(always)]
            fn $assign_method(&mut self, o: Self) {
                *self = self.$by(&o);
            }
        }
        impl $assign<f64> for Lanes {
            #[inline(always)]
            fn $assign_method(&mut self, o: f64) {
                *self = $trait::$method(*self, o);
            }
        }
    )*};
}

operators!(
    Add add AddAssign add_assign plus,
    Sub sub SubAssign sub_assign minus,
    Mul mul MulAssign mul_assign times,
    Div div DivAssign div_assign over,
    Rem rem RemAssign rem_assign remainder
);

/// The operators with a constant.
macro_rules! with_constant {
    ($($trait:ident $method:ident |$x:ident, $c:ident| $value:expr),*) => {$(
        impl $trait<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, $c: f64) -> Self {
                let $x = self;
                $value
            }
        }
    )*};
}

with_constant!(
    Add add |x, c| Self { re: x.re + c, ..x },
    Sub sub |x, c| Self { re: x.re - c, ..x },
    Mul mul |x, c| x.chain(x.re * c, c),
    Div div |x, c| x.chain(x.re / c, 1.0 / c),
    Rem rem |x, c| Self { re: x.re % c, ..x }
);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.re, -1.0)
    }
}
