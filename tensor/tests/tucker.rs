//! What Tucker decompositions promise.

use ndarray::{Array1, Array2, Array3, ArrayD, ArrayViewD, Axis, Dimension};
use proptest::prelude::*;
use prt_tensor::tucker::{Algorithm, Decomposer, Order, Ranks, Tucker, TuckerParams};
use prt_transfer::progress::{Progress, Quiet};
use prt_transfer::random::Random;
use prt_transfer::{Error, Result, linalg};

const ALL: [Algorithm; 4] = [Algorithm::Hosvd, Algorithm::Sequential, Algorithm::Hooi, Algorithm::Randomised];

fn decompose(tensor: &ArrayD<f32>, algorithm: Algorithm, ranks: Ranks) -> Tucker {
    let params = TuckerParams { algorithm, ranks, ..Default::default() };
    Decomposer::new(params).unwrap().decompose(tensor.view(), &Quiet).unwrap()
}

fn given(tensor: &ArrayD<f32>, algorithm: Algorithm, ranks: &[usize]) -> Tucker {
    decompose(tensor, algorithm, Ranks::Given(ranks.to_vec()))
}

/// Uniform in [-1, 1), times `decay`^(sum of indices).
fn noise(shape: &[usize], decay: f64, seed: u64) -> ArrayD<f32> {
    let mut random = Random(seed);
    ArrayD::from_shape_fn(shape.to_vec(), |i| {
        let order: usize = i.slice().iter().sum();
        ((2.0 * random.uniform() - 1.0) * decay.powi(order as i32)) as f32
    })
}

/// A tensor of multilinear ranks `ranks` at most, of small whole numbers: exact in f32.
fn exact(shape: &[usize], ranks: &[usize], seed: u64) -> ArrayD<f32> {
    let mut random = Random(seed);
    let mut digit = move || random.below(5) as f64 - 2.0;
    let mut tensor = ArrayD::from_shape_simple_fn(ranks.to_vec(), &mut digit);
    for (mode, (&size, &rank)) in shape.iter().zip(ranks).enumerate() {
        let factor = Array2::from_shape_simple_fn((size, rank), &mut digit);
        tensor = times(&tensor, mode, &factor);
    }
    tensor.mapv(|v| v as f32)
}

/// T ×_mode M by definition.
fn times(tensor: &ArrayD<f64>, mode: usize, matrix: &Array2<f64>) -> ArrayD<f64> {
    let mut shape = tensor.shape().to_vec();
    shape[mode] = matrix.nrows();
    let mut out = ArrayD::zeros(shape);
    for (lane, mut target) in tensor.lanes(Axis(mode)).into_iter().zip(out.lanes_mut(Axis(mode))) {
        target.assign(&matrix.dot(&lane));
    }
    out
}

fn energy<'a>(values: impl IntoIterator<Item = &'a f32>) -> f64 {
    values.into_iter().map(|v| f64::from(*v).powi(2)).sum()
}

/// ‖T - T̃‖²/‖T‖² by definition.
fn error(tensor: &ArrayD<f32>, tucker: &Tucker) -> f64 {
    let near = tucker.reconstruct();
    assert_eq!(near.shape(), tensor.shape());
    let lost: f64 = tensor.iter().zip(&near).map(|(t, near)| (f64::from(*t) - near).powi(2)).sum();
    lost / energy(tensor).max(f64::MIN_POSITIVE)
}

/// Squares of singular values of each mode, by a decomposition of the unfolding itself.
fn squares(tensor: ArrayViewD<f32>, mode: usize) -> Vec<f64> {
    let rows: Vec<Array1<f64>> =
        tensor.axis_iter(Axis(mode)).map(|s| s.iter().map(|v| f64::from(*v)).collect()).collect();
    let columns = rows[0].len();
    let flat = rows.into_iter().flatten().collect();
    let unfolding = Array2::from_shape_vec((tensor.len_of(Axis(mode)), columns), flat).unwrap();
    linalg::singular(unfolding.view()).unwrap().values.iter().map(|s| s * s).collect()
}

/// Energies of the modes beyond ranks.
fn tails(tensor: &ArrayD<f32>, ranks: &[usize]) -> Vec<f64> {
    (0..tensor.ndim()).map(|mode| squares(tensor.view(), mode).iter().skip(ranks[mode]).sum()).collect()
}

