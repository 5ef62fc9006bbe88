//! Laws that hold for every array.

use super::*;
use proptest::prelude::*;

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
