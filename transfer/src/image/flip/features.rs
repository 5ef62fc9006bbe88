//! Edges and points: where the eye looks first.

use super::filter::{Kernel, Plane, add_along_columns, along_rows};

/// Width of what is detected, in degrees.
const WIDTH: f64 = 0.082;

/// How much of an edge and of a point each pixel is: lengths of the first and of the second derivatives of the lightness (Y of the opponent
/// space), smoothed by a Gaussian, from 0 to √2.
pub(super) fn of(lightness: &Plane, pixels_per_degree: f64) -> Vec<[f32; 2]> {
    let deviation = 0.5 * WIDTH * pixels_per_degree;
    let reach = (3.0 * deviation).ceil() as usize;
    let gaussian = |x: f64| (-0.5 * (x / deviation).powi(2)).exp();
    let smooth = Kernel::new(reach, gaussian).scaled_to_sum();
    let first = Kernel::new(reach, |x| -x * gaussian(x)).balanced();
    let second = Kernel::new(reach, |x| ((x / deviation).powi(2) - 1.0) * gaussian(x)).balanced();

    let values = lightness.values.iter().map(|y| (y + 16.0) / 116.0).collect();
    let grey = Plane { width: lightness.width, values };
    let smoothed = along_rows(&grey, &smooth);
    let [edge, point] = [first, second].map(|derivative| {
        let across = along_columns(&along_rows(&grey, &derivative), &smooth);
        let down = along_columns(&smoothed, &derivative);
        across.values.into_iter().zip(down.values).map(|(x, y)| (x * x + y * y).sqrt()).collect::<Vec<f32>>()
    });
    edge.into_iter().zip(point).map(|(edge, point)| [edge, point]).collect()
}

fn along_columns(plane: &Plane, kernel: &Kernel) -> Plane {
    let mut out = Plane { width: plane.width, values: vec![0.0; plane.values.len()] };
    add_along_columns(plane, kernel, 1.0, &mut out);
    out
}