fn slice_energies(tucker: &Tucker, mode: usize) -> Vec<f64> {
    tucker.core().axis_iter(Axis(mode)).map(|slice| slice.iter().map(|g| g * g).sum()).collect()
}

fn assert_orthonormal(tucker: &Tucker) {
    for (factor, &rank) in tucker.factors().iter().zip(tucker.ranks()) {
        let worst = (factor.t().dot(factor) - Array2::<f64>::eye(rank)).iter().fold(0f64, |w, v| w.max(v.abs()));
        assert!(worst <= 1e-12, "{worst:e}");
        for column in factor.columns() {
            let largest = column.iter().fold(0f64, |l, v| if v.abs() > l.abs() { *v } else { l });
            assert!(largest > 0.0);
        }
    }
}

/// Slices of the core are orthogonal and descend in norm.
fn assert_all_orthogonal(tucker: &Tucker) {
    let scale = tucker.energy();
    for mode in 0..tucker.ranks().len() {
        assert!(slice_energies(tucker, mode).windows(2).all(|pair| pair[0] >= pair[1] - 1e-12 * scale));
        for (i, a) in tucker.core().axis_iter(Axis(mode)).enumerate() {
            for b in tucker.core().axis_iter(Axis(mode)).take(i) {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                assert!(product.abs() <= 1e-12 * scale, "{product:e} of {scale:e}");
            }
        }
    }
}

