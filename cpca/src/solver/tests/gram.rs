//! Eigenpairs of a Gram matrix from a guess.

use super::*;
use crate::solver::leading_of_gram;
use ndarray::s;

fn decaying(n: usize) -> (Array2<f64>, Array2<f64>, Vec<f64>) {
    let s: Vec<f64> = (0..n).map(|i| 1.0 / (i + 1) as f64).collect();
    let (f, v) = with_spectrum(n, n, &s, n as u64);
    (f.t().dot(&f), v, s)
}

/// Rows that are off by `noise` of their norm.
fn disturbed(v: ArrayView2<f64>, noise: f64) -> Array2<f64> {
    let (mut random, n) = (Random(9), v.ncols() as f64);
    v.mapv(|value| value + noise * random.normal() / n.sqrt())
}

/// tr G − tr V G Vᵀ.
fn left_in(gram: &Array2<f64>, vectors: ArrayView2<f64>) -> f64 {
    gram.diag().sum() - vectors.dot(gram).dot(&vectors.t()).diag().sum()
}

#[test]
fn with_any_guess_the_energy_left_over_is_the_optimum() {
    for n in [1, 2, 25, 64, 100, 155] {
        let (gram, v, s) = decaying(n);
        for components in [1, 4, 8] {
            let k = components.min(n);
            let optimum = energy(&s[k..]);
            let hidden = v.slice(s![k.min(n - k)..(2 * k).min(n), ..]).to_owned();
            let good = |noise| Some(disturbed(v.slice(s![..k, ..]), noise));
            for (name, start) in [("none", None), ("1e-6", good(1e-6)), ("1e-2", good(1e-2)), ("hidden", Some(hidden))]
            {
                let principal = leading_of_gram(gram.view(), components, start.as_ref().map(|s| s.view())).unwrap();
                assert_well_formed(&principal, n, 1e-10, name);
                let excess = left_in(&gram, principal.vectors.view()) - optimum;
                assert!(excess <= 1e-6 * optimum + 1e-13, "{n} {components} {name}: {excess:e} of {optimum:e}");
                assert!(principal.residual <= 1e-3, "{n} {components} {name}: {}", principal.residual);
            }
        }
    }
}

#[test]
fn a_good_guess_is_improved_instead_of_decomposing() {
    let (gram, v, _) = decaying(155);
    for noise in [1e-6, 1e-3, 1e-2] {
        let start = disturbed(v.slice(s![..8, ..]), noise);
        let principal = leading_of_gram(gram.view(), 8, Some(start.view())).unwrap();
        assert!(principal.iterations > 0, "{noise}");
    }
}

#[test]
fn repeated_zero_and_missing_eigenvalues_are_no_exception() {
    let v = orthonormal(30, 120, &mut Random(3));
    let gram = product(v.t().as_standard_layout().view(), v.view());
    let start = disturbed(v.slice(s![..5, ..]), 1e-2);
    // A projection: all eigenvalues are 1 or 0, and any five of the thirty will do.
    let principal = leading_of_gram(gram.view(), 5, Some(start.view())).unwrap();
    assert!((left_in(&gram, principal.vectors.view()) - 25.0).abs() < 1e-9);
    let three = product(v.slice(s![..3, ..]).t().as_standard_layout().view(), v.slice(s![..3, ..]));
    assert_eq!(leading_of_gram(three.view(), 5, Some(start.view())).unwrap().squares.len(), 3);
    assert!(
        leading_of_gram(Array2::zeros((100, 100)).view(), 5, Some(start.slice(s![.., ..100])))
            .unwrap()
            .squares
            .is_empty()
    );
}

#[test]
fn what_is_not_square_or_not_finite_is_refused_and_scale_is_exact() {
    assert!(leading_of_gram(Array2::zeros((2, 3)).view(), 1, None).is_err());
    assert!(leading_of_gram(Array2::from_elem((2, 2), f64::NAN).view(), 1, None).is_err());
    assert!(leading_of_gram(Array2::zeros((0, 0)).view(), 1, None).unwrap().squares.is_empty());
    let (gram, v, _) = decaying(100);
    let start = Some(v.slice(s![..3, ..]));
    let (plain, factor) = (leading_of_gram(gram.view(), 3, start).unwrap(), 2f64.powi(-100));
    let scaled = leading_of_gram((&gram * factor).view(), 3, start).unwrap();
    assert_eq!(scaled.vectors, plain.vectors);
    assert_eq!(scaled.squares, plain.squares.iter().map(|s| s * factor).collect::<Vec<_>>());
}
