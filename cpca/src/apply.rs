//! Relighting in two stages (Sloan et al. 2003, §6): representatives meet the light, samples add up their cluster's.

use crate::encoded::EncodedCpca;
use crate::kernel::{self, Products, SPARE};
use crate::layout::BLOCK;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};
use prt_transfer::matrix::check_apply;
use prt_transfer::numbers::UNIT;
use prt_transfer::{Count, Flops, NoCount, Result, Shape, Tally};
use rayon::prelude::*;

/// Samples given to a thread at a time, a multiple of [`BLOCK`].
const TASK: usize = 16 * BLOCK;

/// `out` (rows x channels) = T̃ · `lights` (lights x channels).
pub(crate) fn apply(encoded: &EncodedCpca, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) -> Result<()> {
    check_apply(encoded.shape, &lights, &out)?;
    let (channels, responses) = (lights.ncols(), encoded.shape.responses);
    if out.is_empty() {
        return Ok(());
    }
    let products = project(encoded, lights, &mut NoCount)?;
    let tasks = out.axis_chunks_iter_mut(Axis(0), TASK * responses).into_par_iter().enumerate();
    tasks.for_each_init(Vec::new, |buffer, (task, mut rows)| match rows.as_slice_mut() {
        Some(rows) => combine(encoded, &products, task * TASK, rows, buffer, &mut NoCount),
        // An output with gaps: by way of one without.
        None => {
            let mut whole = Array2::zeros((rows.nrows(), channels));
            let slice = whole.as_slice_mut().expect("a fresh array is contiguous");
            combine(encoded, &products, task * TASK, slice, buffer, &mut NoCount);
            rows.assign(&whole);
        }
    });
    Ok(())
}

/// Operations of relighting with one channel.
pub(crate) fn flops(encoded: &EncodedCpca, light: &[f32]) -> Flops {
    let mut tally = Tally::default();
    let light = ArrayView2::from_shape((light.len(), 1), light).expect("a slice is a column");
    if let Ok(products) = project(encoded, light, &mut tally) {
        let mut out = vec![0f32; encoded.shape.rows()];
        combine(encoded, &products, 0, &mut out, &mut Vec::new(), &mut tally);
    }
    tally.0
}

/// Stage 1: `R_j = X_j l` for the mean and the components of every cluster, those multiplied by the scale of their
/// weights.
fn project<C: Count>(encoded: &EncodedCpca, lights: ArrayView2<f32>, count: &mut C) -> Result<Products> {
    let (numbers, layout) = (&encoded.representatives, &encoded.layout);
    let shape = Shape { samples: layout.vectors(), ..encoded.shape };
    let mut products = Array2::zeros((shape.rows(), lights.ncols()));
    let out = products.view_mut();
    count.multiply_add(numbers.len());
    numbers.apply_stored(0, shape, lights, out)?;
    let unit = numbers.unit();
    count.factors((0..numbers.len()).map(|at| numbers.stored(at) * unit));
    let mut products = products.into_raw_vec_and_offset().0;
    let width = shape.responses * lights.ncols();
    scale(encoded, &mut products, width, count);
    Ok(Products::new(products, width, layout))
}

/// Gives R the scales that its numbers and the weights which will meet them were stored without.
fn scale<C: Count>(encoded: &EncodedCpca, products: &mut [f32], width: usize, count: &mut C) {
    let (layout, of_weights) = (&encoded.layout, encoded.weights.scales());
    let of_vectors = encoded.representatives.scales();
    if width == 0 || of_vectors.is_none() && of_weights.is_none() {
        return;
    }
    for cluster in 0..layout.clusters() {
        let first = layout.first_vector(cluster);
        let own = products[first * width..].chunks_exact_mut(width).take(1 + layout.components(cluster));
        for (j, product) in own.enumerate() {
            // In double precision: a product of two scales may leave the range of f32 where R does not.
            let vector = of_vectors.map(|scales| f64::from(scales[first + j]) / f64::from(UNIT));
            let weight = of_weights.filter(|_| j > 0).map(|scales| f64::from(scales[first - cluster + j - 1]));
            let factor = match (vector, weight) {
                (Some(vector), Some(weight)) => {
                    count.multiply(1);
                    count.factors([weight as f32].into_iter());
                    vector * weight
                }
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => continue,
            };
            count.multiply(width);
            count.factors(std::iter::repeat_n(factor as f32, width));
            product.iter_mut().for_each(|y| *y = (f64::from(*y) * factor) as f32);
        }
    }
}

/// Stage 2: `e_p = R_0 + Σ_j w_p^j R_j` for the samples from `first` on, a multiple of [`BLOCK`]; `out` is samples x
/// responses x channels. `buffer` is scratch.
fn combine<C: Count>(
    encoded: &EncodedCpca,
    products: &Products,
    first: usize,
    out: &mut [f32],
    buffer: &mut Vec<f32>,
    count: &mut C,
) {
    let mut at = encoded.layout.first_weight(first, &encoded.ids);
    let mut clusters = [0; BLOCK];
    for (block, out) in out.chunks_mut(BLOCK * products.width()).enumerate() {
        let clusters = &mut clusters[..out.len() / products.width()];
        encoded.ids.fill(first + block * BLOCK, clusters);
        let end = at + products.weights_of(clusters);
        let weights = encoded.weights.unpack(at..end, SPARE, buffer);
        kernel::combine(products, clusters, weights, out, count);
        at = end;
    }
}
