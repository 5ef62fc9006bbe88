//! Importance sampling of a light of lobes.

use crate::kernel::Kernel;
use crate::light::ScatteredLight;
use crate::lobe::{Lobe, normalised};
use prt_transfer::LightBasis;
use prt_transfer::basis::Direction;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The least share of uniform directions, so that no direction with light has a density near 0.
const UNIFORM: f64 = 0.02;

/// Steps of expectation maximisation; the cross-entropy has long settled.
const STEPS: usize = 40;

/// Texels along an edge of the cubemap on which the mixture is matched to the light.
const RESOLUTION: usize = 32;

/// Draws directions with a density close to a light's radiance.
///
/// The density is a mixture of the light's lobes, each one normalised, and of the uniform one. A lobe may have negative coefficients, so
/// its share is not its flux: shares are those of the least cross-entropy from the positive part of the light, all channels together, by
/// expectation maximisation over the texels of a cubemap. Lobes that only take light away end with a share of 0.
#[derive(Clone, Debug)]
pub struct Sampler {
    kernel: Kernel,
    lobes: Vec<Lobe>,
    /// Of each lobe; what they leave of 1 is uniform.
    shares: Vec<f64>,
    /// Sums of the shares up to each lobe.
    sums: Vec<f64>,
}

impl Sampler {
    /// Shares for a light. One without positive radiance is sampled uniformly.
    pub fn new(light: &ScatteredLight) -> Sampler {
        let basis = LightBasis::Cubemap { resolution: RESOLUTION };
        let (kernel, lobes) = (light.kernel(), light.lobes().to_vec());
        let directions = basis.directions().unwrap_or_default();
        let angles = basis.solid_angles().unwrap_or_default();
        let positive = |d: &Direction| light.radiance(*d).iter().map(|v| v.max(0.0)).sum::<f64>();
        let mut weights: Vec<f64> = directions.par_iter().map(positive).collect();
        weights.iter_mut().zip(angles).for_each(|(w, a)| *w *= a);
        let all: f64 = weights.iter().sum();
        let mut sampler = Sampler { kernel, shares: vec![0.0; lobes.len()], sums: Vec::new(), lobes };
        if all > 0.0 {
            weights.iter_mut().for_each(|w| *w /= all);
            sampler.match_to(&directions, &weights);
        }
        sampler.sums = sampler
            .shares
            .iter()
            .scan(0.0, |sum, share| {
                *sum += share;
                Some(*sum)
            })
            .collect();
        sampler
    }

    /// Shares of the least cross-entropy from weights that add up to 1.
    fn match_to(&mut self, directions: &[Direction], weights: &[f64]) {
        let n = self.lobes.len();
        let densities: Vec<f64> = directions.par_iter().flat_map_iter(|d| self.densities(*d)).collect();
        self.shares.fill((1.0 - UNIFORM) / n.max(1) as f64);
        for _ in 0..STEPS {
            let mut next = vec![0.0; n];
            for (row, weight) in densities.chunks(n.max(1)).zip(weights).filter(|(_, w)| **w > 0.0) {
                let scale = weight / self.mixed(row);
                next.iter_mut().zip(&self.shares).zip(row).for_each(|((sum, share), g)| *sum += scale * share * g);
            }
            self.shares = next;
            let sum: f64 = self.shares.iter().sum();
            if sum > 1.0 - UNIFORM {
                self.shares.iter_mut().for_each(|s| *s *= (1.0 - UNIFORM) / sum);
            }
        }
    }

    /// Density of every lobe in a direction.
    fn densities(&self, direction: Direction) -> impl Iterator<Item = f64> {
        let of = move |lobe: &Lobe| {
            self.kernel.value(lobe.cosine(direction), lobe.bandwidth) / self.kernel.integral(lobe.bandwidth)
        };
        self.lobes.iter().map(of)
    }

    fn mixed(&self, densities: &[f64]) -> f64 {
        let uniform = 1.0 - self.shares.iter().sum::<f64>();
        uniform / (4.0 * PI) + self.shares.iter().zip(densities).map(|(share, g)| share * g).sum::<f64>()
    }

    /// The density of a unit direction, 1/sr.
    pub fn density(&self, direction: Direction) -> f64 {
        self.mixed(&self.densities(direction).collect::<Vec<_>>())
    }

    /// A direction from three uniform numbers in [0, 1): the first one chooses the lobe, the others the direction in it.
    pub fn direction(&self, [choice, u, v]: [f64; 3]) -> Direction {
        let chosen = self.sums.partition_point(|sum| *sum <= choice);
        let phi = 2.0 * PI * v;
        let Some(lobe) = self.lobes.get(chosen) else {
            let z = 1.0 - 2.0 * u;
            let sine = (1.0 - z * z).max(0.0).sqrt();
            return [sine * phi.cos(), sine * phi.sin(), z];
        };
        let fall = self.fall(u, lobe.bandwidth).clamp(0.0, 2.0);
        // sin² = (1 - μ)(1 + μ), which keeps the smallest angles.
        let sine = (fall * (2.0 - fall)).sqrt();
        let [a, b] = lobe.tangents();
        normalised([0, 1, 2].map(|i| (1.0 - fall) * lobe.centre[i] + sine * (phi.cos() * a[i] + phi.sin() * b[i])))
    }

