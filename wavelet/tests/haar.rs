//! The promises of the Haar transform: orthonormal, in the order that is documented, with the light terms that matter most.

use ndarray::{Array2, Axis};
use proptest::prelude::*;
use prt_transfer::{Configure, Error, Flops, LightBasis, LightTransform, Transform};
use prt_wavelet::{BoundHaar, Haar, HaarParams, LightSelect, Scale};

fn bind(resolution: usize, params: HaarParams) -> BoundHaar {
    Haar::new(params).unwrap().bind(&LightBasis::Cubemap { resolution }).unwrap()
}

fn scaled(scale: Scale) -> HaarParams {
    HaarParams { scale, ..Default::default() }
}

fn rows(haar: &BoundHaar, row: &[f32]) -> Vec<f32> {
    let mut out = vec![f32::NAN; row.len()];
    haar.row_into(row, &mut out);
    out
}

fn light(haar: &BoundHaar, light: &[f32]) -> Vec<f32> {
    let lights = Array2::from_shape_vec((light.len(), 1), light.to_vec()).unwrap();
    let mut out = Array2::from_elem((light.len(), 1), f32::NAN);
    haar.light_into(lights.view(), out.view_mut());
    out.into_raw_vec_and_offset().0
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

/// Texels of a cubemap of a random power of two, in [-1, 1] with many zeros, and a second one.
fn texels(most: u32) -> impl Strategy<Value = (usize, Vec<f32>, Vec<f32>)> {
    (0..=most).prop_flat_map(|power| {
        let resolution = 1usize << power;
        let texel = prop_oneof![Just(0f32), -1f32..1.0];
        let face = move || prop::collection::vec(texel.clone(), 6 * resolution * resolution);
        (Just(resolution), face(), face())
    })
}

/// Coefficient `index` of a face as its definition says: a function of height ±1/edge on a square support.
fn wavelet(resolution: usize, index: usize) -> Vec<f32> {
    let mut n = 1;
    while 4 * n * n <= index {
        n *= 2;
    }
    let (kind, place) = if index == 0 { (0, 0) } else { (index / (n * n), index % (n * n)) };
    let edge = resolution / n;
    let (left, top) = (place % n * edge, place / n * edge);
    let mut face = vec![0f32; resolution * resolution];
    for (y, x) in (0..edge * edge).map(|i| (i / edge, i % edge)) {
        let (across, down) = (if 2 * x < edge { 1.0 } else { -1.0 }, if 2 * y < edge { 1.0 } else { -1.0 });
        let sign = match kind {
            0 => 1.0,
            1 => across,
            2 => down,
            _ => across * down,
        };
        face[(top + y) * resolution + left + x] = sign / edge as f32;
    }
    face
}

#[test]
fn coefficients_are_the_products_with_the_documented_wavelets_in_the_documented_order() {
    for resolution in [1, 2, 4, 8, 16] {
        let texels = resolution * resolution;
        let haar = bind(resolution, HaarParams::default());
        let row: Vec<f32> = (0..6 * texels).map(|k| ((k * k + 7 * k) % 101) as f32 / 50.0 - 1.0).collect();
        let coefficients = rows(&haar, &row);
        for (index, coefficient) in coefficients.iter().enumerate() {
            let expected = dot(&wavelet(resolution, index % texels), &row[index / texels * texels..][..texels]);
            assert!(
                (expected - f64::from(*coefficient)).abs() < 1e-5,
                "{resolution}, {index}: {coefficient} {expected}"
            );
        }
    }
}

#[test]
fn the_matrix_of_the_transform_is_orthonormal() {
    for resolution in [1, 2, 4, 8] {
        let n = 6 * resolution * resolution;
        let haar = bind(resolution, HaarParams::default());
        let unit = |k: usize| (0..n).map(|i| f32::from(i == k)).collect::<Vec<f32>>();
        let columns: Vec<Vec<f32>> = (0..n).map(|k| rows(&haar, &unit(k))).collect();
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate().take(i + 1) {
                // Every entry is a power of two: no rounding at all.
                assert_eq!(dot(a, b), if i == j { 1.0 } else { 0.0 }, "{resolution}: {i} {j}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn rows_come_back_and_keep_their_energy((resolution, row, _) in texels(6), sphere: bool) {
        let haar = bind(resolution, scaled(if sphere { Scale::Sphere } else { Scale::None }));
        let coefficients = rows(&haar, &row);
        let mut back = vec![f32::NAN; row.len()];
        haar.restore_row_into(&coefficients, &mut back);
        for (a, b) in row.iter().zip(&back) {
            prop_assert!((a - b).abs() < 4e-6, "{} {}", a, b);
        }
        let angles = LightBasis::Cubemap { resolution }.solid_angles().unwrap();
        let weight = |k: usize| if sphere { 1.0 / angles[k] } else { 1.0 };
        let energy: f64 = row.iter().enumerate().map(|(k, &t)| f64::from(t).powi(2) * weight(k)).sum();
        prop_assert!((dot(&coefficients, &coefficients) - energy).abs() <= 1e-5 * energy);
    }

    #[test]
    fn a_response_is_the_same_in_both_bases((resolution, row, texels) in texels(5), sphere: bool) {
        let haar = bind(resolution, scaled(if sphere { Scale::Sphere } else { Scale::None }));
        let sum = dot(&rows(&haar, &row), &light(&haar, &texels));
        prop_assert!((sum - dot(&row, &texels)).abs() < 1e-5 * (row.len() as f64).sqrt());
    }

    #[test]
    fn the_transform_is_linear((resolution, a, b) in texels(4), factor in -2f32..2.0) {
        let haar = bind(resolution, HaarParams::default());
        let sum: Vec<f32> = a.iter().zip(&b).map(|(a, b)| a + factor * b).collect();
        for ((s, a), b) in rows(&haar, &sum).iter().zip(rows(&haar, &a)).zip(rows(&haar, &b)) {
            prop_assert!((s - (a + factor * b)).abs() < 1e-5);
        }
    }

    #[test]
    fn light_terms_are_those_that_matter_most((resolution, texels, _) in texels(3), terms in 1usize..100, area: bool) {
        let light_select = if area { LightSelect::Area } else { LightSelect::Plain };
        let all = light(&bind(resolution, HaarParams::default()), &texels);
        let some = light(&bind(resolution, HaarParams { light_terms: terms, light_select, ..Default::default() }), &texels);
        // Second way: the support counted on the wavelet itself, and a sort.
        let area_of = |k: usize| {
            let support = wavelet(resolution, k % (resolution * resolution)).iter().filter(|v| **v != 0.0).count();
            (support as f32).sqrt()
        };
        let weight: Vec<f32> = all.iter().enumerate().map(|(k, w)| w.abs() * if area { area_of(k) } else { 1.0 }).collect();
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|&i, &j| weight[j].total_cmp(&weight[i]).then(i.cmp(&j)));
        let mut expected = vec![0f32; all.len()];
        order.iter().take(terms).for_each(|&k| expected[k] = all[k]);
        prop_assert_eq!(some, expected);
    }
}

#[test]
fn channels_of_a_light_are_transformed_each_for_itself() {
    let haar = bind(8, HaarParams { light_terms: 20, ..Default::default() });
    let lights = Array2::from_shape_fn((384, 3), |(k, c)| ((k * (c + 3)) % 17) as f32);
    let mut out = Array2::zeros((384, 3));
    haar.light_into(lights.view(), out.view_mut());
    for c in 0..3 {
        assert_eq!(out.index_axis(Axis(1), c).to_vec(), light(&haar, &lights.index_axis(Axis(1), c).to_vec()));
    }
}

#[test]
fn operations_equal_the_closed_formula() {
    for resolution in [1u64, 2, 8, 32] {
        let texels = 6 * resolution * resolution;
        let count = |params: HaarParams| bind(resolution as usize, params).flops(&vec![1.0; texels as usize]);
        let blocks = texels - 6;
        let plain = Flops { multiplications: blocks / 3 * 4, additions: blocks / 3 * 8, by_one: 0 };
        assert_eq!(count(HaarParams::default()), plain);
        assert_eq!(plain.multiplications, 8 * (resolution * resolution - 1));
        let more = |factor| Flops { multiplications: plain.multiplications + factor * texels, ..plain };
        assert_eq!(count(scaled(Scale::Sphere)), more(1));
        let area = HaarParams { light_terms: 5, light_select: LightSelect::Area, scale: Scale::Sphere };
        assert_eq!(count(area), more(2));
    }
}

#[test]
fn it_holds_the_roots_of_one_face_where_it_scales_and_nothing_else() {
    for resolution in [1, 8, 32] {
        assert_eq!(bind(resolution, HaarParams::default()).derived_bytes(), 0);
        assert_eq!(bind(resolution, scaled(Scale::Sphere)).derived_bytes(), 2 * 4 * resolution * resolution);
    }
}

#[test]
fn it_is_what_its_parameters_say() {
    let params = HaarParams { light_terms: 7, light_select: LightSelect::Area, scale: Scale::Sphere };
    assert_eq!(Haar::new(params.clone()).unwrap().params(), &params);
}

#[test]
fn what_it_is_not_defined_on_is_refused() {
    let haar = Haar::new(HaarParams::default()).unwrap();
    for basis in ["cubemap:3", "cubemap:48", "latlong:64x32", "sh:5", "plain:6"] {
        assert!(matches!(haar.bind(&basis.parse().unwrap()), Err(Error::Unsupported { .. })), "{basis}");
    }
    assert!(haar.bind(&LightBasis::Cubemap { resolution: 0 }).is_err());
    let ignored = HaarParams { light_select: LightSelect::Area, ..Default::default() };
    assert!(matches!(Haar::new(ignored), Err(Error::Parameter { .. })));
}
