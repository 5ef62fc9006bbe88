//! Spherical harmonics restricted to the hemisphere.

use super::Harmonics;
use super::triangular::{Lower, Rows};
use crate::basis::Direction;
use crate::error::{Error, Result};
use crate::quadrature::gauss_legendre;
use std::f64::consts::PI;

/// Spherical harmonics y_i restricted to the hemisphere H: z ≥ 0, where they are not orthonormal.
///
/// After Sloan, Hall, Hart and Snyder 2003, "Clustered Principal Components for Precomputed Radiance Transfer",
/// appendix. A function f(s) = Σ c_i y_i(s) on H has three kinds of numbers, all of
/// [`coefficients`](HemisphereSh::coefficients) length:
///
/// - c, its harmonic coefficients;
/// - b_k = ∫_H f y_k = (A c)_k, its zero-hemisphere projection, where A_ik = ∫_H y_i y_k is the [Gram matrix](HemisphereSh::gram);
/// - d = Lᵀ c = L⁻¹ b, its orthonormal coordinates, where A = L Lᵀ with L lower triangular: f = Σ d_i q_i with the
///   [orthonormal functions](HemisphereSh::evaluate_orthonormal) q = L⁻¹ y.
///
/// For any f on H, band-limited or not, c = A⁻¹ b and d = L⁻¹ b are those of the nearest band-limited function in the
/// sense of ∫_H.
///
/// # In which to compress
///
/// In d: ∫_H (f - f')² = |d - d'|², so that the least Euclidean error is the least radiometric one. In c it is not,
/// since
/// |c - c'|² counts differences that vanish on H as much as any other. There are as many d as c, and they cost nothing more to
/// relight: exit radiance towards v is d · q(v) in place of c · y(v). Nor do they lose digits when rounded; |c| may
/// exceed the norm of f by √(cond A), and what rounding does to f with it. The symmetric root A^(1/2) c would serve as
/// well, being an orthogonal matrix times d; but d is nested. L is ordered by band, so the first n² of the d of a
/// higher order are those of order n, and to cut d short is to project onto fewer bands.
///
/// # Accuracy
///
/// L comes from orthonormalising the sampled functions: √(cond A) amplifies its rounding, where by way of A it would be
/// cond A. The largest relative errors over many random band-limited f, and by how much the ∫_H q_i q_k are off, with q
/// made by this L and by the Cholesky factor of A:
///
/// | functions | cond A | c to d to c | b to d | b to c | q by L | q by Cholesky |
/// | --- | --- | --- | --- | --- | --- | --- |
/// | 16 | 5.9e3 | 9e-16 | 2e-14 | 1e-12 | 5e-15 | 7e-13 |
/// | 24 | 3.2e3 | 6e-16 | 1e-14 | 6e-13 | 5e-15 | 8e-15 |
/// | 25 | 1.5e5 | 2e-15 | 8e-14 | 2e-11 | 2e-14 | 2e-11 |
/// | 36 | 4.2e6 | 3e-15 | 3e-13 | 5e-10 | 1e-13 | 5e-10 |
/// | 64 | 3.5e9 | 3e-14 | 1e-11 | 5e-7 | 3e-12 | 3e-7 |
/// | 99 | 3.0e10 | 9e-14 | 3e-11 | 3e-6 | 1e-11 | 7e-7 |
/// | 100 | 3.1e12 | 4e-13 | 3e-10 | 4e-4 | 1e-10 | 3e-4 |
///
/// What b loses on its way to c lies in directions that all but vanish on H: the function itself is off by hardly more
/// than d is.
pub struct HemisphereSh {
    harmonics: Harmonics,
    /// l(l+1)+m of each function.
    indices: Vec<usize>,
    /// By |m|: functions of different m are orthogonal on H.
    blocks: Vec<Block>,
}

/// The functions of one |m|.
struct Block {
    /// L of those of m, and just so of those of -m.
    lower: Lower,
    /// Their places among all functions, by l; for m, and for -m where that is another.
    places: Vec<Vec<usize>>,
}

impl HemisphereSh {
    /// Bands at most: beyond it c and d tell each other too little in double precision.
    pub const MAX_ORDER: usize = 10;

