use super::*;
use crate::quadrature::gauss_legendre;
use crate::sh::{Harmonics, MAX_ORDER};
use proptest::prelude::*;
use std::f64::consts::PI;

/// The rotation by a unit quaternion, or that followed by a mirror at the origin.
fn orthogonal() -> impl Strategy<Value = [Direction; 3]> {
    // Zeros and tiny numbers too: turns about an axis, or nearly.
    let number = || prop_oneof![3 => -1f64..1.0, 1 => Just(0.0), 1 => -1e-8..1e-8];
    let long = |q: &[f64; 4]| q.iter().map(|v| v * v).sum::<f64>() > 0.01;
    (prop::array::uniform4(number()).prop_filter("a direction", long), any::<bool>()).prop_map(|(q, mirror)| {
        let scale = if mirror { -1.0 } else { 1.0 } / q.iter().map(|v| v * v).sum::<f64>();
        let [w, x, y, z] = q;
        [
            [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
        .map(|row| row.map(|v| v * scale))
    })
}

fn direction() -> impl Strategy<Value = Direction> {
    (-1f64..1.0, 0f64..2.0 * PI).prop_map(|(z, phi)| around(z, phi))
}

fn around(z: f64, phi: f64) -> Direction {
    let r = (1.0 - z * z).sqrt();
    [r * phi.cos(), r * phi.sin(), z]
}

fn times(r: &[Direction; 3], v: &Direction) -> Direction {
    r.map(|row| dot(&row, v))
}

fn transposed(r: &[Direction; 3]) -> [Direction; 3] {
    std::array::from_fn(|i| r.map(|row| row[i]))
}

fn at(order: usize, v: Direction) -> Vec<f64> {
    let mut y = vec![0.0; order * order];
    Harmonics::new(order).unwrap().evaluate(v, &mut y);
    y
}

fn furthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn rotate(r: &[Direction; 3], c: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; c.len()];
    Rotation::new(c.len().isqrt(), *r).unwrap().apply(c, &mut out).unwrap();
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn coefficients_are_those_of_the_function_seen_from_the_new_axes(order in 1usize..=10, r in orthogonal(), c in prop::collection::vec(-1f64..1.0, 100)) {
        // g(v) = f(Rᵀ v), projected by quadrature that is exact for the products.
        let (c, mut g, steps) = (&c[..order * order], vec![0.0; order * order], 2 * order);
        for (z, weight) in gauss_legendre(order) {
            for step in 0..steps {
                let v = around(z, 2.0 * PI * step as f64 / steps as f64);
                let value = dot(c, &at(order, times(&transposed(&r), &v))) * weight * 2.0 * PI / steps as f64;
                g.iter_mut().zip(at(order, v)).for_each(|(g, y)| *g += value * y);
            }
        }
        prop_assert!(furthest(&rotate(&r, c), &g) < 1e-12);
    }

    #[test]
    fn harmonics_in_a_turned_direction_are_turned_harmonics(order in 1usize..=24, r in orthogonal(), v in direction()) {
        prop_assert!(furthest(&rotate(&r, &at(order, v)), &at(order, times(&r, &v))) < 1e-12);
    }

    #[test]
    fn a_product_acts_as_its_factors_one_after_the_other(a in orthogonal(), b in orthogonal(), c in prop::collection::vec(-1f64..1.0, 100)) {
        let product: [Direction; 3] = transposed(&transposed(&b).map(|column| times(&a, &column)));
        prop_assert!(furthest(&rotate(&product, &c), &rotate(&a, &rotate(&b, &c))) < 1e-13);
    }

    #[test]
    fn blocks_are_orthogonal_and_transposed_for_the_way_back(order in 1usize..=16, r in orthogonal()) {
        let (there, back) = (Rotation::new(order, r).unwrap(), Rotation::new(order, transposed(&r)).unwrap());
        for l in 0..order {
            let (n, there, back) = (2 * l + 1, there.band(l), back.band(l));
            for (k, b) in back.iter().enumerate() {
                let (i, j) = (k / n, k % n);
                prop_assert!((b - there[j * n + i]).abs() < 3e-14);
                let product = dot(&there[i * n..][..n], &there[j * n..][..n]);
                prop_assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 3e-14, "band {}: {} {}: {}", l, i, j, product);
            }
        }
    }

    #[test]
    fn frames_in_single_precision_turn_as_orthogonal_ones(r in orthogonal(), c in prop::collection::vec(-1f64..1.0, 100)) {
        let single = r.map(|row| row.map(|v| f64::from(v as f32)));
        let turned = rotate(&single, &c);
        prop_assert!((dot(&turned, &turned) / dot(&c, &c) - 1.0).abs() < 1e-13);
        prop_assert!(furthest(&turned, &rotate(&r, &c)) < 1e-5);
    }

    #[test]
    fn the_columns_of_a_matrix_turn_one_by_one(order in 1usize..=5, width in 0usize..=3, r in orthogonal(), matrix in prop::collection::vec(-1f64..1.0, 75)) {
        let (rotation, matrix) = (Rotation::new(order, r).unwrap(), &matrix[..order * order * width]);
        let mut out = vec![f64::NAN; matrix.len()];
        rotation.apply_rows(matrix, &mut out, width).unwrap();
        let column = |of: &[f64], j: usize| of.iter().skip(j).step_by(width).copied().collect::<Vec<f64>>();
        for j in 0..width {
            prop_assert!(furthest(&column(&out, j), &rotate(&r, &column(matrix, j))) < 1e-14);
        }
    }
}

