//! Blocks and what they leave, laid out as one encoded matrix.

use crate::block::Block;
use crate::distinct::Distinct;
use crate::places::places;
use crate::regions::{blocks, regions};
use crate::sums::Sums;
use crate::symbols::Leaf;
use prt_transfer::compact::{Compact, CompactParams, EncodedCompact};
use prt_transfer::{Codec, Configure, LightBasis, Progress, Quiet, Result, TransferMatrix};

/// The matrix in narrow widths.
pub(crate) fn compact(matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCompact> {
    Compact::new(CompactParams::default())?.encode(matrix, progress)
}

/// The elements of distinct rows.
pub(crate) fn rows(matrix: &TransferMatrix, distinct: &Distinct, kinds: &[u32]) -> Vec<Vec<Leaf>> {
    let row = |&kind: &u32| matrix.row(distinct.first[kind as usize] as usize);
    kinds.iter().map(|kind| row(kind).non_zeros().map(|(column, value)| (column as u32, value)).collect()).collect()
}

/// Shared sums beside what they leave.
pub(crate) fn lay_out(
    matrix: &TransferMatrix,
    distinct: &Distinct,
    blocks: &[Block],
    regions: Vec<u16>,
) -> Result<Sums> {
    let (mut sums, products) = Sums::new(matrix.shape(), &distinct.kind, blocks, regions);
    let mut left = vec![Vec::new(); distinct.first.len()];
    let rows = blocks.iter().flat_map(|b| b.kinds.iter().zip(&b.left));
    rows.for_each(|(&kind, row)| left[kind as usize].clone_from(row));
    if left.iter().any(|row| !row.is_empty()) {
        let rest = of_rows(products.iter().map(|&kind| &left[kind as usize][..]), 1, matrix.basis().clone())?;
        sums.rest = Some(Box::new(compact(&rest, &Quiet)?));
    }
    Ok(sums)
}

/// Distinct rows, regions of the lights, and the distinct rows of each block.
pub(crate) fn partition(
    matrix: &TransferMatrix,
    progress: &dyn Progress,
) -> Result<(Distinct, Vec<u16>, Vec<Vec<u32>>)> {
    let distinct = Distinct::of(matrix, progress)?;
    let regions = regions(matrix, &distinct, &places(matrix));
    let blocks = blocks(matrix, &distinct, &regions);
    Ok((distinct, regions, blocks))
}

/// A sparse matrix like `matrix` with other elements: those of each kind of row.
pub(crate) fn with_rows(
    matrix: &TransferMatrix,
    distinct: &Distinct,
    elements: &[Vec<Leaf>],
) -> Result<TransferMatrix> {
    let rows = distinct.kind.iter().map(|&kind| elements.get(kind as usize).map_or(&[][..], |row| row));
    of_rows(rows, matrix.shape().responses, matrix.basis().clone())
}

fn of_rows<'a>(rows: impl Iterator<Item = &'a [Leaf]>, responses: usize, basis: LightBasis) -> Result<TransferMatrix> {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in rows {
        columns.extend(row.iter().map(|leaf| leaf.0));
        values.extend(row.iter().map(|leaf| leaf.1));
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, responses, basis)
}