/// Shape, ranks within it, and a seed.
fn cases() -> impl Strategy<Value = (Vec<usize>, Vec<usize>, u64)> {
    let sizes = prop::collection::vec((1usize..=7, 0.0..1.0f64), 1..=5);
    (sizes, any::<u64>()).prop_map(|(sizes, seed)| {
        let rank = |(size, part): &(usize, f64)| 1 + (part * *size as f64) as usize;
        (sizes.iter().map(|s| s.0).collect(), sizes.iter().map(rank).collect(), seed)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn factors_are_orthonormal_cores_all_orthogonal_and_errors_true((shape, ranks, seed) in cases()) {
        let tensor = noise(&shape, 0.7, seed);
        for algorithm in ALL {
            let tucker = given(&tensor, algorithm, &ranks);
            assert_orthonormal(&tucker);
            assert_all_orthogonal(&tucker);
            prop_assert!(tucker.ranks().iter().zip(&ranks).all(|(r, asked)| (1..=*asked).contains(r)));
            let (stated, true_error) = (tucker.relative_error(), error(&tensor, &tucker));
            prop_assert!((stated - true_error).abs() <= 1e-13 + 1e-6 * true_error, "{stated:e} {true_error:e}");
            let dropped = 1.0 - tucker.core().iter().map(|g| g * g).sum::<f64>() / tucker.energy();
            prop_assert!((dropped - true_error).abs() <= 1e-13, "{dropped:e} {true_error:e}");
            prop_assert!((tucker.energy() - energy(&tensor)).abs() <= 1e-13 * tucker.energy());
        }
    }

    #[test]
    fn full_ranks_restore_the_array((shape, _, seed) in cases()) {
        let tensor = noise(&shape, 0.8, seed);
        for algorithm in ALL {
            let tucker = given(&tensor, algorithm, &shape);
            prop_assert!(error(&tensor, &tucker) <= 1e-12);
            prop_assert!(tucker.report().converged);
        }
    }

    #[test]
    fn errors_are_between_the_largest_tail_and_the_sum_of_tails((shape, ranks, seed) in cases()) {
        let tensor = noise(&shape, 0.6, seed);
        let (total, tails) = (energy(&tensor), tails(&tensor, &ranks));
        let (least, most) = (tails.iter().fold(0f64, |a, b| a.max(*b)) / total, tails.iter().sum::<f64>() / total);
        for algorithm in [Algorithm::Hosvd, Algorithm::Sequential, Algorithm::Hooi] {
            let error = given(&tensor, algorithm, &ranks).relative_error();
            prop_assert!((least - 1e-12..=most + 1e-12).contains(&error), "{algorithm:?} {least} {error} {most}");
        }
        prop_assert!(given(&tensor, Algorithm::Randomised, &ranks).relative_error() >= least - 1e-12);
    }

    #[test]
    fn sweeps_never_raise_the_error((shape, ranks, seed) in cases()) {
        let tensor = noise(&shape, 0.9, seed);
        let (hooi, start) = (given(&tensor, Algorithm::Hooi, &ranks), given(&tensor, Algorithm::Sequential, &ranks));
        let report = hooi.report();
        prop_assert!((report.start - start.relative_error()).abs() <= 1e-12);
        prop_assert!(hooi.relative_error() <= start.relative_error() + 1e-12);
        let mut before = report.start;
        for &error in &report.sweeps {
            prop_assert!(error <= before + 1e-12);
            before = error;
        }
        prop_assert!((before - hooi.relative_error()).abs() <= 1e-12);
    }

    #[test]
    fn bounds_are_kept_and_leave_no_slice_to_drop((shape, _, seed) in cases(), exponent in -11.0..0.0f64) {
        let (tensor, bound) = (noise(&shape, 0.5, seed), 10f64.powf(exponent));
        for algorithm in ALL {
            let tucker = decompose(&tensor, algorithm, Ranks::MaxError(bound));
            assert_orthonormal(&tucker);
            assert_all_orthogonal(&tucker);
            let lost = error(&tensor, &tucker);
            prop_assert!(lost <= bound, "{algorithm:?} {lost:e} {bound:e}");
            for (mode, &rank) in tucker.ranks().iter().enumerate() {
                let least = slice_energies(&tucker, mode)[rank - 1] / tucker.energy();
                prop_assert!(rank == 1 || lost + least > bound - 1e-12, "{algorithm:?} {lost:e} {least:e} {bound:e}");
            }
        }
    }

    #[test]
    fn low_multilinear_rank_is_found_and_exact((shape, ranks, seed) in cases()) {
        let tensor = exact(&shape, &ranks, seed);
        prop_assume!(energy(&tensor) > 0.0);
        let rank = |mode| {
            let squares = squares(tensor.view(), mode);
            squares.iter().filter(|s| **s > 1e-20 * squares[0]).count()
        };
        let true_ranks: Vec<usize> = (0..shape.len()).map(rank).collect();
        for algorithm in ALL {
            let tucker = decompose(&tensor, algorithm, Ranks::MaxError(1e-12));
            prop_assert_eq!(tucker.ranks(), &true_ranks[..]);
            prop_assert!(error(&tensor, &tucker) <= 1e-24 && tucker.relative_error() <= 1e-24);
            // More than there are: the exact smaller model.
            let tucker = given(&tensor, algorithm, &shape);
            prop_assert_eq!(tucker.ranks(), &true_ranks[..]);
            prop_assert!(error(&tensor, &tucker) <= 1e-24);
        }
    }

    #[test]
    fn a_permutation_of_a_mode_permutes_rows_of_its_factor((shape, ranks, seed) in cases()) {
        let tensor = noise(&shape, 0.6, seed);
        let mode = seed as usize % shape.len();
        let turned: Vec<usize> = (0..shape[mode]).map(|i| (i + 1) % shape[mode]).collect();
        let permuted = tensor.select(Axis(mode), &turned);
        for algorithm in [Algorithm::Hosvd, Algorithm::Sequential] {
            let (a, b) = (given(&tensor, algorithm, &ranks), given(&permuted, algorithm, &ranks));
            prop_assert_eq!(a.ranks(), b.ranks());
            // Spans, since directions of equal energy may turn: what the factors restore.
            let near = a.reconstruct().select(Axis(mode), &turned);
            let scale = near.iter().fold(0f64, |s, v| s.max(v.abs()));
            prop_assert!(near.iter().zip(&b.reconstruct()).all(|(a, b)| (a - b).abs() <= 1e-6 * scale));
        }
    }

    #[test]
    fn a_power_of_two_scales_the_core_only((shape, ranks, seed) in cases(), power in -60i32..60) {
        let (tensor, factor) = (noise(&shape, 0.8, seed), 2f32.powi(power));
        for algorithm in ALL {
            let (a, b) = (given(&tensor, algorithm, &ranks), given(&tensor.mapv(|v| v * factor), algorithm, &ranks));
            prop_assert_eq!(a.ranks(), b.ranks());
            prop_assert!((a.relative_error() - b.relative_error()).abs() <= 1e-12);
            let ratio = b.energy() / a.energy();
            prop_assert!((ratio / f64::from(factor).powi(2) - 1.0).abs() <= 1e-12);
        }
    }

    #[test]
    fn views_in_any_layout_give_the_same_bytes((shape, ranks, seed) in cases()) {
        let tensor = noise(&shape, 0.8, seed);
        let reversed = tensor.t().as_standard_layout().into_owned();
        for algorithm in ALL {
            let params = TuckerParams { algorithm, ranks: Ranks::Given(ranks.clone()), ..Default::default() };
            let view = Decomposer::new(params).unwrap().decompose(reversed.t(), &Quiet).unwrap();
            assert_same(&view, &given(&tensor, algorithm, &ranks));
        }
    }
}

fn assert_same(a: &Tucker, b: &Tucker) {
    let bits = |array: &ArrayD<f64>| array.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(a.core()), bits(b.core()));
    assert!(
        a.factors().iter().zip(b.factors()).all(|(a, b)| bits(&a.clone().into_dyn()) == bits(&b.clone().into_dyn()))
    );
    assert_eq!((a.relative_error().to_bits(), a.report()), (b.relative_error().to_bits(), b.report()));
}

/// A smooth function with noise, that has several blocks in each mode.
fn large() -> ArrayD<f32> {
    let mut random = Random(5);
    let value = |(i, j, k): (usize, usize, usize)| {
        (1.0 + (i as f32 * 0.02 - k as f32 * 0.01).powi(2) + j as f32).recip() + 1e-3 * random.uniform() as f32
    };
    Array3::from_shape_fn((700, 5, 300), value).into_dyn()
}

#[test]
fn results_are_the_same_on_any_number_of_threads() {
    let tensor = large();
    for algorithm in ALL {
        for ranks in [Ranks::Given(vec![20, 3, 20]), Ranks::MaxError(1e-4)] {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| decompose(&tensor, algorithm, ranks.clone()))
            };
            let one = on(1);
            assert_same(&one, &on(2));
            assert_same(&one, &on(5));
        }
    }
}

