//! What Tucker decompositions promise.

mod edges;
mod laws;

use ndarray::{Array1, Array2, ArrayD, ArrayViewD, Axis, Dimension};
use prt_tensor::tucker::{Algorithm, Decomposer, Ranks, Tucker, TuckerParams};
use prt_transfer::linalg;
use prt_transfer::progress::Quiet;
use prt_transfer::random::Random;

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

fn assert_same(a: &Tucker, b: &Tucker) {
    let bits = |array: &ArrayD<f64>| array.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(a.core()), bits(b.core()));
    assert!(
        a.factors().iter().zip(b.factors()).all(|(a, b)| bits(&a.clone().into_dyn()) == bits(&b.clone().into_dyn()))
    );
    assert_eq!((a.relative_error().to_bits(), a.report()), (b.relative_error().to_bits(), b.report()));
}
