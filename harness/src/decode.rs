//! `prt decode`: what a compressed matrix stands for, in the form in which it came.

use crate::files;
use crate::progress::Bar;
use crate::registry::registry;
use crate::room;
use clap::Args;
use ndarray::{Array2, ArrayView1, ArrayViewMut2, s};
use prt_transfer::matrix::Layout;
use prt_transfer::{Compressed, Extent, Progress, Result, TransferMatrix};
use rayon::prelude::*;
use std::path::PathBuf;

/// Arguments of `prt decode`.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  prt decode teapot.prt -o decoded.npz")]
pub struct Decode {
    /// Compressed matrix
    #[arg(value_name = "FILE.prt")]
    pub input: PathBuf,
    /// Where to write the matrix: .npz or .mtx (sparse), .npy (dense)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Decode) -> anyhow::Result<()> {
    let compressed = files::read_prt(&arguments.input, &registry())?;
    let shape = compressed.shape();
    if compressed.layout() != Layout::Sparse {
        let extent = Extent { shape, non_zeros: 0, sparse: false };
        let instead = "prt relight and prt render work on the compressed matrix";
        room::check(&arguments.output.display().to_string(), extent.bytes(), instead)?;
    }
    Ok(files::write_matrix(&arguments.output, &matrix(&compressed, &Bar::default())?)?)
}

/// Rows decoded between two reports, and held twice while they are put together.
const BLOCK: usize = 1024;
/// Rows that one task reconstructs at once.
const AT_ONCE: usize = 32;

/// Every row of T̃: sparse where T came sparse, dense where it came dense.
pub fn matrix(compressed: &Compressed, progress: &dyn Progress) -> Result<TransferMatrix> {
    let (shape, basis, meaning) = (compressed.shape(), compressed.basis().clone(), compressed.responses().clone());
    let (rows, lights) = (shape.rows(), shape.lights);
    progress.start("decode", rows as u64);
    if compressed.layout() != Layout::Sparse {
        let mut values = vec![0f32; rows * lights];
        values.par_chunks_mut((AT_ONCE * lights).max(1)).enumerate().try_for_each(|(task, out)| {
            let count = out.len() / lights.max(1);
            let out = ArrayViewMut2::from_shape((count, lights), out).expect("a chunk is whole rows");
            compressed.rows_into(task * AT_ONCE, out);
            progress.advance(count as u64)
        })?;
        let matrix = TransferMatrix::from_dense(values, rows, shape.responses, basis)?.with_responses(meaning)?;
        return Ok(if compressed.layout() == Layout::Samples { matrix.by_samples() } else { matrix });
    }
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for first in (0..rows).step_by(BLOCK) {
        let last = rows.min(first + BLOCK);
        let task = |buffer: &mut Array2<f32>, from: usize| {
            let mut values = buffer.slice_mut(s![..AT_ONCE.min(last - from), ..]);
            compressed.rows_into(from, values.view_mut());
            let kept = |row: ArrayView1<f32>| -> Vec<(u32, f32)> {
                row.iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(col, v)| (col as u32, *v)).collect()
            };
            values.outer_iter().map(kept).collect::<Vec<_>>()
        };
        let tasks = (first..last).into_par_iter().step_by(AT_ONCE);
        let block: Vec<_> = tasks.map_init(|| Array2::zeros((AT_ONCE, lights)), task).collect();
        let block = block.concat();
        for row in &block {
            columns.extend(row.iter().map(|(col, _)| col));
            values.extend(row.iter().map(|(_, value)| value));
            offsets.push(columns.len());
        }
        progress.advance(block.len() as u64)?;
    }
    TransferMatrix::from_csr(offsets, columns, values, shape.responses, basis)?.with_responses(meaning)
}

#[cfg(test)]
mod tests {
    use super::matrix;
    use crate::registry::{method, registry};
    use prt_transfer::{LightBasis, Quiet, TransferMatrix};

    #[test]
    fn a_matrix_comes_back_as_it_came() {
        let basis = LightBasis::Plain { lights: 3 };
        let values: Vec<f32> = (0..3 * 4000).map(|i| (i % 5) as f32).collect();
        let dense = TransferMatrix::from_dense(values, 4000, 2, basis.clone()).unwrap();
        let offsets = (0..=3000).map(|row| row / 2).collect();
        let columns = (0..1500).map(|i| i % 3).collect();
        let sparse = TransferMatrix::from_csr(offsets, columns, vec![0.25; 1500], 3, basis).unwrap();
        for original in [dense.clone().by_samples(), dense, sparse] {
            let compressed = method(&registry(), "csr").unwrap().encode(&original, &Quiet).unwrap();
            assert_eq!(matrix(&compressed, &Quiet).unwrap(), original);
        }
    }
}
