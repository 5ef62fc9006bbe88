//! The promises of the light transform onto spherical harmonics.

use ndarray::Array2;
use proptest::prelude::*;
use prt_transfer::sh::{BoundSh, Sh, ShParams, project, texel_moments};
use prt_transfer::{Configure, Error, Flops, LightBasis, LightTransform, Transform};
use std::f64::consts::PI;

const GRIDS: [&str; 4] = ["cubemap:4", "cubemap:7", "latlong:16x8", "latlong:9x10"];

fn bind(order: usize, basis: &str) -> Result<BoundSh, Error> {
    Sh::new(ShParams { order })?.bind(&basis.parse()?)
}

fn coefficients(sh: &BoundSh, row: &[f32]) -> Vec<f32> {
    let mut out = vec![f32::NAN; sh.output().lights()];
    sh.row_into(row, &mut out);
    out
}

fn restored(sh: &BoundSh, coefficients: &[f32], lights: usize) -> Vec<f32> {
    let mut out = vec![f32::NAN; lights];
    sh.restore_row_into(coefficients, &mut out);
    out
}

fn squared_error(basis: &LightBasis, a: &[f32], b: &[f32]) -> f64 {
    let angles = basis.solid_angles().unwrap();
    a.iter().zip(b).zip(angles).map(|((a, b), angle)| (f64::from(*a) - f64::from(*b)).powi(2) / angle).sum()
}

#[test]
fn moments_of_a_harmonic_become_its_coefficient() {
    for (grid, order) in GRIDS.into_iter().zip([3, 5, 5, 4]) {
        let (sh, n) = (bind(order, grid).unwrap(), order * order);
        let moments = texel_moments(order, &grid.parse().unwrap()).unwrap();
        for i in 0..n {
            let row: Vec<f32> = moments.chunks(n).map(|texel| texel[i]).collect();
            for (j, c) in coefficients(&sh, &row).into_iter().enumerate() {
                assert!((c - f32::from(i == j)).abs() < 1e-5, "{grid}: {i} {j} {c}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn projection_is_idempotent_and_no_coefficients_are_nearer(grid in 0..GRIDS.len(), seed in prop::collection::vec(-1f32..1.0, 500), change in prop::collection::vec(-0.01f32..0.01, 16)) {
        let basis: LightBasis = GRIDS[grid].parse().unwrap();
        let (sh, lights) = (bind(4, GRIDS[grid]).unwrap(), basis.lights());
        let row = &seed[..lights];
        let c = coefficients(&sh, row);
        let near = restored(&sh, &c, lights);
        for (a, b) in c.iter().zip(coefficients(&sh, &near)) {
            prop_assert!((a - b).abs() < 1e-5 * (1.0 + a.abs()), "{} {}", a, b);
        }
        let other: Vec<f32> = c.iter().zip(change).map(|(c, d)| c + d * c.abs().max(1.0)).collect();
        let (least, more) = (squared_error(&basis, row, &near), squared_error(&basis, row, &restored(&sh, &other, lights)));
        prop_assert!(least <= more * (1.0 + 1e-9), "{} {}", least, more);
    }

    #[test]
    fn a_response_is_the_projected_row_times_the_light(grid in 0..GRIDS.len(), seed in prop::collection::vec(-1f32..1.0, 1000)) {
        let basis: LightBasis = GRIDS[grid].parse().unwrap();
        let (sh, lights) = (bind(4, GRIDS[grid]).unwrap(), basis.lights());
        let (row, light) = (&seed[..lights], &seed[500..500 + lights]);
        let c = coefficients(&sh, row);
        let x = Array2::from_shape_vec((lights, 1), light.to_vec()).unwrap();
        let mut b = Array2::zeros((16, 1));
        sh.light_into(x.view(), b.view_mut());
        for (b, projected) in b.iter().zip(project(4, &basis, light).unwrap()) {
            prop_assert!((f64::from(*b) - projected).abs() < 1e-5);
        }
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
        let (y, expected) = (dot(&c, b.as_slice().unwrap()), dot(&restored(&sh, &c, lights), light));
        prop_assert!((y - expected).abs() < 1e-4 * (1.0 + dot(&c, &c).sqrt()), "{} {}", y, expected);
    }
}

#[test]
fn a_cosine_has_the_coefficients_of_its_closed_form_where_texels_are_small() {
    // max(z, 0) = √π/2 Y_00 + √(π/3) Y_10 + √(5π)/8 Y_20 + …, and nothing in band 3 (Ramamoorthi and Hanrahan 2001).
    let (basis, order) = (LightBasis::Cubemap { resolution: 32 }, 5);
    let sh = bind(order, "cubemap:32").unwrap();
    let (directions, angles) = (basis.directions().unwrap(), basis.solid_angles().unwrap());
    let row: Vec<f32> = directions.iter().zip(angles).map(|(d, a)| (d[2].max(0.0) * a) as f32).collect();
    let c = coefficients(&sh, &row);
    for (i, c) in c.into_iter().enumerate() {
        let expected = match i {
            0 => PI.sqrt() / 2.0,
            2 => (PI / 3.0).sqrt(),
            6 => (5.0 * PI).sqrt() / 8.0,
            20 => -PI.sqrt() / 16.0,
            _ => 0.0,
        };
        assert!((f64::from(c) - expected).abs() < 1e-3, "{i}: {c} {expected}");
    }
}

#[test]
fn operations_equal_the_closed_formula() {
    let n = 6 * 16 * 9;
    let expected = Flops { multiplications: n, additions: n, by_one: 0 };
    assert_eq!(bind(3, "cubemap:4").unwrap().flops(&[1.0; 96]), expected);
}

#[test]
fn grids_that_cannot_tell_the_harmonics_apart_are_refused() {
    for (order, basis) in [(5, "cubemap:2"), (3, "cubemap:1"), (2, "latlong:1x8"), (5, "plain:100"), (2, "sh:3")] {
        assert!(matches!(bind(order, basis), Err(Error::Unsupported { .. })), "{order} {basis}");
    }
    assert!(matches!(bind(32, "cubemap:1024"), Err(Error::TooLarge { .. })));
    assert!(matches!(bind(0, "cubemap:8"), Err(Error::Parameter { .. })));
    assert!(matches!(bind(33, "cubemap:8"), Err(Error::Parameter { .. })));
    bind(10, "cubemap:16").unwrap();
}
