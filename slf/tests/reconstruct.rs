//! Radiance between texels and directions.

mod common;

use common::*;
use proptest::prelude::*;
use prt_slf::{Clusters, Colour, Interpolation, RadianceField, Rows, SlfParams, Sphere, SurfaceLightField, Width};
use prt_transfer::random::Random;
use prt_transfer::texels::{Border, Texels};
use std::f64::consts::{PI, TAU};

fn unit(azimuth: f64, polar: f64) -> [f32; 3] {
    [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()].map(|c| c as f32)
}

#[test]
fn smooth_fields_come_back_to_the_second_order() {
    let error = |scale: usize| {
        let texels = Texels { width: 8 * scale, height: 8 * scale, border: Border::Clamp };
        let sphere = Sphere { z: 16 * scale, w: 8 * scale };
        let matrix = field(texels, sphere, glossy);
        let field = SurfaceLightField::new(texels, sphere, Rows::of(&matrix), Interpolation::Bilinear).unwrap();
        let off = |i: usize| {
            let uv = [(i * 37 % 101) as f64 / 100.0, (i * 53 % 97) as f64 / 96.0].map(|t| 0.1 + 0.8 * t);
            let d = unit((i * 71 % 127) as f64 * 0.05, (i * 29 % 113) as f64 / 112.0 * PI);
            let found = field.radiance(uv.map(|t| t as f32), d);
            (0..3).map(|c| (f64::from(found[c]) - glossy(uv, d.map(f64::from), c)).abs()).fold(0.0, f64::max)
        };
        (0..4000).map(off).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(1), error(2));
    assert!(fine < 0.33 * coarse, "{coarse} {fine}");
}

#[test]
fn texels_and_directions_have_their_own_radiance() {
    let matrix = smooth();
    let rows = Rows::of(&matrix);
    let field = SurfaceLightField::new(TEXELS, SPHERE, &rows, Interpolation::Bilinear).unwrap();
    for (texel, direction) in (0..TEXELS.count()).flat_map(|t| (0..SPHERE.count()).map(move |d| (t, d))) {
        let found = field.radiance(TEXELS.centre(texel).map(|t| t as f32), SPHERE.centres()[direction]);
        for (channel, found) in found.iter().enumerate() {
            let exact = matrix.as_dense().unwrap()[(3 * texel + channel) * SPHERE.count() + direction];
            assert!((found - exact).abs() < 1e-4, "{texel} {direction}: {found} {exact}");
        }
    }
}

/// A sphere with a number of its own in each direction.
fn value(sphere: Sphere, direction: [f32; 3]) -> f32 {
    let number = |at: u32| (at.wrapping_mul(2_654_435_761) >> 16) as f32 / 65_536.0;
    sphere.taps(direction).iter().map(|&(at, weight)| weight * number(at)).sum()
}

proptest! {
    #[test]
    fn taps_are_directions_of_the_grid_with_weights_that_add_up_to_one(
        x in -1f32..1.0, y in -1f32..1.0, z in -1f32..1.0, width in 1usize..9, height in 1usize..7,
    ) {
        let sphere = Sphere { z: width, w: height };
        let taps = sphere.taps([x, y, z]);
        prop_assert!((taps.iter().map(|t| t.1).sum::<f32>() - 1.0).abs() < 1e-5);
        prop_assert!(taps.iter().all(|&(at, w)| (at as usize) < sphere.count() && (0.0..=1.00001).contains(&w)));
    }

    #[test]
    fn any_numbers_on_the_grid_make_a_continuous_function_of_direction(
        azimuth in -4f64..4.0, polar in 0f64..PI, turn in 0f64..6.3, width in 1usize..9, height in 1usize..7,
        place in 0usize..3,
    ) {
        // Anywhere, at the seam, at a pole.
        let (azimuth, polar) = match place {
            0 => (azimuth, polar),
            1 => (PI, polar),
            _ => (azimuth, if polar < 1.5 { 0.0 } else { PI }),
        };
        let sphere = Sphere { z: width, w: height };
        let at = unit(azimuth, polar);
        let near = [at[0] + 1e-4 * turn.cos() as f32, at[1] + 1e-4 * turn.sin() as f32, at[2]];
        let (a, b) = (value(sphere, at), value(sphere, near));
        // Steepest: a step of 1 between neighbours, Z W / π² of it a radian beside a pole.
        prop_assert!((a - b).abs() < 1e-4 * (2 * width * (1 + height) + 4) as f32, "{} {}", a, b);
    }
}