    /// As many functions as there are `coefficients`: n² are all of bands 0 to n-1, n from 1 to
    /// [`MAX_ORDER`](HemisphereSh::MAX_ORDER). From n = 2 on n²-1 are those without l = 1, m = 0, the one that the
    /// others approximate best at the paper's order n = 5, with a squared error of 1.48e-5: the condition of A falls
    /// from 1.5e5 to 3.2e3.
    pub fn new(coefficients: usize) -> Result<HemisphereSh> {
        let refuse = || Error::Unsupported {
            what: "coefficients on the hemisphere".into(),
            expected: format!("n² or, without l = 1, m = 0, n²-1, with n up to {}", HemisphereSh::MAX_ORDER),
            found: coefficients.to_string(),
        };
        let whole = |order: &usize| coefficients == order * order || (*order > 1 && coefficients + 1 == order * order);
        let order = (1..=HemisphereSh::MAX_ORDER).find(whole).ok_or_else(refuse)?;
        let (harmonics, all) = (Harmonics::new(order)?, order * order);
        let indices: Vec<usize> = (0..all).filter(|&i| coefficients == all || i != 2).collect();
        let blocks = (0..order).map(|m| Block::new(&harmonics, &indices, m)).collect();
        Ok(HemisphereSh { harmonics, indices, blocks })
    }

    /// Bands: 0 to order-1.
    pub fn order(&self) -> usize {
        self.harmonics.order()
    }

    /// Functions.
    pub fn coefficients(&self) -> usize {
        self.indices.len()
    }

    /// The index l(l+1)+m of each function among all harmonics, ascending.
    pub fn indices(&self) -> &[usize] {
        &self.indices
    }

    /// `out[i]` = y_i(`direction`), a unit vector with z ≥ 0; as many as there are coefficients.
    pub fn evaluate(&self, direction: Direction, out: &mut [f64]) {
        let mut all = [0f64; HemisphereSh::MAX_ORDER * HemisphereSh::MAX_ORDER];
        self.harmonics.evaluate(direction, &mut all);
        out[..self.coefficients()].iter_mut().zip(&self.indices).for_each(|(out, &i)| *out = all[i]);
    }

    /// `out[i]` = q_i(`direction`), a unit vector with z ≥ 0: the orthonormal functions q = L⁻¹ y; as many as there are
    /// coefficients.
    pub fn evaluate_orthonormal(&self, direction: Direction, out: &mut [f64]) {
        self.evaluate(direction, out);
        self.each_block(&mut out[..self.coefficients()], 1, Lower::forward);
    }

    /// A_ik = ∫_H y_i y_k, row by row, from its closed form: 1/2 on the diagonal, and 0 unless m is the same and l - l'
    /// odd.
    pub fn gram(&self) -> Vec<f64> {
        let mut horizon = vec![0f64; self.harmonics.coefficients()];
        self.harmonics.evaluate([1.0, 0.0, 0.0], &mut horizon);
        let n = self.coefficients();
        let mut gram = vec![0f64; n * n];
        for (m, block) in self.blocks.iter().enumerate() {
            for places in &block.places {
                for (i, k) in places.iter().flat_map(|i| places.iter().map(move |k| (*i, *k))) {
                    gram[i * n + k] = element(&horizon, m, self.indices[i].isqrt(), self.indices[k].isqrt());
                }
            }
        }
        gram
    }

    /// L, row by row, zero above the diagonal.
    pub fn root(&self) -> Vec<f64> {
        let n = self.coefficients();
        let mut root = vec![0f64; n * n];
        for block in &self.blocks {
            for places in &block.places {
                for (row, &i) in places.iter().enumerate() {
                    block.lower.row(row).iter().zip(places).for_each(|(l, k)| root[i * n + k] = *l);
                }
            }
        }
        root
    }

    /// c becomes d = Lᵀ c, for each column of a row-major matrix of as many rows as there are coefficients.
    pub fn to_orthonormal(&self, c: &mut [f64]) -> Result<()> {
        self.each_column(c, Lower::transposed_product)
    }

