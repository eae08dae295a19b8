//! A dual number with eight derivatives.
//!
//! num-dual's own vector types keep the derivatives behind an `Option` and cost about three times as much in a closure
//! of square roots and products (`benches/closure.rs`). This one is a plain array that the compiler keeps in vector
//! registers. Its functions are the chain rule `f(x) + f'(x) ε`.

use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};

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

impl Inv for Lanes {
    type Output = Self;
    fn inv(self) -> Self {
        self.recip()
    }
}

impl PartialEq for Lanes {
    fn eq(&self, o: &Self) -> bool {
        self.re == o.re
    }
}

impl PartialEq<f64> for Lanes {
    fn eq(&self, o: &f64) -> bool {
        self.re == *o
    }
}

impl PartialOrd for Lanes {
    fn partial_cmp(&self, o: &Self) -> Option<std::cmp::Ordering> {
        self.re.partial_cmp(&o.re)
    }
}

impl PartialOrd<f64> for Lanes {
    fn partial_cmp(&self, o: &f64) -> Option<std::cmp::Ordering> {
        self.re.partial_cmp(o)
    }
}

impl Zero for Lanes {
    #[inline(always)]
    fn zero() -> Self {
        Self::constant(0.0)
    }
    fn is_zero(&self) -> bool {
        self.re == 0.0
    }
}

impl One for Lanes {
    #[inline(always)]
    fn one() -> Self {
        Self::constant(1.0)
    }
}

impl Num for Lanes {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self::constant)
    }
}

impl Signed for Lanes {
    fn abs(&self) -> Self {
        if self.re < 0.0 { -*self } else { *self }
    }
    fn abs_sub(&self, o: &Self) -> Self {
        if self.re > o.re { *self - o } else { Self::zero() }
    }
    fn signum(&self) -> Self {
        Self::constant(self.re.signum())
    }
    fn is_positive(&self) -> bool {
        self.re > 0.0
    }
    fn is_negative(&self) -> bool {
        self.re < 0.0
    }
}

impl Sum for Lanes {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::zero(), Add::add)
    }
}

impl Product for Lanes {
    fn product<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::one(), Mul::mul)
    }
}

impl FromPrimitive for Lanes {
    fn from_i64(n: i64) -> Option<Self> {
        f64::from_i64(n).map(Self::constant)
    }
    fn from_u64(n: u64) -> Option<Self> {
        f64::from_u64(n).map(Self::constant)
    }
    fn from_f64(n: f64) -> Option<Self> {
        Some(Self::constant(n))
    }
}

impl From<f64> for Lanes {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl fmt::Display for Lanes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} + {:?}ε", self.re, self.eps)
    }
}

impl DualStruct<Self, f64> for Lanes {
    type Real = f64;
    type Inner = f64;
    fn re(&self) -> f64 {
        self.re
    }
    fn from_inner(inner: &f64) -> Self {
        Self::constant(*inner)
    }
}

impl Mappable<Self> for Lanes {
    type Output<O> = O;
    fn map_dual<M: Fn(Self) -> O, O>(self, f: M) -> O {
        f(self)
    }
}

/// Functions of one number by value and slope at `x`.
macro_rules! functions {
    ($($name:ident |$x:ident| $value:expr, $slope:expr;)*) => {$(
        #[inline(always)]
        fn $name(&self) -> Self {
            let $x = self.re;
            self.chain($value, $slope)
        }
    )*};
}

impl DualNum<f64> for Lanes {
    const NDERIV: usize = 1;

    functions! {
        recip |x| x.recip(), -(x * x).recip();
        cbrt |x| x.cbrt(), x.cbrt() / (3.0 * x);
        exp |x| x.exp(), x.exp();
        exp2 |x| x.exp2(), x.exp2() * std::f64::consts::LN_2;
        exp_m1 |x| x.exp_m1(), x.exp();
        ln |x| x.ln(), x.recip();
        log2 |x| x.log2(), (x * std::f64::consts::LN_2).recip();
        log10 |x| x.log10(), (x * std::f64::consts::LN_10).recip();
        ln_1p |x| x.ln_1p(), (1.0 + x).recip();
        sin |x| x.sin(), x.cos();
        cos |x| x.cos(), -x.sin();
        tan |x| x.tan(), x.cos().powi(-2);
        asin |x| x.asin(), (1.0 - x * x).sqrt().recip();
        acos |x| x.acos(), -(1.0 - x * x).sqrt().recip();
        atan |x| x.atan(), (1.0 + x * x).recip();
        sinh |x| x.sinh(), x.cosh();
        cosh |x| x.cosh(), x.sinh();
        tanh |x| x.tanh(), x.cosh().powi(-2);
        asinh |x| x.asinh(), (1.0 + x * x).sqrt().recip();
        acosh |x| x.acosh(), (x * x - 1.0).sqrt().recip();
        atanh |x| x.atanh(), (1.0 - x * x).recip();
    }

