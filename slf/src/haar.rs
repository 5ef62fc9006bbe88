//! An orthonormal Haar transform of images of any size.
//!
//! A step along a line takes neighbours a and b, which stand for s and t pixels, to `(√s a + √t b)/√(s + t)`, their common part, and
//! `(√t a − √s b)/√(s + t)`: a rotation, so that sums of squares stay, and an even image has no second part whatever its size. A line of an
//! odd number leaves its last over to the next step.

/// Pixels that each of the numbers of a line stands for.
fn halved(pixels: &[f64]) -> Vec<f64> {
    pixels.chunks(2).map(|pair| pair.iter().sum()).collect()
}

/// Of two neighbours that stand for s and t pixels: (√s, √t) / √(s + t).
fn rotation(s: f64, t: f64) -> (f64, f64) {
    ((s / (s + t)).sqrt(), (t / (s + t)).sqrt())
}

/// One step along a line of `stride`, common parts first.
fn step(image: &mut [f64], first: usize, stride: usize, pixels: &[f64], line: &mut Vec<f64>) {
    line.clear();
    line.extend((0..pixels.len()).map(|i| image[first + i * stride]));
    let common = pixels.len().div_ceil(2);
    for (i, (pair, pixels)) in line.chunks(2).zip(pixels.chunks(2)).enumerate() {
        if let ([a, b], [s, t]) = (pair, pixels) {
            let (c, d) = rotation(*s, *t);
            image[first + i * stride] = c * a + d * b;
            image[first + (common + i) * stride] = d * a - c * b;
        } else {
            image[first + i * stride] = pair[0];
        }
    }
}

/// The way back from [`step`].
fn back(image: &mut [f64], first: usize, stride: usize, pixels: &[f64], line: &mut Vec<f64>) {
    line.clear();
    line.extend((0..pixels.len()).map(|i| image[first + i * stride]));
    let common = pixels.len().div_ceil(2);
    for (i, pixels) in pixels.chunks(2).enumerate() {
        let at = first + 2 * i * stride;
        if let [s, t] = pixels {
            let (c, d) = rotation(*s, *t);
            image[at] = c * line[i] + d * line[common + i];
            image[at + stride] = d * line[i] - c * line[common + i];
        } else {
            image[at] = line[i];
        }
    }
}

/// Pixels along both sides at each level, the image itself first; the last has one number.
fn levels(width: usize, height: usize) -> Vec<[Vec<f64>; 2]> {
    let mut levels = vec![[vec![1.0; width], vec![1.0; height]]];
    while let Some([across, down]) = levels.last().filter(|[across, down]| across.len() * down.len() > 1) {
        levels.push([halved(across), halved(down)]);
    }
    levels
}

/// A row-major image of `width` x `height` in place: its coarsest part in the corner, details of each level beyond it.
pub(crate) fn forward(image: &mut [f64], [width, height]: [usize; 2]) {
    let mut line = Vec::new();
    for [across, down] in levels(width, height) {
        (0..down.len()).for_each(|row| step(image, row * width, 1, &across, &mut line));
        (0..across.len()).for_each(|column| step(image, column, width, &down, &mut line));
    }
}

/// The way back from [`forward`].
pub(crate) fn inverse(image: &mut [f64], [width, height]: [usize; 2]) {
    let mut line = Vec::new();
    for [across, down] in levels(width, height).into_iter().rev() {
        (0..across.len()).for_each(|column| back(image, column, width, &down, &mut line));
        (0..down.len()).for_each(|row| back(image, row * width, 1, &across, &mut line));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square(image: &[f64]) -> f64 {
        image.iter().map(|v| v * v).sum()
    }

    proptest! {
        #[test]
        fn sums_of_squares_stay_and_images_of_any_size_come_back(
            width in 1usize..20, height in 1usize..20, seed in prop::collection::vec(-1f64..1.0, 400),
        ) {
            let image = seed[..width * height].to_vec();
            let mut waves = image.clone();
            forward(&mut waves, [width, height]);
            prop_assert!((square(&waves) - square(&image)).abs() <= 1e-12 * square(&image));
            inverse(&mut waves, [width, height]);
            prop_assert!(waves.iter().zip(&image).all(|(a, b)| (a - b).abs() < 1e-13));
        }
    }

    #[test]
    fn unit_images_become_orthonormal_ones() {
        let size = [5, 3];
        let columns: Vec<Vec<f64>> = (0..15)
            .map(|i| {
                let mut image = vec![0.0; 15];
                image[i] = 1.0;
                forward(&mut image, size);
                image
            })
            .collect();
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn an_even_image_is_one_number() {
        for size in [[1, 1], [8, 4], [7, 5], [1, 13], [6, 11]] {
            let mut image = vec![2.0; size[0] * size[1]];
            forward(&mut image, size);
            assert!((image[0] - 2.0 * ((size[0] * size[1]) as f64).sqrt()).abs() < 1e-12, "{size:?}");
            assert!(image[1..].iter().all(|v| v.abs() < 1e-12), "{size:?}");
        }
    }
}
