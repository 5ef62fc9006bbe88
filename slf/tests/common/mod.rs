//! Light fields that tests compress.
#![allow(dead_code)]

use prt_slf::{EncodedSlf, Slf, SlfParams, Sphere};
use prt_transfer::responses::Directions;
use prt_transfer::texels::{Border, Texels};
use prt_transfer::{Codec, Configure, Encoded, LightBasis, Quiet, ResponseBasis, TransferMatrix};

/// A matrix of texels x 3 x sphere.
pub(crate) fn field(
    texels: Texels,
    sphere: Sphere,
    radiance: impl Fn([f64; 2], [f64; 3], usize) -> f64,
) -> TransferMatrix {
    let directions = sphere.centres().into_iter().map(|d| d.map(f64::from)).collect::<Vec<_>>();
    let mut values = Vec::new();
    for texel in 0..texels.count() {
        for channel in 0..3 {
            values.extend(directions.iter().map(|&d| radiance(texels.centre(texel), d, channel) as f32));
        }
    }
    let basis = LightBasis::LatLong { width: sphere.z, height: sphere.w };
    let matrix = TransferMatrix::from_dense(values, 3 * texels.count(), 3, basis).unwrap();
    matrix.with_responses(ResponseBasis::Radiance { texels, directions: Directions::World }).unwrap()
}

/// Smooth in place and direction: a diffuse part and a glossy lobe that turns along the surface.
pub(crate) fn glossy([u, v]: [f64; 2], d: [f64; 3], channel: usize) -> f64 {
    let axis = [(2.0 * u).sin(), (2.0 * v).sin() * 0.7, 0.6 + (u * v).cos()];
    let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    let cosine = axis.iter().zip(d).map(|(a, d)| a * d).sum::<f64>() / length;
    let tint = [1.0, 0.7, 0.4][channel];
    0.3 * tint * (1.0 + u + 0.5 * (5.0 * v).sin()) + (1.0 + channel as f64 * u) * (6.0 * (cosine - 1.0)).exp()
}

pub(crate) const TEXELS: Texels = Texels { width: 12, height: 9, border: Border::Clamp };
pub(crate) const SPHERE: Sphere = Sphere { z: 10, w: 6 };

pub(crate) fn smooth() -> TransferMatrix {
    field(TEXELS, SPHERE, glossy)
}

/// Numbers without any order.
pub(crate) fn noise(samples: usize, responses: usize, lights: usize) -> TransferMatrix {
    let value = |i: usize| ((i as u64 * 2_654_435_761 + 12_345).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32;
    let values = (0..samples * responses * lights).map(|i| value(i) / 8_388_608.0 - 0.5).collect();
    TransferMatrix::from_dense(values, samples * responses, responses, LightBasis::Plain { lights }).unwrap()
}

pub(crate) fn encoded(params: SlfParams, matrix: &TransferMatrix) -> EncodedSlf {
    Slf::new(params).unwrap().encode(matrix, &Quiet).unwrap()
}

pub(crate) fn rows(encoded: &EncodedSlf) -> Vec<f32> {
    let shape = encoded.shape();
    let mut out = vec![0f32; shape.rows() * shape.lights];
    out.chunks_mut(shape.lights.max(1)).enumerate().for_each(|(row, out)| encoded.row_into(row, out));
    out
}

/// Σ w (T-T̃)² and Σ w T².
pub(crate) fn error(encoded: &EncodedSlf, matrix: &TransferMatrix, weights: Option<&[f64]>) -> (f64, f64) {
    let (exact, n) = (matrix.as_dense().unwrap(), matrix.lights());
    let each = exact.iter().zip(rows(encoded)).enumerate().map(|(i, (e, d))| {
        let (w, e, d) = (weights.map_or(1.0, |w| w[i % n]), f64::from(*e), f64::from(d));
        (w * (e - d).powi(2), w * e * e)
    });
    each.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
}
