//! Number traits for generic code.

use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{Add, Mul};

use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};

use super::Lanes;

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