    /// d becomes c = L⁻ᵀ d, for each column of a row-major matrix of as many rows as there are coefficients.
    pub fn to_harmonic(&self, d: &mut [f64]) -> Result<()> {
        self.each_column(d, Lower::backward)
    }

    /// b becomes d = L⁻¹ b, for each column of a row-major matrix of as many rows as there are coefficients: from a
    /// zero-hemisphere projection to the orthonormal coordinates of the least-squares projection.
    pub fn project(&self, b: &mut [f64]) -> Result<()> {
        self.each_column(b, Lower::forward)
    }

    /// b becomes c = A⁻¹ b, for each column of a row-major matrix of as many rows as there are coefficients: from a
    /// zero-hemisphere projection to the harmonic coefficients of the least-squares projection.
    pub fn project_harmonic(&self, b: &mut [f64]) -> Result<()> {
        self.project(b)?;
        self.to_harmonic(b)
    }

    fn each_column(&self, matrix: &mut [f64], operation: fn(&Lower, &mut Rows)) -> Result<()> {
        let (rows, found) = (self.coefficients(), matrix.len());
        let width = found / rows;
        Error::expect_size(format!("matrix of {rows} rows, coefficients on the hemisphere"), rows * width, found)?;
        self.each_block(matrix, width, operation);
        Ok(())
    }

    fn each_block(&self, matrix: &mut [f64], width: usize, operation: fn(&Lower, &mut Rows)) {
        for block in &self.blocks {
            for places in &block.places {
                operation(&block.lower, &mut Rows { matrix, width, places });
            }
        }
    }
}

impl Block {
    /// Of those `indices` with order ±`m`.
    fn new(harmonics: &Harmonics, indices: &[usize], m: usize) -> Block {
        let order = harmonics.order();
        let of = |m: i64| -> Vec<usize> {
            let here = |i: &usize| *i as i64 - (i.isqrt() * (i.isqrt() + 1)) as i64 == m;
            indices.iter().enumerate().filter(|(_, i)| here(i)).map(|(place, _)| place).collect()
        };
        let mut functions = vec![Vec::with_capacity(order); order];
        // A product of two is a polynomial in z of a degree up to 2·order-2: this many nodes are exact.
        for (node, weight) in gauss_legendre(order) {
            let z = 0.5 + 0.5 * node;
            let mut y = [0f64; HemisphereSh::MAX_ORDER * HemisphereSh::MAX_ORDER];
            harmonics.evaluate([(1.0 - z * z).sqrt(), 0.0, z], &mut y);
            let root = (0.5 * weight * turn(m)).sqrt();
            functions.iter_mut().enumerate().skip(m).for_each(|(l, f)| f.push(root * y[l * (l + 1) + m]));
        }
        let places = if m == 0 { vec![of(0)] } else { vec![of(m as i64), of(-(m as i64))] };
        let kept = places[0].iter().map(|&place| std::mem::take(&mut functions[indices[place].isqrt()])).collect();
        Block { lower: Lower::gram_schmidt(kept), places }
    }
}

/// ∫ (Y_lm(φ) / Y_lm(0))² dφ
fn turn(m: usize) -> f64 {
    if m == 0 { 2.0 * PI } else { PI }
}

/// ∫_H Y_lm Y_km dω, with the harmonics in direction x.
fn element(horizon: &[f64], m: usize, l: usize, k: usize) -> f64 {
    if l == k {
        return 0.5;
    }
    if (l + k).is_multiple_of(2) {
        return 0.0;
    }
    // One function is even in z and one odd. Legendre's equation times the other function, subtracted and integrated by
    // parts, leaves (odd(odd+1) - even(even+1)) ∫_0^1 Y_even Y_odd dz = Y_even(0) Y_odd'(0).
    let (even, odd) = if (l + m).is_multiple_of(2) { (l, k) } else { (k, l) };
    let value = |l: usize| horizon[l * (l + 1) + m];
    let slope = (((2 * odd + 1) * (odd - m) * (odd + m)) as f64 / (2 * odd - 1) as f64).sqrt() * value(odd - 1);
    turn(m) * value(even) * slope / ((odd * (odd + 1)) as f64 - (even * (even + 1)) as f64)
}