#[test]
fn a_sketch_is_as_good_as_all_vectors_where_spectra_decay() {
    let tensor = Array3::from_shape_fn((120, 90, 60), |(i, j, k)| {
        (1.0 + 0.1 * i as f32 + 0.07 * j as f32 + 0.15 * k as f32).recip()
    });
    let tensor = tensor.into_dyn() + noise(&[120, 90, 60], 0.97, 3) * 1e-3;
    for (powers, factor) in [(0, 2.0), (1, 1.1), (2, 1.02)] {
        let sketched = |seed, ranks| {
            let algorithm = Algorithm::Randomised;
            let params = TuckerParams { algorithm, ranks, power_iterations: powers, seed, ..Default::default() };
            Decomposer::new(params).unwrap().decompose(tensor.view(), &Quiet).unwrap()
        };
        let ranks = Ranks::Given(vec![6, 6, 6]);
        let exact = decompose(&tensor, Algorithm::Sequential, ranks.clone());
        for seed in 0..3 {
            let near = sketched(seed, ranks.clone());
            assert!(near.relative_error() <= factor * exact.relative_error(), "{powers} {seed}");
            assert_same(&near, &sketched(seed, ranks.clone()));
            assert!(error(&tensor, &sketched(seed, Ranks::MaxError(1e-7))) <= 1e-7);
        }
        assert_ne!(sketched(0, ranks.clone()).core(), sketched(1, ranks).core());
    }
}

#[test]
fn vectors_of_large_modes_are_found_by_iterating() {
    // Both sides above 1024, where the Gram matrix is formed, and above 4096, where it is not. Singular values 2^-i.
    let rank = 12;
    let mut random = Random(9);
    let mut orthonormal = |size: usize| {
        linalg::orthonormal_columns(Array2::from_shape_simple_fn((size, rank), || random.normal()).view())
    };
    let energy = |range: std::ops::Range<usize>| range.map(|i| 0.25f64.powi(i as i32)).sum::<f64>();
    let expected = energy(6..rank) / energy(0..rank);
    for (m, n) in [(1100, 1200), (1300, 1100), (4100, 4150)] {
        let u = Array2::from_diag(&Array1::from_shape_fn(rank, |i| 0.5f64.powi(i as i32)));
        let tensor = orthonormal(m).dot(&u).dot(&orthonormal(n).t()).mapv(|v| v as f32);
        let tensor = tensor.into_shape_with_order(vec![m, 1, n]).unwrap();
        for (algorithm, ranks) in [
            (Algorithm::Sequential, Ranks::Given(vec![6, 1, 6])),
            (Algorithm::Hosvd, Ranks::Given(vec![6, 1, 6])),
            (Algorithm::Sequential, Ranks::MaxError(expected * 1.01)),
        ] {
            let tucker = decompose(&tensor, algorithm, ranks);
            assert_eq!(tucker.ranks(), [6, 1, 6]);
            assert!(tucker.report().converged && (tucker.relative_error() / expected - 1.0).abs() < 1e-4);
        }
    }
}

