//! Products of spherical harmonics.

use super::Harmonics;
use crate::error::Result;
use crate::quadrature::gauss_legendre;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The matrix of multiplication with a function: with `f = Σ f_k y_k`,
///
/// ```text
/// T_ij = ∫ f y_i y_j dω = Σ_k γ_ijk f_k,   γ_ijk = ∫ y_i y_j y_k dω
/// ```
///
/// exactly, for `f` of whatever bands: only those below rows + columns - 1 take part. With the moments of visibility
/// for `f_k` it is the transfer of incident light (Sloan et al. 2002, §5).
pub struct Products {
    rows: usize,
    columns: usize,
    /// Where in `factors` element (i, j) begins, row-major, and the end.
    offsets: Vec<u32>,
    /// (k, γ_ijk) of every element in turn, those that are not 0.
    factors: Vec<(u32, f64)>,
}

/// Below this a factor is 0 but for rounding; the least others are about 1e-3.
const NONE: f64 = 1e-12;

/// A direction of the quadrature: its weight, and the harmonics of both sides there.
struct Node {
    weight: f64,
    y: Vec<f64>,
}

impl Products {
    /// Rows i of bands below `rows`, columns j of bands below `columns`.
    pub fn new(rows: usize, columns: usize) -> Result<Products> {
        [rows, columns].into_iter().try_for_each(super::check_order)?;
        let bands = rows + columns - 1;
        let harmonics = Harmonics::new(bands)?;
        let nodes = nodes(&harmonics, bands);
        let of_row = |i: usize| -> Vec<Vec<(u32, f64)>> {
            (0..columns * columns).map(|j| products(&nodes, i, j, bands)).collect()
        };
        let elements: Vec<Vec<(u32, f64)>> =
            (0..rows * rows).into_par_iter().map(of_row).collect::<Vec<_>>().into_iter().flatten().collect();
        let mut offsets = vec![0];
        let mut end = 0;
        offsets.extend(elements.iter().map(|e| {
            end += e.len() as u32;
            end
        }));
        Ok(Products { rows: rows * rows, columns: columns * columns, offsets, factors: elements.concat() })
    }

    /// Bands of the function that take part.
    pub fn bands(rows: usize, columns: usize) -> usize {
        rows + columns - 1
    }

    /// T, rows x columns, row by row, of the function with coefficients `f`; those beyond `f` are taken for 0.
    ///
    /// # Panics
    /// Where `out` is of another size.
    pub fn matrix_into(&self, f: &[f64], out: &mut [f64]) {
        assert_eq!(out.len(), self.rows * self.columns, "rows x columns");
        for (out, range) in out.iter_mut().zip(self.offsets.windows(2)) {
            let factors = &self.factors[range[0] as usize..range[1] as usize];
            *out = factors.iter().map(|&(k, factor)| factor * f.get(k as usize).copied().unwrap_or(0.0)).sum();
        }
    }
}

/// A quadrature that is exact for products of three harmonics below `bands`, of which two have fewer.
fn nodes(harmonics: &Harmonics, bands: usize) -> Vec<Node> {
    // The three degrees add up to at most 2 (bands - 1).
    let around = 2 * bands;
    gauss_legendre(bands)
        .into_iter()
        .flat_map(|(z, weight)| (0..around).map(move |a| (z, weight, 2.0 * PI * a as f64 / around as f64)))
        .map(|(z, weight, phi)| {
            let (radius, mut y) = ((1.0 - z * z).sqrt(), vec![0f64; harmonics.coefficients()]);
            harmonics.evaluate([radius * phi.cos(), radius * phi.sin(), z], &mut y);
            Node { weight: weight * 2.0 * PI / around as f64, y }
        })
        .collect()
}

/// Band and |m| of coefficient k.
fn band_and_order(k: usize) -> (usize, usize) {
    let l = k.isqrt();
    (l, k.abs_diff(l * l + l))
}

fn products(nodes: &[Node], i: usize, j: usize, bands: usize) -> Vec<(u32, f64)> {
    let ((l, m), (other_l, other_m)) = (band_and_order(i), band_and_order(j));
    let candidates = (0..bands * bands).filter(|&k| {
        let (band, order) = band_and_order(k);
        // cos mφ cos m'φ holds m + m' and |m - m'| alone; bands obey the triangle inequality and parity.
        (order == m + other_m || order == m.abs_diff(other_m))
            && (l.abs_diff(other_l)..=l + other_l).contains(&band)
            && (l + other_l + band).is_multiple_of(2)
    });
    let pair: Vec<f64> = nodes.iter().map(|node| node.weight * node.y[i] * node.y[j]).collect();
    candidates
        .map(|k| (k as u32, pair.iter().zip(nodes).map(|(pair, node)| pair * node.y[k]).sum::<f64>()))
        .filter(|(_, factor)| factor.abs() > NONE)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiplying_coefficients_is_multiplying_values() {
        // With rows of as many bands as the product has, nothing is cut off.
        let (f_bands, columns, rows) = (3, 4, 6);
        let products = Products::new(rows, columns).unwrap();
        let coefficients = |n: usize, seed: f64| (0..n * n).map(|k| (seed * (k + 1) as f64).sin()).collect::<Vec<_>>();
        let (f, x) = (coefficients(f_bands, 1.3), coefficients(columns, 0.7));
        let mut matrix = vec![f64::NAN; 36 * 16];
        products.matrix_into(&f, &mut matrix);
        let product: Vec<f64> = matrix.chunks(16).map(|row| row.iter().zip(&x).map(|(t, x)| t * x).sum()).collect();
        let value = |c: &[f64], direction| {
            let order = c.len().isqrt();
            let mut y = vec![0.0; c.len()];
            super::super::evaluate(order, direction, &mut y).unwrap();
            c.iter().zip(y).map(|(c, y)| c * y).sum::<f64>()
        };
        for (z, phi) in [(0.3f64, 1.0f64), (-0.8, 2.0), (0.99, -1.2), (-0.1, 4.0)] {
            let radius = (1.0 - z * z).sqrt();
            let direction = [radius * phi.cos(), radius * phi.sin(), z];
            let (expected, found) = (value(&f, direction) * value(&x, direction), value(&product, direction));
            assert!((expected - found).abs() < 1e-12, "{expected} {found}");
        }
    }

    #[test]
    fn the_selection_rules_leave_nothing_out() {
        // Every factor by brute force, at bands small enough to try all.
        let (rows, columns) = (3, 3);
        let bands = Products::bands(rows, columns);
        let (harmonics, products) = (Harmonics::new(bands).unwrap(), Products::new(rows, columns).unwrap());
        let nodes = nodes(&harmonics, bands);
        for k in 0..bands * bands {
            let mut f = vec![0.0; bands * bands];
            f[k] = 1.0;
            let mut matrix = vec![f64::NAN; 81];
            products.matrix_into(&f, &mut matrix);
            for (at, found) in matrix.iter().enumerate() {
                let sum: f64 = nodes.iter().map(|n| n.weight * n.y[at / 9] * n.y[at % 9] * n.y[k]).sum();
                assert!((sum - found).abs() < 1e-12, "{at} {k}: {sum} {found}");
            }
        }
    }
}
