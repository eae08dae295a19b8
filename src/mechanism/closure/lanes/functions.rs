//! Elementary functions by the chain rule.

use num_dual::DualNum;

use super::Lanes;

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
