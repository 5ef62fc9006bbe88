//! Kernels: functions of the angle to a centre, with one bandwidth (Tsai and Shih 2006, Eqs. 3 and 4).
//!
//! `μ` is the cosine of that angle throughout. Both kernels are positive definite: their Legendre coefficients are positive, so that
//! lobes of distinct centres are linearly independent.

use crate::{exponential, legendre};
use prt_transfer::basis::Direction;
use std::f64::consts::PI;

prt_transfer::choices! {
    /// A function of the angle to a centre.
    pub enum Kernel {
        /// e^(λ (μ - 1)), λ > 0: 1 at its centre, of standard deviation about 1/√λ rad where λ is large. Up to scale it is the von
        /// Mises-Fisher density.
        Gaussian = "gaussian",
        /// (1 - λ²) / (1 - 2λμ + λ²)^(3/2), 0 < λ < 1: the Poisson kernel, of integral 4π; a peak of half-width about 1 - λ rad
        /// with a tail that falls with the cube of the angle.
        AbelPoisson = "abel-poisson",
    }
}

impl Kernel {
    /// The bandwidths that are accepted: 0.01 to 1e5 for a Gaussian, 0.01 to 0.9999 for an Abel-Poisson kernel.
    pub fn bandwidths(self) -> [f64; 2] {
        match self {
            Kernel::Gaussian => [0.01, 1e5],
            Kernel::AbelPoisson => [0.01, 0.9999],
        }
    }

    /// The kernel at cosine `mu`.
    pub fn value(self, mu: f64, bandwidth: f64) -> f64 {
        match self {
            Kernel::Gaussian => (bandwidth * (mu - 1.0)).exp(),
            Kernel::AbelPoisson => (1.0 - bandwidth) * (1.0 + bandwidth) * distance(mu, bandwidth).powf(-1.5),
        }
    }

    /// Replaces every cosine by the kernel there.
    pub fn values(self, cosines: &mut [f64], bandwidth: f64) {
        match self {
            Kernel::Gaussian => exponential::gaussian(cosines, bandwidth),
            Kernel::AbelPoisson => cosines.iter_mut().for_each(|mu| *mu = self.value(*mu, bandwidth)),
        }
    }

    /// ∂G/∂μ: the gradient in the centre ξ is that times the direction η (less its part along ξ, which does not move the lobe).
    pub fn slope(self, mu: f64, bandwidth: f64) -> f64 {
        self.value(mu, bandwidth) * self.logarithmic_slopes(mu, bandwidth)[0]
    }

    /// ∂G/∂λ.
    pub fn bandwidth_slope(self, mu: f64, bandwidth: f64) -> f64 {
        self.value(mu, bandwidth) * self.logarithmic_slopes(mu, bandwidth)[1]
    }

    /// ∂ ln G/∂μ and ∂ ln G/∂λ.
    pub fn logarithmic_slopes(self, mu: f64, bandwidth: f64) -> [f64; 2] {
        match self {
            Kernel::Gaussian => [bandwidth, mu - 1.0],
            Kernel::AbelPoisson => {
                let threefold = 3.0 / distance(mu, bandwidth);
                let squares = (1.0 - bandwidth) * (1.0 + bandwidth);
                [bandwidth * threefold, (mu - bandwidth) * threefold - 2.0 * bandwidth / squares]
            }
        }
    }

    /// G_0 to G_(`count` - 1) of G(μ) = Σ G_l P_l(μ) (Eq. 1): (2l+1) e^(-λ) i_l(λ) with the modified spherical Bessel functions, or
    /// (2l+1) λ^l.
    pub fn legendre(self, bandwidth: f64, count: usize) -> Vec<f64> {
        match self {
            Kernel::Gaussian => legendre::gaussian(bandwidth, count),
            Kernel::AbelPoisson => (0..count).map(|l| (2 * l + 1) as f64 * bandwidth.powi(l as i32)).collect(),
        }
    }

    /// ∫ G dω over the sphere.
    pub fn integral(self, bandwidth: f64) -> f64 {
        match self {
            Kernel::Gaussian => 2.0 * PI * -(-2.0 * bandwidth).exp_m1() / bandwidth,
            Kernel::AbelPoisson => 4.0 * PI,
        }
    }

