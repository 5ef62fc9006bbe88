//! Frames and runs of a matrix.

use super::cells::Cells;
use super::fit::{Observed, fit};
use super::frame::{self, Frame};
use super::sky::Sky;
use super::{BLOCK_SAMPLES, EncodedVisibility, MAX_LEVELS, Symbol, refuse};
use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::hemisphere::{MAX_EDGE, local_directions};
use crate::matrix::TransferMatrix;
use crate::narrow::Whole;
use crate::progress::Progress;
use rayon::prelude::*;

/// The most exceptions: one for so many non-zero elements. Beyond it the rows are not those of a frame, …
const ELEMENTS_PER_EXCEPTION: usize = 16;
/// … but so many are always allowed: a few elements need not lie together to have a frame.
const FEW_EXCEPTIONS: usize = 64;

/// Columns of a sample: level counted from 1, 0 for none, and response.
type Column = (u16, u16);

/// What is stored of a sample.
struct Sample {
    frame: Frame,
    /// Columns and symbol of each run.
    runs: Vec<(usize, Symbol)>,
    /// Column and response.
    exceptions: Vec<[u32; 2]>,
}

pub(super) fn encode(matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedVisibility> {
    let shape = matrix.shape();
    let &LightBasis::Cubemap { resolution } = matrix.basis() else {
        return Err(Error::Unsupported {
            what: "light basis of visibility".into(),
            expected: "cubemap".into(),
            found: matrix.basis().to_string(),
        });
    };
    let edge = shape.responses.isqrt();
    if edge * edge != shape.responses || edge > MAX_EDGE {
        let expected = format!("a square of 1 to {MAX_EDGE} local directions along an edge");
        return Err(refuse("responses of a sample", expected, shape.responses));
    }
    if shape.samples > u32::MAX as usize {
        return Err(refuse("samples", "less than 2^32", shape.samples));
    }
    let levels = levels(matrix)?;
    let sky = Sky::new(resolution, samples_along_edge(&levels));
    let directions = local_directions(edge);
    let cells = Cells::new(&directions);
    progress.start("encode", shape.samples as u64);
    let encode = |buffer: &mut Vec<Column>, sample| {
        columns_of(matrix, sample, &levels, buffer)?;
        progress.advance(1)?;
        Ok(encode_sample(&cells, &sky, &levels, buffer))
    };
    let samples: Vec<Sample> =
        (0..shape.samples).into_par_iter().map_init(Vec::new, encode).collect::<Result<Vec<_>>>()?;
    let (exceptions, elements) = (samples.iter().map(|s| s.exceptions.len()).sum::<usize>(), matrix.non_zeros());
    if exceptions > FEW_EXCEPTIONS.max(elements / ELEMENTS_PER_EXCEPTION) {
        let found = format!("{exceptions} of {elements} elements elsewhere");
        return Err(refuse("rows", "those of the local directions nearest to the texels in some frame", found));
    }
    let mut encoded = EncodedVisibility {
        shape,
        sky,
        directions,
        frames: Vec::with_capacity(samples.len()),
        counts: Whole::up_to(shape.lights),
        starts: Vec::with_capacity(samples.len().div_ceil(BLOCK_SAMPLES)),
        lengths: Vec::new(),
        symbols: Whole::up_to(2 * levels.len() + 1),
        exceptions: Vec::with_capacity(exceptions),
        levels,
    };
    samples.into_iter().for_each(|sample| encoded.push(sample));
    encoded.counts = encoded.counts.narrowed(encoded.counts.max());
    encoded.lengths.shrink_to_fit();
    encoded.symbols.shrink_to_fit();
    Ok(encoded)
}

impl EncodedVisibility {
    fn push(&mut self, Sample { frame, runs, exceptions }: Sample) {
        let sample = self.frames.len();
        if sample.is_multiple_of(BLOCK_SAMPLES) {
            self.starts.push(self.lengths.len() as u64);
        }
        self.frames.push(frame);
        self.counts.push(runs.len());
        for (columns, symbol) in runs {
            self.lengths.push((columns - 1) as u8);
            self.symbols.push(symbol.code(self.levels.len()));
        }
        self.exceptions.extend(exceptions.into_iter().map(|[column, response]| [sample as u32, column, response]));
    }
}

/// Distinct values, ascending.
fn levels(matrix: &TransferMatrix) -> Result<Vec<f32>> {
    let mut levels: Vec<f32> = Vec::new();
    let mut last = 0.0;
    for (_, value) in (0..matrix.rows()).flat_map(|row| matrix.row(row).non_zeros().collect::<Vec<_>>()) {
        if value == last {
            continue;
        }
        last = value;
        if let Err(at) = levels.binary_search_by(|l| l.total_cmp(&value)) {
            if levels.len() == MAX_LEVELS {
                return Err(refuse("distinct values", format!("at most {MAX_LEVELS}"), "more"));
            }
            levels.insert(at, value);
        }
    }
    Ok(levels)
}

/// Samples along an edge of a texel whose visible part takes these values: the least power of two that makes them so.
fn samples_along_edge(levels: &[f32]) -> usize {
    let parts = |edge: &usize| {
        let samples = (edge * edge) as f32;
        levels.iter().all(|&l| l > 0.0 && l <= 1.0 && (l * samples).fract() == 0.0)
    };
    (0..5).map(|m| 1 << m).find(|edge| *edge <= Sky::MAX_EDGE && parts(edge)).unwrap_or(1)
}

/// Gathers a sample's rows into one level and response for each column.
fn columns_of(matrix: &TransferMatrix, sample: usize, levels: &[f32], columns: &mut Vec<Column>) -> Result<()> {
    columns.clear();
    columns.resize(matrix.lights(), (0, 0));
    let responses = matrix.shape().responses;
    for response in 0..responses {
        for (column, value) in matrix.row(sample * responses + response).non_zeros() {
            let (level, other) = columns[column];
            if level != 0 {
                let found = format!("responses {other} and {response}");
                return Err(refuse(format!("column {column} of sample {sample}"), "one response", found));
            }
            let level = 1 + levels.partition_point(|l| *l < value);
            columns[column] = (level as u16, response as u16);
        }
    }
    Ok(())
}

fn encode_sample(cells: &Cells, sky: &Sky, levels: &[f32], columns: &[Column]) -> Sample {
    let texels = || sky.scan().map(|texel| (columns[texel.column], texel));
    let seen = || texels().filter(|(column, _)| column.0 != 0).map(|(column, texel)| (usize::from(column.1), texel));
    let observed: Vec<Observed> = seen().map(|(response, texel)| (texel.centre, response)).collect();
    let frame = fit(cells, &observed);
    let axes = frame.axes();
    let elsewhere = seen().filter(|(response, texel)| {
        let direction = frame::above_horizon(frame::to_local(&axes, texel.centre));
        cells.nearest(*response, direction) != *response
    });
    let mut exceptions: Vec<_> = elsewhere.map(|(response, texel)| [texel.column as u32, response as u32]).collect();
    exceptions.sort_unstable();
    let predicted = sky.predictions(levels);
    let mut runs: Vec<(usize, Symbol)> = Vec::new();
    for ((level, _), texel) in texels() {
        let (level, above) = (usize::from(level).checked_sub(1), sky.above(&texel, axes[2]));
        match runs.last_mut() {
            // A run goes on for as long as what it says is true.
            Some((length, symbol)) if symbol.level(|| above, &predicted) == level && *length <= 0xff => *length += 1,
            Some((_, symbol)) if symbol.level(|| above, &predicted) == level => {
                let symbol = *symbol;
                runs.push((1, symbol));
            }
            _ => runs.push((1, Symbol::of(level, above, &predicted))),
        }
    }
    Sample { frame, runs, exceptions }
}