    #[inline(always)]
    fn sqrt(&self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, 0.5 / root)
    }

    fn powi(&self, n: i32) -> Self {
        self.chain(self.re.powi(n), f64::from(n) * self.re.powi(n - 1))
    }

    fn powf(&self, n: f64) -> Self {
        self.chain(self.re.powf(n), n * self.re.powf(n - 1.0))
    }

    fn log(&self, base: f64) -> Self {
        self.chain(self.re.log(base), (self.re * base.ln()).recip())
    }

    #[inline(always)]
    fn sin_cos(&self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    fn atan2(&self, x: Self) -> Self {
        let square = self.re * self.re + x.re * x.re;
        self.zip(&x, self.re.atan2(x.re), |a, b| (a * x.re - b * self.re) / square)
    }

    fn sph_j0(&self) -> Self {
        self.through_num_dual(DualNum::sph_j0)
    }

    fn sph_j1(&self) -> Self {
        self.through_num_dual(DualNum::sph_j1)
    }

    fn sph_j2(&self) -> Self {
        self.through_num_dual(DualNum::sph_j2)
    }
}

impl Lanes {
    /// A function whose series num-dual already has.
    fn through_num_dual(self, f: fn(&num_dual::Dual64) -> num_dual::Dual64) -> Self {
        let y = f(&num_dual::Dual64::from_re(self.re).derivative());
        self.chain(y.re, y.eps)
    }
}

#[cfg(test)]
mod tests {
    use num_dual::DualSVec64;

    use super::*;

    /// Every operation once, on numbers on which all of them have a value.
    fn everything<T: DualNum<f64> + Copy>(x: T, y: T) -> Vec<T> {
        let (s, c) = (x * y).sin_cos();
        vec![
            x + y,
            x - y,
            x * y,
            x / y,
            -x,
            x + 2.0,
            x - 2.0,
            x * 3.0,
            x / 3.0,
            x.recip(),
            x.inv(),
            x.powi(3),
            x.powf(1.7),
            x.powd(y),
            x.sqrt(),
            x.cbrt(),
            x.exp(),
            x.exp2(),
            x.exp_m1(),
            x.ln(),
            x.log(3.0),
            x.log2(),
            x.log10(),
            x.ln_1p(),
            x.sin(),
            x.cos(),
            x.tan(),
            s,
            c,
            x.asin(),
            x.acos(),
            x.atan(),
            x.atan2(y),
            y.atan2(x),
            x.sinh(),
            x.cosh(),
            x.tanh(),
            x.asinh(),
            (x + 1.0).acosh(),
            x.atanh(),
            x.sph_j0(),
            x.sph_j1(),
            x.sph_j2(),
            x.mul_add(y, x),
            x.abs(),
            (-x).abs(),
            [x, y].into_iter().sum(),
            [x, y].into_iter().product(),
            T::from(2.5) * x,
        ]
    }

    #[test]
    fn a_remainder_has_the_slopes_of_its_parts() {
        let mut x = Lanes::constant(2.3);
        let mut y = Lanes::constant(0.7);
        (x.eps[0], y.eps[1]) = (1.0, 1.0);
        let r = x % y;
        assert!((r.re - 0.2).abs() < 1e-15 && r.eps[0] == 1.0 && r.eps[1] == -3.0, "{r}");
    }

    #[test]
    fn all_functions_agree_with_num_dual() {
        let ours = |re: f64, lane: usize| {
            let mut x = Lanes::constant(re);
            x.eps[lane] = 1.0;
            x
        };
        let theirs = |re: f64, lane: usize| DualSVec64::<8>::from_re(re).derivative(lane);
        let (a, b) = (everything(ours(0.7, 0), ours(0.4, 5)), everything(theirs(0.7, 0), theirs(0.4, 5)));
        for (k, (a, b)) in a.iter().zip(&b).enumerate() {
            let eps = b.eps.unwrap_generic(nalgebra::Const::<8>, nalgebra::U1);
            assert!((a.re - b.re).abs() < 1e-14, "function {k}: {a} {b}");
            (0..8).for_each(|lane| assert!((a.eps[lane] - eps[lane]).abs() < 1e-13, "function {k}: {a} {b}"));
        }
    }
}
