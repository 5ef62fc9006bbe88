//! Lat-long images resampled to the texels of a light basis, with their energy.

use crate::basis::{Direction, FACES, LightBasis, latlong_direction};
use crate::error::{Error, Result};
use crate::image::Image;
use ndarray::Array2;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Meridians across a cubemap's texel, at least, along which overlaps are integrated.
const MERIDIANS: usize = 16;

/// The texel that holds a unit direction; `None` for a basis without texels.
pub fn texel_of(basis: &LightBasis, direction: Direction) -> Option<usize> {
    // Where in 0..n a fraction in 0..=1 falls; rounding may put it at or beyond an end.
    let cell = |fraction: f64, n: usize| ((fraction * n as f64) as usize).min(n - 1);
    let [x, y, z] = direction;
    match *basis {
        LightBasis::Cubemap { resolution } => {
            let magnitudes = direction.map(f64::abs);
            let axis = (0..3).fold(0, |best, i| if magnitudes[i] > magnitudes[best] { i } else { best });
            let face = 2 * axis + usize::from(direction[axis] < 0.0);
            let along = |axis: Direction| axis[0] * x + axis[1] * y + axis[2] * z;
            let [forward, right, down] = FACES[face].map(along);
            let edge = |c: f64| cell(0.5 * (c / forward + 1.0), resolution);
            Some((face * resolution + edge(down)) * resolution + edge(right))
        }
        LightBasis::LatLong { width, height } => {
            let s = 0.5 - y.atan2(x) / (2.0 * PI);
            let t = x.hypot(y).atan2(z) / PI;
            Some(cell(t, height) * width + cell(s, width))
        }
        _ => None,
    }
}

/// Mean radiance of each texel of a cubemap or lat-long basis, from a lat-long image of constant pixels: lights x 3.
///
/// Every pixel's energy goes to the texels that it overlaps, so that ∫ L dω is that of the image up to rounding to f32,
/// a single bright pixel included; the overlap of pixels and texels is exact on lat-long grids and right to about 1e-4
/// of a texel on cubemaps.
///
/// # Errors
/// A basis without texels, an empty image, NaN or infinite pixels.
pub fn resample(image: &Image, basis: &LightBasis) -> Result<Array2<f32>> {
    image.check()?;
    match *basis {
        LightBasis::LatLong { width, height } => Ok(to_latlong(image, width, height)),
        LightBasis::Cubemap { resolution } => Ok(to_cubemap(image, resolution)),
        _ => Err(Error::Unsupported {
            what: "resampling of an image".into(),
            expected: "a basis of texels (cubemap, latlong)".into(),
            found: basis.to_string(),
        }),
    }
}

/// Radiance of a lat-long image from a unit direction, bilinear between the centres of its pixels; around the poles it
/// is that of the last row.
///
/// # Panics
/// For an image that [`Image::check`] refuses.
pub fn lookup(image: &Image, [x, y, z]: Direction) -> [f32; 3] {
    let (width, height) = (image.width, image.height);
    let s = (0.5 - y.atan2(x) / (2.0 * PI)) * width as f64 - 0.5;
    let t = (x.hypot(y).atan2(z) / PI * height as f64 - 0.5).clamp(0.0, (height - 1) as f64);
    let (column, row) = (s.rem_euclid(width as f64), t as usize);
    let (columns, rows) = ([column as usize % width, (column as usize + 1) % width], [row, (row + 1).min(height - 1)]);
    let [u, v] = [column.fract(), t.fract()];
    let pixel = |i: usize, j: usize, c: usize| f64::from(image.pixels[rows[j] * width + columns[i]][c]);
    let along = |j: usize, c: usize| pixel(0, j, c) + u * (pixel(1, j, c) - pixel(0, j, c));
    [0, 1, 2].map(|c| (along(0, c) + v * (along(1, c) - along(0, c))) as f32)
}

