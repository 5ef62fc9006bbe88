//! Compressed rows from elements in any order, duplicates summed.

use super::matrix::Description;
use crate::error::{Error, Result};
use crate::matrix::{MAX_LIGHTS, TransferMatrix};

/// Elements by row, column and value.
pub(super) struct Triplets {
    pub(super) rows: Vec<u32>,
    pub(super) columns: Vec<u32>,
    pub(super) values: Vec<f32>,
}

impl Triplets {
    /// Compressed rows of a matrix of `shape` (rows, columns), unsorted within each row. Indices outside are refused.
    pub(super) fn compress(self, shape: (u64, u64)) -> Result<SparseParts> {
        let rows = affordable_rows(shape.0, self.values.len())?;
        let mut offsets = vec![0usize; rows + 1];
        for &row in &self.rows {
            if row as usize >= rows {
                return Err(Error::TooLarge {
                    what: "row index".into(),
                    limit: (rows as u64).saturating_sub(1),
                    found: row.into(),
                });
            }
            offsets[row as usize + 1] += 1;
        }
        for row in 0..rows {
            offsets[row + 1] += offsets[row];
        }
        // Counting sort: the next free place of each row.
        let mut next = offsets.clone();
        let mut columns = vec![0; self.values.len()];
        let mut values = vec![0.0; self.values.len()];
        for ((row, column), value) in self.rows.into_iter().zip(self.columns).zip(self.values) {
            let at = next[row as usize];
            next[row as usize] += 1;
            (columns[at], values[at]) = (column, value);
        }
        Ok(SparseParts { offsets, columns, values, lights: lights(shape.1)? })
    }
}

/// Compressed rows whose columns need not ascend.
pub(super) struct SparseParts {
    pub(super) offsets: Vec<usize>,
    pub(super) columns: Vec<u32>,
    pub(super) values: Vec<f32>,
    pub(super) lights: usize,
}

impl SparseParts {
    /// The matrix: columns sorted, duplicates summed (as scipy's `sum_duplicates`), everything checked.
    pub(super) fn matrix(mut self, given: &Description, carried: Description) -> Result<TransferMatrix> {
        let (responses, basis) = given.and(carried, self.lights)?;
        let ends = self.offsets.first().zip(self.offsets.last());
        let legal = ends == Some((&0, &self.columns.len())) && self.offsets.is_sorted();
        let canonical = |w: &[usize]| self.columns[w[0]..w[1]].is_sorted_by(|a, b| a < b);
        // What is not legal is left as it is: the constructor says what is wrong with it.
        if legal && !self.offsets.windows(2).all(canonical) {
            self.sort_and_sum();
        }
        TransferMatrix::from_csr(self.offsets, self.columns, self.values, responses.responses(), basis)?
            .with_responses(responses)
    }

    fn sort_and_sum(&mut self) {
        let mut kept = 0;
        let mut row: Vec<(u32, f32)> = Vec::new();
        for r in 0..self.offsets.len() - 1 {
            let range = self.offsets[r]..self.offsets[r + 1];
            row.clear();
            row.extend(range.map(|i| (self.columns[i], self.values[i])));
            row.sort_by_key(|&(column, _)| column);
            self.offsets[r] = kept;
            for same in row.chunk_by(|a, b| a.0 == b.0) {
                self.columns[kept] = same[0].0;
                self.values[kept] = same.iter().map(|&(_, v)| f64::from(v)).sum::<f64>() as f32;
                kept += 1;
            }
        }
        *self.offsets.last_mut().expect("offsets are never empty") = kept;
        self.columns.truncate(kept);
        self.values.truncate(kept);
    }
}

/// Columns of a matrix, at most [`MAX_LIGHTS`].
pub(super) fn lights(columns: u64) -> Result<usize> {
    match usize::try_from(columns) {
        Ok(lights) if lights <= MAX_LIGHTS => Ok(lights),
        _ => Err(Error::TooLarge {
            what: "columns of the matrix (light coefficients)".into(),
            limit: MAX_LIGHTS as u64,
            found: columns,
        }),
    }
}

/// Rows of a dense matrix whose `rows * lights` elements are still to be read.
pub(super) fn rows_of(rows: u64, lights: usize) -> Result<usize> {
    if lights == 0 {
        return affordable_rows(rows, 0);
    }
    let cells = rows.checked_mul(lights as u64);
    match cells.filter(|&cells| cells <= isize::MAX as u64 / 8) {
        Some(_) => Ok(rows as usize),
        None => Err(Error::TooLarge {
            what: format!("rows of a matrix of {lights} columns"),
            limit: isize::MAX as u64 / 8 / lights as u64,
            found: rows,
        }),
    }
}

/// Rows of a matrix stored as `elements` triplets: a few bytes must not claim a table of 2⁶⁰ empty rows.
fn affordable_rows(rows: u64, elements: usize) -> Result<usize> {
    let limit = ((1 << 20) + 64 * elements as u64).min(u32::MAX.into());
    if rows <= limit {
        Ok(rows as usize)
    } else {
        Err(Error::TooLarge { what: format!("rows of a matrix with {elements} stored elements"), limit, found: rows })
    }
}
