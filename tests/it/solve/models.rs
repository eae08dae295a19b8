//! The models of the collection: the value at one observation and its gradient by the parameters.
//!
//! `b` are the parameters in the order of the data sheet and `x` the predictors. Several problems share a
//! model. Outside their domain the functions return what arithmetic makes of it, NaN or infinity.

use std::f64::consts::{PI, TAU};

/// A model, or its gradient.
pub(crate) type Value = fn(&[f64], &[f64]) -> f64;
/// See [`Value`].
pub(crate) type Gradient = fn(&[f64], &[f64]) -> Vec<f64>;

/// Problem, model and gradient.
pub(crate) const MODELS: [(&str, Value, Gradient); 27] = [
    ("Misra1a", saturation, saturation_gradient),
    ("Chwirut2", chwirut, chwirut_gradient),
    ("Chwirut1", chwirut, chwirut_gradient),
    ("Lanczos3", lanczos, lanczos_gradient),
    ("Gauss1", gauss, gauss_gradient),
    ("Gauss2", gauss, gauss_gradient),
    ("DanWood", dan_wood, dan_wood_gradient),
    ("Misra1b", misra1b, misra1b_gradient),
    ("Kirby2", rational, rational_gradient),
    ("Hahn1", rational, rational_gradient),
    ("Nelson", nelson, nelson_gradient),
    ("MGH17", mgh17, mgh17_gradient),
    ("Lanczos1", lanczos, lanczos_gradient),
    ("Lanczos2", lanczos, lanczos_gradient),
    ("Gauss3", gauss, gauss_gradient),
    ("Misra1c", misra1c, misra1c_gradient),
    ("Misra1d", misra1d, misra1d_gradient),
    ("Roszman1", roszman1, roszman1_gradient),
    ("ENSO", enso, enso_gradient),
    ("MGH09", mgh09, mgh09_gradient),
    ("Thurber", rational, rational_gradient),
    ("BoxBOD", saturation, saturation_gradient),
    ("Rat42", rat42, rat42_gradient),
    ("MGH10", mgh10, mgh10_gradient),
    ("Eckerle4", eckerle4, eckerle4_gradient),
    ("Rat43", rat43, rat43_gradient),
    ("Bennett5", bennett5, bennett5_gradient),
];

/// `b₁ (1 - e^(-b₂ x))`.
fn saturation(b: &[f64], x: &[f64]) -> f64 {
    -b[0] * (-b[1] * x[0]).exp_m1()
}

fn saturation_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let t = -b[1] * x[0];
    vec![-t.exp_m1(), b[0] * x[0] * t.exp()]
}

/// `b₁ (1 - (1 + b₂ x / 2)^(-2))`.
fn misra1b(b: &[f64], x: &[f64]) -> f64 {
    b[0] * (1.0 - (1.0 + 0.5 * b[1] * x[0]).powi(-2))
}

fn misra1b_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let u = 1.0 + 0.5 * b[1] * x[0];
    vec![1.0 - u.powi(-2), b[0] * x[0] * u.powi(-3)]
}

/// `b₁ (1 - (1 + 2 b₂ x)^(-1/2))`.
fn misra1c(b: &[f64], x: &[f64]) -> f64 {
    b[0] * (1.0 - (1.0 + 2.0 * b[1] * x[0]).powf(-0.5))
}

fn misra1c_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let u = 1.0 + 2.0 * b[1] * x[0];
    vec![1.0 - u.powf(-0.5), b[0] * x[0] * u.powf(-1.5)]
}

/// `b₁ b₂ x / (1 + b₂ x)`.
fn misra1d(b: &[f64], x: &[f64]) -> f64 {
    b[0] * b[1] * x[0] / (1.0 + b[1] * x[0])
}

fn misra1d_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let u = 1.0 + b[1] * x[0];
    vec![b[1] * x[0] / u, b[0] * x[0] / (u * u)]
}

/// `e^(-b₁ x) / (b₂ + b_3 x)`.
fn chwirut(b: &[f64], x: &[f64]) -> f64 {
    (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])
}