    /// ∫ G_g G_h dω of two lobes (the spherical singular integral, Eqs. 5 and 6), of unit centres and bandwidths.
    ///
    /// For Gaussians, with r = |λ_g ξ_g + λ_h ξ_h|, it is 4π e^(-λ_g - λ_h) sinh(r)/r, evaluated without overflow or cancellation:
    /// `2π e^(-δ) (1 - e^(-2r))/r`, δ = λ_g + λ_h - r = λ_g λ_h |ξ_g - ξ_h|² / (λ_g + λ_h + r). For Abel-Poisson kernels it is 4π
    /// G(μ; λ_g λ_h).
    pub fn inner_product(self, [a, b]: [Direction; 2], [g, h]: [f64; 2]) -> f64 {
        let chord = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
        match self {
            Kernel::Gaussian => {
                let r = (0..3).map(|i| (g * a[i] + h * b[i]).powi(2)).sum::<f64>().sqrt();
                let delta = g * h * chord / (g + h + r);
                let quotient = if r == 0.0 { 2.0 } else { -(-2.0 * r).exp_m1() / r };
                2.0 * PI * (-delta).exp() * quotient
            }
            Kernel::AbelPoisson => 4.0 * PI * self.value(1.0 - 0.5 * chord, g * h),
        }
    }

    /// (∫ G² dω)^½.
    pub fn norm(self, bandwidth: f64) -> f64 {
        self.square(bandwidth).sqrt()
    }

    fn square(self, bandwidth: f64) -> f64 {
        match self {
            Kernel::Gaussian => self.integral(2.0 * bandwidth),
            Kernel::AbelPoisson => self.inner_product([[0.0, 0.0, 1.0]; 2], [bandwidth; 2]),
        }
    }

    /// d ln(norm)/dλ.
    pub fn norm_slope(self, bandwidth: f64) -> f64 {
        let l = bandwidth;
        match self {
            // ½ d/dλ [ln(1 - e^(-4λ)) - ln λ]; 2e^(-4λ)/(1 - e^(-4λ)) = 2/(e^(4λ) - 1).
            Kernel::Gaussian => 2.0 / (4.0 * l).exp_m1() - 0.5 / l,
            // ‖G‖² = 4π (1 + λ²)/(1 - λ²)².
            Kernel::AbelPoisson => l / (1.0 + l * l) + 2.0 * l / ((1.0 - l) * (1.0 + l)),
        }
    }

    /// The standard deviation in rad of a lobe's square about its centre (Freeden and Windheuser 1997): (|m|^-2 - 1)^½ with the mean
    /// m of the direction under the density G²/∫G², for which |m| = coth 2λ - 1/2λ, or 2λ/(1 + λ²).
    pub fn spread(self, bandwidth: f64) -> f64 {
        let mean = match self {
            Kernel::Gaussian => langevin(2.0 * bandwidth),
            Kernel::AbelPoisson => 2.0 * bandwidth / (1.0 + bandwidth * bandwidth),
        };
        ((1.0 - mean) * (1.0 + mean)).sqrt() / mean
    }

    /// The bandwidth of a [`Kernel::spread`] in rad; the nearest accepted one where there is none.
    pub fn bandwidth_of_spread(self, spread: f64) -> f64 {
        let [low, high] = self.bandwidths();
        let (mut low, mut high) = (self.coordinate(low), self.coordinate(high));
        // The spread falls with the bandwidth; halving a range of at most 17 to rounding takes 60 steps.
        for _ in 0..60 {
            let middle = low.midpoint(high);
            *if self.spread(self.bandwidth_at(middle)) > spread { &mut low } else { &mut high } = middle;
        }
        self.bandwidth_at(low.midpoint(high))
    }

    /// A coordinate of bandwidths in which a step means the same change of width everywhere: ln λ, or -2 ln(1 - λ).
    pub fn coordinate(self, bandwidth: f64) -> f64 {
        match self {
            Kernel::Gaussian => bandwidth.ln(),
            Kernel::AbelPoisson => -2.0 * (-bandwidth).ln_1p(),
        }
    }

    /// The bandwidth at a coordinate.
    pub fn bandwidth_at(self, coordinate: f64) -> f64 {
        match self {
            Kernel::Gaussian => coordinate.exp(),
            Kernel::AbelPoisson => -(-0.5 * coordinate).exp_m1(),
        }
    }

    /// dλ / d coordinate.
    pub fn coordinate_slope(self, bandwidth: f64) -> f64 {
        match self {
            Kernel::Gaussian => bandwidth,
            Kernel::AbelPoisson => 0.5 * (1.0 - bandwidth),
        }
    }
}

/// 1 - 2λμ + λ², without cancellation where λ and μ are near 1.
fn distance(mu: f64, bandwidth: f64) -> f64 {
    (1.0 - bandwidth).powi(2) + 2.0 * bandwidth * (1.0 - mu)
}

/// coth x - 1/x.
fn langevin(x: f64) -> f64 {
    if x < 0.1 {
        // The series' next term is 2 x⁹/93555: below 1e-12 of the sum, as is what the difference loses above.
        let square = x * x;
        return x * (1.0 / 3.0 - square * (1.0 / 45.0 - square * (2.0 / 945.0 - square / 4725.0)));
    }
    1.0 / x.tanh() - 1.0 / x
}

#[cfg(test)]
mod tests;
