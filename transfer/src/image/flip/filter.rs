//! Convolution with separable kernels.

use rayon::prelude::*;

/// A channel of a picture, row by row.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) values: Vec<f32>,
}

/// Weights at -reach..=reach pixels.
#[derive(Clone, Debug)]
pub(super) struct Kernel(Vec<f64>);

impl Kernel {
    /// A function of the distance in pixels.
    pub(super) fn new(reach: usize, function: impl Fn(f64) -> f64) -> Kernel {
        Kernel((0..=2 * reach).map(|i| function(i as f64 - reach as f64)).collect())
    }

    pub(super) fn sum(&self) -> f64 {
        self.0.iter().sum()
    }

    /// With a sum of 1.
    pub(super) fn scaled_to_sum(&self) -> Kernel {
        let sum = self.sum();
        Kernel(self.0.iter().map(|k| k / sum).collect())
    }

    /// With positive weights that add up to 1 and negative ones that add up to -1, so that a constant has no response. Where rounding leaves
    /// no weights of one sign there are none of the other either.
    pub(super) fn balanced(&self) -> Kernel {
        let positive: f64 = self.0.iter().filter(|k| **k > 0.0).sum();
        let negative: f64 = self.0.iter().filter(|k| **k < 0.0).sum();
        let scale = |k: &f64| match k {
            _ if positive == 0.0 || negative == 0.0 => 0.0,
            k if *k > 0.0 => k / positive,
            k => -k / negative,
        };
        Kernel(self.0.iter().map(scale).collect())
    }

    fn reach(&self) -> usize {
        self.0.len() / 2
    }
}

/// The plane filtered along its rows; beyond its edges it goes on as it ends.
pub(super) fn along_rows(plane: &Plane, kernel: &Kernel) -> Plane {
    let (width, reach) = (plane.width, kernel.reach());
    let mut values = vec![0.0; plane.values.len()];
    let rows = values.par_chunks_mut(width).zip(plane.values.par_chunks(width));
    rows.for_each_init(
        || vec![0f32; width + 2 * reach],
        |wide, (out, row)| {
            wide[..reach].fill(row[0]);
            wide[reach..reach + width].copy_from_slice(row);
            wide[reach + width..].fill(row[width - 1]);
            for (i, &weight) in kernel.0.iter().enumerate() {
                add_scaled(out, &wide[i..i + width], weight as f32);
            }
        },
    );
    Plane { width, values }
}

/// Adds `factor` times the plane filtered along its columns.
pub(super) fn add_along_columns(plane: &Plane, kernel: &Kernel, factor: f32, out: &mut Plane) {
    let (width, reach) = (plane.width, kernel.reach());
    let last = plane.values.len() / width - 1;
    out.values.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (i, &weight) in kernel.0.iter().enumerate() {
            let from = (y + i).saturating_sub(reach).min(last);
            add_scaled(out, &plane.values[from * width..][..width], factor * weight as f32);
        }
    });
}

/// Adds `factor` times the plane filtered by the product of two kernels.
pub(super) fn add_separable(plane: &Plane, across: &Kernel, down: &Kernel, factor: f32, out: &mut Plane) {
    add_along_columns(&along_rows(plane, across), down, factor, out);
}

fn add_scaled(out: &mut [f32], row: &[f32], factor: f32) {
    out.iter_mut().zip(row).for_each(|(out, value)| *out += factor * value);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As it is defined, by the two-dimensional kernel.
    fn whole(plane: &Plane, across: &Kernel, down: &Kernel) -> Vec<f64> {
        let (width, height) = (plane.width as i64, (plane.values.len() / plane.width) as i64);
        let at = |x: i64, y: i64| {
            let (x, y) = (x.clamp(0, width - 1), y.clamp(0, height - 1));
            f64::from(plane.values[(y * width + x) as usize])
        };
        let of = |x: i64, y: i64| -> f64 {
            let [r, s] = [across, down].map(|k| k.reach() as i64);
            let terms = (-s..=s).flat_map(|dy| (-r..=r).map(move |dx| (dx, dy)));
            terms.map(|(dx, dy)| across.0[(dx + r) as usize] * down.0[(dy + s) as usize] * at(x + dx, y + dy)).sum()
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| of(x, y)).collect()
    }

    #[test]
    fn two_passes_are_the_convolution_even_where_the_kernel_is_larger_than_the_picture() {
        for (width, height) in [(13, 7), (1, 5), (4, 1)] {
            let values = (0..width * height).map(|i| (i * 37 % 101) as f32).collect();
            let plane = Plane { width, values };
            let across = Kernel::new(3, |x| 1.0 + x);
            let down = Kernel::new(5, |y| (-y * y / 8.0).exp());
            let mut out = Plane { width, values: vec![1.0; width * height] };
            add_separable(&plane, &across, &down, 0.5, &mut out);
            for (a, b) in out.values.iter().zip(whole(&plane, &across, &down)) {
                assert!((f64::from(*a) - 1.0 - 0.5 * b).abs() < 1e-3 * b.abs().max(1.0), "{width} x {height}: {a} {b}");
            }
        }
    }

    #[test]
    fn kernels_keep_a_constant_or_answer_it_with_nothing() {
        let gaussian = Kernel::new(9, |x| (-x * x / 12.0).exp());
        assert!((gaussian.scaled_to_sum().sum() - 1.0).abs() < 1e-12);
        for derivative in [
            Kernel::new(9, |x| -x * (-x * x / 12.0).exp()),
            Kernel::new(9, |x| (x * x / 6.0 - 1.0) * (-x * x / 12.0).exp()),
        ] {
            let balanced = derivative.balanced();
            let positive: f64 = balanced.0.iter().filter(|k| **k > 0.0).sum();
            assert!(balanced.sum().abs() < 1e-12 && (positive - 1.0).abs() < 1e-12);
        }
    }
}