fn chwirut_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let (v, d) = (chwirut(b, x), b[1] + b[2] * x[0]);
    vec![-x[0] * v, -v / d, -x[0] * v / d]
}

/// `b₁ e^(-b₂ x) + b_3 e^(-b_4 x) + b_5 e^(-b_6 x)`.
fn lanczos(b: &[f64], x: &[f64]) -> f64 {
    b.chunks(2).map(|term| term[0] * (-term[1] * x[0]).exp()).sum()
}

fn lanczos_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let term = |term: &[f64]| {
        let e = (-term[1] * x[0]).exp();
        [e, -term[0] * x[0] * e]
    };
    b.chunks(2).flat_map(term).collect()
}

/// `b₁ e^(-b₂ x) + b_3 e^(-(x - b_4)² / b_5²) + b_6 e^(-(x - b_7)² / b_8²)`.
fn gauss(b: &[f64], x: &[f64]) -> f64 {
    let peaks: f64 = b[2..].chunks(3).map(|p| p[0] * (-((x[0] - p[1]) / p[2]).powi(2)).exp()).sum();
    b[0] * (-b[1] * x[0]).exp() + peaks
}

fn gauss_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let decay = (-b[1] * x[0]).exp();
    let peak = |p: &[f64]| {
        let z = (x[0] - p[1]) / p[2];
        let e = (-z * z).exp();
        [e, 2.0 * p[0] * e * z / p[2], 2.0 * p[0] * e * z * z / p[2]]
    };
    [decay, -b[0] * x[0] * decay].into_iter().chain(b[2..].chunks(3).flat_map(peak)).collect()
}

/// `b₁ x^(b₂)`.
fn dan_wood(b: &[f64], x: &[f64]) -> f64 {
    b[0] * x[0].powf(b[1])
}

fn dan_wood_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let p = x[0].powf(b[1]);
    vec![p, b[0] * p * x[0].ln()]
}

/// Numerator and denominator of [`rational`], and how many parameters the numerator has.
fn fraction(b: &[f64], x: f64) -> (f64, f64, usize) {
    let count = b.len() / 2 + 1;
    let horner = |c: &[f64]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    (horner(&b[..count]), 1.0 + x * horner(&b[count..]), count)
}

/// `(b₁ + b₂ x + … + bₖ x^(k-1)) / (1 + bₖ+1 x + … + b_2k-1 x^(k-1))`.
fn rational(b: &[f64], x: &[f64]) -> f64 {
    let (numerator, denominator, _) = fraction(b, x[0]);
    numerator / denominator
}

fn rational_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let (numerator, denominator, count) = fraction(b, x[0]);
    let powers = |k: usize| x[0].powi(k as i32);
    let above = (0..count).map(|k| powers(k) / denominator);
    let below = (1..count).map(|k| -powers(k) * numerator / (denominator * denominator));
    above.chain(below).collect()
}

/// `b₁ - b₂ x₁ e^(-b_3 x₂)`; it predicts the logarithm of the response.
fn nelson(b: &[f64], x: &[f64]) -> f64 {
    b[0] - b[1] * x[0] * (-b[2] * x[1]).exp()
}

fn nelson_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let e = x[0] * (-b[2] * x[1]).exp();
    vec![1.0, -e, b[1] * x[1] * e]
}

/// `b₁ + b₂ e^(-b_4 x) + b_3 e^(-b_5 x)`.
fn mgh17(b: &[f64], x: &[f64]) -> f64 {
    b[0] + b[1] * (-b[3] * x[0]).exp() + b[2] * (-b[4] * x[0]).exp()
}

fn mgh17_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let (e, f) = ((-b[3] * x[0]).exp(), (-b[4] * x[0]).exp());
    vec![1.0, e, f, -b[1] * x[0] * e, -b[2] * x[0] * f]
}

/// `b₁ - b₂ x - \arctan(b_3 / (x - b_4)) / π`.
fn roszman1(b: &[f64], x: &[f64]) -> f64 {
    b[0] - b[1] * x[0] - (b[2] / (x[0] - b[3])).atan() / PI
}

