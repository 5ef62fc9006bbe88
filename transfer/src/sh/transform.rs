//! `sh`: the light transform onto spherical harmonics.

use super::moments::texel_moments;
use super::triangular::Lower;
use crate::basis::LightBasis;
use crate::codec::Configure;
use crate::error::{Error, Result};
use crate::flops::{Count, Flops, NoCount, Tally};
use crate::params::Params;
use crate::transform::{LightTransform, Transform, wrong_basis};
use ndarray::{ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

crate::params! {
    /// Spherical harmonics: the band-limited approximation of texels, best over the sphere.
    pub struct ShParams: "sh" {
        /// Bands, 1 to 32: order² coefficients.
        order: usize = 5,
    }
}

/// The largest order: beyond it the texels themselves are cheaper.
const MAX_TRANSFORM_ORDER: usize = 32;

/// Numbers that a bound transform may hold: 256 MiB of moments.
const MAX_MOMENTS: usize = 1 << 24;

/// The light transform from texels to spherical harmonics.
///
/// A row holds the moments T_k = ∫ f dω over texels. It is replaced by those of the nearest band-limited function: T̃_k
/// = Σ_i c_i B_ik with the moments `B_ik` = ∫ Y_i dω of the harmonics, and c minimising the error over the sphere Σ_k
/// (T_k - T̃_k)²/dω_k:
///
/// ```text
/// c = (B D⁻¹ Bᵀ)⁻¹ B D⁻¹ T,   D = diag(dω)
/// ```
///
/// The matrix in parentheses is the Gram matrix of the harmonics averaged over texels. It tends to the identity as
/// texels shrink; inverting it makes the projection exact on any grid: T̃ projects onto itself, and no other c is
/// nearer. A light's coefficients are B·x, which are exactly those of the light that is constant on each texel.
pub struct Sh(ShParams);

/// [`Sh`] on a grid of texels. The transform of a light takes lights · order² multiplications and as many additions.
pub struct BoundSh {
    order: usize,
    /// Bᵀ: lights x order².
    moments: Vec<f32>,
    /// 1/dω of each texel in 1/sr.
    inverse_angles: Vec<f64>,
    gram: Lower,
}

impl Configure for Sh {
    type Params = ShParams;
    fn new(params: ShParams) -> Result<Sh> {
        if !(1..=MAX_TRANSFORM_ORDER).contains(&params.order) {
            return Err(ShParams::refuse("order", params.order, format!("from 1 to {MAX_TRANSFORM_ORDER}")));
        }
        Ok(Sh(params))
    }
    fn params(&self) -> &ShParams {
        &self.0
    }
}

impl Transform for Sh {
    type Bound = BoundSh;
    fn bind(&self, basis: &LightBasis) -> Result<BoundSh> {
        let order = self.0.order;
        let too_coarse = || wrong_basis("sh", &format!("texels that tell {} harmonics apart", order * order), basis);
        let (limit, found) = (MAX_MOMENTS as u64, basis.lights() as u64 * (order * order) as u64);
        if found > limit {
            return Err(Error::TooLarge { what: format!("moments of sh:order={order} on {basis}"), limit, found });
        }
        let angles = basis.solid_angles().ok_or_else(|| wrong_basis("sh", "texels: cubemap or latlong", basis))?;
        if angles.len() < order * order {
            return Err(too_coarse());
        }
        let moments = texel_moments(order, basis)?;
        let inverse_angles: Vec<f64> = angles.into_iter().map(|a| 1.0 / a).collect();
        let gram = Lower::cholesky(gram(&moments, &inverse_angles, order * order), order * order);
        Ok(BoundSh { order, moments, inverse_angles, gram: gram.ok_or_else(too_coarse)? })
    }
}

/// B D⁻¹ Bᵀ, lower triangle, row by row.
fn gram(moments: &[f32], inverse_angles: &[f64], n: usize) -> Vec<f64> {
    let mut gram = vec![0f64; n * n];
    gram.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
        for (moments, inverse_angle) in moments.chunks(n).zip(inverse_angles) {
            axpy(&mut row[..=i], f64::from(moments[i]) * inverse_angle, &moments[..=i]);
        }
    });
    gram
}

/// `sum` += `factor` · `numbers`
fn axpy(sum: &mut [f64], factor: f64, numbers: &[f32]) {
    sum.iter_mut().zip(numbers).for_each(|(s, &n)| *s += factor * f64::from(n));
}

impl BoundSh {
    fn coefficients(&self) -> usize {
        self.order * self.order
    }

    /// B·x of one channel.
    fn project<C: Count>(&self, light: impl Iterator<Item = f32>, count: &mut C) -> Vec<f64> {
        let mut sum = vec![0f64; self.coefficients()];
        for (x, moments) in light.zip(self.moments.chunks(self.coefficients())) {
            axpy(&mut sum, x.into(), moments);
            count.multiply_add(moments.len());
        }
        sum
    }
}

impl LightTransform for BoundSh {
    fn output(&self) -> LightBasis {
        LightBasis::SphericalHarmonics { order: self.order }
    }

    fn row_into(&self, row: &[f32], out: &mut [f32]) {
        let mut c = vec![0f64; self.coefficients()];
        for (k, &t) in row.iter().enumerate().filter(|(_, t)| **t != 0.0) {
            axpy(&mut c, f64::from(t) * self.inverse_angles[k], &self.moments[k * self.coefficients()..][..out.len()]);
        }
        self.gram.solve(&mut c);
        out.iter_mut().zip(c).for_each(|(out, c)| *out = c as f32);
    }

    fn restore_row_into(&self, coefficients: &[f32], out: &mut [f32]) {
        for (out, moments) in out.iter_mut().zip(self.moments.chunks(self.coefficients())) {
            let sum: f64 = coefficients.iter().zip(moments).map(|(c, m)| f64::from(*c) * f64::from(*m)).sum();
            *out = sum as f32;
        }
    }

    fn light_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        for (light, mut out) in lights.columns().into_iter().zip(out.columns_mut()) {
            let coefficients = self.project(light.iter().copied(), &mut NoCount);
            out.iter_mut().zip(coefficients).for_each(|(out, c)| *out = c as f32);
        }
    }

    fn derived_bytes(&self) -> usize {
        let BoundSh { moments, inverse_angles, gram, .. } = self;
        size_of_val(&moments[..]) + size_of_val(&inverse_angles[..]) + gram.bytes()
    }

    fn flops(&self, light: &[f32]) -> Flops {
        let mut tally = Tally::default();
        self.project(light.iter().copied(), &mut tally);
        tally.0
    }
}
