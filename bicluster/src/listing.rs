//! The elements of a matrix as runs, for the file.
//!
//! Where no two rows of a sample have a column in common (each direction of light reaches one local direction), the elements
//! of a sample are listed column by column, and one row's run starts where another's ends. Otherwise each row is listed by
//! itself. A run is a gap, a row of its sample and a length; values other than the most frequent one are exceptions.

use crate::planes;
use prt_transfer::sections::broken;
use prt_transfer::{LightBasis, Result, Shape, Sink, Source, TransferMatrix};
use rayon::prelude::*;
use std::collections::HashMap;

/// Elements that a file may list for each run, and rows for each run or count: they bound what reading allocates.
const ELEMENTS_PER_RUN: usize = 64;
const ROWS_PER_RUN: usize = 256;

/// Whether so many elements and rows may be listed in so many runs.
fn is_readable(shape: Shape, elements: usize, runs: usize) -> bool {
    elements <= ELEMENTS_PER_RUN.saturating_mul(runs)
        && shape.rows() <= ROWS_PER_RUN.saturating_mul(shape.samples + runs)
        && shape.rows() < u32::MAX as usize
}

/// Whether a matrix can be listed. Its runs are the same however rows are listed together.
pub(crate) fn can_list(matrix: &TransferMatrix) -> bool {
    let runs_of = |row: usize| {
        let (mut end, mut runs) = (usize::MAX, 0);
        for (column, _) in matrix.row(row).non_zeros() {
            runs += usize::from(column != end);
            end = column + 1;
        }
        runs
    };
    let runs = (0..matrix.rows()).into_par_iter().map(runs_of).sum();
    is_readable(matrix.shape(), matrix.non_zeros(), runs)
}

/// Elements of one sample or row: column, row within the sample, value.
type Element = (u32, u32, f32);

/// Runs and exceptions.
#[derive(Default)]
pub(crate) struct Listing {
    /// Rows listed together: the responses of a sample, or 1.
    together: usize,
    /// Runs of each sample or row.
    counts: Vec<u32>,
    gaps: Vec<u32>,
    rows: Vec<u32>,
    lengths: Vec<u32>,
    /// Distinct values, the most frequent first.
    table: Vec<f32>,
    /// Elements from one exception to the next, in the order of listing; the first counts from before the first element.
    steps: Vec<u32>,
    /// Places of the exceptions in the table, less 1.
    codes: Vec<u32>,
    elements: usize,
}

impl Listing {
    /// Lists the elements that `row(index)` hands over, columns ascending.
    pub(crate) fn of(shape: Shape, row: impl Fn(usize, &mut Vec<(u32, f32)>)) -> Listing {
        let whole = Listing::together(shape, shape.responses, &row);
        whole.or_else(|| Listing::together(shape, 1, &row)).expect("the columns of one row differ")
    }

