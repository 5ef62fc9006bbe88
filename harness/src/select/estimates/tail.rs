//! Tail energy: what is left of the square when the largest parts are kept (Eckart and Young 1936 for components). The fewest parts whose rest is
//! within a bound are exactly what a model in full precision needs.

use prt_transfer::TransferMatrix;
use rayon::prelude::*;

/// Whose estimate it is.
pub(super) const NAME: &str = "tail energy";

/// Rows that are summed together: a fixed number, so that sums do not depend on threads.
const BLOCK: usize = 64;

/// The smallest index at which `tails`, descending, is at most `bound`.
pub(super) fn needed(tails: &[f64], bound: f64) -> usize {
    tails.partition_point(|tail| *tail > bound)
}

/// By the number of parts that are kept, from 0 to all: the sum of the others of `parts`, descending.
pub(super) fn sums(parts: &[f64]) -> Vec<f64> {
    let mut tails = vec![0.0; parts.len() + 1];
    for (i, part) in parts.iter().enumerate().rev() {
        tails[i] = tails[i + 1] + part.max(0.0);
    }
    tails
}

/// The same of all rows together, when each keeps so many of its largest elements.
pub(super) fn of_rows(matrix: &TransferMatrix) -> Vec<f64> {
    let (rows, lights) = (matrix.rows(), matrix.lights());
    let block = |block: usize| {
        let (mut tails, mut row) = (vec![0f64; lights + 1], vec![0f32; lights]);
        for index in block * BLOCK..rows.min((block + 1) * BLOCK) {
            matrix.gather(index, &mut row);
            let mut squares: Vec<f64> = row.iter().map(|&v| f64::from(v).powi(2)).filter(|s| *s > 0.0).collect();
            squares.sort_unstable_by(|a, b| b.total_cmp(a));
            tails.iter_mut().zip(sums(&squares)).for_each(|(all, tail)| *all += tail);
        }
        tails
    };
    let blocks: Vec<Vec<f64>> = (0..rows.div_ceil(BLOCK)).into_par_iter().map(block).collect();
    let mut tails = vec![0f64; lights + 1];
    for block in blocks {
        tails.iter_mut().zip(block).for_each(|(all, tail)| *all += tail);
    }
    tails
}
