//! `runs`: exact, runs of equal values in a row as intervals, relit from prefix sums of the light.
//!
//! With P\[k\] = Σ x\[i\] over i < k, a run of the value v from column s to before column e adds v · (P\[e\] − P\[s\]) to its row,
//! however long it is. Runs of one value in a row share its multiplication; elements alone are multiplied as they are, in the
//! widths of [`compact`](crate::compact). A matrix that takes fewer bytes without runs is stored as `compact` stores it.
//!
//! FLOPs, with s single elements, r runs of two or more elements and g pairs of a row and a value that has runs there:
//! s + g multiplications and s + g + 2r + lights additions. Without runs: 2 for each stored element, as for `compact`.
//!
//! Prefix sums are f64 and never restart: of n lights, they bring at most n · 2⁻⁵³ · Σ|x| of error into a difference,
//! before the last rounding to f32. A light whose coefficients, products and partial sums are multiples of one power of two,
//! below 2²⁴ times it, relights without any rounding: to the bits of an exact sum. A light with an infinite coefficient is
//! multiplied element by element.

mod intervals;
mod split;

use crate::codec::{Codec, Configure, Encoded, Restore};
use crate::error::Result;
use crate::flops::{Count, Flops, NoCount, Tally};
use crate::footprint::{Extent, Footprint, by};
use crate::kernel::{self, BLOCK_ROWS, RowKernel};
use crate::matrix::{Shape, TransferMatrix, check_apply};
use crate::narrow::Narrow;
use crate::progress::Progress;
use crate::sections::{Sink, Source, broken};
use intervals::Intervals;
use ndarray::{ArrayView2, ArrayViewMut2};

crate::params! {
    /// Runs of equal values, relit from prefix sums of the light; single elements in the narrowest exact widths. Exact.
    pub struct RunsParams: "runs" {}
}

/// The codec.
pub struct Runs(RunsParams);

/// Intervals of equal values, and the elements between them. FLOPs: see the [module](self).
pub struct EncodedRuns {
    /// Elements that are in no run.
    singles: Narrow,
    /// `None` where the matrix takes fewer bytes without: then `singles` is all of it.
    runs: Option<Intervals>,
}

impl Configure for Runs {
    type Params = RunsParams;
    fn new(params: RunsParams) -> Result<Runs> {
        Ok(Runs(params))
    }
    fn params(&self) -> &RunsParams {
        &self.0
    }
}

impl Codec for Runs {
    type Encoded = EncodedRuns;

    /// O(non-zeros · log of the runs in a row).
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedRuns> {
        let (singles, runs) = split::split(matrix, progress)?;
        let bytes = singles.bytes() + runs.bytes();
        // The least that `compact` could take: a byte an element in full, or one and its column for each that is not 0.
        let cells = matrix.rows() * matrix.lights();
        if bytes > cells.min(split::least_sparse_bytes(matrix)) {
            let whole = Narrow::exact(matrix, progress)?;
            if whole.bytes() <= bytes {
                return Ok(EncodedRuns { singles: whole, runs: None });
            }
        }
        Ok(EncodedRuns { singles, runs: Some(runs) })
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // Runs of visibility are long: two bytes an element. Values that all differ are runs of one.
        let of_rows = by(32.0, extent.rows());
        let (peak, result) = match extent.is_thin() {
            true => (by(2.0, extent.non_zeros), by(1.5, extent.non_zeros)),
            false => (by(12.0, extent.non_zeros) + by(8.8, extent.cells()), by(4.0, extent.cells())),
        };
        Some(Footprint { peak: peak + of_rows, result: result + of_rows })
    }
}

/// Prefix sums: the light before each column, and all of it.
struct Prefix<const N: usize> {
    sums: Vec<f64>,
    /// Numbers before the first, so that four channels never lie across a line of the cache.
    skip: usize,
}

