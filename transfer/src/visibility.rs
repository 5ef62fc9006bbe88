//! `visibility`: exact, the least that a signal of visibility takes at rest. An archive: relighting decodes it every time.
//!
//! It is for matrices such as `biscale`, in which each column of a sample lies in one row: that of the local direction nearest
//! to the texel's centre in the sample's own frame. The rows are therefore implied by the frame, which the codec fits to them
//! and stores in eight bytes; the few columns that rounding puts elsewhere are listed. What is left is one value for
//! each column, told in runs along the faces' scanlines as a correction of what the frame predicts: the part of the texel above the
//! horizon.
//!
//! Decoding adds, multiplies and divides f64 and stored numbers alone, so that it gives the same matrix on every machine.
//!
//! Relighting finds the row of every visible texel again and multiplies it there: 2 FLOPs for each non-zero element, decoding
//! not counted, and some hundred times the time of [`compact`](crate::compact).
//!
//! Refused, as [`Error::Unsupported`]: a basis that is no cubemap, responses that are no square, a column in two rows of a sample,
//! more than [`MAX_LEVELS`] distinct values, and rows that no frame explains.

mod cells;
mod encode;
mod fit;
mod frame;
mod read;
mod sky;

use crate::codec::{Codec, Configure, Encoded};
use crate::error::{Error, Result};
use crate::flops::{Count, Flops, Tally};
use crate::footprint::{Extent, Footprint, by};
use crate::kernel::BLOCK_ROWS;
use crate::matrix::{Shape, TransferMatrix, check_apply};
use crate::narrow::Whole;
use crate::progress::Progress;
use crate::sections::Sink;
use cells::Cells;
use frame::{Frame, Vector};
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use rayon::prelude::*;
use sky::Sky;

/// Most distinct values, zero apart.
pub const MAX_LEVELS: usize = 1 << 12;

/// Samples between two stored starts of their runs.
const BLOCK_SAMPLES: usize = BLOCK_ROWS;

crate::params! {
    /// Frames and runs of visibility: the smallest file of a signal whose samples see each texel in one row. Exact; relights by decoding.
    pub struct VisibilityParams: "visibility" {}
}

/// The codec.
pub struct Visibility(VisibilityParams);

/// Frames, and runs of corrections to what they predict. FLOPs: 2·nnz.
pub struct EncodedVisibility {
    shape: Shape,
    sky: Sky,
    /// Unit directions of the responses in a sample's frame.
    directions: Vec<[f32; 3]>,
    /// Distinct values other than 0, ascending.
    levels: Vec<f32>,
    frames: Vec<Frame>,
    /// Runs of each sample, and those before every block of [`BLOCK_SAMPLES`].
    counts: Whole,
    starts: Vec<u64>,
    /// Columns of each run, less one.
    lengths: Vec<u8>,
    /// What a run says of its columns: see [`Symbol`].
    symbols: Whole,
    /// Sample, column and response where the frame's is another; ascending.
    exceptions: Vec<[u32; 3]>,
}

/// What a run says of each of its columns.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Symbol {
    /// The level of the part above the horizon.
    Predicted,
    /// Zero.
    Hidden,
    /// This level where anything is above the horizon.
    Level(usize),
    /// This level, horizon or not.
    Forced(usize),
}

impl Symbol {
    /// From the number that is stored; levels count from 0.
    fn from_code(code: usize, levels: usize) -> Symbol {
        match code {
            0 => Symbol::Predicted,
            1 => Symbol::Hidden,
            _ if code < 2 + levels => Symbol::Level(code - 2),
            _ => Symbol::Forced(code - 2 - levels),
        }
    }

    /// The symbol of a run that begins with this column.
    fn of(level: Option<usize>, above: usize, predicted: &[Option<usize>]) -> Symbol {
        match level {
            _ if level == predicted[above] => Symbol::Predicted,
            None => Symbol::Hidden,
            Some(level) if above > 0 => Symbol::Level(level),
            Some(level) => Symbol::Forced(level),
        }
    }

    /// The level of a column of which so many samples are above the horizon; `None` for zero.
    fn level(self, above: impl FnOnce() -> usize, predicted: &[Option<usize>]) -> Option<usize> {
        match self {
            Symbol::Predicted => predicted[above()],
            Symbol::Hidden => None,
            Symbol::Level(level) => (above() > 0).then_some(level),
            Symbol::Forced(level) => Some(level),
        }
    }

    fn code(self, levels: usize) -> usize {
        match self {
            Symbol::Predicted => 0,
            Symbol::Hidden => 1,
            Symbol::Level(level) => 2 + level,
            Symbol::Forced(level) => 2 + levels + level,
        }
    }
}

/// A column that is not 0: where, what, and its direction in the sample's frame.
struct Seen {
    column: usize,
    value: f32,
    direction: Vector,
}

impl Configure for Visibility {
    type Params = VisibilityParams;
    fn new(params: VisibilityParams) -> Result<Visibility> {
        Ok(Visibility(params))
    }
    fn params(&self) -> &VisibilityParams {
        &self.0
    }
}

