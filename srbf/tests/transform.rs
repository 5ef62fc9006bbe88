//! The promises of the light transform onto lobes.

use ndarray::{Array2, ArrayView2};
use proptest::prelude::*;
use prt_srbf::icosphere::{centers, least_angle};
use prt_srbf::{BoundSrbf, Centers, Coordinates, Kernel, Ridge, Srbf, SrbfParams};
use prt_transfer::basis::Direction;
use prt_transfer::{Configure, Flops, LightBasis, LightTransform, Result, Transform};
use std::f64::consts::PI;

const BOTH: [Coordinates; 2] = [Coordinates::Orthonormal, Coordinates::Lobes];

fn bind(params: SrbfParams, basis: &str) -> Result<BoundSrbf> {
    Srbf::new(params)?.bind(&basis.parse()?)
}

fn spread(count: usize) -> SrbfParams {
    SrbfParams { centers: Centers::Count(count), ..Default::default() }
}

fn coefficients(srbf: &BoundSrbf, row: &[f32]) -> Vec<f32> {
    let mut out = vec![f32::NAN; srbf.output().lights()];
    srbf.row_into(row, &mut out);
    out
}

fn restored(srbf: &BoundSrbf, coefficients: &[f32], texels: usize) -> Vec<f32> {
    let mut out = vec![f32::NAN; texels];
    srbf.restore_row_into(coefficients, &mut out);
    out
}

fn projected(srbf: &BoundSrbf, row: &[f32]) -> Vec<f32> {
    restored(srbf, &coefficients(srbf, row), row.len())
}

fn light(srbf: &BoundSrbf, light: &[f32]) -> Vec<f32> {
    let mut out = Array2::from_elem((srbf.output().lights(), 1), f32::NAN);
    srbf.light_into(ArrayView2::from_shape((light.len(), 1), light).unwrap(), out.view_mut());
    out.into_raw_vec_and_offset().0
}

/// Σ (a - b)²/dω.
fn squared_error(basis: &LightBasis, a: &[f32], b: &[f32]) -> f64 {
    let angles = basis.solid_angles().unwrap();
    a.iter().zip(b).zip(angles).map(|((a, b), angle)| (f64::from(*a) - f64::from(*b)).powi(2) / angle).sum()
}

fn dot(a: Direction, b: Direction) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Moments of a clamped cosine of which a wall hides a part.
fn shadowed(basis: &LightBasis) -> Vec<f32> {
    let (normal, wall) = ([0.48, 0.6, 0.64], [0.8, -0.6, 0.0]);
    let value = |d: Direction| if dot(d, wall) > 0.5 { 0.0 } else { dot(d, normal).max(0.0) };
    basis
        .directions()
        .unwrap()
        .into_iter()
        .zip(basis.solid_angles().unwrap())
        .map(|(d, a)| (value(d) * a) as f32)
        .collect()
}

/// Numbers in [-1, 1), times what a texel's moments are times.
fn noise(basis: &LightBasis, seed: u64) -> Vec<f32> {
    let angles = basis.solid_angles().unwrap();
    let number = |k: usize| {
        let mixed = (k as u64 + 1)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15 ^ seed)
            .rotate_left(29)
            .wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    angles.iter().enumerate().map(|(k, a)| (number(k) * a) as f32).collect()
}

#[test]
fn at_the_usual_bandwidth_lobes_have_the_papers_spread_and_a_condition_that_needs_no_ridge() {
    for (count, grid) in [(12, "cubemap:8"), (42, "latlong:32x16"), (162, "cubemap:16"), (642, "cubemap:24")] {
        let srbf = bind(spread(count), grid).unwrap();
        let scale = least_angle(&centers(count).unwrap()) / least_angle(&centers(642).unwrap());
        let expected = Kernel::Gaussian.bandwidth_of_spread(PI / 40.0 * scale);
        assert!(srbf.bandwidths().iter().all(|b| *b == expected));
        assert_eq!((srbf.ridge(), srbf.centers()), (0.0, &centers(count).unwrap()[..]));
        let condition = srbf.condition().unwrap();
        assert!((2.0..400.0).contains(&condition), "{count}: {condition}");
        if count == 642 {
            assert!((expected - 162.9).abs() < 0.1, "{expected}");
            assert!((30.0..80.0).contains(&condition), "{condition}: 51 by closed inner products");
        }
    }
}