impl<const N: usize> Prefix<N> {
    fn of<C: Count>(x: &[[f32; N]], count: &mut C) -> Prefix<N> {
        count.add(x.len());
        let mut sums = vec![0f64; N * (x.len() + 1) + 3];
        let skip = sums.as_ptr().align_offset(32).min(3);
        let (mut sum, places) = ([0f64; N], sums[skip..].as_chunks_mut::<N>().0);
        for (place, x) in places[1..].iter_mut().zip(x) {
            sum.iter_mut().zip(x).for_each(|(sum, &x)| *sum += f64::from(x));
            *place = sum;
        }
        Prefix { sums, skip }
    }

    fn sums(&self) -> &[[f64; N]] {
        self.sums[self.skip..].as_chunks().0
    }
}

impl EncodedRuns {
    fn apply_packed<const N: usize>(&self, runs: &Intervals, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) {
        let x = kernel::pack::<N>(lights);
        if !kernel::all_finite(&x) {
            return kernel::by_blocks(out, |first, y| {
                y.iter_mut().enumerate().for_each(|(i, y)| *y = self.elementwise(runs, first + i, &x));
            });
        }
        let prefix = Prefix::of(&x, &mut NoCount);
        kernel::by_blocks(out, |first, y| {
            self.singles.block(first, &x, y);
            let mut sums = [[0f64; N]; BLOCK_ROWS];
            runs.add_block(first / BLOCK_ROWS, prefix.sums(), &mut sums, &mut NoCount);
            y.as_flattened_mut().iter_mut().zip(sums.as_flattened()).for_each(|(y, s)| *y = (f64::from(*y) + s) as f32);
        });
    }

    /// One row's product, element by element: an infinite coefficient reaches only the rows that have its column.
    fn elementwise<const N: usize>(&self, runs: &Intervals, row: usize, x: &[[f32; N]]) -> [f32; N] {
        let mut y = self.singles.product(row, x, &mut NoCount);
        for (value, range) in runs.row(row) {
            x[range].iter().for_each(|x| y.iter_mut().zip(x).for_each(|(y, x)| *y += value * x));
        }
        y
    }
}

impl Encoded for EncodedRuns {
    fn shape(&self) -> Shape {
        self.singles.shape()
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        let Some(runs) = &self.runs else {
            return self.singles.apply_into(lights, out);
        };
        check_apply(self.shape(), &lights, &out)?;
        kernel::by_channels(lights, out, |lights, out| match lights.ncols() {
            1 => self.apply_packed::<1>(runs, lights, out),
            _ => self.apply_packed::<4>(runs, lights, out),
        });
        Ok(())
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        self.singles.row_into(row, out);
        if let Some(runs) = &self.runs {
            runs.row(row).for_each(|(value, range)| out[range].fill(value));
        }
    }
    fn flops(&self, light: &[f32]) -> Flops {
        let mut tally = Tally(self.singles.flops(light));
        if let Some(runs) = &self.runs {
            let x: Vec<[f32; 1]> = light.iter().map(|&x| [x]).collect();
            let prefix = Prefix::of(&x, &mut tally);
            let mut sums = [[0f64; 1]; BLOCK_ROWS];
            (0..runs.blocks()).for_each(|block| runs.add_block(block, prefix.sums(), &mut sums, &mut tally));
        }
        tally.0
    }
    fn write(&self, sink: &mut Sink) {
        self.singles.write(sink);
        if let Some(runs) = &self.runs {
            runs.write(sink);
        }
    }
}

impl Restore for EncodedRuns {
    const TAG: &'static str = "runs.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedRuns> {
        let singles = Narrow::read(shape, source)?;
        if !Intervals::are_in(source) {
            return Ok(EncodedRuns { singles, runs: None });
        }
        if singles.is_full() {
            return Err(broken("index/run_starts", "no runs beside a full matrix", "this section"));
        }
        let runs = Intervals::read(shape, source)?;
        runs.check_apart(shape, &singles)?;
        Ok(EncodedRuns { singles, runs: Some(runs) })
    }
}
