//! Kept elements column by column within blocks of rows: light coefficients that are 0 are skipped.

use crate::encoded::Layout;
use crate::keep::Kept;
use crate::stored::{Index, Value};
use crate::wire;
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use prt_transfer::matrix::check_apply;
use prt_transfer::sections::broken;
use prt_transfer::{Count, Encoded, Flops, NoCount, Result, Shape, Sink, Source, Tally};
use rayon::prelude::*;

/// Rows of a block: their sums stay in the first-level cache, and a block is a thread's piece of work.
const BLOCK: usize = 1024;

/// Where the blocks' columns and elements begin; the last is where all end.
type Starts = Vec<[u32; 2]>;

/// Compressed columns of blocks of rows; a column without elements is not there.
pub(crate) struct Columns<I, V> {
    shape: Shape,
    starts: Starts,
    /// Ascending within a block, below `shape.lights`.
    columns: Vec<I>,
    /// Elements of each column, 1 to [`BLOCK`].
    lengths: Vec<u16>,
    /// Rows counted from the block's first, ascending within a column.
    rows: Vec<u16>,
    values: Vec<V>,
    /// The step of each row; empty where values are stored as they are.
    steps: Vec<f32>,
}

impl<I: Index, V: Value> Columns<I, V> {
    /// The columns of a block: their index, and the positions of their elements.
    fn block(&self, block: usize) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + '_ {
        let ([from, element], [to, _]) = (self.starts[block], self.starts[block + 1]);
        let columns = from as usize..to as usize;
        let mut end = element as usize;
        self.columns[columns.clone()].iter().zip(&self.lengths[columns]).map(move |(column, &length)| {
            let start = end;
            end += usize::from(length);
            (column.at(), start..end)
        })
    }

    /// The kernel: adds the product of a block with N packed channels onto `sums`, telling what one channel takes.
    fn product<const N: usize, C: Count>(
        &self,
        block: usize,
        x: &[[f32; N]],
        sums: &mut [[f32; N]; BLOCK],
        count: &mut C,
    ) {
        for (column, elements) in self.block(block) {
            let x = x[column];
            if x == [0.0; N] {
                continue;
            }
            let (rows, values) = (&self.rows[elements.clone()], &self.values[elements]);
            count.multiply_add(values.len());
            count.factors(values.iter().map(|v| v.number()));
            for (row, value) in rows.iter().zip(values) {
                // Rows are below BLOCK already; the remainder tells the compiler so.
                let (sum, value) = (&mut sums[usize::from(*row) % BLOCK], value.number());
                sum.iter_mut().zip(x).for_each(|(s, x)| *s += value * x);
            }
        }
        if !self.steps.is_empty() {
            let steps = self.steps.iter().skip(block * BLOCK).take(BLOCK);
            count.multiply(steps.len());
            count.factors(steps.clone().copied());
            sums.iter_mut().zip(steps).for_each(|(sum, step)| sum.iter_mut().for_each(|s| *s *= step));
        }
    }

    fn apply_packed<const N: usize>(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        let pack = |k: usize| std::array::from_fn(|c| if c < lights.ncols() { lights[[k, c]] } else { 0.0 });
        let packed: Vec<[f32; N]> = (0..lights.nrows()).map(pack).collect();
        out.axis_chunks_iter_mut(Axis(0), BLOCK).into_par_iter().enumerate().for_each(|(block, mut rows)| {
            let mut sums = [[0f32; N]; BLOCK];
            self.product(block, &packed, &mut sums, &mut NoCount);
            for (mut y, sum) in rows.outer_iter_mut().zip(sums) {
                y.iter_mut().zip(sum).for_each(|(y, s)| *y = s);
            }
        });
    }

    fn check_block(&self, block: usize) -> Result<()> {
        let ([from, element], [to, end]) = (self.starts[block], self.starts[block + 1]);
        let (columns, elements) = (from as usize..to as usize, element as usize..end as usize);
        let place = || format!("block {block}");
        let indices = self.columns[columns.clone()].iter().map(|c| c.at());
        wire::check_ascending("index/columns", place, indices, self.shape.lights)?;
        let sum: usize = self.lengths[columns.clone()].iter().map(|&l| usize::from(l)).sum();
        if sum != elements.len() || self.lengths[columns].contains(&0) {
            let expected = format!("{} elements in block {block}, none of 0", elements.len());
            return Err(broken("index/lengths", expected, sum.to_string()));
        }
        let rows = BLOCK.min(self.shape.rows() - block * BLOCK);
        for (column, elements) in self.block(block) {
            let place = || format!("column {column} of block {block}");
            wire::check_ascending("index/rows", place, self.rows[elements].iter().map(|&r| r.into()), rows)?;
        }
        Ok(())
    }
}

