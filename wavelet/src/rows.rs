//! Kept elements row by row, and the kernel that multiplies a row: the one file here with `unsafe`.

use crate::encoded::Layout;
use crate::keep::Kept;
use crate::stored::{Index, Value};
use crate::wire;
use ndarray::{ArrayView2, ArrayViewMut2};
use prt_transfer::kernel::{self, RowKernel};
use prt_transfer::sections::broken;
use prt_transfer::{Count, Encoded, Flops, Result, Shape, Sink, Source};
use std::iter::once;

/// Compressed rows. Every column is below `shape.lights`: [`RowKernel::product`] relies on it.
pub(crate) struct Rows<I, V> {
    shape: Shape,
    offsets: Vec<u32>,
    columns: Vec<I>,
    values: Vec<V>,
    /// The step of each row; empty where values are stored as they are.
    steps: Vec<f32>,
}

impl<I: Index, V: Value> Rows<I, V> {
    fn row(&self, row: usize) -> (&[I], &[V]) {
        let range = self.offsets[row] as usize..self.offsets[row + 1] as usize;
        (&self.columns[range.clone()], &self.values[range])
    }
}

impl<I: Index, V: Value> Layout for Rows<I, V> {
    fn new(shape: Shape, kept: Kept) -> Self {
        let mut values = Vec::with_capacity(kept.values.len());
        for (ends, &step) in kept.offsets.windows(2).zip(&kept.steps) {
            let row = &kept.values[ends[0] as usize..ends[1] as usize];
            values.extend(row.iter().map(|&v| V::store(v, step)));
        }
        let columns = kept.columns.iter().map(|&c| I::narrow(c)).collect();
        Rows { shape, offsets: kept.offsets, columns, values, steps: wire::steps_of::<V>(kept.steps) }
    }

    fn read(shape: Shape, source: &mut Source) -> Result<Self> {
        let offsets: Vec<u32> = source.take_exact("index/offsets", shape.rows() + 1)?;
        let columns: Vec<I> = source.take("index/columns")?;
        let ends = (offsets[0], offsets[shape.rows()] as usize);
        if ends != (0, columns.len()) {
            return Err(broken("index/offsets", format!("from 0 to {}", columns.len()), format!("{ends:?}")));
        }
        for (row, ends) in offsets.windows(2).enumerate() {
            if ends[0] > ends[1] {
                let expected = format!("at least {} after row {row}", ends[0]);
                return Err(broken("index/offsets", expected, ends[1].to_string()));
            }
        }
        // Only now are all ranges known to lie inside.
        for (row, ends) in offsets.windows(2).enumerate() {
            let range = ends[0] as usize..ends[1] as usize;
            let place = || format!("row {row}");
            wire::check_ascending("index/columns", place, columns[range].iter().map(|c| c.at()), shape.lights)?;
        }
        let values = wire::take_values(source, columns.len())?;
        Ok(Rows { shape, offsets, columns, values, steps: wire::take_steps::<V>(source, shape.rows())? })
    }
}

impl<I: Index, V: Value> RowKernel for Rows<I, V> {
    #[inline]
    fn product<const N: usize, C: Count>(&self, row: usize, x: &[[f32; N]], count: &mut C) -> [f32; N] {
        let (columns, values) = self.row(row);
        count.multiply_add(values.len());
        count.factors(values.iter().map(|v| v.number()));
        let (mut sum, mut buffer) = ([0f32; N], [0f32; 64]);
        for (columns, values) in columns.chunks(V::CHUNK).zip(values.chunks(V::CHUNK)) {
            // SAFETY: `new` takes columns from a TransferMatrix and `read` checks them, so all are below shape.lights, which is
            // x.len(); both chunks have one length.
            let part = unsafe { kernel::sparse_dot(columns, V::numbers(values, &mut buffer), x) };
            sum.iter_mut().zip(part).for_each(|(s, p)| *s += p);
        }
        if let Some(&step) = self.steps.get(row) {
            count.multiply(1);
            count.factors(once(step));
            sum.iter_mut().for_each(|s| *s *= step);
        }
        sum
    }
}

impl<I: Index, V: Value> Encoded for Rows<I, V> {
    fn shape(&self) -> Shape {
        self.shape
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        kernel::apply(self, self.shape, lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        out.fill(0.0);
        let (columns, values) = self.row(row);
        let step = self.steps.get(row).copied().unwrap_or(1.0);
        columns.iter().zip(values).for_each(|(c, v)| out[c.at()] = v.number() * step);
    }
    fn flops(&self, light: &[f32]) -> Flops {
        kernel::count(self, self.shape, light)
    }
    fn write(&self, sink: &mut Sink) {
        sink.put("index/offsets", &self.offsets);
        sink.put("index/columns", &self.columns);
        wire::put_values(sink, &self.values, &self.steps);
    }
}
