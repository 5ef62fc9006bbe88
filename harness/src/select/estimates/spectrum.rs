//! The spectrum of a matrix: squares of its singular values as samples around their mean.

use anyhow::Result;
use ndarray::{Array1, Array2};
use prt_transfer::linalg::{add_gram, eigenvalues, times_transposed_f64};
use prt_transfer::{Metric, TransferMatrix};

/// Squared singular values of samples less their mean.
#[derive(Clone, Debug)]
pub(super) struct Spectrum {
    /// Descending.
    pub(super) values: Vec<f64>,
    /// How many vectors of so many numbers as there are values they come from.
    pub(super) observations: usize,
    /// The square of everything, the mean included.
    pub(super) whole: f64,
}

/// The smaller side of a matrix is at most this; samples evenly spread stand for a larger one.
const MOST: usize = 1024;
/// Numbers of a block of samples, so that a dense copy of them stays small.
const BLOCK: usize = 1 << 22;

impl Spectrum {
    /// Of the samples of a matrix, all rows of each as one vector, in orthonormal coordinates of `metric` where one is given.
    ///
    /// # Errors
    /// An iteration that does not end.
    pub(super) fn of(matrix: &TransferMatrix, metric: Option<&Metric>) -> Result<Spectrum> {
        let shape = matrix.shape();
        let dimension = shape.responses * shape.lights;
        let step = if dimension > MOST { shape.samples.div_ceil(MOST).max(1) } else { 1 };
        let samples: Vec<usize> = (0..shape.samples).step_by(step).collect();
        let read = |sample: usize, out: &mut [f64]| {
            let mut row = vec![0f32; shape.lights];
            for (response, out) in out.chunks_mut(shape.lights).enumerate() {
                matrix.gather(sample * shape.responses + response, &mut row);
                out.iter_mut().zip(&row).for_each(|(to, &value)| *to = f64::from(value));
            }
            if let Some(metric) = metric {
                metric.to_orthonormal(out, shape.lights);
            }
        };
        let block = (BLOCK / dimension.max(1)).max(1);
        let blocks: Vec<&[usize]> = samples.chunks(block).collect();
        let taken = |block: &[usize]| {
            let mut vectors = Array2::zeros((block.len(), dimension));
            for (mut vector, &sample) in vectors.outer_iter_mut().zip(block) {
                read(sample, vector.as_slice_mut().expect("rows of a new array are contiguous"));
            }
            vectors
        };
        let (mut mean, mut whole) = (Array1::<f64>::zeros(dimension), 0.0);
        for block in &blocks {
            let vectors = taken(block);
            whole += vectors.iter().map(|v| v * v).sum::<f64>();
            mean += &vectors.sum_axis(ndarray::Axis(0));
        }
        mean /= samples.len().max(1) as f64;
        let centred = |block: &[usize]| taken(block) - &mean;
        let gram = match dimension <= samples.len() {
            true => {
                let mut gram = Array2::zeros((dimension, dimension));
                blocks.iter().for_each(|block| add_gram(centred(block).view(), gram.view_mut()));
                gram
            }
            false => between(&blocks, samples.len(), block, centred),
        };
        let mut values = eigenvalues(gram.view())?;
        // A mean takes one dimension from as many samples.
        values.truncate(dimension.min(samples.len().saturating_sub(1)));
        let observations = dimension.max(samples.len().saturating_sub(1));
        Ok(Spectrum { values, observations, whole })
    }

    /// What is left of the square by the number of components that are kept.
    pub(super) fn tails(&self) -> Vec<f64> {
        super::tail::sums(&self.values)
    }
}

/// Inner products of all samples with each other, block by block.
fn between(blocks: &[&[usize]], count: usize, block: usize, centred: impl Fn(&[usize]) -> Array2<f64>) -> Array2<f64> {
    let mut gram = Array2::zeros((count, count));
    for (i, rows) in blocks.iter().enumerate() {
        let rows = centred(rows);
        for (j, columns) in blocks.iter().enumerate().take(i + 1) {
            let columns = if i == j { rows.clone() } else { centred(columns) };
            let mut product = Array2::zeros((rows.nrows(), columns.nrows()));
            times_transposed_f64(rows.view(), columns.view(), product.view_mut());
            let place = ndarray::s![i * block..i * block + rows.nrows(), j * block..j * block + columns.nrows()];
            gram.slice_mut(place).assign(&product);
        }
    }
    gram
}
