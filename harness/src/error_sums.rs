//! The error of a compressed matrix: streamed by samples, summed in `f64`, the same on any number of threads.

use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use prt_transfer::{Compressed, Metric, TransferMatrix};
use rayon::prelude::*;

/// Rows of one task, about. Fixed, so that the order of additions does not depend on the threads.
const BLOCK: usize = 64;
/// Sums that run side by side, so that one addition need not wait for the one before.
const LANES: usize = 8;

/// Sums over all elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Σ d²
    pub squares: f64,
    /// The same of radiance, in the matrix's metric; equals `squares` where it has none.
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
pub fn of_matrix(matrix: &TransferMatrix, metric: &Metric) -> Sums {
    by_samples(matrix, metric, |_, mut out| out.fill(0.0))
}

/// Sums of T - T̃.
pub fn of_difference(matrix: &TransferMatrix, compressed: &Compressed, metric: &Metric) -> Sums {
    by_samples(matrix, metric, |first, out| compressed.rows_into(first, out))
}

/// Sums of C - C̃ of T ≈ C·B, given C.
pub fn of_coefficients(coefficients: &TransferMatrix, compressed: &Compressed, metric: &Metric) -> Sums {
    by_samples(coefficients, metric, |first, out| compressed.coefficient_rows_into(first, out))
}

/// `error / whole`; an error where there is nothing to be relative to is infinite.
pub fn relative(error: f64, whole: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / whole }
}

/// `other` is given the first of so many rows.
fn by_samples(matrix: &TransferMatrix, metric: &Metric, other: impl Fn(usize, ArrayViewMut2<f32>) + Sync) -> Sums {
    let (shape, samples_of_task) = (matrix.shape(), BLOCK.div_ceil(matrix.shape().responses));
    let (responses, lights) = (shape.responses, shape.lights);
    let of_sample = |ours: &mut [f32], differences: &mut [f64], sample: usize, theirs: ArrayView2<f32>| {
        let mut sums = Sums::default();
        let mut equal = true;
        for (response, theirs) in theirs.outer_iter().enumerate() {
            matrix.gather(sample * responses + response, ours);
            let theirs = theirs.to_slice().expect("rows of a new array are contiguous");
            // Exact methods need no arithmetic: most rows of most exact methods end here.
            if ours != theirs {
                equal = false;
                sums = sums.merge(of_row(ours, theirs, metric.weights()));
            }
            if metric.mixes_responses() {
                let differences = &mut differences[response * lights..][..lights];
                let both = ours.iter().zip(theirs);
                differences.iter_mut().zip(both).for_each(|(d, (a, b))| *d = f64::from(*a) - f64::from(*b));
            }
        }
        if metric.mixes_responses() && !equal {
            sums.weighted = metric.square_of(differences, lights);
        }
        sums
    };
    let task = |Buffers { ours, theirs, differences }: &mut Buffers, task: usize| {
        let samples = task * samples_of_task..shape.samples.min((task + 1) * samples_of_task);
        let mut theirs = theirs.slice_mut(s![..samples.len() * responses, ..]);
        other(samples.start * responses, theirs.view_mut());
        let of_samples = samples.clone().zip(theirs.axis_chunks_iter(Axis(0), responses));
        of_samples.fold(Sums::default(), |sums, (i, theirs)| sums.merge(of_sample(ours, differences, i, theirs)))
    };
    let differences = if metric.mixes_responses() { responses * lights } else { 0 };
    let buffers = || Buffers {
        ours: vec![0.0; lights],
        theirs: Array2::zeros((samples_of_task.min(shape.samples) * responses, lights)),
        differences: vec![0.0; differences],
    };
    let tasks = 0..shape.samples.div_ceil(samples_of_task);
    let sums: Vec<Sums> = tasks.into_par_iter().map_init(buffers, task).collect();
    sums.into_iter().fold(Sums::default(), Sums::merge)
}

/// A row of the matrix, rows of a task of the other, and the differences of all rows of a sample.
struct Buffers {
    ours: Vec<f32>,
    theirs: Array2<f32>,
    differences: Vec<f64>,
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
    use prt_transfer::sh::HemisphereSh;
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
        let metric = Metric::of(&t).unwrap();
        let weights = t.basis().sphere_weights().unwrap();
        let compressed = method(&registry(), "csr").unwrap().encode(&half, &Quiet).unwrap();
        let sums = of_difference(&t, &compressed, &metric);
        let d = |i: usize| f64::from(t.as_dense().unwrap()[i]) / 2.0;
        let squares: f64 = (0..200 * 54).map(|i| d(i) * d(i)).sum();
        let weighted: f64 = (0..200 * 54).map(|i| weights[i % 54] * d(i) * d(i)).sum();
        assert!(close(sums.squares, squares) && close(sums.weighted, weighted), "{sums:?} {squares} {weighted}");
        assert_eq!(sums.max, 25.0);
        // Half the matrix is missing: a quarter of its energy.
        let whole = of_matrix(&t, &metric);
        assert!(close(relative(sums.squares, whole.squares), 0.25));
    }

    #[test]
    fn an_error_of_exit_radiance_is_one_of_radiance_in_whatever_coordinates() {
        // The same change of the same function, in harmonics and in orthonormal coordinates.
        let sh = HemisphereSh::new(24).unwrap();
        let orthonormal: Vec<f64> = (0..3 * 24 * 4).map(|i| ((i * 37 % 101) as f64 - 50.0) * 0.1).collect();
        let exit = |kind: &str, scale: f64| {
            let mut values = orthonormal.clone();
            if kind == "exit" {
                values.chunks_mut(24 * 4).for_each(|sample| sh.to_harmonic(sample).unwrap());
            }
            let values = values.iter().map(|v| (scale * v) as f32).collect();
            let basis = LightBasis::SphericalHarmonics { order: 2 };
            let matrix = TransferMatrix::from_dense(values, 72, 24, basis).unwrap();
            matrix.with_responses(format!("{kind}:24").parse().unwrap()).unwrap()
        };
        let squares: f64 = orthonormal.iter().map(|v| v * v).sum();
        for kind in ["exit", "exit-orthonormal"] {
            let (t, near) = (exit(kind, 1.0), exit(kind, 0.9));
            let compressed = method(&registry(), "csr").unwrap().encode(&near, &Quiet).unwrap();
            let sums = of_difference(&t, &compressed, &Metric::of(&t).unwrap());
            assert!((sums.weighted / (0.01 * squares) - 1.0).abs() < 1e-4, "{kind}: {sums:?} {squares}");
            assert_eq!(kind == "exit", sums.squares > 2.0 * sums.weighted, "{kind}: {sums:?}");
        }
    }

    #[test]
    fn the_sums_are_the_same_on_any_number_of_threads() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let t = matrix(0.1);
            pool.install(|| of_matrix(&t, &Metric::of(&t).unwrap()))
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn an_exact_method_has_no_error_at_all_and_nothing_is_relative_to_nothing() {
        let t = matrix(1.0);
        let compressed = method(&registry(), "csr").unwrap().encode(&t, &Quiet).unwrap();
        assert_eq!(of_difference(&t, &compressed, &Metric::of(&t).unwrap()), Sums::default());
        assert_eq!((relative(0.0, 0.0), relative(1.0, 0.0)), (0.0, f64::INFINITY));
    }
}