/// A lat-long image turned about z by an angle in degrees, counter-clockwise seen from above. Each pixel is the mean of what the turned image
/// of constant pixels has there: no energy is lost.
///
/// # Panics
/// For an image of other than width x height pixels.
pub fn turned(image: &Image, degrees: f64) -> Image {
    let Image { width, height, .. } = *image;
    // Longitude grows to the left: what is so many pixels to the right comes here.
    let by = (degrees / 360.0).rem_euclid(1.0) * width as f64;
    let (whole, part) = (by as usize, by.fract() as f32);
    let pixel = |i: usize| {
        let (row, column) = (i / width * width, i % width + whole);
        let [near, far] = [column, column + 1].map(|column| image.pixels[row + column % width]);
        [0, 1, 2].map(|c| (1.0 - part) * near[c] + part * far[c])
    };
    Image { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// Exact: a texel overlaps a pixel in an interval of longitude times an interval of z.
fn to_latlong(image: &Image, width: usize, height: usize) -> Array2<f32> {
    let z = |t: f64| (PI * t).cos();
    let columns: Vec<_> = (0..width).map(|i| overlaps(i, width, image.width)).collect();
    let rows: Vec<_> = (0..height).map(|j| overlaps(j, height, image.height)).collect();
    let mean = |k: usize| {
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for &(row, [t0, t1]) in &rows[k / width] {
            for &(column, [s0, s1]) in &columns[k % width] {
                let weight = (z(t0) - z(t1)) * (s1 - s0);
                let pixel = image.pixels[row * image.width + column];
                sum.iter_mut().zip(pixel).for_each(|(sum, l)| *sum += weight * f64::from(l));
                weights += weight;
            }
        }
        sum.map(|sum| (sum / weights) as f32)
    };
    from_texels((0..width * height).into_par_iter().map(mean).collect())
}

/// The cells of a division into `from` parts that overlap cell `i` of a division into `to`, with the interval they
/// share.
fn overlaps(i: usize, to: usize, from: usize) -> Vec<(usize, [f64; 2])> {
    let (first, last) = (i * from / to, ((i + 1) * from).div_ceil(to));
    // Compared as whole numbers over to·from, so that borders that coincide leave no sliver.
    let interval = |k: usize| [(i * from).max(k * to), ((i + 1) * from).min((k + 1) * to)];
    (first..last).map(|k| (k, interval(k).map(|n| n as f64 / (to * from) as f64))).collect()
}

/// Exact along meridians, where all borders are known, and the midpoint rule across them.
fn to_cubemap(image: &Image, resolution: usize) -> Array2<f32> {
    let basis = LightBasis::Cubemap { resolution };
    let (z_of_rows, borders): (Vec<f64>, Vec<f64>) = (
        (0..=image.height).map(|j| (PI * j as f64 / image.height as f64).cos()).collect(),
        longitudes(image, resolution),
    );
    let mut energies = vec![[0.0f64; 3]; basis.lights()];
    for ends in borders.windows(2) {
        let column = ((ends[0].midpoint(ends[1]) * image.width as f64) as usize).min(image.width - 1);
        let meridians = ((ends[1] - ends[0]) * (4 * resolution * MERIDIANS) as f64).ceil();
        let width = (ends[1] - ends[0]) / meridians;
        for i in 0..meridians as usize {
            let [x, y, _] = latlong_direction(ends[0] + (i as f64 + 0.5) * width, 0.5);
            for [high, low] in segments([x, y], resolution, &z_of_rows) {
                let z = high.midpoint(low);
                let sine = (1.0 - z * z).sqrt();
                let Some(texel) = texel_of(&basis, [x * sine, y * sine, z]) else { continue };
                let row = z_of_rows.partition_point(|&border| border > z) - 1;
                let angle = 2.0 * PI * width * (high - low);
                let pixel = image.pixels[row * image.width + column];
                energies[texel].iter_mut().zip(pixel).for_each(|(sum, l)| *sum += angle * f64::from(l));
            }
        }
    }
    let angles = basis.solid_angles().unwrap_or_default();
    from_texels(energies.iter().zip(angles).map(|(e, angle)| e.map(|e| (e / angle) as f32)).collect())
}

/// Longitudes, as ascending fractions of the image's width, at which a column of pixels or of a side face's texels
/// ends.
fn longitudes(image: &Image, resolution: usize) -> Vec<f64> {
    let columns = (0..=image.width).map(|i| i as f64 / image.width as f64);
    // tan of the longitude from a side face's middle is the face coordinate; faces are quarter turns apart.
    let texels = (0..4 * resolution).map(|k| {
        let u = 2.0 * (k % resolution) as f64 / resolution as f64 - 1.0;
        (0.25 * (k / resolution) as f64 + 0.125 + (u.atan() + 0.25 * PI) / (2.0 * PI)) % 1.0
    });
    sorted(columns.chain(texels).collect())
}

/// The parts of the meridian through the horizontal unit vector `[x, y]` that lie in one texel and one row of pixels,
/// from the top: intervals of z.
fn segments([x, y]: [f64; 2], resolution: usize, z_of_rows: &[f64]) -> impl Iterator<Item = [f64; 2]> {
    let (x, y) = (x.abs(), y.abs());
    let edges = (0..=resolution).map(|k| 2.0 * k as f64 / resolution as f64 - 1.0);
    // With q = z/√(1 − z²): rows of a side face end at q = v max(x, y), rows and columns of the top and the bottom
    // where x/q or y/q is an edge. Borders that belong to the other faces only part an interval in two.
    let borders = edges.flat_map(|v| [v * x.max(y), x / v, y / v]).filter(|q| q.is_finite());
    let mut z: Vec<f64> = borders.map(|q| q / (1.0 + q * q).sqrt()).chain(z_of_rows.iter().copied()).collect();
    z = sorted(z);
    (1..z.len()).rev().map(move |i| [z[i], z[i - 1]])
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() < 1e-14);
    values
}

fn from_texels(texels: Vec<[f32; 3]>) -> Array2<f32> {
    Array2::from_shape_fn((texels.len(), 3), |(k, channel)| texels[k][channel])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn energy(basis: &LightBasis, texels: &Array2<f32>, channel: usize) -> f64 {
        let angles = basis.solid_angles().unwrap();
        angles.iter().zip(texels.column(channel)).map(|(a, &l)| a * f64::from(l)).sum()
    }

    #[test]
    fn every_texel_holds_the_directions_inside_it() {
        for basis in ["cubemap:5", "latlong:7x4"].map(|text| text.parse::<LightBasis>().unwrap()) {
            for (k, &d) in basis.directions().unwrap().iter().enumerate() {
                assert_eq!(texel_of(&basis, d), Some(k));
            }
            for i in 0..6 {
                let mut d = [0.0; 3];
                d[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
                assert!(texel_of(&basis, d).unwrap() < basis.lights());
            }
        }
        assert_eq!(texel_of(&LightBasis::Plain { lights: 3 }, [0.0, 0.0, 1.0]), None);
    }

    #[test]
    fn a_constant_image_stays_constant() {
        for (width, height) in [(1, 1), (5, 2), (64, 32)] {
            let image = Image { width, height, pixels: vec![[3.0, 0.0, 1e-3]; width * height] };
            for basis in ["cubemap:1", "cubemap:6", "latlong:9x4", "latlong:128x64"] {
                let texels = resample(&image, &basis.parse().unwrap()).unwrap();
                for row in texels.rows() {
                    assert!((row[0] / 3.0 - 1.0).abs() < 1e-3 && row[1] == 0.0, "{width} {basis}: {row}");
                }
            }
        }
    }

    #[test]
    fn a_smooth_light_arrives_where_it_was() {
        // L = 1 + d·(1, 2, 3)/4, finely sampled, against its value at the centres of texels.
        let value = |d: Direction| (1.0 + 0.25 * (d[0] + 2.0 * d[1] + 3.0 * d[2])) as f32;
        let source = LightBasis::LatLong { width: 360, height: 180 };
        let pixels = source.directions().unwrap().into_iter().map(|d| [value(d); 3]).collect();
        let image = Image { width: 360, height: 180, pixels };
        for basis in ["cubemap:16", "latlong:32x16"].map(|text| text.parse::<LightBasis>().unwrap()) {
            let texels = resample(&image, &basis).unwrap();
            for (d, row) in basis.directions().unwrap().into_iter().zip(texels.rows()) {
                assert!((row[2] - value(d)).abs() < 0.025, "{basis} {d:?}: {} {}", row[2], value(d));
            }
        }
    }

    #[test]
    fn looking_up_a_smooth_light_gives_its_value_and_pixels_theirs() {
        let value = |d: Direction| (2.0 + d[0] - 0.5 * d[1] + 0.7 * d[2]) as f32;
        let source = LightBasis::LatLong { width: 256, height: 128 };
        let pixels = source.directions().unwrap().into_iter().map(|d| [value(d), 1.0, 0.0]).collect();
        let image = Image { width: 256, height: 128, pixels };
        for (k, d) in source.directions().unwrap().into_iter().enumerate() {
            assert!((lookup(&image, d)[0] - image.pixels[k][0]).abs() < 1e-5);
        }
        let poles = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [-1.0, -1e-12, 0.0]];
        let directions = LightBasis::Cubemap { resolution: 9 }.directions().unwrap();
        for d in directions.into_iter().chain(poles) {
            assert!((lookup(&image, d)[0] - value(d)).abs() < 0.02 && lookup(&image, d)[1..] == [1.0, 0.0], "{d:?}");
        }
    }

    #[test]
    fn a_turned_image_is_the_image_in_turned_directions_and_a_whole_turn_is_none() {
        let value = |d: Direction| (2.0 + d[0] - 0.5 * d[1] + 0.7 * d[2]) as f32;
        let basis = LightBasis::LatLong { width: 256, height: 128 };
        let directions = basis.directions().unwrap();
        let pixels = directions.iter().map(|&d| [value(d), 1.0, 0.0]).collect();
        let image = Image { width: 256, height: 128, pixels };
        for degrees in [0.0f64, 2.0, 45.0, 133.7, -20.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            for (d, pixel) in directions.iter().zip(turned(&image, degrees).pixels) {
                let before = [cosine * d[0] + sine * d[1], cosine * d[1] - sine * d[0], d[2]];
                assert!((pixel[0] - value(before)).abs() < 1e-3 && pixel[1..] == [1.0, 0.0], "{degrees} {d:?}");
            }
        }
        for degrees in [0.0, 360.0, -720.0] {
            assert_eq!(turned(&image, degrees), image);
        }
        // One column is 360/256 degrees: the last one comes to the front when the light turns clockwise.
        let by_one = turned(&image, -360.0 / 256.0);
        assert_eq!((by_one.pixels[0], by_one.pixels[1]), (image.pixels[255], image.pixels[0]));
    }

    #[test]
    fn images_and_bases_that_do_not_fit_are_refused() {
        let image = Image { width: 2, height: 1, pixels: vec![[1.0; 3], [f32::INFINITY, 0.0, 0.0]] };
        assert!(resample(&image, &LightBasis::Cubemap { resolution: 2 }).is_err());
        let image = Image { width: 1, height: 1, pixels: vec![[1.0; 3]] };
        assert!(resample(&image, &LightBasis::SphericalHarmonics { order: 3 }).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn no_energy_is_lost_even_from_one_bright_pixel(
            width in 1..40usize, height in 1..20usize, sun in 0..800usize, resolution in 1..9usize,
            columns in 1..50usize, rows in 1..30usize,
        ) {
            let mut pixels: Vec<[f32; 3]> = (0..width * height).map(|i| [(i % 7) as f32, 1.0, 0.0]).collect();
            pixels[sun % (width * height)][2] = 1e5;
            let image = Image { width, height, pixels };
            let source = LightBasis::LatLong { width, height };
            let before = resample(&image, &source).unwrap();
            for basis in [LightBasis::Cubemap { resolution }, LightBasis::LatLong { width: columns, height: rows }] {
                let after = resample(&image, &basis).unwrap();
                for channel in 0..3 {
                    let [a, b] = [energy(&source, &before, channel), energy(&basis, &after, channel)];
                    prop_assert!((a - b).abs() <= 1e-5 * a, "{basis}: {a} {b}");
                }
            }
        }
    }
}
