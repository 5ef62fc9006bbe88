//! Blocks of rows: those whose middle elements lie in the same region of the lights.
//!
//! Rows that share sums are rows with similar columns, wherever in the matrix they are; so the columns are divided into
//! regions by median cuts, and a row belongs to the region of its middle element. Blocks depend on the matrix alone, never on
//! the number of threads.

use crate::distinct::Distinct;
use crate::places::Place;
use prt_transfer::TransferMatrix;

/// Rows that a region aims at: more rows share more, fewer keep the sums of a block in the nearest cache.
const REGION_ROWS: usize = 4096;
/// Rows of a block at most; more in one region are cut in their order.
const BLOCK_ROWS: usize = 8192;
/// About so many regions at most, few enough for numbers of two bytes.
const REGIONS: usize = 1 << 14;

/// The region of each column, counted from 0.
pub(crate) fn regions(matrix: &TransferMatrix, distinct: &Distinct, places: &[Place]) -> Vec<u16> {
    let mut rows = vec![0usize; places.len()];
    distinct.first.iter().for_each(|&row| rows[middle(matrix, row)] += 1);
    let mut columns: Vec<u32> = (0..places.len() as u32).filter(|&c| rows[c as usize] > 0).collect();
    let target = REGION_ROWS.max(distinct.first.len() / REGIONS);
    let (mut regions, mut found) = (vec![0; places.len()], 0);
    cut(&mut columns, &rows, places, target, &mut |region| {
        region.iter().for_each(|&c| regions[c as usize] = found as u16);
        found += 1;
    });
    regions
}

/// The column of a row's middle element.
fn middle(matrix: &TransferMatrix, row: u32) -> usize {
    let row = matrix.row(row as usize);
    let elements = row.non_zeros().count();
    row.non_zeros().nth(elements / 2).map_or(0, |(column, _)| column)
}

/// Cuts columns at the weighted median along their longest extent until each part holds at most `target` rows.
fn cut(columns: &mut [u32], rows: &[usize], places: &[Place], target: usize, part: &mut impl FnMut(&[u32])) {
    let total: usize = columns.iter().map(|&c| rows[c as usize]).sum();
    if total <= target || columns.len() == 1 {
        return part(columns);
    }
    let place = |c: &u32, axis: usize| places[*c as usize][axis];
    let extent = |axis: usize| {
        let bounds =
            columns.iter().map(|c| place(c, axis)).fold([f32::MAX, f32::MIN], |[l, h], p| [l.min(p), h.max(p)]);
        bounds[1] - bounds[0]
    };
    let axis = (1..3).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
    columns.sort_unstable_by(|a, b| place(a, axis).total_cmp(&place(b, axis)).then(a.cmp(b)));
    let mut below = 0;
    let median = columns.iter().position(|&c| {
        below += rows[c as usize];
        2 * below >= total
    });
    let (low, high) = columns.split_at_mut((median.unwrap_or(0) + 1).min(columns.len() - 1));
    cut(low, rows, places, target, part);
    cut(high, rows, places, target, part);
}

/// The kinds of rows of each block, ascending.
pub(crate) fn blocks(matrix: &TransferMatrix, distinct: &Distinct, regions: &[u16]) -> Vec<Vec<u32>> {
    let mut of_region: Vec<Vec<u32>> = vec![Vec::new(); regions.iter().map(|&r| usize::from(r) + 1).max().unwrap_or(0)];
    for (kind, &row) in distinct.first.iter().enumerate() {
        of_region[usize::from(regions[middle(matrix, row)])].push(kind as u32);
    }
    of_region.iter().flat_map(|kinds| kinds.chunks(BLOCK_ROWS).map(<[u32]>::to_vec)).collect()
}
