//! Spectra with known answers.

use super::*;
use crate::solver::zero;

const SHAPES: [(usize, usize); 4] = [(120, 70), (70, 120), (20, 50), (130, 125)];

/// Names and singular values, the first `rank` of which are used.
fn spectra(rank: usize) -> Vec<(String, Vec<f64>)> {
    let of = |value: &dyn Fn(usize) -> f64| (0..rank).map(value).collect::<Vec<_>>();
    let clustered = |gap: f64| of(&|i| 1.0 - gap * i.min(9) as f64 - if i > 9 { 0.5 } else { 0.0 });
    let mut all = vec![
        ("repeated".into(), of(&|i| if i < 6 { 3.0 } else { 1.0 })),
        ("all equal".into(), of(&|_| 1.0)),
        ("clustered 1e-3".into(), clustered(1e-3)),
        ("clustered 1e-6".into(), clustered(1e-6)),
        ("slowly decaying".into(), of(&|i| 1.0 / ((i + 1) as f64).sqrt())),
        ("rank 2".into(), vec![5.0, 1.0]),
        ("rank 8".into(), (0..8).map(|i| f64::from(8 - i)).collect()),
    ];
    for power in 2..=8 {
        let at = |i: usize| 10f64.powf(-f64::from(power) * i as f64 / (rank - 1) as f64);
        all.push((format!("condition 1e{power}"), of(&at)));
        let steep = |i: usize| 10f64.powf(-f64::from(power) * i as f64 / 9.0).max(1e-9);
        all.push((format!("condition 1e{power} in ten"), of(&steep)));
    }
    all
}

#[test]
fn energy_left_over_is_the_optimum_of_every_spectrum() {
    for (m, n) in SHAPES {
        for (name, s) in spectra(m.min(n)) {
            let (f, _) = with_spectrum(m, n, &s, 7);
            for components in [1, 3, 8] {
                let optimum = energy(&s[components.min(s.len())..]);
                for solver in EXACT {
                    let what = format!("{name}, {m} x {n}, {components} by {solver:?}");
                    let principal = solve(solver, &f, components);
                    assert_well_formed(&principal, n, 1e-10, &what);
                    let excess = left_over(&f, principal.vectors.view()) - optimum;
                    assert!(excess <= 1e-6 * energy(&s), "{what}: {excess:e}");
                    if above_rounding(solver, (m, n), &s, components) {
                        assert!(excess <= 1e-6 * optimum, "{what}: {excess:e} above {optimum:e}");
                    }
                    if optimum == 0.0 {
                        assert_eq!(principal.squares.len(), components.min(s.len()), "{what}");
                    }
                    for (square, s) in principal.squares.iter().zip(&s) {
                        assert!(
                            (square - s * s).abs() <= 1e-6 * energy(&[s.max(1e-6)]) + 1e-13,
                            "{what}: {square} {s}"
                        );
                    }
                }
            }
        }
    }
}

/// Whether a relative excess of 1e-6 is above what the solver says of its rounding.
fn above_rounding(solver: Solver, shape: (usize, usize), s: &[f64], components: usize) -> bool {
    let optimum = energy(&s[components.min(s.len())..]);
    if solver == Solver::Gram {
        return optimum > 0.0 && s[components - 1] * optimum.sqrt() >= 1e3 * zero(shape) * energy(&s[..1]);
    }
    optimum > 1e-18 * energy(s)
}

#[test]
fn a_rank_below_the_components_gives_the_exact_smaller_model() {
    for (m, n, rank) in [(60, 90, 5), (90, 60, 1), (12, 12, 4)] {
        let s: Vec<f64> = (0..rank).map(|i| f64::from(10 - i as i32)).collect();
        let (f, _) = with_spectrum(m, n, &s, 3);
        for solver in EXACT {
            let principal = solve(solver, &f, 8);
            assert_eq!(principal.squares.len(), rank, "{solver:?}");
            assert!(left_over(&f, principal.vectors.view()) <= 1e-24 * energy(&s), "{solver:?}");
        }
        assert!(solve(Solver::Power, &f, 8).squares.len() >= rank);
    }
}

#[test]
fn a_start_orthogonal_to_the_leading_vectors_hides_nothing_from_krylov() {
    for (m, n, s) in [(90, 120, spectra(90)[4].1.clone()), (120, 90, [vec![2.0; 3], vec![1.0; 60]].concat())] {
        let (f, v) = with_spectrum(m, n, &s, 11);
        for components in [1, 3] {
            let start = v.slice(ndarray::s![components..2 * components, ..]);
            for solver in EXACT {
                let principal = solver.solver().leading(f.view(), components, Some(start)).unwrap();
                let (excess, optimum) =
                    (left_over(&f, principal.vectors.view()) - energy(&s[components..]), energy(&s[components..]));
                assert!(excess <= 1e-6 * optimum, "{solver:?}: {excess:e} of {optimum:e}");
            }
        }
    }
}

#[test]
fn a_good_start_saves_krylov_blocks() {
    let s: Vec<f64> = (0..150).map(|i| 1.0 / ((i + 1) as f64).sqrt()).collect();
    let (f, v) = with_spectrum(150, 300, &s, 5);
    let cold = solve(Solver::Krylov, &f, 4);
    let warm = Solver::Krylov.solver().leading(f.view(), 4, Some(v.slice(ndarray::s![..4, ..]))).unwrap();
    assert!(cold.iterations > 0, "the iteration was not used");
    assert!(warm.iterations < cold.iterations, "{} {}", warm.iterations, cold.iterations);
}
