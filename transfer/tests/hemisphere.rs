//! The promises of harmonics on the hemisphere, and the figures of the appendix of Sloan et al. 2003.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use proptest::prelude::*;
use prt_transfer::Error;
use prt_transfer::sh::{HemisphereSh, Rotation};
use std::f64::consts::PI;

/// Every number of coefficients there is.
fn sizes() -> impl Iterator<Item = usize> {
    (1..=HemisphereSh::MAX_ORDER).flat_map(|n| if n > 1 { vec![n * n, n * n - 1] } else { vec![1] })
}

/// Directions and weights that integrate products of two harmonics below `order` over the hemisphere exactly. Heights
/// are the eigenvalues of Legendre's Jacobi matrix (Golub and Welsch 1969), which is not how the library finds them.
fn quadrature(order: usize) -> Vec<([f64; 3], f64)> {
    let off = |k: usize| k as f64 / ((4 * k * k) as f64 - 1.0).sqrt();
    let eigen = SymmetricEigen::new(DMatrix::from_fn(order + 1, order + 1, |i, k| {
        if i.abs_diff(k) == 1 { off(i.max(k)) } else { 0.0 }
    }));
    let steps = 2 * order + 1;
    let ring = |i: usize| {
        let (z, weight) = (0.5 + 0.5 * eigen.eigenvalues[i], eigen.eigenvectors[(0, i)].powi(2));
        let (r, angle) = ((1.0 - z * z).sqrt(), 2.0 * PI / steps as f64);
        (0..steps).map(move |step| {
            let phi = angle * (step as f64 + 0.3);
            ([r * phi.cos(), r * phi.sin(), z], weight * angle)
        })
    };
    (0..=order).flat_map(ring).collect()
}

fn gram(coefficients: usize) -> DMatrix<f64> {
    DMatrix::from_row_slice(coefficients, coefficients, &HemisphereSh::new(coefficients).unwrap().gram())
}

