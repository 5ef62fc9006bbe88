//! Two directions a hair apart, on either side of the middle of a texel: radiance between them may not jump.

use super::field;
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{direction, dot};
use prt_slf::{Interpolation, Sphere};
use prt_transfer::Result;
use prt_transfer::random::Random;

pub(super) const CASE: Case = Case {
    name: "seams",
    title: "Two directions a hair apart",
    source: "Miandji et al. 2011, §3.3: seamless reconstruction",
    parameter: "angle between two directions, rad",
    values: &[1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4],
    quantity: "the largest change of radiance between them, of a field of random texels of size 1",
    printed: Form { name: "w_i = e^{d·d_i}, made to add up to 1", figure: |angle| jump(angle, Interpolation::Paper) },
    here: Form { name: "bilinear", figure: |angle| jump(angle, Interpolation::Bilinear) },
    bound: |angle| 100.0 * angle,
    promise: "100 times the angle: no jump, whatever the texels",
    breaks: Some(3e-3),
};

fn jump(angle: f64, interpolation: Interpolation) -> Result<f64> {
    let sphere = Sphere { z: 32, w: 16 };
    let mut random = Random(84);
    let values: Vec<f32> = (0..sphere.count()).map(|_| random.uniform() as f32).collect();
    let field = field(sphere, &values, interpolation)?;
    let mut most = 0f64;
    for _ in 0..20_000 {
        let d = direction(&mut random);
        // Across d, and as far from it as is asked for.
        let other = direction(&mut random);
        let along = dot(d, other);
        let across: [f64; 3] = std::array::from_fn(|i| other[i] - along * d[i]);
        let length = dot(across, across).sqrt();
        let (sin, cos) = angle.sin_cos();
        let beside: [f64; 3] = std::array::from_fn(|i| cos * d[i] + sin * across[i] / length);
        let [a, b] = [d, beside].map(|d| f64::from(field.radiance([0.5, 0.5], d.map(|c| c as f32))[0]));
        most = most.max((a - b).abs());
    }
    Ok(most)
}
