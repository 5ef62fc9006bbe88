//! Colours as the eye compares them: through its contrast sensitivity in an opponent space, then in a space of even distances.

use super::filter::{Kernel, Plane, add_separable};
use crate::image::tone::{Picture, linear};
use rayon::prelude::*;
use std::f64::consts::PI;

/// L*, a* and b*, the latter two as vivid as the lightness lets them appear (Hunt).
pub(super) type Lab = [f32; 3];

/// Linear RGB with the primaries of sRGB and a white of D65 to CIE XYZ, rows.
const XYZ: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_49],
    [0.212_636_82, 0.715_183, 0.072_180_2],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];
/// Its inverse.
const RGB: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_9],
    [-0.969_224_2, 1.875_93, 0.041_554_226],
    [0.055_639_42, -0.204_011_21, 1.057_149],
];
/// XYZ of white.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

/// Σ a √(π/b) e^(-π² d²/b) of a distance d in degrees, one of Y, Cx and Cz each: [a, b] of the terms (Table 1 of the paper).
const SENSITIVITY: [&[[f64; 2]]; 3] = [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];
/// The largest b, which decides how far all filters reach.
const WIDEST: f64 = 0.04;

/// Y, Cx and Cz of each pixel: a linear space of lightness, red against green and blue against yellow.
pub(super) fn opponent(picture: &Picture) -> [Plane; 3] {
    let codes: Vec<f32> = (0..=255).map(|code| linear(code) as f32).collect();
    let of_pixel = |pixel: &[u8; 3]| {
        let [x, y, z] = xyz(pixel.map(|code| codes[usize::from(code)]));
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    };
    let pixels: Vec<[f32; 3]> = picture.pixels.par_iter().map(of_pixel).collect();
    [0, 1, 2].map(|c| Plane { width: picture.width, values: pixels.iter().map(|p| p[c]).collect() })
}

/// The colours that are left of fine detail.
pub(super) fn seen(opponent: &[Plane; 3], pixels_per_degree: f64) -> Vec<Lab> {
    let [y, c_x, c_z] = [0, 1, 2].map(|c| filtered(&opponent[c], SENSITIVITY[c], pixels_per_degree));
    let of_pixel = |i: usize| {
        let y_y = (y.values[i] + 16.0) / 116.0;
        let relative = [c_x.values[i] / 500.0 + y_y, y_y, y_y - c_z.values[i] / 200.0];
        let rgb = times(&RGB, [0, 1, 2].map(|k| relative[k] * WHITE[k]));
        hunt(lab(rgb.map(|c| c.clamp(0.0, 1.0))))
    };
    (0..y.values.len()).into_par_iter().map(of_pixel).collect()
}

/// The plane filtered by a sum of Gaussians, each of them separable, of a sum of 1 over the square within reach.
fn filtered(plane: &Plane, terms: &[[f64; 2]], pixels_per_degree: f64) -> Plane {
    // Three standard deviations of the widest.
    let reach = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    let kernels = terms.iter().map(|&[a, b]| {
        let gaussian = |i: f64| (-(PI * i / pixels_per_degree).powi(2) / b).exp();
        let weight = a * (PI / b).sqrt() * Kernel::new(reach, gaussian).sum().powi(2);
        (weight, Kernel::new(reach, gaussian).scaled_to_sum())
    });
    let kernels: Vec<(f64, Kernel)> = kernels.collect();
    let whole: f64 = kernels.iter().map(|(weight, _)| weight).sum();
    let mut out = Plane { width: plane.width, values: vec![0.0; plane.values.len()] };
    for (weight, kernel) in &kernels {
        add_separable(plane, kernel, kernel, (weight / whole) as f32, &mut out);
    }
    out
}

/// |ΔL| + |Δ(a, b)|: large distances of lightness and of hue are judged apart (Abasi et al.).
pub(super) fn hyab(p: Lab, q: Lab) -> f32 {
    let [a, b] = [p[1] - q[1], p[2] - q[2]];
    (p[0] - q[0]).abs() + (a * a + b * b).sqrt()
}

/// Of pure green and blue, of all colours of the cube.
pub(super) fn largest_difference() -> f32 {
    hyab(hunt(lab([0.0, 1.0, 0.0])), hunt(lab([0.0, 0.0, 1.0])))
}

/// CIE L*a*b* of linear RGB.
fn lab(rgb: [f32; 3]) -> Lab {
    const DELTA: f32 = 6.0 / 29.0;
    let curve = |t: f32| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = xyz(rgb).map(curve);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Colours are more vivid in the light.
fn hunt([l, a, b]: Lab) -> Lab {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// XYZ relative to white.
fn xyz(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = times(&XYZ, rgb);
    [0, 1, 2].map(|k| xyz[k] / WHITE[k])
}

fn times(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrices_are_inverse_and_white_is_white() {
        for i in 0..3 {
            let unit: [f32; 3] = std::array::from_fn(|k| f32::from(u8::from(k == i)));
            let back = times(&RGB, times(&XYZ, unit));
            assert!(back.iter().zip(unit).all(|(a, b)| (a - b).abs() < 1e-5), "{back:?}");
        }
        assert!(times(&XYZ, [1.0; 3]).iter().zip(WHITE).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn colours_have_the_coordinates_that_tables_give() {
        // Lindbloom's calculator, sRGB, D65.
        let known = [
            ([0.0, 1.0, 0.0], [87.735, -86.183, 83.180]),
            ([0.0, 0.0, 1.0], [32.297, 79.188, -107.860]),
            ([1.0, 0.0, 0.0], [53.241, 80.092, 67.203]),
            ([1.0, 1.0, 1.0], [100.0, 0.0, 0.0]),
        ];
        for (rgb, expected) in known {
            let found = lab(rgb);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02), "{found:?} {expected:?}");
        }
    }
}