#[test]
fn sequential_truncation_follows_the_order_asked_for() {
    let tensor = noise(&[4, 6, 5], 0.8, 11);
    let with = |order| {
        let params = TuckerParams { ranks: Ranks::Given(vec![2, 3, 2]), order, ..Default::default() };
        Decomposer::new(params).unwrap().decompose(tensor.view(), &Quiet)
    };
    assert_same(&with(Order::Ascending).unwrap(), &with(Order::Given(vec![0, 2, 1])).unwrap());
    assert_ne!(with(Order::Ascending).unwrap().core(), with(Order::Given(vec![1, 2, 0])).unwrap().core());
    for bad in [vec![0, 1], vec![0, 1, 1], vec![1, 2, 3]] {
        assert!(matches!(with(Order::Given(bad)), Err(Error::Parameter { .. })));
    }
}

#[test]
fn factors_are_orthonormal_where_singular_values_span_six_decades() {
    let mut random = Random(6);
    let left = Array2::from_shape_simple_fn((200, 12), || random.normal());
    let right = linalg::orthonormal_columns(Array2::from_shape_simple_fn((12, 12), || random.normal()).view());
    let values = Array2::from_diag(&Array1::from_shape_fn(12, |i| 10f64.powf(-0.5 * i as f64)));
    let tensor = left.dot(&values).dot(&right).mapv(|v| v as f32).into_shape_with_order(vec![200, 3, 4]).unwrap();
    for algorithm in ALL {
        let tucker = given(&tensor, algorithm, &[12, 3, 4]);
        assert_eq!(tucker.ranks(), [12, 3, 4]);
        assert_orthonormal(&tucker);
        assert!(error(&tensor, &tucker) <= 1e-20);
    }
}

#[test]
fn two_modes_are_a_singular_value_decomposition() {
    let tensor = noise(&[9, 14], 0.9, 2);
    let squares = squares(tensor.view(), 0);
    for algorithm in ALL {
        let tucker = given(&tensor, algorithm, &[4, 4]);
        for (i, square) in squares.iter().take(4).enumerate() {
            assert!(
                (tucker.core()[[i, i]].powi(2) - square).abs()
                    <= 1e-6 * squares[0] * f64::from(u8::from(algorithm == Algorithm::Randomised)) + 1e-12 * squares[0]
            );
        }
    }
}

#[test]
fn zeros_and_nothing_have_ranks_of_zero() {
    for shape in [vec![3, 4, 2], vec![1], vec![0], vec![3, 0, 2], vec![0, 0]] {
        for algorithm in ALL {
            for ranks in [Ranks::Given(vec![2; shape.len()]), Ranks::MaxError(0.1)] {
                let tensor = ArrayD::<f32>::zeros(shape.clone());
                let tucker = decompose(&tensor, algorithm, ranks);
                assert_eq!(tucker.ranks(), vec![0; shape.len()]);
                assert_eq!((tucker.numbers(), tucker.relative_error(), tucker.energy()), (0, 0.0, 0.0));
                assert_eq!(tucker.reconstruct(), tensor.mapv(f64::from));
                assert!(tucker.factors().iter().zip(&shape).all(|(u, n)| u.dim() == (*n, 0)));
            }
        }
    }
}

#[test]
fn a_constant_or_a_single_slice_has_one_column_a_factor() {
    let mut slice = ArrayD::<f32>::zeros(vec![5, 6, 4]);
    slice.index_axis_mut(Axis(1), 3).fill(2.5);
    for tensor in [
        ArrayD::from_elem(vec![5, 6, 4], 0.3f32),
        slice,
        ArrayD::from_elem(vec![9], -1.0),
        ArrayD::from_elem(vec![1], 3.0),
    ] {
        for algorithm in ALL {
            let tucker = given(&tensor, algorithm, &vec![4; tensor.ndim()]);
            assert_eq!(tucker.ranks(), vec![1; tensor.ndim()]);
            assert!(error(&tensor, &tucker) <= 1e-28);
        }
    }
}

