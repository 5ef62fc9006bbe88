//! Matrices made of others, and how far what came of them is apart.

use crate::{Case, cases};
use ndarray::{Array2, ArrayView2};
use prt_transfer::TransferMatrix;

/// The same matrix with other rows, of whole samples.
pub fn with(matrix: &TransferMatrix, elements: Array2<f32>) -> TransferMatrix {
    let (rows, values) = (elements.nrows(), elements.as_standard_layout().iter().copied().collect());
    TransferMatrix::from_dense(values, rows, matrix.shape().responses, matrix.basis().clone())
        .and_then(|other| other.with_responses(matrix.responses().clone()))
        .expect("a case is valid")
}

/// Cases of magnitudes around 1.
pub fn harmless() -> Vec<Case> {
    let names = ["visibility", "smooth", "noise", "windows", "turned hemispheres"];
    let mut found: Vec<Case> = Vec::new();
    for case in cases() {
        if names.contains(&case.name) && found.iter().all(|other| other.name != case.name) {
            found.push(case);
        }
    }
    assert_eq!(found.len(), names.len());
    found
}

/// The largest difference, as a part of the largest magnitude of `b`.
pub fn far(a: ArrayView2<f32>, b: ArrayView2<f32>) -> f32 {
    let largest = b.iter().fold(0f32, |most, v| most.max(v.abs()));
    a.iter().zip(b).fold(0f32, |most, (a, b)| most.max((a - b).abs())) / largest.max(f32::MIN_POSITIVE)
}

/// Σ(a-b)²/Σb².
pub fn relative_error(a: ArrayView2<f32>, b: ArrayView2<f32>) -> f64 {
    let square = |v: f32| f64::from(v).powi(2);
    let lost: f64 = a.iter().zip(b).map(|(a, b)| square(a - b)).sum();
    if lost == 0.0 { 0.0 } else { lost / b.iter().map(|b| square(*b)).sum::<f64>() }
}