#[test]
fn blends_of_a_compressed_field_are_those_of_its_rows() {
    let matrix = smooth();
    for colour in [Colour::Shared, Colour::Separate, Colour::Joint] {
        for (surface, views) in [(Width::F32, Width::F32), (Width::F16, Width::I16), (Width::F32, Width::F16)] {
            let clusters = Clusters::Number(7);
            let params = SlfParams { clusters, components: 9, colour, surface, views, ..Default::default() };
            let encoded = encoded(params, &matrix);
            let rows = Rows::decoded(&encoded);
            let mut random = Random(7);
            for _ in 0..500 {
                let place = [random.uniform() as f32, random.uniform() as f32];
                let direction = unit(TAU * random.uniform(), PI * random.uniform());
                let (texels, directions) = (TEXELS.taps(place), SPHERE.taps(direction));
                let (fast, slow) = (encoded.blend(&texels, &directions), rows.blend(&texels, &directions));
                assert!(fast.iter().zip(slow).all(|(a, b)| (a - b).abs() < 1e-5), "{colour:?} {fast:?} {slow:?}");
            }
            // Any number of taps.
            let all: Vec<(u32, f32)> = (0..60).map(|i| (i, 0.01 * i as f32)).collect();
            let (fast, slow) = (encoded.blend(&all, &all), rows.blend(&all, &all));
            assert!(fast.iter().zip(slow).all(|(a, b)| (a - b).abs() < 1e-4 * b), "{colour:?} {fast:?} {slow:?}");
        }
    }
}

#[test]
fn a_field_of_one_channel_is_grey() {
    let matrix = noise(6, 1, 8);
    let encoded = encoded(SlfParams { components: 8, clusters: Clusters::Number(1), ..Default::default() }, &matrix);
    for blended in [encoded.blend(&[(3, 1.0)], &[(5, 1.0)]), Rows::of(&matrix).blend(&[(3, 1.0)], &[(5, 1.0)])] {
        assert!(blended.iter().all(|b| (b - matrix.as_dense().unwrap()[29]).abs() < 1e-6), "{blended:?}");
    }
}

#[test]
fn cluster_borders_do_not_show_where_nothing_is_lost() {
    let matrix = smooth();
    let lossless = |clusters| {
        let params =
            SlfParams { clusters: Clusters::Number(clusters), components: SPHERE.count(), ..Default::default() };
        let encoded = encoded(params, &matrix);
        assert_eq!(encoded.clusters(), clusters);
        SurfaceLightField::new(TEXELS, SPHERE, encoded, Interpolation::Bilinear).unwrap()
    };
    let (one, two) = (lossless(1), lossless(2));
    for i in 0..2000 {
        let uv = [(i * 37 % 101) as f32 / 100.0, (i * 53 % 97) as f32 / 96.0];
        let d = unit((i * 71 % 127) as f64 * 0.05, (i * 29 % 113) as f64 / 36.0);
        let (a, b) = (one.radiance(uv, d), two.radiance(uv, d));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4), "{a:?} {b:?}");
    }
}

#[test]
fn the_papers_weights_are_flat_between_directions_and_singular_at_texels() {
    let matrix = smooth();
    let rows = Rows::of(&matrix);
    let paper = SurfaceLightField::new(TEXELS, SPHERE, &rows, Interpolation::Paper).unwrap();
    let exact = |texel: usize, direction: usize| matrix.as_dense().unwrap()[3 * texel * SPHERE.count() + direction];
    // At a texel it alone counts; e^{d·d_i} of the four directions differs by little.
    let (texel, at) = (40, 23);
    let d = SPHERE.centres()[at];
    let found = paper.radiance(TEXELS.centre(texel).map(|t| t as f32), d)[0];
    let directions = [at, at + 1, at + 10, at + 11];
    let cosine = |i: usize| d.iter().zip(SPHERE.centres()[i]).map(|(a, b)| a * b).sum::<f32>();
    let candidates: Vec<f32> = [-1i64, 0]
        .into_iter()
        .flat_map(|x| [-10, 0].map(|y| directions.map(|i| (i as i64 + x + y) as usize)))
        .map(|four| {
            let whole: f32 = four.map(|i| cosine(i).exp()).iter().sum();
            four.map(|i| cosine(i).exp() / whole * exact(texel, i)).iter().sum()
        })
        .collect();
    assert!(candidates.iter().any(|c| (c - found).abs() < 1e-4), "{found} {candidates:?}");
    assert!((found - exact(texel, at)).abs() > 1e-3);
    // Halfway between two texels and two rows of texels all four are as near.
    let (a, b) = (TEXELS.centre(40), TEXELS.centre(53));
    let middle = [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0].map(|t| t as f32);
    let each = [40, 41, 52, 53].map(|t| paper.radiance(TEXELS.centre(t).map(|t| t as f32), d)[0]);
    assert!((paper.radiance(middle, d)[0] - each.iter().sum::<f32>() / 4.0).abs() < 1e-4);
}

#[test]
fn fields_of_another_size_are_refused() {
    let rows = Rows::of(&smooth());
    let new = |width, z| {
        let texels = Texels { width, ..TEXELS };
        SurfaceLightField::new(texels, Sphere { z, ..SPHERE }, &rows, Interpolation::Bilinear).map(|_| ())
    };
    assert!(new(12, 10).is_ok());
    assert!(new(11, 10).unwrap_err().to_string().contains("expected 99, found 108"));
    assert!(new(12, 11).unwrap_err().to_string().contains("expected 66, found 60"));
}
