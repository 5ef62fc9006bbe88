//! e^{d·d_i} hardly differs among directions close to each other: nearly the mean of four.

use super::field;
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{direction, dot};
use prt_slf::{Interpolation, Sphere};
use prt_transfer::Result;
use prt_transfer::random::Random;
use std::f64::consts::PI;

pub(super) const CASE: Case = Case {
    name: "interpolation",
    title: "Between the directions of a grid",
    source: "Miandji et al. 2011, §3.3: w_i = e^{d·d_i}",
    parameter: "directions from pole to pole",
    values: &[4.0, 8.0, 16.0, 32.0, 64.0],
    quantity: "root mean square error of a lobe of width 1 rad",
    printed: Form {
        name: "w_i = e^{d·d_i}, made to add up to 1",
        figure: |rows| off(rows as usize, Interpolation::Paper),
    },
    here: Form { name: "bilinear", figure: |rows| off(rows as usize, Interpolation::Bilinear) },
    bound: |rows| 0.25 * (PI / rows).powi(2),
    promise: "a quarter of the square of the step: of the second order",
    breaks: Some(16.0),
};

fn off(height: usize, interpolation: Interpolation) -> Result<f64> {
    let sphere = Sphere { z: 2 * height, w: height };
    let radiance = |d: [f64; 3]| (dot(d, [0.48, 0.6, 0.64]) - 1.0).exp();
    let values: Vec<f32> = sphere.centres().iter().map(|d| radiance(d.map(f64::from)) as f32).collect();
    let field = field(sphere, &values, interpolation)?;
    let (mut random, mut sum) = (Random(83), 0.0);
    const DIRECTIONS: usize = 4000;
    for _ in 0..DIRECTIONS {
        let d = direction(&mut random);
        let found = f64::from(field.radiance([0.5, 0.5], d.map(|c| c as f32))[0]);
        sum += (found - radiance(d)).powi(2);
    }
    Ok((sum / DIRECTIONS as f64).sqrt())
}
