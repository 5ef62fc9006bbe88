use super::*;
use prt_transfer::{LightBasis, TransferMatrix};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn normal(random: &mut Pcg64) -> f64 {
    // The sum of twelve uniform numbers, less their mean, has the variance of one normal number.
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

/// A matrix of a rank, each component as strong as the others, in white noise.
fn ranked(samples: usize, lights: usize, rank: usize, noise: f64) -> TransferMatrix {
    let mut random = Pcg64::seed_from_u64(7);
    let mut factor = |rows: usize| -> Vec<Vec<f64>> {
        (0..rows).map(|_| (0..rank).map(|_| normal(&mut random)).collect()).collect()
    };
    let (left, right) = (factor(samples), factor(lights));
    let mut random = Pcg64::seed_from_u64(8);
    let element = |i: usize| -> f64 {
        let product: f64 = left[i / lights].iter().zip(&right[i % lights]).map(|(a, b)| a * b).sum();
        product + noise * normal(&mut random)
    };
    let values = (0..samples * lights).map(element).map(|v| v as f32).collect();
    TransferMatrix::from_dense(values, samples, 1, LightBasis::Plain { lights }).unwrap()
}

#[test]
fn a_rank_in_noise_is_found_by_gavish_and_donoho_and_by_mdl() {
    for (samples, lights) in [(300, 80), (80, 300), (150, 150)] {
        for rank in [1, 6, 17] {
            let spectrum = Spectrum::of(&ranked(samples, lights, rank, 0.5), None).unwrap();
            assert_eq!(gavish_donoho::rank(&spectrum), rank, "{samples} x {lights}");
            assert_eq!(mdl::rank(&spectrum.values, spectrum.observations), rank, "{samples} x {lights}");
        }
    }
}

#[test]
fn noise_alone_has_no_rank() {
    let spectrum = Spectrum::of(&ranked(300, 80, 0, 1.0), None).unwrap();
    assert_eq!((gavish_donoho::rank(&spectrum), mdl::rank(&spectrum.values, spectrum.observations)), (0, 0));
}

#[test]
fn either_gram_matrix_has_the_same_spectrum_and_the_whole_square() {
    let matrix = ranked(40, 90, 5, 0.3);
    let spectrum = Spectrum::of(&matrix, None).unwrap();
    // The same samples once more: twice every square, and more samples than lights.
    let doubled: Vec<f32> = [matrix.as_dense().unwrap(); 3].concat();
    let tripled = TransferMatrix::from_dense(doubled, 120, 1, matrix.basis().clone()).unwrap();
    let other = Spectrum::of(&tripled, None).unwrap();
    for (a, b) in spectrum.values.iter().zip(&other.values) {
        assert!((3.0 * a - b).abs() < 1e-9 * other.whole, "{a} {b}");
    }
    let square: f64 = matrix.as_dense().unwrap().iter().map(|&v| f64::from(v).powi(2)).sum();
    assert!((spectrum.whole / square - 1.0).abs() < 1e-12);
}

#[test]
fn tail_energy_of_rows_is_what_the_largest_elements_leave() {
    let values = vec![3.0, -1.0, 2.0, 0.0, 0.5, 4.0];
    let matrix = TransferMatrix::from_dense(values, 2, 1, LightBasis::Plain { lights: 3 }).unwrap();
    assert_eq!(tail::of_rows(&matrix), [30.25, 5.25, 1.0, 0.0]);
    for (bound, terms) in [(31.0, 0), (30.25, 0), (30.0, 1), (1.0, 2), (0.9, 3), (0.0, 3)] {
        assert_eq!(tail::needed(&tail::of_rows(&matrix), bound), terms, "{bound}");
    }
}