impl<I: Index, V: Value> Layout for Columns<I, V> {
    fn new(shape: Shape, kept: Kept) -> Self {
        let total = kept.values.len();
        let (mut starts, mut columns, mut lengths) = (vec![[0, 0]], Vec::new(), Vec::new());
        let (mut rows, mut values) = (vec![0u16; total], vec![V::store(0.0, 1.0); total]);
        // Counting sort of each block by column; rows ascend since they come in order.
        let mut next = vec![0usize; shape.lights];
        for first in (0..shape.rows()).step_by(BLOCK) {
            let last = shape.rows().min(first + BLOCK);
            let (from, to) = (kept.offsets[first] as usize, kept.offsets[last] as usize);
            next.fill(0);
            kept.columns[from..to].iter().for_each(|&c| next[c as usize] += 1);
            let mut position = from;
            for (column, next) in next.iter_mut().enumerate().filter(|(_, n)| **n > 0) {
                columns.push(I::narrow(column as u32));
                lengths.push(*next as u16);
                position += std::mem::replace(next, position);
            }
            for row in first..last {
                for i in kept.offsets[row] as usize..kept.offsets[row + 1] as usize {
                    let to = &mut next[kept.columns[i] as usize];
                    rows[*to] = (row - first) as u16;
                    values[*to] = V::store(kept.values[i], kept.steps[row]);
                    *to += 1;
                }
            }
            starts.push([columns.len() as u32, to as u32]);
        }
        Columns { shape, starts, columns, lengths, rows, values, steps: wire::steps_of::<V>(kept.steps) }
    }

    fn read(shape: Shape, source: &mut Source) -> Result<Self> {
        let blocks = shape.rows().div_ceil(BLOCK);
        let starts: Starts = source.take_exact("index/blocks", blocks + 1)?;
        let columns: Vec<I> = source.take("index/columns")?;
        let lengths = source.take_exact("index/lengths", columns.len())?;
        let rows: Vec<u16> = source.take("index/rows")?;
        let values = wire::take_values(source, rows.len())?;
        let steps = wire::take_steps::<V>(source, shape.rows())?;
        let ends = [starts[0], starts[blocks]].map(|s| s.map(|n| n as usize));
        let descent = starts.windows(2).position(|w| w[0][0] > w[1][0] || w[0][1] > w[1][1]);
        if ends != [[0, 0], [columns.len(), rows.len()]] || descent.is_some() {
            let expected = format!("ascending from [0, 0] to {:?}", [columns.len(), rows.len()]);
            let found = format!("{ends:?}, descending after block {descent:?}");
            return Err(broken("index/blocks", expected, found));
        }
        let encoded = Columns { shape, starts, columns, lengths, rows, values, steps };
        (0..blocks).try_for_each(|block| encoded.check_block(block))?;
        Ok(encoded)
    }
}

impl<I: Index, V: Value> Encoded for Columns<I, V> {
    fn shape(&self) -> Shape {
        self.shape
    }
    fn apply_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) -> Result<()> {
        check_apply(self.shape, &lights, &out)?;
        let channels = lights.ncols();
        let mut first = 0;
        while first < channels {
            // Three channels travel as four: one vector register, the last lane idle.
            let width = if channels - first == 1 { 1 } else { (channels - first).min(4) };
            let lights = lights.slice(s![.., first..first + width]);
            let out = out.slice_mut(s![.., first..first + width]);
            if width == 1 {
                self.apply_packed::<1>(lights, out)
            } else {
                self.apply_packed::<4>(lights, out)
            }
            first += width;
        }
        Ok(())
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        out.fill(0.0);
        let step = self.steps.get(row).copied().unwrap_or(1.0);
        let local = (row % BLOCK) as u16;
        for (column, elements) in self.block(row / BLOCK) {
            if let Ok(at) = self.rows[elements.clone()].binary_search(&local) {
                out[column] = self.values[elements.start + at].number() * step;
            }
        }
    }
    fn flops(&self, light: &[f32]) -> Flops {
        let packed: Vec<[f32; 1]> = light.iter().map(|&x| [x]).collect();
        let (mut tally, mut sums) = (Tally::default(), [[0f32]; BLOCK]);
        (0..self.starts.len() - 1).for_each(|block| self.product(block, &packed, &mut sums, &mut tally));
        tally.0
    }
    fn write(&self, sink: &mut Sink) {
        sink.put("index/blocks", &self.starts);
        sink.put("index/columns", &self.columns);
        sink.put("index/lengths", &self.lengths);
        sink.put("index/rows", &self.rows);
        wire::put_values(sink, &self.values, &self.steps);
    }
}
