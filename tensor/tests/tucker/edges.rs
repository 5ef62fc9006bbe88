//! Large and degenerate arrays, what is refused, and what is cut short.

use super::*;
use ndarray::Array3;
use prt_tensor::tucker::Order;
use prt_transfer::progress::Progress;
use prt_transfer::{Error, Result};

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
