//! What cases stand on: matrices of numbers, and what a method makes of them.

use crate::error_sums;
use crate::files;
use crate::registry::registry;
use ndarray::{Array2, ArrayView2};
use prt_transfer::random::Random;
use prt_transfer::{Compressed, LightBasis, Metric, Quiet, Result, TransferMatrix};

/// rows x lights in single precision, a response for each row.
pub(super) fn plain(rows: ArrayView2<f64>) -> Result<TransferMatrix> {
    on(rows, 1, LightBasis::Plain { lights: rows.ncols() })
}

/// rows x lights on a basis, `responses` rows a sample.
pub(super) fn on(rows: ArrayView2<f64>, responses: usize, basis: LightBasis) -> Result<TransferMatrix> {
    TransferMatrix::from_dense(rows.iter().map(|v| *v as f32).collect(), rows.nrows(), responses, basis)
}

/// What came back from the file of a method.
pub(super) fn encoded(label: &str, matrix: &TransferMatrix) -> Result<Compressed> {
    let registry = registry();
    reloaded(&registry.method(&label.parse()?)?.encode(matrix, &Quiet)?)
}

/// Through a file's bytes.
pub(super) fn reloaded(compressed: &Compressed) -> Result<Compressed> {
    files::prt_from_bytes(&files::prt_bytes(compressed, &Quiet)?, &registry())
}

/// Every row, rows x lights.
pub(super) fn decoded(compressed: &Compressed) -> Array2<f32> {
    let mut rows = Array2::zeros((compressed.shape().rows(), compressed.shape().lights));
    compressed.rows_into(0, rows.view_mut());
    rows
}

/// Σ(T-T̃)²/ΣT², each element alike.
pub(super) fn error(label: &str, matrix: &TransferMatrix) -> Result<f64> {
    Ok(errors(&encoded(label, matrix)?, matrix)?[0])
}

/// The same, and in the matrix's metric.
pub(super) fn errors(compressed: &Compressed, matrix: &TransferMatrix) -> Result<[f64; 2]> {
    let metric = Metric::of(matrix)?;
    let whole = error_sums::of_matrix(matrix, &metric);
    let lost = error_sums::of_difference(matrix, compressed, &metric);
    Ok([error_sums::relative(lost.squares, whole.squares), error_sums::relative(lost.weighted, whole.weighted)])
}

/// Σ(a-b)²/Σb².
pub(super) fn distance(a: ArrayView2<f64>, b: ArrayView2<f64>) -> f64 {
    let lost = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    error_sums::relative(lost, square(b))
}

/// Σ a².
pub(super) fn square(a: ArrayView2<f64>) -> f64 {
    a.iter().map(|v| v * v).sum()
}

/// Numbers of mean 0 and variance 1, rows x columns.
pub(super) fn noise(rows: usize, columns: usize, seed: u64) -> Array2<f64> {
    let mut random = Random(seed);
    Array2::from_shape_simple_fn((rows, columns), || random.normal())
}

/// A direction, all alike.
pub(super) fn direction(random: &mut Random) -> [f64; 3] {
    let (z, phi) = (2.0 * random.uniform() - 1.0, std::f64::consts::TAU * random.uniform());
    let r = (1.0 - z * z).sqrt();
    [r * phi.cos(), r * phi.sin(), z]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