#[test]
fn the_largest_order_is_exact_to_ten_digits() {
    let r = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
    for v in [around(0.3, 1.0), around(-0.9, 4.0), around(1.0, 0.0)] {
        let (turned, expected) = (rotate(&r, &at(MAX_ORDER, v)), at(MAX_ORDER, times(&r, &v)));
        assert!(furthest(&turned, &expected) < 1e-10, "{:e}", furthest(&turned, &expected));
    }
}

#[test]
fn turns_about_the_pole_and_mirrors_have_their_closed_forms() {
    let (sin, cos) = 0.7f64.sin_cos();
    for mirror in [1.0, -1.0] {
        let rotation = Rotation::new(10, [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, mirror]]).unwrap();
        for l in 0..10i32 {
            for (k, value) in rotation.band(l as usize).iter().enumerate() {
                let (m, from) = (k as i32 / (2 * l + 1) - l, k as i32 % (2 * l + 1) - l);
                // New azimuth is old azimuth - 0.7; the mirror changes the sign of what is odd in z.
                let turned = match (m == from, m == -from) {
                    (true, _) => (0.7 * f64::from(m)).cos(),
                    (_, true) => (0.7 * f64::from(m)).sin(),
                    _ => 0.0,
                };
                let expected = turned * if (l + m) % 2 == 0 { 1.0 } else { mirror };
                assert!((value - expected).abs() < 1e-14, "{mirror}: {l} {m} {from}: {value} {expected}");
            }
        }
    }
}

#[test]
fn matrices_that_are_not_orthogonal_are_refused_and_leave_the_rotation_as_it_was() {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut rotation = Rotation::new(4, identity).unwrap();
    let before = rotation.band(3).to_vec();
    for (i, j, value) in [(0, 0, 1.001), (0, 1, 0.001), (2, 2, f64::NAN), (1, 1, f64::INFINITY), (1, 1, 0.0)] {
        let mut wrong = identity;
        wrong[i][j] = value;
        assert!(matches!(rotation.set(wrong), Err(Error::Unsupported { .. })), "{wrong:?}");
    }
    assert_eq!(rotation.band(3), before);
    assert!(Rotation::new(0, identity).is_err() && Rotation::new(MAX_ORDER + 1, identity).is_err());
    assert!(matches!(rotation.apply(&[0.0; 16], &mut [0.0; 15]), Err(Error::Shape { .. })));
    assert!(matches!(rotation.apply_rows(&[0.0; 31], &mut [0.0; 32], 2), Err(Error::Shape { .. })));
}
