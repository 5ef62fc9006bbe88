//! Integrals of spherical harmonics over texels.

use super::Harmonics;
use crate::basis::{Direction, LightBasis, cubemap_direction, latlong_direction};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Texels that one sum goes over; fixed, so that rounding does not depend on threads.
const BLOCK: usize = 1024;

/// Gauss-Legendre quadrature over the texels of a basis.
struct Texels {
    harmonics: Harmonics,
    basis: LightBasis,
    nodes: Vec<(f64, f64)>,
}

/// Nodes in (-1, 1) and weights with which polynomials of degree 2n-1 are integrated exactly.
pub(crate) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            // Newton's method on P_n, from Tricomi's approximation of its roots.
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut before, mut p) = (0.0, 1.0);
                for k in 0..n {
                    (before, p) = (p, ((2 * k + 1) as f64 * x * p - k as f64 * before) / (k + 1) as f64);
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

impl Texels {
    fn new(order: usize, basis: &LightBasis) -> Result<Texels> {
        let harmonics = Harmonics::new(order)?;
        // The angle of a texel's edge, in radians.
        let edge = match *basis {
            LightBasis::Cubemap { resolution } if resolution > 0 => 0.5 * PI / resolution as f64,
            LightBasis::LatLong { width, height } if width > 0 && height > 0 => {
                (2.0 * PI / width as f64).max(PI / height as f64)
            }
            _ => {
                return Err(crate::transform::wrong_basis("sh", "texels: cubemap or latlong", basis));
            }
        };
        // Enough for the highest harmonic and for the projection of the cube, whose nearest singularity is a face away:
        // checked against closed forms from one texel a face upward.
        let nodes = 4 + (edge * (order + 8) as f64).ceil() as usize;
        Ok(Texels { harmonics, basis: basis.clone(), nodes: gauss_legendre(nodes) })
    }

    /// Adds ∫ Y_i dω over texel `k` to `out`; `y` is scratch, both order² long.
    fn add_moments(&self, k: usize, y: &mut [f64], out: &mut [f64]) {
        for (s, s_weight) in &self.nodes {
            for (t, t_weight) in &self.nodes {
                let (direction, density) = self.sample(k, 0.5 + 0.5 * s, 0.5 + 0.5 * t);
                self.harmonics.evaluate(direction, y);
                let weight = 0.25 * s_weight * t_weight * density;
                out.iter_mut().zip(&*y).for_each(|(out, y)| *out += weight * y);
            }
        }
    }

    /// The direction at a place in [0, 1]² of texel `k`, and the solid angle per area of that square.
    fn sample(&self, k: usize, s: f64, t: f64) -> (Direction, f64) {
        match self.basis {
            LightBasis::Cubemap { resolution: r } => {
                let edge = 2.0 / r as f64;
                let (u, v) = (edge * ((k % r) as f64 + s) - 1.0, edge * ((k / r % r) as f64 + t) - 1.0);
                (cubemap_direction(k / (r * r), u, v), edge * edge * (1.0 + u * u + v * v).powf(-1.5))
            }
            LightBasis::LatLong { width, height } => {
                let (s, t) = (((k % width) as f64 + s) / width as f64, ((k / width) as f64 + t) / height as f64);
                let cell = 2.0 * PI * PI / (width * height) as f64;
                (latlong_direction(s, t), cell * (PI * t).sin())
            }
            // `new` lets no other basis in.
            _ => ([0.0, 0.0, 1.0], 0.0),
        }
    }
}

/// The integrals ∫ Y_i dω over every texel: lights x order², row by row, in sr.
///
/// Defined on cubemaps and latitude-longitude grids, by Gauss-Legendre quadrature (relative error below 1e-9).
pub fn texel_moments(order: usize, basis: &LightBasis) -> Result<Vec<f32>> {
    let texels = Texels::new(order, basis)?;
    let n = order * order;
    let mut moments = vec![0f32; basis.lights() * n];
    moments.par_chunks_mut(n).enumerate().for_each_init(
        || (vec![0f64; n], vec![0f64; n]),
        |(y, sum), (k, out)| {
            sum.fill(0.0);
            texels.add_moments(k, y, sum);
            out.iter_mut().zip(sum).for_each(|(out, s)| *out = *s as f32);
        },
    );
    Ok(moments)
}

/// Coefficients Σ_k values_k ∫ Y_i dω of a function that is constant on each texel: the orthogonal projection of, say,
/// a light onto the harmonics. `values.len()` = lights of `basis`; the result has order² numbers.
pub fn project(order: usize, basis: &LightBasis, values: &[f32]) -> Result<Vec<f64>> {
    Error::expect_size(format!("values on {basis}"), basis.lights(), values.len())?;
    let texels = Texels::new(order, basis)?;
    let n = order * order;
    let sums: Vec<Vec<f64>> = values
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, values)| {
            let (mut y, mut moments, mut sum) = (vec![0f64; n], vec![0f64; n], vec![0f64; n]);
            for (i, &value) in values.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                moments.fill(0.0);
                texels.add_moments(block * BLOCK + i, &mut y, &mut moments);
                sum.iter_mut().zip(&moments).for_each(|(s, m)| *s += f64::from(value) * m);
            }
            sum
        })
        .collect();
    let mut all = vec![0f64; n];
    sums.into_iter().for_each(|sum| all.iter_mut().zip(sum).for_each(|(a, s)| *a += s));
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_integrates_polynomials_exactly() {
        for n in 1..40 {
            let nodes = gauss_legendre(n);
            for degree in 0..2 * n {
                let sum: f64 = nodes.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree + 1) as f64 } else { 0.0 };
                assert!((sum - exact).abs() < 1e-13, "{n} nodes, degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn moments_of_a_texel_are_its_solid_angle_and_sum_to_those_of_the_sphere() {
        for basis in ["cubemap:1", "cubemap:2", "cubemap:8", "latlong:8x4", "latlong:3x2", "latlong:1x1"] {
            let basis: LightBasis = basis.parse().unwrap();
            let (order, angles) = (10, basis.solid_angles().unwrap());
            let texels = Texels::new(order, &basis).unwrap();
            let (mut y, mut all) = (vec![0.0; 100], vec![0.0; 100]);
            for (k, angle) in angles.iter().enumerate() {
                let mut moments = vec![0.0; 100];
                texels.add_moments(k, &mut y, &mut moments);
                let expected = angle * (0.25 / PI).sqrt();
                assert!((moments[0] / expected - 1.0).abs() < 1e-9, "{basis}: {} {expected}", moments[0]);
                all.iter_mut().zip(moments).for_each(|(a, m)| *a += m);
            }
            for (i, sum) in all.iter().enumerate() {
                let expected = if i == 0 { (4.0 * PI).sqrt() } else { 0.0 };
                assert!((sum - expected).abs() < 1e-9, "{basis} coefficient {i}: {sum}");
            }
        }
    }

    #[test]
    fn projecting_is_multiplying_with_the_moments() {
        let basis = LightBasis::Cubemap { resolution: 16 };
        let values: Vec<f32> = (0..basis.lights()).map(|k| (k % 7) as f32).collect();
        let moments = texel_moments(4, &basis).unwrap();
        for (i, c) in project(4, &basis, &values).unwrap().into_iter().enumerate() {
            let sum: f64 = values.iter().zip(moments.chunks(16)).map(|(v, m)| f64::from(*v) * f64::from(m[i])).sum();
            assert!((sum - c).abs() < 1e-5, "{i}: {sum} {c}");
        }
        assert!(matches!(project(4, &basis, &values[1..]), Err(Error::Shape { .. })));
        assert!(project(4, &LightBasis::Plain { lights: 2 }, &[1.0, 2.0]).is_err());
    }
}