fn eigenvalues(matrix: &DMatrix<f64>) -> Vec<f64> {
    let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Σ w f fᵀ over the hemisphere.
fn second_moments(order: usize, size: usize, f: impl Fn([f64; 3], &mut [f64])) -> DMatrix<f64> {
    let (mut sum, mut values) = (DMatrix::zeros(size, size), DVector::zeros(size));
    for (direction, weight) in quadrature(order) {
        f(direction, values.as_mut_slice());
        sum.ger(weight, &values, &values, 1.0);
    }
    sum
}

#[track_caller]
fn assert_printed(found: f64, printed: f64, last_digit: f64) {
    assert!((found - printed).abs() <= 0.5 * last_digit, "{found} is not {printed} to {last_digit}");
}

#[test]
fn the_gram_matrix_is_that_of_quadrature_and_the_product_of_its_root() {
    for n in sizes() {
        let h = HemisphereSh::new(n).unwrap();
        let sampled = second_moments(h.order(), n, |direction, out| h.evaluate(direction, out));
        let root = DMatrix::from_row_slice(n, n, &h.root());
        assert!((&sampled - gram(n)).amax() < 3e-14, "{n}");
        assert!((&root * root.transpose() - gram(n)).amax() < 1e-14, "{n}");
        assert!(
            root.upper_triangle() == DMatrix::from_diagonal(&root.diagonal()) && root.diagonal().min() > 0.0,
            "{n}"
        );
    }
}

#[test]
fn orthonormal_functions_are_so_to_half_the_digits_that_a_cholesky_factor_loses() {
    for n in sizes() {
        let (h, a) = (HemisphereSh::new(n).unwrap(), gram(n));
        let off = |f: &dyn Fn([f64; 3], &mut [f64])| {
            (second_moments(h.order(), n, f) - DMatrix::<f64>::identity(n, n)).amax()
        };
        let ours = off(&|direction, out| h.evaluate_orthonormal(direction, out));
        let condition = eigenvalues(&a)[n - 1] / eigenvalues(&a)[0];
        assert!(ours < 1e-14 + 1e-15 * condition.sqrt(), "{n}: {ours:e}");
        if condition > 1e7 {
            let cholesky = a.cholesky().unwrap();
            let theirs = off(&|direction, out| {
                h.evaluate(direction, out);
                let mut out = nalgebra::DVectorViewMut::from_slice(out, n);
                cholesky.l_dirty().solve_lower_triangular_mut(&mut out);
            });
            assert!(theirs > 1e2 * ours, "{n}: {theirs:e} {ours:e}");
        }
    }
}

#[test]
fn appendix_eigenvalues_of_the_gram_matrix_and_its_condition_by_order() {
    let values = eigenvalues(&gram(25));
    assert_printed(values[0], 6.59e-6, 1e-8);
    assert_printed(values[1], 3.10e-4, 1e-6);
    assert_printed(values[2], 3.10e-4, 1e-6);
    assert!(values[3] > 1e-3, "{}", values[3]);
    assert_printed(values[24], 0.999993, 1e-6);
    for (order, condition, digit) in
        [(3, 254.0, 1.0), (4, 5.9e3, 1e2), (5, 1.5e5, 1e4), (6, 4.2e6, 1e5), (7, 1.2e8, 1e7), (8, 3.5e9, 1e8)]
    {
        let values = eigenvalues(&gram(order * order));
        assert_printed(values[order * order - 1] / values[0], condition, digit);
    }
}

#[test]
fn appendix_discarding_the_function_linear_in_z_costs_least() {
    // The squared error of function k, approximated by the others, is 1/(A⁻¹)_kk.
    let inverse = gram(25).try_inverse().unwrap();
    let costs: Vec<f64> = (0..25).map(|k| 1.0 / inverse[(k, k)]).collect();
    assert_printed(costs[2], 1.477e-5, 1e-8);
    assert!((0..25).all(|k| k == 2 || costs[k] > 1.01 * costs[2]), "{costs:?}");
    // The same from the projection onto the 24: ∫ y² - |d|².
    let h = HemisphereSh::new(24).unwrap();
    let mut d: Vec<f64> = h.indices().iter().map(|&i| gram(25)[(i, 2)]).collect();
    h.project(&mut d).unwrap();
    assert_printed(0.5 - d.iter().map(|d| d * d).sum::<f64>(), 1.477e-5, 1e-8);
    let left = eigenvalues(&gram(24));
    assert_printed(left[23] / left[0], 3229.0, 1.0);
}

/// The largest and the mean squared error on the hemisphere, over all c of 25 and length 1, of the reconstruction
/// `kept`·A c from harmonics of `order`: the eigenvalues of the upper left block of (K A - I)ᵀ A (K A - I), K =
/// diag(kept(l, m)).
fn reflection_error(order: usize, kept: impl Fn(usize, i64) -> f64) -> (f64, f64) {
    let (n, a) = (order * order, gram(order * order));
    let scale = DVector::from_fn(n, |i, _| kept(i.isqrt(), i as i64 - (i.isqrt() * (i.isqrt() + 1)) as i64));
    let off = DMatrix::from_diagonal(&scale) * &a - DMatrix::identity(n, n);
    let values = eigenvalues(&(off.transpose() * a * off).view((0, 0), (25, 25)).into_owned());
    (values[24], values.iter().sum::<f64>() / 25.0)
}

#[test]
fn appendix_errors_of_zero_hemisphere_and_reflected_projections() {
    let (odd, even) = (|l: usize, m: i64| (l as i64 + m) % 2 != 0, |l: usize, m: i64| (l as i64 + m) % 2 == 0);
    let twice = |kept: bool| if kept { 2.0 } else { 0.0 };
    let (most, mean) = reflection_error(5, |_, _| 1.0);
    assert_printed(most, 0.1250, 1e-4);
    assert_printed(mean, 0.0402, 1e-4);
    let (most, mean) = reflection_error(8, |l, m| twice(odd(l, m)));
    assert_printed(most, 0.1453, 1e-4);
    assert_printed(mean, 0.0444, 1e-4);
    let (most, mean) = reflection_error(7, |l, m| twice(even(l, m)));
    assert_printed(most, 0.0220, 1e-4);
    assert_printed(mean, 0.00358, 1e-5);
    let (most, mean) = reflection_error(5, |l, m| twice(even(l, m)));
    assert_printed(most, 0.193, 1e-3);
    assert_printed(mean, 0.030, 1e-3);
}

#[test]
fn the_appendix_counts_and_figures_are_those_of_odd_meaning_a_change_of_sign() {
    // As printed, "odd" are the y with y(x,y,z) = y(x,y,-z). A mirror tells them: its block is diagonal, 1 where that
    // holds.
    let mirror = Rotation::new(8, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).unwrap();
    let sign = |l: usize, m: i64| mirror.band(l)[(l as i64 + m) as usize * (2 * l + 2)];
    let (as_printed, opposite) = (|l, m| 1.0 + sign(l, m), |l, m| 1.0 - sign(l, m));
    let count = |kept: &dyn Fn(usize, i64) -> f64| -> usize {
        (0..8).map(|l| (-(l as i64)..=l as i64).filter(|&m| kept(l, m) > 1.0).count()).sum()
    };
    // The text: 28 odd and 36 even of 64; errors of the odd 0.145 and 0.044, of the even 0.022 and 0.0036 (order 7).
    assert_eq!((count(&opposite), count(&as_printed)), (28, 36));
    assert_printed(reflection_error(8, opposite).0, 0.145, 1e-3);
    assert_printed(reflection_error(7, as_printed).0, 0.022, 1e-3);
    // Read as printed the two methods would change places.
    assert!(reflection_error(8, as_printed).0 < 0.022 && reflection_error(7, opposite).0 > 0.145);
}

/// Bounds, at each order from 1, on the relative errors that the documentation prints: of c by way of d, of d from b,
/// of c from b.
const ERRORS: [(f64, f64, f64); 10] = [
    (1e-15, 3e-15, 3e-15),
    (1e-15, 4e-15, 2e-14),
    (2e-15, 2e-14, 2e-13),
    (4e-15, 1e-13, 4e-12),
    (1e-14, 4e-13, 1e-10),
    (2e-14, 2e-12, 2e-9),
    (5e-14, 1e-11, 1e-7),
    (2e-13, 5e-11, 2e-6),
    (5e-13, 4e-10, 1e-4),
    (2e-12, 2e-9, 2e-3),
];

fn relative(found: &[f64], expected: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|v| v * v).sum::<f64>().sqrt();
    norm(&mut found.iter().zip(expected).map(|(a, b)| a - b)) / norm(&mut expected.iter().copied())
}

