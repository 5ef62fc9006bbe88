//! Integrals of spherical harmonics over texels.

use super::Harmonics;
use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::quadrature::{self, gauss_legendre};
use rayon::prelude::*;

/// Texels that one sum goes over; fixed, so that rounding does not depend on threads.
const BLOCK: usize = 1024;

/// Harmonics that are evaluated for the moments of a basis: seconds. No more than a quarter of it is needed where texels are about as long as
/// wide.
const MAX_EVALUATIONS: u64 = 1 << 32;

/// Gauss-Legendre quadrature over the texels of a basis.
struct Texels {
    harmonics: Harmonics,
    grid: quadrature::Texels,
    nodes: Vec<(f64, f64)>,
}

impl Texels {
    fn new(order: usize, basis: &LightBasis) -> Result<Texels> {
        let harmonics = Harmonics::new(order)?;
        let grid = quadrature::Texels::of(basis);
        let grid = grid.ok_or_else(|| crate::transform::wrong_basis("sh", "texels: cubemap or latlong", basis))?;
        // Enough for the highest harmonic and for the projection of the cube, whose nearest singularity is a face away:
        // checked against closed forms from one texel a face upward.
        let nodes = 4 + (grid.edge() * (order + 8) as f64).ceil() as usize;
        Ok(Texels { harmonics, grid, nodes: gauss_legendre(nodes) })
    }

    /// Harmonics that are evaluated for the moments of all texels.
    fn evaluations(&self, order: usize, basis: &LightBasis) -> u64 {
        [basis.lights(), order * order, self.nodes.len(), self.nodes.len()]
            .iter()
            .fold(1, |product, &n| product.saturating_mul(n as u64))
    }

    /// Adds ∫ Y_i dω over texel `k` to `out`; `y` is scratch, both order² long.
    fn add_moments(&self, k: usize, y: &mut [f64], out: &mut [f64]) {
        for (s, s_weight) in &self.nodes {
            for (t, t_weight) in &self.nodes {
                let (direction, density) = self.grid.point(k, 0.5 + 0.5 * s, 0.5 + 0.5 * t);
                self.harmonics.evaluate(direction, y);
                let weight = 0.25 * s_weight * t_weight * density;
                out.iter_mut().zip(&*y).for_each(|(out, y)| *out += weight * y);
            }
        }
    }
}

/// The integrals ∫ Y_i dω over every texel: lights x order², row by row, in sr.
///
/// Defined on cubemaps and latitude-longitude grids, by Gauss-Legendre quadrature (relative error below 1e-9).
///
/// # Errors
/// A basis without texels; one of long texels, as `latlong:1x16384`, on which the quadrature of high orders would take hours.
pub fn texel_moments(order: usize, basis: &LightBasis) -> Result<Vec<f32>> {
    let texels = Texels::new(order, basis)?;
    let found = texels.evaluations(order, basis);
    if found > MAX_EVALUATIONS {
        let what = format!("harmonics to evaluate for sh:order={order} on {basis}");
        return Err(Error::TooLarge { what, limit: MAX_EVALUATIONS, found });
    }
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
    use std::f64::consts::PI;

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
    fn texels_that_would_take_hours_are_refused_and_square_ones_are_not() {
        let refused = texel_moments(32, &"latlong:1x16384".parse().unwrap());
        assert!(matches!(refused, Err(Error::TooLarge { .. })));
        for (order, basis) in [(32, "cubemap:52"), (16, "latlong:256x256"), (1, "cubemap:1672"), (32, "latlong:64x32")]
        {
            let basis = basis.parse().unwrap();
            assert!(4 * Texels::new(order, &basis).unwrap().evaluations(order, &basis) <= MAX_EVALUATIONS);
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
