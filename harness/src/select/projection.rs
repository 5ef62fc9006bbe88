//! The error of T̃ = C̃·B without making a row of T̃.
//!
//! With W the weights of the columns, P = T W Bᵀ and G = B W Bᵀ the squared error is
//!
//! ```text
//! Σ_r |t_r - c_r B|² = Σ_r |t_r|² - 2 <p_r, c_r> + c_r G c_rᵀ
//! ```
//!
//! where C has far fewer columns than T. P and G are made once for all models of a light transform.

use crate::measure::Reference;
use ndarray::{Array2, ArrayViewMut2, s};
use prt_transfer::linalg::times_transposed_f64;
use prt_transfer::method::Transformed;
use prt_transfer::{Compressed, LightTransform};
use rayon::prelude::*;

/// P and G, without weights and with those of the sphere.
pub(super) struct Projection {
    plain: Products,
    weighted: Option<Products>,
}

struct Products {
    /// P, rows x C's columns.
    of_rows: Array2<f64>,
    /// G, C's columns squared.
    gram: Array2<f64>,
}

/// Rows that are taken together: a fixed number, so that sums do not depend on threads.
const BLOCK: usize = 32;
/// C's columns are at most a part of T's: one in so many.
const LEAST_RATIO: usize = 4;
/// P takes at most so many numbers.
const MOST_NUMBERS: usize = 1 << 26;
/// Below this part of the square, what is left of it is rounding of B in single precision: it is measured on rows.
const RESOLVED: f64 = 1e-9;

impl Projection {
    /// Where a light transform leaves so few columns that this is less work, and no metric mixes rows.
    pub(super) fn worthwhile(transformed: &Transformed, reference: &Reference) -> Option<Projection> {
        let (matrix, metric) = (reference.matrix(), reference.metric());
        let columns = transformed.coefficients()?.lights();
        if columns * LEAST_RATIO > matrix.lights() || matrix.rows() * columns > MOST_NUMBERS || metric.mixes_responses()
        {
            return None;
        }
        let rows = rows_of(transformed.transform(), columns, matrix.lights());
        let products = |weights: Option<&[f64]>| {
            let weighted = Array2::from_shape_fn(rows.dim(), |(j, k)| rows[[j, k]] * weights.map_or(1.0, |w| w[k]));
            let mut gram = Array2::zeros((columns, columns));
            times_transposed_f64(rows.view(), weighted.view(), gram.view_mut());
            let mut of_rows = Array2::zeros((matrix.rows(), columns));
            blocks(&mut of_rows, columns).for_each(|(first, mut out)| {
                let (mut values, count) = (vec![0f32; matrix.lights()], out.nrows());
                let mut taken = Array2::zeros((count, matrix.lights()));
                for (i, mut row) in taken.outer_iter_mut().enumerate() {
                    matrix.gather(first + i, &mut values);
                    row.iter_mut().zip(&values).for_each(|(to, &value)| *to = f64::from(value));
                }
                times_transposed_f64(taken.view(), weighted.view(), out.view_mut());
            });
            Products { of_rows, gram }
        };
        let weighted = metric.weights().map(|weights| products(Some(weights)));
        Some(Projection { plain: products(None), weighted })
    }

    /// As [`Reference::error_of`].
    pub(super) fn error_of(&self, compressed: &Compressed, reference: &Reference) -> (f64, Option<f64>) {
        let whole = reference.whole();
        let plain = self.plain.square(compressed, whole.squares);
        let weighted = self.weighted.as_ref().map(|products| products.square(compressed, whole.weighted));
        let resolved = |part: f64| part > RESOLVED;
        if !resolved(plain) || !weighted.is_none_or(resolved) {
            return reference.error_of(compressed);
        }
        (plain, weighted.or_else(|| reference.metric().is_known().then_some(plain)))
    }
}

impl Products {
    /// The squared error over the square of T.
    fn square(&self, compressed: &Compressed, whole: f64) -> f64 {
        let (rows, columns) = self.of_rows.dim();
        let parts: Vec<f64> = (0..rows.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let range = block * BLOCK..rows.min((block + 1) * BLOCK);
                let mut single = Array2::zeros((range.len(), columns));
                compressed.coefficient_rows_into(range.start, single.view_mut());
                let coefficients = single.mapv(f64::from);
                let mut product = Array2::zeros(coefficients.dim());
                // G is its own transpose.
                times_transposed_f64(coefficients.view(), self.gram.view(), product.view_mut());
                product.scaled_add(-2.0, &self.of_rows.slice(s![range, ..]));
                (product * coefficients).sum()
            })
            .collect();
        1.0 + parts.iter().sum::<f64>() / whole
    }
}

/// The rows of B: what the light transform makes of a row of C with a single 1.
fn rows_of(transform: &dyn LightTransform, columns: usize, lights: usize) -> Array2<f64> {
    let mut rows = Array2::zeros((columns, lights));
    blocks(&mut rows, lights).for_each(|(first, mut out)| {
        let (mut unit, mut row) = (vec![0f32; columns], vec![0f32; lights]);
        for (i, mut out) in out.outer_iter_mut().enumerate() {
            unit[first + i] = 1.0;
            transform.restore_row_into(&unit, &mut row);
            unit[first + i] = 0.0;
            out.iter_mut().zip(&row).for_each(|(to, &value)| *to = f64::from(value));
        }
    });
    rows
}

/// Blocks of consecutive rows, each with its first.
fn blocks(array: &mut Array2<f64>, width: usize) -> impl ParallelIterator<Item = (usize, ArrayViewMut2<'_, f64>)> {
    let values = array.as_slice_mut().expect("a new array is contiguous");
    values.par_chunks_mut((BLOCK * width).max(1)).enumerate().map(move |(i, values)| {
        let shape = (values.len() / width.max(1), width);
        (i * BLOCK, ArrayViewMut2::from_shape(shape, values).expect("a chunk is whole rows"))
    })
}
