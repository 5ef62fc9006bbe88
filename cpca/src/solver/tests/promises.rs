//! What holds for every matrix.

use super::*;
use ndarray::array;
use proptest::prelude::*;
use prt_transfer::{Error, Progress, Result};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

const ALL: [Solver; 5] = [Solver::Power, Solver::Krylov, Solver::Gram, Solver::Svd, Solver::Auto];

#[test]
fn matrices_without_energy_or_components_have_no_pairs() {
    for solver in ALL {
        for (m, n, components) in [(0, 3, 2), (3, 0, 2), (0, 0, 1), (5, 4, 3)] {
            let principal = solve(solver, &Array2::zeros((m, n)), components);
            assert_eq!(principal.vectors.dim(), (0, n), "{solver:?}");
            assert!(principal.squares.is_empty());
        }
        assert!(solve(solver, &array![[1.0, 2.0]], 0).squares.is_empty());
    }
}

#[test]
fn a_single_row_or_column_is_its_own_component() {
    for solver in ALL {
        let row = solve(solver, &array![[3.0, -4.0, 0.0]], 2);
        assert!((row.squares[0] - 25.0).abs() < 1e-4 && row.squares.len() == 1, "{solver:?}");
        assert!((row.vectors[[0, 1]] - 0.8).abs() < 1e-6 && (row.vectors[[0, 0]] + 0.6).abs() < 1e-6);
        let column = solve(solver, &array![[3.0], [-4.0], [0.0]], 2);
        assert!((column.squares[0] - 25.0).abs() < 1e-4 && column.vectors == array![[1.0]], "{solver:?}");
    }
}

/// Stops what asks for the third time.
struct Impatient(AtomicUsize);

impl Progress for Impatient {
    fn advance(&self, _: u64) -> Result<()> {
        if self.0.fetch_add(1, Relaxed) < 2 { Ok(()) } else { Err(Error::Cancelled) }
    }
}

#[test]
fn solvers_that_iterate_stop_when_they_are_told_to() {
    // Values so close that two blocks do not tell them apart.
    let values: Vec<f64> = (0..80).map(|i| 1.0 - f64::from(i) * 1e-3).collect();
    let (f, _) = with_spectrum(90, 80, &values, 4);
    for (solver, iterates) in ALL.map(|solver| (solver, matches!(solver, Solver::Krylov | Solver::Power))) {
        let asked = Impatient(AtomicUsize::new(0));
        let found = solver.watched(&asked).leading(f.view(), 3, None);
        assert!(found.is_ok() || matches!(found, Err(Error::Cancelled)), "{solver:?}");
        assert!(!iterates || (found.is_err() && asked.0.into_inner() == 3), "{solver:?}");
    }
}

#[test]
fn what_is_not_finite_or_does_not_fit_is_refused() {
    for solver in ALL {
        for bad in [f64::NAN, f64::INFINITY] {
            let matrix = array![[1.0, 2.0], [bad, 0.0]];
            assert!(solver.solver().leading(matrix.view(), 1, None).is_err());
            let start = array![[bad, 0.0]];
            assert!(solver.solver().leading(Array2::eye(2).view(), 1, Some(start.view())).is_err());
        }
        assert!(solver.solver().leading(Array2::eye(2).view(), 1, Some(Array2::eye(3).view())).is_err());
        assert!(solver.solver().leading(array![[1e200]].view(), 1, None).is_err());
        assert_eq!(solve(solver, &array![[f64::MIN_POSITIVE / 4.0]], 1).vectors, array![[1.0]]);
    }
}

#[test]
fn a_power_of_two_scales_squares_and_leaves_vectors() {
    let s: Vec<f64> = (0..60).map(|i| 1.0 / f64::from(i + 1)).collect();
    let (f, v) = with_spectrum(60, 80, &s, 2);
    for solver in ALL {
        for start in [None, Some(v.slice(ndarray::s![..2, ..]))] {
            let plain = solver.solver().leading(f.view(), 3, start).unwrap();
            for exponent in [-100, 100] {
                let factor = 2f64.powi(exponent);
                let scaled = solver.solver().leading((&f * factor).view(), 3, start).unwrap();
                assert_eq!(scaled.vectors, plain.vectors, "{solver:?}");
                let squares: Vec<f64> = plain.squares.iter().map(|s| s * factor * factor).collect();
                assert_eq!(scaled.squares, squares, "{solver:?}");
            }
        }
    }
}

#[test]
fn layout_of_the_rows_does_not_matter() {
    let (f, _) = with_spectrum(9, 14, &[3.0, 2.0, 1.0], 4);
    let columns = f.t().as_standard_layout().into_owned();
    for solver in ALL {
        let by_columns = solver.solver().leading(columns.t(), 2, None).unwrap();
        assert_eq!(by_columns, solve(solver, &f, 2), "{solver:?}");
    }
}

/// Values that repeat, so that rows do, and singular values with them.
fn matrices() -> impl Strategy<Value = Array2<f64>> {
    let value = prop_oneof![Just(0.0), Just(1.0), Just(-1.0), -1.0..1.0, Just(1e-7), Just(1e4)];
    (1..40usize, 1..40usize).prop_flat_map(move |(m, n)| {
        let values = prop::collection::vec(value.clone(), m * n);
        (values, 1..=m)
            .prop_map(move |(values, distinct)| Array2::from_shape_fn((m, n), |(i, j)| values[i % distinct * n + j]))
    })
}

proptest! {
    #[test]
    fn every_solver_finds_what_the_singular_values_say(f in matrices(), components in 0..12usize) {
        let n = f.ncols();
        let values = prt_transfer::linalg::singular(f.view()).unwrap().values;
        let optimum = energy(&values[components.min(values.len())..]);
        for solver in EXACT {
            let principal = solve(solver, &f, components);
            assert_well_formed(&principal, n, 1e-10, &format!("{solver:?}"));
            let excess = left_over(&f, principal.vectors.view()) - optimum;
            prop_assert!(excess <= 1e-12 * energy(&values), "{:?}: {:e}", solver, excess);
        }
        assert_well_formed(&solve(Solver::Power, &f, components), n, 1.0, "power");
    }
}
