//! What is kept of a matrix: which elements, gathered as sparse rows.

use crate::largest;
use crate::stored::Rounding;
use crate::threshold::Threshold;
use prt_transfer::{Error, Progress, Result, TransferMatrix};
use rayon::prelude::*;

/// Which elements of a row are kept.
pub(crate) enum Rule {
    /// Each row for itself.
    PerRow {
        /// The most coefficients of a row.
        terms: usize,
        /// The share of the row's sum of squares that is kept with the fewest coefficients; `None` = all of it.
        energy: Option<f64>,
    },
    /// Those of the whole matrix that are at least so large.
    Threshold(Threshold),
}

/// The kept elements in compressed rows, columns ascending.
#[derive(Default)]
pub(crate) struct Kept {
    /// rows + 1 offsets into the others.
    pub(crate) offsets: Vec<u32>,
    pub(crate) columns: Vec<u32>,
    pub(crate) values: Vec<f32>,
    /// One for each row: the step of its stored values.
    pub(crate) steps: Vec<f32>,
}

/// Rows that a thread selects at a time.
const BLOCK: usize = 256;

impl Rule {
    /// Reduces the non-zero elements of a row (column, value) to those that are kept. `keys` is scratch.
    fn reduce(&self, row: usize, elements: &mut Vec<(u32, f32)>, keys: &mut Vec<u64>) {
        let (terms, energy) = match self {
            Rule::Threshold(threshold) => return threshold.reduce(row, elements),
            Rule::PerRow { terms, energy } => (*terms, *energy),
        };
        let total: f64 = elements.iter().map(|&(_, v)| f64::from(v).powi(2)).sum();
        keys.clear();
        keys.extend(elements.iter().enumerate().map(|(i, &(_, v))| largest::key(v, i as u32)));
        largest::keep_terms(keys, terms);
        if let Some(energy) = energy {
            // What the limit on terms has dropped is not in `keys` any more: it counts against the budget.
            let kept: f64 = keys.iter().map(|&k| f64::from(elements[largest::place(k) as usize].1).powi(2)).sum();
            largest::keep_energy(keys, (1.0 - energy) * total - (total - kept).max(0.0));
        }
        keys.iter_mut().for_each(|k| *k = largest::place(*k).into());
        keys.sort_unstable();
        // Ascending places: each element moves to the front or stays.
        keys.iter().enumerate().for_each(|(to, &from)| elements[to] = elements[from as usize]);
        elements.truncate(keys.len());
    }
}

impl Kept {
    /// What `rule` keeps of `matrix`, without what `rounding` would decode as 0.
    pub(crate) fn gather(
        matrix: &TransferMatrix,
        rule: &Rule,
        rounding: Rounding,
        progress: &dyn Progress,
    ) -> Result<Kept> {
        let rows = matrix.rows();
        progress.start("encode", rows as u64);
        let blocks: Vec<(Vec<usize>, Kept)> = (0..rows.div_ceil(BLOCK))
            .into_par_iter()
            .map_init(
                || (Vec::new(), Vec::new()),
                |(elements, keys), block| {
                    let (mut lengths, mut kept) = (Vec::new(), Kept::default());
                    for row in block * BLOCK..rows.min((block + 1) * BLOCK) {
                        elements.clear();
                        elements.extend(matrix.row(row).non_zeros().map(|(col, value)| (col as u32, value)));
                        rule.reduce(row, elements, keys);
                        let step = rounding.step(elements.iter().map(|e| e.1));
                        elements.retain(|e| rounding.decoded(e.1, step) != 0.0);
                        lengths.push(elements.len());
                        kept.columns.extend(elements.iter().map(|e| e.0));
                        kept.values.extend(elements.iter().map(|e| e.1));
                        kept.steps.push(step);
                    }
                    progress.advance(lengths.len() as u64)?;
                    Ok((lengths, kept))
                },
            )
            .collect::<Result<_>>()?;
        Kept::join(blocks)
    }

    /// Blocks of rows one after the other, with the lengths of their rows.
    fn join(blocks: Vec<(Vec<usize>, Kept)>) -> Result<Kept> {
        let total: usize = blocks.iter().map(|(_, kept)| kept.columns.len()).sum();
        if u32::try_from(total).is_err() {
            let (limit, found) = (u32::MAX.into(), total as u64);
            return Err(Error::TooLarge { what: "kept coefficients".into(), limit, found });
        }
        let mut all = Kept { offsets: vec![0], ..Kept::default() };
        let mut end = 0;
        for (lengths, kept) in blocks {
            for length in lengths {
                end += length as u32;
                all.offsets.push(end);
            }
            all.columns.extend(kept.columns);
            all.values.extend(kept.values);
            all.steps.extend(kept.steps);
        }
        Ok(all)
    }
}
