//! Blocks and what they leave, laid out as one encoded matrix.

use crate::block::Block;
use crate::distinct::Distinct;
use crate::sums::Sums;
use crate::symbols::Leaf;
use prt_transfer::compact::{Compact, CompactParams, EncodedCompact};
use prt_transfer::{Codec, Configure, Progress, Quiet, Result, TransferMatrix};

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
    let mut sums = Sums::new(matrix.shape(), &distinct.kind, blocks, regions);
    let mut left: Vec<&[Leaf]> = vec![&[]; distinct.first.len()];
    blocks.iter().flat_map(|b| b.kinds.iter().zip(&b.left)).for_each(|(&kind, row)| left[kind as usize] = row);
    if left.iter().any(|row| !row.is_empty()) {
        let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for &kind in &distinct.kind {
            for &(column, value) in left.get(kind as usize).copied().unwrap_or(&[]) {
                columns.push(column);
                values.push(value);
            }
            offsets.push(columns.len());
        }
        let (responses, basis) = (matrix.shape().responses, matrix.basis().clone());
        let rest = TransferMatrix::from_csr(offsets, columns, values, responses, basis)?;
        sums.rest = Some(Box::new(compact(&rest, &Quiet)?));
    }
    Ok(sums)
}
