//! What a matrix is multiplied by multiplies what comes back.

use ndarray::Array2;
use prt_harness::registry::registry;
use prt_tests::*;
use prt_transfer::TransferMatrix;

/// The same matrix with other elements.
fn with(matrix: &TransferMatrix, elements: Array2<f32>) -> TransferMatrix {
    let (rows, values) = (elements.nrows(), elements.into_raw_vec_and_offset().0);
    TransferMatrix::from_dense(values, rows, matrix.shape().responses, matrix.basis().clone())
        .and_then(|scaled| scaled.with_responses(matrix.responses().clone()))
        .expect("a case is valid")
}

/// Cases of magnitudes around 1.
fn harmless() -> Vec<Case> {
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
fn far(a: &Array2<f32>, b: &Array2<f32>) -> f32 {
    let largest = b.iter().fold(0f32, |most, v| most.max(v.abs()));
    a.iter().zip(b).fold(0f32, |most, (a, b)| most.max((a - b).abs())) / largest.max(f32::MIN_POSITIVE)
}

/// Samples of `cta` are drawn by what they hold, so that another factor draws others; everything else does what it does in units of the
/// largest element.
#[test]
fn a_power_of_two_passes_through_every_method() {
    let registry = registry();
    for label in labels(&registry).into_iter().filter(|label| label.codec.name != "cta") {
        for case in harmless() {
            let Some((_, plain)) = encode_where_defined(&registry, &label, &case) else { continue };
            let plain = decoded(&plain);
            for exponent in [-80, 80] {
                let factor = 2f32.powi(exponent);
                let scaled = Case { name: case.name, matrix: with(&case.matrix, elements(&case.matrix) * factor) };
                let compressed = encode_where_defined(&registry, &label, &scaled);
                let name = || format!("{label} on {} by 2^{exponent}", case.name);
                let (_, compressed) = compressed.unwrap_or_else(|| panic!("{} is refused", name()));
                let distance = far(&(decoded(&compressed) / factor), &plain);
                assert!(distance < 1e-5, "{}: {distance:e}", name());
            }
        }
    }
}

/// What `cta` finds at another scale is as good, in whatever numbers it is stored.
#[test]
fn a_power_of_two_costs_clustered_tensors_no_accuracy() {
    let registry = registry();
    for label in labels(&registry).into_iter().filter(|label| label.codec.name == "cta") {
        // Noise has no clusters: which are found is chance.
        for case in harmless().into_iter().filter(|case| case.name != "noise") {
            let square = |a: &Array2<f32>| a.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
            let exact = elements(&case.matrix);
            let error = |factor: f32| {
                let scaled = Case { name: case.name, matrix: with(&case.matrix, &exact * factor) };
                let (_, compressed) = encode_where_defined(&registry, &label, &scaled)?;
                Some(square(&(decoded(&compressed) / factor - &exact)) / square(&exact))
            };
            let Some(plain) = error(1.0) else { continue };
            for exponent in [-80, 80] {
                let scaled = error(2f32.powi(exponent)).unwrap_or(f64::NAN);
                assert!(scaled <= 1.2 * plain + 1e-6, "{label} on {} by 2^{exponent}: {scaled:e} {plain:e}", case.name);
            }
        }
    }
}
