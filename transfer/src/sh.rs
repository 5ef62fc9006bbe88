//! Real spherical harmonics: evaluation, [rotation](Rotation), [restriction to the hemisphere](HemisphereSh),
//! projection of texels, and the light transform `sh`.
//!
//! Convention: orthonormal over the sphere, z up, index `l(l+1)+m`, no Condon-Shortley phase. With x, y, z the unit
//! direction,
//!
//! ```text
//! Y_lm = √2 p_lm(z) Re (x+iy)^m      m > 0
//!        p_l0(z)                     m = 0
//!        √2 p_l|m|(z) Im (x+iy)^|m|  m < 0
//! ```
//!
//! where `p_lm(z) (1-z²)^(m/2)` is the associated Legendre function scaled so that `2π ∫ p_lm² (1-z²)^m dz = 1`,
//! positive at z = 1. Bands 0 and 1 are thus `√(1/4π)` and `√(3/4π) (y, z, x)`.

mod hemisphere;
mod moments;
mod product;
mod rotation;
mod transform;
mod triangular;

pub use hemisphere::HemisphereSh;
pub use moments::{project, texel_moments};
pub use product::Products;
pub use rotation::Rotation;
pub use transform::{BoundSh, Sh, ShParams};

use crate::basis::Direction;
use crate::error::{Error, Result};
use std::f64::consts::{PI, SQRT_2};

/// Bands that [`Harmonics`] evaluates at most: to here the recurrence is tested (addition theorem to 1e-12).
pub const MAX_ORDER: usize = 64;

/// `Ok` for an order from 1 to [`MAX_ORDER`].
fn check_order(order: usize) -> Result<()> {
    if (1..=MAX_ORDER).contains(&order) {
        return Ok(());
    }
    Err(Error::Unsupported {
        what: "order of spherical harmonics".into(),
        expected: format!("1 to {MAX_ORDER}"),
        found: order.to_string(),
    })
}

/// Spherical harmonics of bands 0 to order-1, with the factors of their recurrence made once.
pub struct Harmonics {
    order: usize,
    /// p_mm for each m.
    diagonal: Vec<f64>,
    /// For each m, then each l > m: the factors (a, b) of `p_l = a (z p_(l-1) - b p_(l-2))`.
    rising: Vec<(f64, f64)>,
}

impl Harmonics {
    /// Bands 0 to `order`-1; `order` from 1 to [`MAX_ORDER`].
    pub fn new(order: usize) -> Result<Harmonics> {
        check_order(order)?;
        let (mut diagonal, mut rising) = (vec![(0.25 / PI).sqrt()], Vec::new());
        for m in 0..order {
            let square = |n: usize| (n * n) as f64;
            for l in m + 1..order {
                // Press et al., Numerical Recipes, 3rd edition, §6.7: P̃_l in terms of P̃_(l-1) and P̃_(l-2).
                let a = ((4.0 * square(l) - 1.0) / (square(l) - square(m))).sqrt();
                let b = if l == m + 1 { 0.0 } else { (square(l - 1) - square(m)) / (4.0 * square(l - 1) - 1.0) };
                rising.push((a, b.sqrt()));
            }
            diagonal.push(diagonal[m] * ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt());
        }
        Ok(Harmonics { order, diagonal, rising })
    }

    /// Bands.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Coefficients: order².
    pub fn coefficients(&self) -> usize {
        self.order * self.order
    }

    /// `out[l(l+1)+m]` = Y_lm(`direction`), a unit vector; `out.len()` = order².
    pub fn evaluate(&self, [x, y, z]: Direction, out: &mut [f64]) {
        // √2 (x+iy)^m, without the √2 at m = 0.
        let (mut re, mut im) = (1.0, 0.0);
        let mut rising = self.rising.iter();
        for m in 0..self.order {
            let (mut before, mut p) = (0.0, self.diagonal[m]);
            for l in m..self.order {
                if l > m
                    && let Some((a, b)) = rising.next()
                {
                    (before, p) = (p, a * (z * p - b * before));
                }
                out[l * (l + 1) + m] = p * re;
                if m > 0 {
                    out[l * (l + 1) - m] = p * im;
                }
            }
            let root = if m == 0 { SQRT_2 } else { 1.0 };
            (re, im) = (root * (re * x - im * y), root * (re * y + im * x));
        }
    }
}

