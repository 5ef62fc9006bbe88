mod gram;
mod power;
mod promises;
mod spectra;

use super::Principal;
use crate::params::Solver;
use crate::solver::basis::{Basis, product};
use ndarray::{Array2, ArrayView2};
use prt_transfer::random::Random;

/// Solvers that keep promises.
const EXACT: [Solver; 4] = [Solver::Krylov, Solver::Gram, Solver::Svd, Solver::Auto];

/// Random orthonormal rows.
fn orthonormal(rows: usize, n: usize, random: &mut Random) -> Array2<f64> {
    let mut basis = Basis::new(rows, n);
    basis.extend(Array2::from_shape_simple_fn((rows, n), || random.normal()), 1e-10);
    basis.into_rows()
}

/// F = U diag(s) Vᵀ (m x n) and Vᵀ.
fn with_spectrum(m: usize, n: usize, s: &[f64], seed: u64) -> (Array2<f64>, Array2<f64>) {
    let mut random = Random(seed);
    let mut u = orthonormal(s.len(), m, &mut random);
    let v = orthonormal(s.len(), n, &mut random);
    for (mut row, s) in u.rows_mut().into_iter().zip(s) {
        row.mapv_inplace(|value| value * s);
    }
    (product(u.t().as_standard_layout().view(), v.view()), v)
}

/// ‖F − F VᵀV‖².
fn left_over(f: &Array2<f64>, vectors: ArrayView2<f64>) -> f64 {
    (f - f.dot(&vectors.t()).dot(&vectors)).iter().map(|v| v * v).sum()
}

fn energy(s: &[f64]) -> f64 {
    s.iter().map(|s| s * s).sum()
}

fn solve(solver: Solver, f: &Array2<f64>, components: usize) -> Principal {
    solver.solver().leading(f.view(), components, None).unwrap()
}

/// What holds for every answer: descending squares, orthonormal vectors, signs.
fn assert_well_formed(principal: &Principal, n: usize, orthonormal: f64, what: &str) {
    let Principal { squares, vectors, residual, .. } = principal;
    assert_eq!(vectors.dim(), (squares.len(), n), "{what}");
    assert!(squares.is_sorted_by(|a, b| a >= b) && squares.iter().all(|s| *s > 0.0 && s.is_finite()), "{what}");
    assert!(residual.is_finite(), "{what}");
    let products = vectors.dot(&vectors.t()) - Array2::<f64>::eye(squares.len());
    let worst = products.iter().fold(0f64, |worst, v| worst.max(v.abs()));
    assert!(worst <= orthonormal, "{what}: {worst:e} from orthonormal");
    for row in vectors.rows() {
        let largest = row.iter().fold(0f64, |l, v| if v.abs() > l.abs() { *v } else { l });
        assert!(largest > 0.0, "{what}: a largest element of {largest}");
    }
}
