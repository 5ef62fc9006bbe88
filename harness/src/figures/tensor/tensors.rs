//! Arrays that a small core holds well, badly, and not at all.

use ndarray::{Array3, ArrayD};
use prt_transfer::random::Random;

/// An array of any size.
pub(super) struct Tensor {
    /// Its name.
    pub(super) name: &'static str,
    /// Its element at x, y, z, each from 0 to 1.
    pub(super) formula: &'static str,
    fill: fn([usize; 3]) -> Array3<f32>,
}

/// Analytic, cut off at an edge as a shadow is, and without any structure.
pub(super) static TENSORS: [Tensor; 3] = [
    Tensor {
        name: "smooth",
        formula: "exp(-100 (x - z - 0.3 y)²)",
        fill: |size| sampled(size, |[x, y, z]| (-100.0 * (x - z - 0.3 * y).powi(2)).exp()),
    },
    Tensor {
        name: "rough",
        formula: "1 + y where z > 0.5 + 0.4 sin 2π(x + y/4), else 0",
        fill: |size| sampled(size, |[x, y, z]| if z > edge(x, y) { 1.0 + y } else { 0.0 }),
    },
    Tensor { name: "noise", formula: "independent, mean 0, variance 1", fill: noise },
];

fn edge(x: f64, y: f64) -> f64 {
    0.5 + 0.4 * (std::f64::consts::TAU * (x + 0.25 * y)).sin()
}

fn sampled(size: [usize; 3], at: fn([f64; 3]) -> f64) -> Array3<f32> {
    let place = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
    Array3::from_shape_fn(size, |(i, j, k)| at([place(i, size[0]), place(j, size[1]), place(k, size[2])]) as f32)
}

fn noise(size: [usize; 3]) -> Array3<f32> {
    let mut random = Random(1);
    Array3::from_shape_simple_fn(size, || random.normal() as f32)
}

impl Tensor {
    /// Of this size.
    pub(super) fn of(&self, size: [usize; 3]) -> ArrayD<f32> {
        (self.fill)(size).into_dyn()
    }
}