#[test]
fn the_gram_matrix_tends_to_closed_inner_products_where_texels_are_small() {
    let directions = centers(42).unwrap();
    for kernel in [Kernel::Gaussian, Kernel::AbelPoisson] {
        let srbf = bind(SrbfParams { kernel, ..spread(42) }, "cubemap:48").unwrap();
        let (gram, bandwidth) = (srbf.gram(), srbf.bandwidths()[0]);
        let peak = kernel.inner_product([directions[0]; 2], [bandwidth; 2]);
        for ((i, j), value) in gram.indexed_iter() {
            let exact = kernel.inner_product([directions[i], directions[j]], [bandwidth; 2]);
            assert!((value - exact).abs() < 2e-3 * peak, "{kernel:?} {i} {j}: {value} {exact}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn projection_is_idempotent_and_no_coefficients_are_nearer(
        grid in prop::sample::select(vec!["cubemap:8", "latlong:24x12"]),
        kernel in prop::sample::select(vec![Kernel::Gaussian, Kernel::AbelPoisson]),
        count in prop::sample::select(vec![12usize, 42, 162]),
        coordinates in prop::sample::select(BOTH.to_vec()),
        seed in any::<u64>(),
    ) {
        let basis: LightBasis = grid.parse().unwrap();
        let srbf = bind(SrbfParams { kernel, coordinates, ..spread(count) }, grid).unwrap();
        prop_assert_eq!(srbf.ridge(), 0.0);
        let row = noise(&basis, seed);
        let c = coefficients(&srbf, &row);
        let nearest = restored(&srbf, &c, row.len());
        let square = squared_error(&basis, &row, &vec![0.0; row.len()]);
        let again = projected(&srbf, &nearest);
        prop_assert!(squared_error(&basis, &nearest, &again) < 1e-9 * square);
        let error = squared_error(&basis, &row, &nearest);
        let size = c.iter().fold(0f32, |m, c| m.max(c.abs()));
        for i in 0..8 {
            let moved: Vec<f32> = c.iter().zip(noise(&basis, seed ^ i).iter().cycle()).map(|(c, n)| c + 3.0 * size * n).collect();
            let other = squared_error(&basis, &row, &restored(&srbf, &moved, row.len()));
            prop_assert!(other > error, "{} {}", other, error);
        }
        // Pythagoras: what is left is orthogonal to what is kept.
        let kept = squared_error(&basis, &nearest, &vec![0.0; row.len()]);
        prop_assert!((error + kept - square).abs() < 1e-5 * square);
    }
}

#[test]
fn orthonormal_coordinates_measure_errors_over_the_sphere() {
    let basis: LightBasis = "cubemap:8".parse().unwrap();
    let srbf = bind(spread(42), "cubemap:8").unwrap();
    assert_eq!(srbf.output().to_string(), "lobes:42:orthonormal");
    let [a, b] = [1, 2].map(|seed| coefficients(&srbf, &noise(&basis, seed)));
    let plain: f64 = a.iter().zip(&b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let sphere = squared_error(&basis, &restored(&srbf, &a, 384), &restored(&srbf, &b, 384));
    assert!((plain / sphere - 1.0).abs() < 1e-5, "{plain} {sphere}");
    let lobes = bind(SrbfParams { coordinates: Coordinates::Lobes, ..spread(42) }, "cubemap:8").unwrap();
    assert_eq!(lobes.output().to_string(), "lobes:42");
}

/// Coefficients and projection by QR of D^-½ Bᵀ in another library's arithmetic: Householder reflections, no Gram matrix.
#[test]
fn coefficients_are_those_of_an_independent_least_squares_solve() {
    let (basis, grid) = ("cubemap:6".parse::<LightBasis>().unwrap(), "cubemap:6");
    let angles = basis.solid_angles().unwrap();
    for count in [12, 42] {
        let srbf = bind(SrbfParams { coordinates: Coordinates::Lobes, ..spread(count) }, grid).unwrap();
        // Column j of Bᵀ is what restores unit coefficient j.
        let mut a: Vec<Vec<f64>> = (0..count)
            .map(|j| {
                let unit: Vec<f32> = (0..count).map(|i| if i == j { 1.0 } else { 0.0 }).collect();
                let moments = restored(&srbf, &unit, angles.len());
                moments.iter().zip(&angles).map(|(b, a)| f64::from(*b) / a.sqrt()).collect()
            })
            .collect();
        let row = shadowed(&basis);
        let mut right: Vec<f64> = row.iter().zip(&angles).map(|(t, a)| f64::from(*t) / a.sqrt()).collect();
        let expected = householder(&mut a, &mut right);
        let found = coefficients(&srbf, &row);
        let size = expected.iter().fold(0f64, |m, c| m.max(c.abs()));
        for (e, f) in expected.iter().zip(&found) {
            assert!((e - f64::from(*f)).abs() < 1e-5 * size, "{count}: {e} {f}");
        }
    }
}

/// argmin |A x - b| by Householder's reflections; `a` holds the columns of A.
fn householder(a: &mut [Vec<f64>], b: &mut [f64]) -> Vec<f64> {
    let inner = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let n = a.len();
    for i in 0..n {
        let mut v = a[i][i..].to_vec();
        v[0] += v[0].signum() * inner(&v, &v).sqrt();
        let square = inner(&v, &v);
        for column in a[i..].iter_mut().map(|column| &mut column[i..]).chain([&mut b[i..]]) {
            let along = 2.0 * inner(&v, column) / square;
            column.iter_mut().zip(&v).for_each(|(c, v)| *c -= along * v);
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| a[j][i] * x[j]).sum();
        x[i] = (b[i] - known) / a[i][i];
    }
    x
}

#[test]
fn a_response_is_the_projected_row_times_the_light() {
    let basis: LightBasis = "cubemap:8".parse().unwrap();
    let texels: Vec<f32> = (0..basis.lights()).map(|k| ((k * 37) % 101) as f32 / 50.0).collect();
    for coordinates in BOTH {
        for ridge in [Ridge::Auto, Ridge::Share(0.05)] {
            let srbf = bind(SrbfParams { coordinates, ridge, ..spread(162) }, "cubemap:8").unwrap();
            let row = shadowed(&basis);
            let product = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
            let by_coefficients = product(&coefficients(&srbf, &row), &light(&srbf, &texels));
            let by_texels = product(&projected(&srbf, &row), &texels);
            assert!((by_coefficients / by_texels - 1.0).abs() < 1e-5, "{by_coefficients} {by_texels}");
        }
    }
}

#[test]
fn both_coordinates_and_blocks_of_rows_give_the_same_projection() {
    let basis: LightBasis = "cubemap:8".parse().unwrap();
    let rows = Array2::from_shape_fn((19, basis.lights()), |(r, k)| noise(&basis, r as u64)[k]);
    let mut decoded = Vec::new();
    for coordinates in BOTH {
        let srbf = bind(SrbfParams { coordinates, ridge: Ridge::Share(1e-3), ..spread(162) }, "cubemap:8").unwrap();
        let mut block = Array2::from_elem((19, 162), f32::NAN);
        srbf.rows_into(rows.view(), block.view_mut());
        for (row, together) in rows.outer_iter().zip(block.outer_iter()) {
            let alone = coefficients(&srbf, row.as_slice().unwrap());
            let size = alone.iter().fold(0f32, |m, c| m.max(c.abs()));
            assert!(alone.iter().zip(together).all(|(a, b)| (a - b).abs() <= 1e-6 * size));
        }
        decoded.push(restored(&srbf, block.row(3).as_slice().unwrap(), basis.lights()));
    }
    let square = squared_error(&basis, &decoded[0], &vec![0.0; basis.lights()]);
    assert!(squared_error(&basis, &decoded[0], &decoded[1]) < 1e-10 * square);
}

#[test]
fn operations_equal_the_closed_formula() {
    for (coordinates, solve) in [(Coordinates::Orthonormal, [42 * 43 / 2, 42 * 41 / 2]), (Coordinates::Lobes, [0, 0])] {
        let srbf = bind(SrbfParams { coordinates, ..spread(42) }, "cubemap:8").unwrap();
        // A moment that is held makes a unit light of its texel reach its lobe. These are the same in both coordinates.
        let lobes = bind(SrbfParams { coordinates: Coordinates::Lobes, ..spread(42) }, "cubemap:8").unwrap();
        let unit = |k: usize| (0..384).map(|i| if i == k { 1.0 } else { 0.0 }).collect::<Vec<f32>>();
        let moments: usize = (0..384).map(|k| light(&lobes, &unit(k)).iter().filter(|b| **b != 0.0).count()).sum();
        let [multiplications, additions] = solve.map(|n: u64| n + moments as u64);
        assert_eq!(srbf.flops(&vec![1.0; 384]), Flops { multiplications, additions, by_one: 0 });
    }
}

#[test]
fn a_constant_is_reproduced_and_the_error_of_a_shadow_falls_with_the_number_of_lobes() {
    let basis: LightBasis = "cubemap:32".parse().unwrap();
    let constant: Vec<f32> = basis.solid_angles().unwrap().iter().map(|a| *a as f32).collect();
    let row = shadowed(&basis);
    let relative = |row: &[f32], count: usize| {
        let nearest = projected(&bind(spread(count), "cubemap:32").unwrap(), row);
        squared_error(&basis, row, &nearest) / squared_error(&basis, row, &vec![0.0; row.len()])
    };
    let constant = relative(&constant, 642);
    assert!(constant < 1e-4, "{constant:e}");
    let errors = [12, 42, 162, 642].map(|count| relative(&row, count));
    assert!(errors.is_sorted_by(|a, b| *a > 1.5 * *b), "{errors:?}");
    assert!(errors[3] < 0.02, "{errors:?}");
}

#[test]
fn lights_of_lobes_are_interpolated_by_closed_forms_as_texels_see_them() {
    let grid = "cubemap:64";
    let basis: LightBasis = grid.parse().unwrap();
    let others: Vec<Direction> = vec![[0.48, 0.6, 0.64], [0.0, -0.6, 0.8], [-1.0, 0.0, 0.0]];
    for (kernel, bandwidths) in [(Kernel::Gaussian, [5.0, 20.0, 60.0]), (Kernel::AbelPoisson, [0.2, 0.6, 0.75])] {
        for coordinates in BOTH {
            let srbf = bind(SrbfParams { kernel, coordinates, ..spread(42) }, grid).unwrap();
            let interpolation = srbf.interpolation(&others, &bandwidths).unwrap();
            for (l, column) in interpolation.columns().into_iter().enumerate() {
                let value = |d: Direction| kernel.value(dot(d, others[l]), bandwidths[l]) as f32;
                let texels: Vec<f32> = basis.directions().unwrap().into_iter().map(value).collect();
                let seen = light(&srbf, &texels);
                let size = column.iter().fold(0f64, |m, a| m.max(a.abs()));
                for (a, b) in column.iter().zip(seen) {
                    assert!((a - f64::from(b)).abs() < 2e-3 * size, "{kernel:?} {coordinates:?} {l}: {a} {b}");
                }
            }
        }
    }
    let srbf = bind(spread(12), "cubemap:8").unwrap();
    assert!(srbf.interpolation(&others, &[1.0]).is_err());
    assert!(srbf.interpolation(&[[0.0; 3]], &[1.0]).is_err());
}

/// What is left of a row when coefficients are rounded to `bits` bits of the largest magnitude.
fn quantised(srbf: &BoundSrbf, basis: &LightBasis, row: &[f32], bits: i32) -> f64 {
    let c = coefficients(srbf, row);
    let step = c.iter().fold(0f32, |m, c| m.max(c.abs())) * 2f32.powi(1 - bits);
    let rounded: Vec<f32> = c.iter().map(|c| (c / step).round() * step).collect();
    let exact = restored(srbf, &c, row.len());
    squared_error(basis, &exact, &restored(srbf, &rounded, row.len()))
        / squared_error(basis, &exact, &vec![0.0; row.len()])
}

#[test]
fn sixteen_bits_are_enough_in_orthonormal_coordinates_and_amplified_by_the_condition_of_wide_lobes_in_their_own() {
    let basis: LightBasis = "cubemap:16".parse().unwrap();
    let row = shadowed(&basis);
    let error = |bandwidth, coordinates| {
        let params = SrbfParams { bandwidth: Some(bandwidth), coordinates, ..spread(162) };
        quantised(&bind(params, "cubemap:16").unwrap(), &basis, &row, 16)
    };
    // λ = 45 is the usual one of 162 lobes; at λ = 4 they are nearly dependent.
    for bandwidth in [45.0, 10.0, 4.0] {
        let orthonormal = error(bandwidth, Coordinates::Orthonormal);
        assert!(orthonormal < 1e-7, "{bandwidth}: {orthonormal:e}");
    }
    let [usual, wide] = [45.0, 4.0].map(|bandwidth| error(bandwidth, Coordinates::Lobes));
    assert!(usual < 1e-6 && wide > 1e3 * usual, "{usual:e} {wide:e}");
}

#[test]
fn a_rotation_of_the_sphere_that_maps_texels_onto_texels_may_be_applied_to_the_centers_instead() {
    let basis: LightBasis = "cubemap:8".parse().unwrap();
    // A quarter turn about z maps the cube onto itself.
    let turn = |d: &Direction| [-d[1], d[0], d[2]];
    let directions = basis.directions().unwrap();
    let image: Vec<usize> =
        directions.iter().map(|d| directions.iter().position(|e| dot(turn(d), *e) > 1.0 - 1e-9).unwrap()).collect();
    let spread: Vec<Direction> = centers(42).unwrap();
    let given = |centers: Vec<Direction>| {
        let bandwidths = (0..42).map(|i| 8.0 + f64::from(i) * 0.2).collect();
        Srbf::with_centers(SrbfParams::default(), centers, bandwidths).unwrap().bind(&basis).unwrap()
    };
    let (still, turned) = (given(spread.clone()), given(spread.iter().map(turn).collect()));
    let row = shadowed(&basis);
    let mut turned_row = vec![0f32; row.len()];
    row.iter().zip(&image).for_each(|(t, &k)| turned_row[k] = *t);
    let (a, b) = (coefficients(&still, &row), coefficients(&turned, &turned_row));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5), "coefficients do not change");
}

#[test]
fn more_lobes_than_texels_work_with_a_ridge_and_are_refused_without() {
    let basis: LightBasis = "cubemap:2".parse().unwrap();
    let srbf = bind(spread(642), "cubemap:2").unwrap();
    assert!(srbf.ridge() > 0.0 && srbf.ridge() < 1e-5, "{:e}", srbf.ridge());
    assert!(srbf.condition().unwrap() > 1e12, "singular to rounding");
    // They span all rows: what is lost is what the ridge costs.
    let row = shadowed(&basis);
    let error = squared_error(&basis, &row, &projected(&srbf, &row));
    assert!(error < 1e-9 * squared_error(&basis, &row, &[0.0; 24]), "{error:e}");
    assert!(srbf.note().unwrap().contains("642 lobes are told apart with a ridge of"));
    assert_eq!(bind(spread(12), "cubemap:8").unwrap().note(), None, "none is needed");
    let message = bind(SrbfParams { ridge: Ridge::Share(0.0), ..spread(642) }, "cubemap:2").err().unwrap().to_string();
    assert!(message.starts_with("light basis for srbf") && message.contains("642 lobes"), "{message}");
    // Two lobes in one place.
    let twins = |ridge| {
        let params = SrbfParams { ridge, ..Default::default() };
        Srbf::with_centers(params, vec![[0.0, 0.0, 1.0]; 2], vec![9.0; 2]).unwrap().bind(&basis)
    };
    assert!(twins(Ridge::Auto).unwrap().ridge() > 0.0 && twins(Ridge::Share(0.0)).is_err());
}

#[test]
fn what_is_out_of_range_is_refused_with_a_reason() {
    let refused = |label: &str| {
        let stage = label.parse::<prt_transfer::Stage>().unwrap();
        let params: Result<SrbfParams> = prt_transfer::Params::from_stage(&stage);
        params.and_then(|p| bind(p, "cubemap:4")).err().unwrap_or_else(|| panic!("{label}")).to_string()
    };
    assert_eq!(refused("srbf:centers=641"), "srbf: centers=641 must be 12, 42, 162, 642, 2562 or given");
    assert!(refused("srbf:centers=given").contains("a label does not say where"));
    assert!(refused("srbf:centers=given:bandwidth=9").contains("each of them has its own"));
    assert!(refused("srbf:bandwidth=0").contains("from 0.01 to 100000 for kernel=gaussian"));
    assert!(refused("srbf:bandwidth=1:kernel=abel-poisson").contains("for kernel=abel-poisson"));
    for label in ["srbf:ridge=-1", "srbf:ridge=2", "srbf:ridge=none", "srbf:bandwidth=auto", "srbf:kernel=x"] {
        refused(label);
    }
    for basis in ["plain:96", "sh:5", "lobes:42"] {
        let message = bind(spread(12), basis).err().unwrap().to_string();
        assert!(message.starts_with("light basis for srbf: expected texels"), "{message}");
    }
    assert!(bind(spread(642), "cubemap:2048").is_err());
    let given = |centers: &[Direction], bandwidths: &[f64]| {
        Srbf::with_centers(SrbfParams::default(), centers.to_vec(), bandwidths.to_vec()).err().map(|e| e.to_string())
    };
    let z = [0.0, 0.0, 1.0];
    assert!(given(&[], &[]).unwrap().contains("at least one"));
    assert!(given(&[z], &[]).unwrap().contains("bandwidths beside centers"));
    for bad in [[0.0; 3], [0.0, 0.0, 1.00001], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
        assert!(given(&[z, bad], &[9.0; 2]).unwrap().contains("length 1"), "{bad:?}");
    }
    for bad in [0.0, -1.0, f64::NAN, 1e6] {
        assert!(given(&[z], &[bad]).unwrap().contains("bandwidth"), "{bad}");
    }
    assert_eq!(given(&[[0.0, 0.0, 1.0 + 4e-7]], &[9.0]), None);
    assert!(given(&vec![z; 4097], &vec![9.0; 4097]).unwrap().contains("4096"));
}