#[test]
fn ranks_beyond_the_product_of_the_others_are_the_exact_smaller_model() {
    let tensor = noise(&[8, 5, 6], 1.0, 4);
    for algorithm in ALL {
        let tucker = given(&tensor, algorithm, &[8, 2, 2]);
        assert!(tucker.ranks()[0] <= 4);
        let huge = given(&tensor, algorithm, &[usize::MAX, 2, 2]);
        assert_same(&tucker, &huge);
    }
}

#[test]
fn the_smallest_and_largest_numbers_of_32_bits_work() {
    for scale in [f32::MIN_POSITIVE * 64.0, f32::MAX / 2.0] {
        let tensor = noise(&[4, 5, 3], 1.0, 8).mapv(|v| v * scale);
        for algorithm in ALL {
            let tucker = given(&tensor, algorithm, &[4, 5, 3]);
            assert!(error(&tensor, &tucker) <= 1e-12);
            assert!(error(&tensor, &given(&tensor, algorithm, &[2, 2, 2])) < 1.0);
        }
    }
}

#[test]
fn what_cannot_be_decomposed_is_refused_with_its_place() {
    let tensor = noise(&[3, 4, 2], 1.0, 1);
    let run = |tensor: &ArrayD<f32>, ranks| -> Result<Tucker> {
        Decomposer::new(TuckerParams { ranks, ..Default::default() })?.decompose(tensor.view(), &Quiet)
    };
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut bad = tensor.clone();
        bad[[2, 1, 1]] = value;
        let refused = run(&bad, Ranks::MaxError(0.1));
        assert!(matches!(refused, Err(Error::NotFinite { row: 2, col: 3, .. })), "{refused:?}");
    }
    let two = run(&tensor, Ranks::Given(vec![2, 2]));
    assert!(matches!(two, Err(Error::Shape { expected: 3, found: 2, .. })), "{two:?}");
    assert!(matches!(run(&tensor, Ranks::Given(vec![2, 0, 2])), Err(Error::Parameter { .. })));
    for error in [0.0, -0.1, 1.0001, 1e-13, f64::NAN, f64::INFINITY] {
        assert!(matches!(run(&tensor, Ranks::MaxError(error)), Err(Error::Parameter { .. })), "{error}");
    }
    assert!(run(&ArrayD::from_elem(vec![], 1.0), Ranks::MaxError(0.1)).is_err());
    for params in [
        TuckerParams { sweeps: 0, ..Default::default() },
        TuckerParams { tolerance: 1.0, ..Default::default() },
        TuckerParams { tolerance: f64::NAN, ..Default::default() },
        TuckerParams { oversampling: 0, ..Default::default() },
        TuckerParams { power_iterations: 101, ..Default::default() },
    ] {
        assert!(matches!(Decomposer::new(params), Err(Error::Parameter { .. })));
    }
}

#[test]
fn an_iteration_that_is_cut_short_says_so() {
    let tensor = noise(&[9, 8, 7], 1.0, 21);
    let with = |sweeps, tolerance| {
        let ranks = Ranks::Given(vec![3, 3, 3]);
        let params = TuckerParams { algorithm: Algorithm::Hooi, ranks, sweeps, tolerance, ..Default::default() };
        Decomposer::new(params).unwrap().decompose(tensor.view(), &Quiet).unwrap()
    };
    let (cut, whole) = (with(1, 1e-6), with(10_000, 1e-6));
    assert!(!cut.report().converged && cut.report().sweeps.len() == 1);
    assert!(whole.report().converged && whole.report().sweeps.len() > 1);
    assert!(whole.relative_error() < cut.relative_error());
}

#[test]
fn progress_can_stop_a_decomposition() {
    struct Stop;
    impl Progress for Stop {
        fn advance(&self, _: u64) -> Result<()> {
            Err(Error::Cancelled)
        }
    }
    let tensor = noise(&[3, 4, 2], 1.0, 1);
    for algorithm in ALL {
        let decomposer = Decomposer::new(TuckerParams { algorithm, ..Default::default() }).unwrap();
        assert!(matches!(decomposer.decompose(tensor.view(), &Stop), Err(Error::Cancelled)));
    }
}