impl Codec for Visibility {
    type Encoded = EncodedVisibility;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedVisibility> {
        encode::encode(matrix, progress)
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // A frame a sample and its runs, a byte or two an element.
        let peak = by(1.6, extent.non_zeros) + by(12.0, extent.rows());
        Some(Footprint { peak, result: by(0.25, extent.non_zeros) + by(64.0, extent.shape.samples as u64) })
    }
}

/// [`Error::Unsupported`] of this codec.
fn refuse(what: impl std::fmt::Display, expected: impl Into<String>, found: impl ToString) -> Error {
    Error::Unsupported { what: format!("visibility: {what}"), expected: expected.into(), found: found.to_string() }
}

impl EncodedVisibility {
    /// Calls `visit` for every column of a sample that is not 0, in the order of the scan.
    fn for_each_seen(&self, sample: usize, mut visit: impl FnMut(Seen)) {
        let axes = self.frames[sample].axes();
        let predicted = self.sky.predictions(&self.levels);
        let mut runs = self.runs(sample).map(|run| (usize::from(self.lengths[run]) + 1, self.symbols.at(run)));
        let (mut left, mut symbol) = (0, Symbol::Hidden);
        self.sky.scan().for_each(|texel| {
            if left == 0 {
                let (length, code) = runs.next().expect("runs add up to the lights");
                (left, symbol) = (length, Symbol::from_code(code, self.levels.len()));
            }
            left -= 1;
            if let Some(level) = symbol.level(|| self.sky.above(&texel, axes[2]), &predicted) {
                let direction = frame::above_horizon(frame::to_local(&axes, texel.centre));
                visit(Seen { column: texel.column, value: self.levels[level], direction });
            }
        });
    }

    fn runs(&self, sample: usize) -> std::ops::Range<usize> {
        let block = sample / BLOCK_SAMPLES;
        let before: usize = (block * BLOCK_SAMPLES..sample).map(|s| self.counts.at(s)).sum();
        let start = self.starts[block] as usize + before;
        start..start + self.counts.at(sample)
    }

    /// What is stored of columns of a sample whose response is not that of the nearest direction: seldom anything.
    fn exceptions(&self, sample: usize) -> &[[u32; 3]] {
        let before = |sample: usize| self.exceptions.partition_point(|e| (e[0] as usize) < sample);
        &self.exceptions[before(sample)..before(sample + 1)]
    }
}

/// The response that a sample's exceptions have for a column.
fn exception(exceptions: &[[u32; 3]], column: usize) -> Option<usize> {
    let at = exceptions.binary_search_by_key(&column, |e| e[1] as usize).ok()?;
    Some(exceptions[at][2] as usize)
}

impl Encoded for EncodedVisibility {
    fn shape(&self) -> Shape {
        self.shape
    }

    /// Decodes every sample and multiplies what it sees, row by row.
    fn apply_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) -> Result<()> {
        check_apply(self.shape, &lights, &out)?;
        let (cells, channels) = (Cells::new(&self.directions), lights.ncols());
        let samples = out.axis_chunks_iter_mut(Axis(0), self.shape.responses).into_par_iter().enumerate();
        samples.for_each(|(sample, mut out)| {
            let mut sums = vec![0f64; self.shape.responses * channels];
            let (mut nearest, exceptions) = (0, self.exceptions(sample));
            self.for_each_seen(sample, |seen| {
                nearest = cells.nearest(nearest, seen.direction);
                let response = exception(exceptions, seen.column).unwrap_or(nearest);
                let sums = &mut sums[response * channels..(response + 1) * channels];
                let light = lights.row(seen.column);
                sums.iter_mut().zip(light).for_each(|(sum, &x)| *sum += f64::from(seen.value) * f64::from(x));
            });
            out.iter_mut().zip(sums).for_each(|(y, sum)| *y = sum as f32);
        });
        Ok(())
    }

    fn row_into(&self, row: usize, out: &mut [f32]) {
        let (sample, response) = (row / self.shape.responses, row % self.shape.responses);
        let (exceptions, mut guess) = (self.exceptions(sample), response);
        out.fill(0.0);
        self.for_each_seen(sample, |seen| {
            let nearer = cells::nearer(&self.directions, response, guess, seen.direction);
            guess = nearer.unwrap_or(guess);
            let here = match exception(exceptions, seen.column) {
                Some(stored) => stored == response,
                None => nearer.is_none(),
            };
            if here {
                out[seen.column] = seen.value;
            }
        });
    }

    fn flops(&self, _light: &[f32]) -> Flops {
        let mut tally = Tally::default();
        for sample in 0..self.shape.samples {
            self.for_each_seen(sample, |seen| {
                tally.multiply_add(1);
                tally.factors(std::iter::once(seen.value));
            });
        }
        tally.0
    }

    fn write(&self, sink: &mut Sink) {
        sink.put("header/layout", &[self.sky.edge() as i32, self.counts.width(), self.symbols.width()]);
        sink.put("basis/directions", &self.directions);
        sink.put("basis/frames", &self.frames);
        sink.put("weights/levels", &self.levels);
        self.counts.write(sink, "index/counts");
        sink.put("index/starts", &self.starts);
        sink.put("index/lengths", &self.lengths);
        self.symbols.write(sink, "weights/symbols");
        sink.put("index/exceptions", &self.exceptions);
    }
}