    /// 1 - μ at which a normalised kernel's distribution from the centre outwards reaches `u`.
    fn fall(&self, u: f64, bandwidth: f64) -> f64 {
        match self.kernel {
            // 1 - u (1 - e^-2λ) = e^(-λ (1 - μ))
            Kernel::Gaussian => -(u * (-2.0 * bandwidth).exp_m1()).ln_1p() / bandwidth,
            // The phase function of Henyey and Greenstein 1941, counted from the centre.
            Kernel::AbelPoisson => {
                let g = bandwidth;
                let root = (1.0 - g) * (1.0 + g) / (1.0 + g - 2.0 * g * u);
                (root - (1.0 - g)) * (root + (1.0 - g)) / (2.0 * g)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;
    use prt_transfer::random::Random;

    fn lights() -> Vec<ScatteredLight> {
        let lobe = |centre: Direction, bandwidth| Lobe { centre: normalised(centre), bandwidth };
        let centres = [[0.3, -0.5, 0.8], [-0.6, 0.2, -0.7], [0.25, -0.5, 0.85]];
        let light = |kernel, bandwidths: [f64; 3]| {
            let lobes = centres.iter().zip(bandwidths).map(|(c, b)| lobe(*c, b)).collect();
            // The third lobe takes light away from the first.
            ScatteredLight::new(kernel, lobes, array![[3.0, 2.0], [0.5, 1.0], [-0.6, -0.1]]).unwrap()
        };
        vec![light(Kernel::Gaussian, [40.0, 3.0, 90.0]), light(Kernel::AbelPoisson, [0.8, 0.3, 0.9])]
    }

    fn draws(count: usize) -> impl Iterator<Item = [f64; 3]> {
        let mut random = Random(5);
        (0..count).map(move |_| [0; 3].map(|_| random.uniform()))
    }

    #[test]
    fn draws_have_the_density_that_is_told() {
        for light in lights() {
            let sampler = Sampler::new(&light);
            // Cells of equal solid angle: bands of z times sectors.
            let (bands, sectors, fine, count) = (12, 12, 24, 200_000);
            let mut seen = vec![0f64; bands * sectors];
            for u in draws(count) {
                let [x, y, z] = sampler.direction(u);
                let band = ((z + 1.0) / 2.0 * bands as f64).clamp(0.0, bands as f64 - 1.0) as usize;
                let turn = y.atan2(x) / (2.0 * PI) + 0.5;
                seen[band * sectors + (turn * sectors as f64).clamp(0.0, sectors as f64 - 1.0) as usize] += 1.0;
            }
            let (mut chi, mut total) = (0.0, 0.0);
            for (cell, seen) in seen.iter().enumerate() {
                let mut expected = 0.0;
                for i in 0..fine * fine {
                    let z =
                        -1.0 + 2.0 * ((cell / sectors) as f64 + (0.5 + (i / fine) as f64) / fine as f64) / bands as f64;
                    let turn = ((cell % sectors) as f64 + (0.5 + (i % fine) as f64) / fine as f64) / sectors as f64;
                    let (sine, phi) = ((1.0 - z * z).sqrt(), 2.0 * PI * (turn - 0.5));
                    let area = 4.0 * PI / (bands * sectors * fine * fine) as f64;
                    expected += area * sampler.density([sine * phi.cos(), sine * phi.sin(), z]);
                }
                total += expected;
                chi += (seen - expected * count as f64).powi(2) / (expected * count as f64);
            }
            assert!((total - 1.0).abs() < 2e-3, "{total}");
            // χ² of 143 degrees of freedom: mean 143, standard deviation 17.
            assert!(chi < 143.0 + 6.0 * 17.0, "{:?}: {chi}", light.kernel());
        }
    }

    #[test]
    fn estimates_are_right_and_far_less_noisy_than_uniform_ones() {
        for light in lights() {
            let (sampler, count) = (Sampler::new(&light), 20_000);
            let value = |d: Direction| light.radiance(d).iter().sum::<f64>();
            let moments = |terms: Vec<f64>| {
                let mean = terms.iter().sum::<f64>() / count as f64;
                (mean, terms.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / count as f64)
            };
            let drawn =
                moments(draws(count).map(|u| sampler.direction(u)).map(|d| value(d) / sampler.density(d)).collect());
            let uniform =
                Sampler::new(&ScatteredLight::new(light.kernel(), Vec::new(), ndarray::Array2::zeros((0, 2))).unwrap());
            let even =
                moments(draws(count).map(|u| uniform.direction(u)).map(|d| value(d) / uniform.density(d)).collect());
            let exact: f64 = light.flux().iter().sum();
            assert!((drawn.0 - exact).abs() < 5.0 * (drawn.1 / count as f64).sqrt(), "{} {exact}", drawn.0);
            assert!((even.0 - exact).abs() < 5.0 * (even.1 / count as f64).sqrt(), "{} {exact}", even.0);
            assert!(drawn.1 < even.1 / 20.0, "{:?}: {} {}", light.kernel(), drawn.1, even.1);
        }
    }
}
