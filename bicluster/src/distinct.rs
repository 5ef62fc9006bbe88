//! Rows that differ: equal rows are compressed and summed once.

use prt_transfer::{Progress, Result, Row, TransferMatrix};
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};

/// The kind of a row without elements.
pub(crate) const EMPTY: u32 = u32::MAX;

/// Which rows are equal.
pub(crate) struct Distinct {
    /// The first row of each kind.
    pub(crate) first: Vec<u32>,
    /// The kind of every row, [`EMPTY`] where it has no elements.
    pub(crate) kind: Vec<u32>,
}

impl Distinct {
    /// Compares all rows, through their hashes. `matrix` has fewer than 2^32 - 1 rows.
    pub(crate) fn of(matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Distinct> {
        progress.start("compare rows", matrix.rows() as u64);
        let hashes = (0..matrix.rows()).into_par_iter().map(|row| progress.advance(1).map(|()| hash(matrix.row(row))));
        let hashes: Vec<Option<u64>> = hashes.collect::<Result<_>>()?;
        let (mut first, mut kind) = (Vec::new(), Vec::with_capacity(hashes.len()));
        let mut kinds_of_hash: HashMap<u64, Vec<u32>> = HashMap::new();
        for (row, hash) in hashes.into_iter().enumerate() {
            let Some(hash) = hash else {
                kind.push(EMPTY);
                continue;
            };
            let kinds = kinds_of_hash.entry(hash).or_default();
            let equal = |&&k: &&u32| equal(matrix.row(first[k as usize] as usize), matrix.row(row));
            kind.push(kinds.iter().find(equal).copied().unwrap_or_else(|| {
                kinds.push(first.len() as u32);
                first.push(row as u32);
                first.len() as u32 - 1
            }));
        }
        Ok(Distinct { first, kind })
    }
}

fn equal(a: Row, b: Row) -> bool {
    match (a, b) {
        (Row::Sparse { columns: a, values: v }, Row::Sparse { columns: b, values: w }) => a == b && v == w,
        _ => a.non_zeros().eq(b.non_zeros()),
    }
}

/// A hash of the elements; `None` without any.
fn hash(row: Row) -> Option<u64> {
    let (mut hasher, mut elements) = (DefaultHasher::new(), 0);
    for (column, value) in row.non_zeros() {
        hasher.write_u64((column as u64) << 32 | u64::from(value.to_bits()));
        elements += 1;
    }
    (elements > 0).then(|| hasher.finish())
}