fn changed(v: &[f64], operation: impl Fn(&mut [f64]) -> Result<(), Error>) -> Vec<f64> {
    let mut v = v.to_vec();
    operation(&mut v).unwrap();
    v
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_band_limited_function_is_projected_onto_itself(pick in 0usize..19, c in prop::collection::vec(-1f64..1.0, 100)) {
        let n = sizes().nth(pick).unwrap();
        let (h, c) = (HemisphereSh::new(n).unwrap(), &c[..n]);
        let (mut y, mut b, mut energy) = (vec![0.0; n], vec![0.0; n], 0.0);
        for (direction, weight) in quadrature(h.order()) {
            h.evaluate(direction, &mut y);
            let f: f64 = y.iter().zip(c).map(|(y, c)| y * c).sum();
            b.iter_mut().zip(&y).for_each(|(b, y)| *b += weight * f * y);
            energy += weight * f * f;
        }
        let d = changed(c, |c| h.to_orthonormal(c));
        let (round_trip, d_from_b, c_from_b) = ERRORS[h.order() - 1];
        prop_assert!(relative(&changed(&d, |d| h.to_harmonic(d)), c) < round_trip);
        prop_assert!(relative(&changed(&b, |b| h.project(b)), &d) < d_from_b);
        let near = changed(&b, |b| h.project_harmonic(b));
        prop_assert!(relative(&near, c) < c_from_b);
        prop_assert!(relative(&changed(&near, |c| h.to_orthonormal(c)), &d) < d_from_b, "the function is nearer than c");
        prop_assert!((d.iter().map(|d| d * d).sum::<f64>() / energy - 1.0).abs() < 3e-14);
        let direction = [0.48, -0.64, 0.6];
        h.evaluate(direction, &mut y);
        let in_c: f64 = y.iter().zip(c).map(|(y, c)| y * c).sum();
        h.evaluate_orthonormal(direction, &mut y);
        let in_d: f64 = y.iter().zip(&d).map(|(q, d)| q * d).sum();
        prop_assert!((in_c - in_d).abs() < 1e-13 * (1.0 + n as f64), "{} {}", in_c, in_d);
    }

    #[test]
    fn the_first_of_d_are_the_projection_onto_fewer_bands(pick in 0usize..17, b in prop::collection::vec(-1f64..1.0, 100)) {
        let (fewer, more) = (sizes().nth(pick).unwrap(), sizes().nth(pick + 2).unwrap());
        let (d, [fewer, more]) = (&b[..more], [fewer, more].map(|n| HemisphereSh::new(n).unwrap()));
        let n = fewer.coefficients();
        prop_assert_eq!(fewer.indices(), &more.indices()[..n]);
        let (d, first) = (changed(d, |b| more.project(b)), changed(&b[..n], |b| fewer.project(b)));
        prop_assert!(relative(&d[..n], &first) < 1e-8);
    }

    #[test]
    fn columns_are_treated_one_by_one(pick in 0usize..7, width in 0usize..4, numbers in prop::collection::vec(-1f64..1.0, 75)) {
        let n = sizes().nth(pick).unwrap();
        let (h, matrix) = (HemisphereSh::new(n).unwrap(), &numbers[..n * width]);
        let column = |of: &[f64], j: usize| of.iter().skip(j).step_by(width).copied().collect::<Vec<f64>>();
        type Operation = fn(&HemisphereSh, &mut [f64]) -> Result<(), Error>;
        let operations: [Operation; 4] =
            [HemisphereSh::to_orthonormal, HemisphereSh::to_harmonic, HemisphereSh::project, HemisphereSh::project_harmonic];
        for operation in operations {
            let all = changed(matrix, |m| operation(&h, m));
            for j in 0..width {
                prop_assert_eq!(column(&all, j), changed(&column(matrix, j), |c| operation(&h, c)));
            }
        }
    }
}

#[test]
fn rounding_to_single_precision_spoils_c_where_it_spares_d() {
    let h = HemisphereSh::new(100).unwrap();
    let single = |v: &[f64]| v.iter().map(|&v| f64::from(v as f32)).collect::<Vec<f64>>();
    let d: Vec<f64> = (0..100).map(|i| (2.4 * f64::from(i)).sin()).collect();
    let c = changed(&d, |d| h.to_harmonic(d));
    assert!(relative(&single(&d), &d) < 1e-7);
    assert!(relative(&changed(&single(&c), |c| h.to_orthonormal(c)), &d) > 1e-4);
}

#[test]
fn sizes_that_do_not_fit_are_refused() {
    for n in (0..=130).filter(|n| !sizes().any(|size| size == *n)) {
        assert!(matches!(HemisphereSh::new(n), Err(Error::Unsupported { .. })), "{n}");
    }
    let h = HemisphereSh::new(24).unwrap();
    assert!(matches!(h.project(&mut [0.0; 25]), Err(Error::Shape { .. })));
    assert!(h.indices().iter().eq((0..25).filter(|&i| i != 2).collect::<Vec<_>>().iter()));
}
