//! A BRDF as a matrix between harmonics of two hemispheres.

use crate::scene::brdf::Brdf;
use crate::scene::separable::Views;
use crate::scene::separable::factor::norm;
use crate::scene::separable::kernel::{Kernel, Moments, Resolution};
use crate::sh::HemisphereSh;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// An orthonormal function on the hemisphere, f(z) cos mφ or f(z) sin mφ.
struct Function {
    order: usize,
    sine: bool,
    /// Place of the cosine that has the same f.
    cosine: usize,
}

/// `Q_ij = ∫∫ q_i(v) q_j(s) ρ(v,s) s_z ds dv`, exit x incident, q orthonormal on the hemisphere: to 1e-3 of a white
/// surface down to the narrowest lobes.
pub(super) fn reflection(brdf: &Brdf, exit: &HemisphereSh, incident: &HemisphereSh) -> Vec<f64> {
    let bands = exit.order().max(incident.order());
    let rings = ((8.0 / brdf.width()) as usize).clamp(64, 400);
    // The functions alone are integrated exactly by so many views in a quarter turn.
    let exact = bands / 2 + 1;
    let sectors = if brdf.is_isotropic() { exact } else { ((4.0 / brdf.width()) as usize).clamp(24, 96) };
    let kernel = Kernel::new(brdf, Views::SolidAngle, Resolution { rings, orders: bands, sectors });
    let (rows, columns) = (functions(exit), functions(incident));
    let [of_exit, of_incident] = [exit, incident].map(|sh| radial(sh, &kernel));
    let ring = |i: usize| {
        let view = kernel.rings[i];
        let (mut product, mut moments) = (vec![0f64; rows.len() * columns.len()], Vec::new());
        for sector in 0..sectors {
            let phi = FRAC_PI_2 * (sector as f64 + 0.5) / sectors as f64;
            if sector == 0 || !brdf.is_isotropic() {
                moments = kernel.rings.iter().map(|light| at(&kernel, view.z, phi, light.z, bands)).collect::<Vec<_>>();
            }
            let turn = |f: &Function| (f.order as f64 * phi).sin_cos();
            let reflected: Vec<f64> = (columns.iter())
                .map(|f| {
                    let along = |(j, moments): (usize, &Moments)| {
                        let light = kernel.rings[j];
                        light.light * light.z * of_incident[j][f.cosine] * moments.of(f.sine, f.order, turn(f))
                    };
                    norm(f.order) * moments.iter().enumerate().map(along).sum::<f64>()
                })
                .collect();
            // By symmetry in x and in y a quarter turn stands for all four, and functions of unequal parity do not mix.
            let weight = 4.0 * FRAC_PI_2 / sectors as f64 * view.view;
            for (f, row) in rows.iter().zip(product.chunks_exact_mut(columns.len())) {
                let (sin, cos) = turn(f);
                let q = weight * of_exit[i][f.cosine] * if f.sine { sin } else { cos };
                let same = row.iter_mut().zip(&columns).zip(&reflected).filter(|((_, g), _)| f.parity() == g.parity());
                same.for_each(|((t, _), r)| *t += q * r);
            }
        }
        product
    };
    let mut sum = vec![0f64; rows.len() * columns.len()];
    for batch in (0..rings).collect::<Vec<_>>().chunks(64) {
        let products: Vec<Vec<f64>> = batch.par_iter().map(|&i| ring(i)).collect();
        products.iter().for_each(|product| sum.iter_mut().zip(product).for_each(|(s, p)| *s += p));
    }
    sum
}

impl Function {
    /// Whether it changes its sign with x, and with y: cos mφ under φ → π - φ and under φ → -φ; sin the other way
    /// round.
    fn parity(&self) -> (bool, bool) {
        (self.order.is_multiple_of(2) == self.sine, self.sine)
    }
}

fn functions(sh: &HemisphereSh) -> Vec<Function> {
    let band_and_m = |k: usize| (k.isqrt(), k as i64 - (k.isqrt() * k.isqrt() + k.isqrt()) as i64);
    let place = |k: usize| sh.indices().iter().position(|&other| other == k);
    (sh.indices().iter())
        .map(|&k| {
            let (l, m) = band_and_m(k);
            let cosine = place(l * l + l + m.unsigned_abs() as usize).expect("l, |m| is there wherever l, -|m| is");
            Function { order: m.unsigned_abs() as usize, sine: m < 0, cosine }
        })
        .collect()
}

/// Values at azimuth 0, where every cosine is 1, of each ring.
fn radial(sh: &HemisphereSh, kernel: &Kernel) -> Vec<Vec<f64>> {
    let of_ring = |z: f64| {
        let mut q = vec![0f64; sh.coefficients()];
        sh.evaluate_orthonormal(DVec3::new((1.0 - z * z).sqrt(), 0.0, z).to_array(), &mut q);
        q
    };
    kernel.rings.iter().map(|ring| of_ring(ring.z)).collect()
}

fn at(kernel: &Kernel, view: f64, phi: f64, light: f64, bands: usize) -> Moments {
    let mut moments = Moments::new(bands);
    kernel.moments(view, (phi.cos(), phi.sin()), light, &mut moments);
    moments
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under radiance 1 from everywhere the surface sends out its albedo, which every model computes in its own way.
    #[test]
    fn what_a_white_sky_becomes_is_the_albedo_of_the_model() {
        let sh = HemisphereSh::new(24).unwrap();
        for (brdf, tolerance) in [
            ("lambert:albedo=0.6", 1e-4),
            ("phong:exponent=5", 2e-3),
            ("phong:exponent=10000", 2e-3),
            ("cook-torrance:roughness=0.3:f0=1", 2e-3),
            ("cook-torrance:roughness=0.05", 2e-3),
            ("cook-torrance:roughness=0.01:f0=0.5:diffuse=0.3:specular=0.7", 2e-3),
            ("ward", 2e-3),
            ("ward:alpha_x=0.03:alpha_y=0.3", 2e-3),
        ] {
            let brdf: Brdf = brdf.parse().unwrap();
            let found = reflection(&brdf, &sh, &sh);
            // 1 = √2π q_0, and radiance towards v is the albedo of v.
            let n = 400;
            let mut expected = [0f64; 24];
            for k in 0..n {
                let t = (k as f64 + 0.5) / n as f64;
                let (z, weight) = (t * t, 2.0 * t / n as f64);
                for a in 0..3 {
                    let phi = FRAC_PI_2 * (f64::from(a) + 0.5) / 3.0;
                    let v = DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z);
                    let mut q = vec![0f64; 24];
                    sh.evaluate_orthonormal(v.to_array(), &mut q);
                    // By symmetry a quarter turn stands for all four.
                    let share = weight * 4.0 * FRAC_PI_2 / 3.0 * brdf.albedo(v);
                    expected.iter_mut().zip(q).for_each(|(e, q)| *e += share * q);
                }
            }
            let white = (4.0 * FRAC_PI_2).sqrt();
            let difference = |i: usize| found[i * 24] * white - expected[i];
            // The azimuths above are few: only functions without one are integrated well where the model is
            // anisotropic.
            let error = sh.indices().iter().enumerate().filter(|(_, k)| [0, 2, 6, 12, 20].contains(*k));
            let error = error.map(|(i, _)| difference(i).powi(2)).sum::<f64>().sqrt();
            assert!(error < tolerance * expected[0], "{brdf}: {error} of {}", expected[0]);
        }
    }
}