fn roszman1_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let u = x[0] - b[3];
    let d = PI * (u * u + b[2] * b[2]);
    vec![1.0, -x[0], -u / d, -b[2] / d]
}

/// A year's cycle and two of unknown periods `b_4` and `b_7`.
fn enso(b: &[f64], x: &[f64]) -> f64 {
    let wave = |period: f64, c: f64, s: f64| c * (TAU * x[0] / period).cos() + s * (TAU * x[0] / period).sin();
    b[0] + wave(12.0, b[1], b[2]) + wave(b[3], b[4], b[5]) + wave(b[6], b[7], b[8])
}

fn enso_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let (sin, cos) = (TAU * x[0] / 12.0).sin_cos();
    let wave = |w: &[f64]| {
        let phase = TAU * x[0] / w[0];
        let (sin, cos) = phase.sin_cos();
        [(w[1] * sin - w[2] * cos) * phase / w[0], cos, sin]
    };
    [1.0, cos, sin].into_iter().chain(b[3..].chunks(3).flat_map(wave)).collect()
}

/// `b₁ (x² + b₂ x) / (x² + b_3 x + b_4)`.
fn mgh09(b: &[f64], x: &[f64]) -> f64 {
    b[0] * x[0] * (x[0] + b[1]) / (x[0] * (x[0] + b[2]) + b[3])
}

fn mgh09_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let (x, v, d) = (x[0], mgh09(b, x), x[0] * (x[0] + b[2]) + b[3]);
    vec![x * (x + b[1]) / d, b[0] * x / d, -x * v / d, -v / d]
}

/// `b₁ e^(b₂ / (x + b_3))`.
fn mgh10(b: &[f64], x: &[f64]) -> f64 {
    b[0] * (b[1] / (x[0] + b[2])).exp()
}

fn mgh10_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let u = x[0] + b[2];
    let e = (b[1] / u).exp();
    vec![e, b[0] * e / u, -b[0] * e * b[1] / (u * u)]
}

/// `b₁ / (1 + e^(b₂ - b_3 x))`.
fn rat42(b: &[f64], x: &[f64]) -> f64 {
    b[0] / (1.0 + (b[1] - b[2] * x[0]).exp())
}

fn rat42_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let grown = 1.0 / (1.0 + (b[1] - b[2] * x[0]).exp());
    let slope = b[0] * grown * (1.0 - grown);
    vec![grown, -slope, x[0] * slope]
}

/// `b₁ / (1 + e^(b₂ - b_3 x))^(1/b_4)`.
fn rat43(b: &[f64], x: &[f64]) -> f64 {
    b[0] / (1.0 + (b[1] - b[2] * x[0]).exp()).powf(1.0 / b[3])
}

fn rat43_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let e = (b[1] - b[2] * x[0]).exp();
    let grown = (1.0 + e).powf(-1.0 / b[3]);
    let slope = b[0] * grown * e / ((1.0 + e) * b[3]);
    vec![grown, -slope, x[0] * slope, b[0] * grown * e.ln_1p() / (b[3] * b[3])]
}

/// `(b₁ / b₂) e^(-((x - b_3) / b₂)² / 2)`.
fn eckerle4(b: &[f64], x: &[f64]) -> f64 {
    b[0] / b[1] * (-0.5 * ((x[0] - b[2]) / b[1]).powi(2)).exp()
}

fn eckerle4_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let (v, z) = (eckerle4(b, x), (x[0] - b[2]) / b[1]);
    vec![(-0.5 * z * z).exp() / b[1], v * (z * z - 1.0) / b[1], v * z / b[1]]
}

/// `b₁ (b₂ + x)^(-1/b_3)`.
fn bennett5(b: &[f64], x: &[f64]) -> f64 {
    b[0] * (b[1] + x[0]).powf(-1.0 / b[2])
}

fn bennett5_gradient(b: &[f64], x: &[f64]) -> Vec<f64> {
    let (u, v) = (b[1] + x[0], bennett5(b, x));
    vec![v / b[0], -v / (b[2] * u), v * u.ln() / (b[2] * b[2])]
}