/// `out[l(l+1)+m]` = Y_lm(`direction`), a unit vector; `out.len()` = order². For many directions make [`Harmonics`]
/// once.
pub fn evaluate(order: usize, direction: Direction, out: &mut [f64]) -> Result<()> {
    let harmonics = Harmonics::new(order)?;
    Error::expect_size(format!("spherical harmonics of order {order}"), harmonics.coefficients(), out.len())?;
    harmonics.evaluate(direction, out);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    fn at(order: usize, direction: Direction) -> Vec<f64> {
        let mut out = vec![f64::NAN; order * order];
        evaluate(order, direction, &mut out).unwrap();
        out
    }

    fn direction(z: f64, phi: f64) -> Direction {
        let r = (1.0 - z * z).sqrt();
        [r * phi.cos(), r * phi.sin(), z]
    }

    /// Directions all over the sphere, poles included.
    fn directions(n: usize) -> Vec<Direction> {
        (0..n).map(|i| direction(1.0 - 2.0 * i as f64 / (n - 1) as f64, 2.4 * i as f64)).collect()
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn the_first_bands_have_their_closed_forms() {
        for d @ [x, y, z] in directions(40) {
            let (one, two) = ((0.75 / PI).sqrt(), (3.75 / PI).sqrt());
            let expected = [
                (0.25 / PI).sqrt(),
                one * y,
                one * z,
                one * x,
                two * x * y,
                two * y * z,
                (5.0 / 16.0 / PI).sqrt() * (3.0 * z * z - 1.0),
                two * x * z,
                0.5 * two * (x * x - y * y),
                (35.0 / 32.0 / PI).sqrt() * y * (3.0 * x * x - y * y),
            ];
            for (i, (a, b)) in at(4, d).iter().zip(expected).enumerate() {
                assert!((a - b).abs() < 1e-14, "{i}: {a} {b}");
            }
        }
    }

    #[test]
    fn they_are_orthonormal() {
        // Gauss in z and equal steps in φ integrate products of two harmonics exactly.
        for order in [1, 2, 5, 10, 20] {
            let harmonics = Harmonics::new(order).unwrap();
            let (n, rings) = (order * order, gauss_legendre(order));
            let (mut gram, mut y) = (vec![0f64; n * n], vec![0f64; n]);
            for (z, weight) in rings {
                for step in 0..2 * order {
                    harmonics.evaluate(direction(z, PI * (step as f64 + 0.3) / order as f64), &mut y);
                    for (i, row) in gram.chunks_mut(n).enumerate() {
                        let factor = y[i] * weight * PI / order as f64;
                        row.iter_mut().zip(&y).for_each(|(g, y)| *g += factor * y);
                    }
                }
            }
            for (k, g) in gram.iter().enumerate() {
                let expected = if k / n == k % n { 1.0 } else { 0.0 };
                assert!((g - expected).abs() < 1e-10, "order {order}: {} {}: {g}", k / n, k % n);
            }
        }
    }

    #[test]
    fn each_band_obeys_the_addition_theorem() {
        // Σ_m Y_lm(a) Y_lm(b) = (2l+1)/4π P_l(a·b), with P_l from its own recurrence.
        for (a, b) in directions(23).into_iter().zip(directions(23).into_iter().rev().skip(5)) {
            let (ya, yb, mu) = (at(MAX_ORDER, a), at(MAX_ORDER, b), dot(&a, &b));
            let (mut before, mut legendre) = (0.0, 1.0);
            for l in 0..MAX_ORDER {
                let band = l * l..(l + 1) * (l + 1);
                let (sum, scale) = (dot(&ya[band.clone()], &yb[band]), (2 * l + 1) as f64 / (4.0 * PI));
                assert!((sum - scale * legendre).abs() < 1e-12 * scale, "band {l} at {mu}: {sum}");
                let next = ((2 * l + 1) as f64 * mu * legendre - l as f64 * before) / (l + 1) as f64;
                (before, legendre) = (legendre, next);
            }
        }
    }

    #[test]
    fn rotation_moves_no_energy_between_bands() {
        // f = Σ_i w_i δ(d_i) has the coefficients Σ w_i Y(d_i); its energy in a band must not depend on the frame.
        let (sin, cos) = 0.7f64.sin_cos();
        let turn = |[x, y, z]: Direction| {
            let [x, y, z] = [cos * x - sin * z, y, sin * x + cos * z];
            [cos * x + sin * y, cos * y - sin * x, z]
        };
        let order = 10;
        let bands = |frame: &dyn Fn(Direction) -> Direction| -> Vec<f64> {
            let mut sum = vec![0f64; order * order];
            for (i, d) in directions(9).into_iter().enumerate() {
                sum.iter_mut().zip(at(order, frame(d))).for_each(|(s, y)| *s += (1.0 + i as f64 * 0.3) * y);
            }
            (0..order).map(|l| sum[l * l..(l + 1) * (l + 1)].iter().map(|c| c * c).sum()).collect()
        };
        for (l, (a, b)) in bands(&|d| d).into_iter().zip(bands(&turn)).enumerate() {
            assert!((a - b).abs() < 1e-10 * a.max(1.0), "band {l}: {a} {b}");
        }
        assert!((at(3, turn([1.0, 0.0, 0.0]))[3] - at(3, [1.0, 0.0, 0.0])[3]).abs() > 0.1, "the frame does turn");
    }

    #[test]
    fn orders_and_sizes_that_do_not_fit_are_refused() {
        assert!(Harmonics::new(0).is_err() && Harmonics::new(MAX_ORDER + 1).is_err());
        assert!(matches!(evaluate(3, [0.0, 0.0, 1.0], &mut [0.0; 8]), Err(Error::Shape { .. })));
    }
}
