//! The error of a compressed matrix: streamed by rows, summed in `f64`, the same on any number of threads.

use prt_transfer::{Compressed, TransferMatrix};
use rayon::prelude::*;

/// Rows of one task. Fixed, so that the order of additions does not depend on the threads.
const BLOCK: usize = 64;
/// Sums that run side by side, so that one addition need not wait for the one before.
const LANES: usize = 8;

/// Sums over all elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Σ d²
    pub squares: f64,
    /// Σ w d², with the sphere's weights; equals `squares` without them.
    pub weighted: f64,
    /// max |d|
    pub max: f64,
}

impl Sums {
    fn merge(self, other: Sums) -> Sums {
        Sums {
            squares: self.squares + other.squares,
            weighted: self.weighted + other.weighted,
            max: larger(self.max, other.max),
        }
    }
}

/// Sums of the matrix itself: what errors are relative to.
pub fn of_matrix(matrix: &TransferMatrix, weights: Option<&[f64]>) -> Sums {
    by_rows(matrix, weights, |_, out| out.fill(0.0))
}

/// Sums of T - T̃.
pub fn of_difference(matrix: &TransferMatrix, compressed: &Compressed, weights: Option<&[f64]>) -> Sums {
    by_rows(matrix, weights, |row, out| compressed.row_into(row, out))
}

/// `error / whole`; an error where there is nothing to be relative to is infinite.
pub fn relative(error: f64, whole: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / whole }
}

fn by_rows(matrix: &TransferMatrix, weights: Option<&[f64]>, other: impl Fn(usize, &mut [f32]) + Sync) -> Sums {
    let (rows, lights) = (matrix.rows(), matrix.lights());
    let block = |buffers: &mut (Vec<f32>, Vec<f32>), block: usize| {
        let (ours, theirs) = buffers;
        (block * BLOCK..rows.min((block + 1) * BLOCK)).fold(Sums::default(), |sums, row| {
            matrix.gather(row, ours);
            other(row, theirs);
            // Exact methods need no arithmetic: most rows of most exact methods end here.
            if ours == theirs { sums } else { sums.merge(of_row(ours, theirs, weights)) }
        })
    };
    let buffers = || (vec![0f32; lights], vec![0f32; lights]);
    let blocks: Vec<Sums> = (0..rows.div_ceil(BLOCK)).into_par_iter().map_init(buffers, block).collect();
    blocks.into_iter().fold(Sums::default(), Sums::merge)
}

fn of_row(ours: &[f32], theirs: &[f32], weights: Option<&[f64]>) -> Sums {
    let (mut squares, mut weighted, mut max) = ([0f64; LANES], [0f64; LANES], [0f64; LANES]);
    let mut step = |k: usize, lane: usize, weight: f64| {
        let d = f64::from(ours[k]) - f64::from(theirs[k]);
        squares[lane] += d * d;
        weighted[lane] += weight * d * d;
        max[lane] = larger(max[lane], d.abs());
    };
    let whole = ours.len() / LANES * LANES;
    for start in (0..whole).step_by(LANES) {
        for lane in 0..LANES {
            step(start + lane, lane, weights.map_or(1.0, |w| w[start + lane]));
        }
    }
    for k in whole..ours.len() {
        step(k, k - whole, weights.map_or(1.0, |w| w[k]));
    }
    Sums { squares: squares.iter().sum(), weighted: weighted.iter().sum(), max: max.into_iter().fold(0.0, larger) }
}

/// Not `f64::max`, which would let a NaN pass for no error.
fn larger(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::{method, registry};
    use prt_transfer::{LightBasis, Quiet};

    /// Rows enough for several blocks, columns that do not fill the lanes.
    fn matrix(scale: f32) -> TransferMatrix {
        let basis = LightBasis::Cubemap { resolution: 3 };
        let values = (0..200 * 54).map(|i| scale * ((i * 37 % 101) as f32 - 50.0)).collect();
        TransferMatrix::from_dense(values, 200, 1, basis).unwrap()
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs()
    }

    #[test]
    fn the_sums_are_those_of_the_definition() {
        let (t, half) = (matrix(1.0), matrix(0.5));
        let weights = t.basis().sphere_weights().unwrap();
        let compressed = method(&registry(), "csr").unwrap().encode(&half, &Quiet).unwrap();
        let sums = of_difference(&t, &compressed, Some(&weights));
        let d = |i: usize| f64::from(t.as_dense().unwrap()[i]) / 2.0;
        let squares: f64 = (0..200 * 54).map(|i| d(i) * d(i)).sum();
        let weighted: f64 = (0..200 * 54).map(|i| weights[i % 54] * d(i) * d(i)).sum();
        assert!(close(sums.squares, squares) && close(sums.weighted, weighted), "{sums:?} {squares} {weighted}");
        assert_eq!(sums.max, 25.0);
        // Half the matrix is missing: a quarter of its energy.
        let whole = of_matrix(&t, Some(&weights));
        assert!(close(relative(sums.squares, whole.squares), 0.25));
    }

    #[test]
    fn the_sums_are_the_same_on_any_number_of_threads() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| of_matrix(&matrix(0.1), None))
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn an_exact_method_has_no_error_at_all_and_nothing_is_relative_to_nothing() {
        let t = matrix(1.0);
        let compressed = method(&registry(), "csr").unwrap().encode(&t, &Quiet).unwrap();
        assert_eq!(of_difference(&t, &compressed, None), Sums::default());
        assert_eq!((relative(0.0, 0.0), relative(1.0, 0.0)), (0.0, f64::INFINITY));
    }
}