    /// `None` where two rows listed together have a column in common.
    fn together(shape: Shape, together: usize, row: &impl Fn(usize, &mut Vec<(u32, f32)>)) -> Option<Listing> {
        let mut listing = Listing { together, ..Listing::default() };
        let (mut leaves, mut elements, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for sample in 0..shape.rows() / together {
            elements.clear();
            for part in 0..together {
                leaves.clear();
                row(sample * together + part, &mut leaves);
                elements.extend(leaves.iter().map(|&(column, value)| (column, part as u32, value)));
            }
            elements.sort_unstable_by_key(|e: &Element| e.0);
            if elements.windows(2).any(|w| w[0].0 == w[1].0) {
                return None;
            }
            listing.push(&elements);
            values.extend(elements.iter().map(|e| e.2));
        }
        listing.elements = values.len();
        listing.name_values(&values);
        Some(listing)
    }

    fn push(&mut self, elements: &[Element]) {
        let (before, mut end) = (self.gaps.len(), 0);
        for run in elements.chunk_by(|a, b| b.0 == a.0 + 1 && a.1 == b.1) {
            self.gaps.push(run[0].0 - end);
            self.rows.push(run[0].1);
            self.lengths.push(run.len() as u32);
            end = run[0].0 + run.len() as u32;
        }
        self.counts.push((self.gaps.len() - before) as u32);
    }

    fn name_values(&mut self, values: &[f32]) {
        let mut frequency: HashMap<u32, u64> = HashMap::new();
        values.iter().for_each(|v| *frequency.entry(v.to_bits()).or_default() += 1);
        let mut table: Vec<(u32, u64)> = frequency.into_iter().collect();
        table.sort_unstable_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let code: HashMap<u32, u32> = table.iter().zip(0..).map(|(&(bits, _), code)| (bits, code)).collect();
        self.table = table.iter().map(|&(bits, _)| f32::from_bits(bits)).collect();
        let mut step = 0;
        for value in values {
            step += 1;
            let code = code[&value.to_bits()];
            if code > 0 {
                self.codes.push(code - 1);
                self.steps.push(std::mem::take(&mut step));
            }
        }
    }

    pub(crate) fn write(&self, lights: usize, sink: &mut Sink) {
        sink.put("header/listing", &[self.together as u32]);
        planes::put(sink, "index/counts", &self.counts, u32::MAX as usize);
        planes::put(sink, "index/gaps", &self.gaps, lights);
        planes::put(sink, "index/rows", &self.rows, self.together - 1);
        planes::put(sink, "index/lengths", &self.lengths, lights);
        sink.put("weights/table", &self.table);
        planes::put(sink, "index/steps", &self.steps, u32::MAX as usize);
        planes::put(sink, "index/codes", &self.codes, self.table.len());
    }

    /// The matrix, on a basis without directions.
    pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<TransferMatrix> {
        let together = source.take_exact::<u32>("header/listing", 1)?[0] as usize;
        if together != 1 && together != shape.responses {
            return Err(broken("header/listing", format!("1 or {}", shape.responses), together.to_string()));
        }
        let counts = planes::take(source, "index/counts", u32::MAX as usize)?;
        let gaps = planes::take(source, "index/gaps", shape.lights)?;
        let rows = planes::take(source, "index/rows", together - 1)?;
        let lengths = planes::take(source, "index/lengths", shape.lights)?;
        let table: Vec<f32> = source.take("weights/table")?;
        let steps = planes::take(source, "index/steps", u32::MAX as usize)?;
        let codes = planes::take(source, "index/codes", table.len())?;
        let runs: u64 = counts.iter().map(|&n| u64::from(n)).sum();
        let elements: u64 = lengths.iter().map(|&n| u64::from(n)).sum();
        let agree = counts.len() == shape.rows() / together
            && runs == gaps.len() as u64
            && gaps.len() == rows.len()
            && gaps.len() == lengths.len()
            && steps.len() == codes.len();
        if !agree || !is_readable(shape, usize::try_from(elements).unwrap_or(usize::MAX), gaps.len()) {
            let expected = format!(
                "runs of {} samples, {ELEMENTS_PER_RUN} elements and {ROWS_PER_RUN} rows a run on average at most",
                shape.rows() / together
            );
            return Err(broken("index/counts", expected, format!("{} counts, {runs} runs", counts.len())));
        }
        let listing =
            Listing { together, counts, gaps, rows, lengths, table, steps, codes, elements: elements as usize };
        let values = listing.values()?;
        listing.matrix(shape, &values)
    }

    /// The value of each element in the order of listing.
    fn values(&self) -> Result<Vec<f32>> {
        let usual = match (self.table.first(), self.elements) {
            (None, 1..) => return Err(broken("weights/table", "a value", "none")),
            (usual, _) => usual.copied().unwrap_or_default(),
        };
        let (mut values, mut at) = (vec![usual; self.elements], 0);
        for (&step, &code) in self.steps.iter().zip(&self.codes) {
            at += step as usize;
            let value = self.table.get(code as usize + 1);
            match (value, at.checked_sub(1).and_then(|i| values.get_mut(i))) {
                (Some(&value), Some(element)) => *element = value,
                _ => return Err(broken("index/steps", format!("{} elements", self.elements), at.to_string())),
            }
        }
        Ok(values)
    }

    fn matrix(&self, shape: Shape, values: &[f32]) -> Result<TransferMatrix> {
        let (mut offsets, mut columns, mut sorted) = (vec![0], Vec::new(), Vec::new());
        let (mut run, mut values) = (0, values);
        let mut rows: Vec<Vec<(u32, f32)>> = vec![Vec::new(); self.together];
        for &count in &self.counts {
            let mut column = 0u64;
            for run in run..run + count as usize {
                column += u64::from(self.gaps[run]);
                let (own, rest) = values.split_at(self.lengths[run] as usize);
                if column + own.len() as u64 > shape.lights as u64 {
                    return Err(broken("index/gaps", format!("columns below {}", shape.lights), column.to_string()));
                }
                rows[self.rows[run] as usize].extend((column as u32..).zip(own.iter().copied()));
                column += own.len() as u64;
                values = rest;
            }
            run += count as usize;
            for row in &mut rows {
                columns.extend(row.iter().map(|e| e.0));
                sorted.extend(row.drain(..).map(|e| e.1));
                offsets.push(columns.len());
            }
        }
        TransferMatrix::from_csr(offsets, columns, sorted, shape.responses, LightBasis::Plain { lights: shape.lights })
    }
}
