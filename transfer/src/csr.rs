//! `csr`: the exact reference that every other method is drawn against. Compressed sparse rows with 32-bit columns and values.

use crate::codec::{Codec, Configure, Encoded, Restore};
use crate::error::Result;
use crate::flops::{Count, Flops};
use crate::footprint::{Extent, Footprint, by};
use crate::kernel::{self, BLOCK_ROWS, RowKernel};
use crate::matrix::{Row, Shape, TransferMatrix};
use crate::progress::Progress;
use crate::sections::{Sink, Source, broken};
use ndarray::{ArrayView2, ArrayViewMut2};

crate::params! {
    /// Compressed sparse rows: u32 columns, f32 values, u64 offsets. Exact.
    pub struct CsrParams: "csr" {}
}

/// The codec.
pub struct Csr(CsrParams);

/// Rows of non-zero elements. FLOPs: 2·nnz.
pub struct EncodedCsr {
    shape: Shape,
    offsets: Vec<u64>,
    columns: Vec<u32>,
    values: Vec<f32>,
}

impl Configure for Csr {
    type Params = CsrParams;
    fn new(params: CsrParams) -> Result<Csr> {
        Ok(Csr(params))
    }
    fn params(&self) -> &CsrParams {
        &self.0
    }
}

impl Codec for Csr {
    type Encoded = EncodedCsr;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCsr> {
        let rows = matrix.rows();
        progress.start("encode", rows as u64);
        if let Some((offsets, columns, values)) = matrix.as_csr() {
            let offsets = offsets.iter().map(|&o| o as u64).collect();
            progress.advance(rows as u64)?;
            return Ok(EncodedCsr {
                shape: matrix.shape(),
                offsets,
                columns: columns.to_vec(),
                values: values.to_vec(),
            });
        }
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        let mut offsets = Vec::with_capacity(rows + 1);
        offsets.push(0);
        for row in 0..rows {
            for (col, value) in matrix.row(row).non_zeros() {
                columns.push(col as u32);
                values.push(value);
            }
            offsets.push(columns.len() as u64);
            progress.advance(1)?;
        }
        columns.shrink_to_fit();
        values.shrink_to_fit();
        Ok(EncodedCsr { shape: matrix.shape(), offsets, columns, values })
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // Of a dense matrix nobody knows how many there will be: vectors grow to twice what they hold.
        let (offsets, grown) = (by(8.0, extent.rows() + 1), if extent.sparse { 1.0 } else { 2.0 });
        let of_elements = |bytes: f64| by(bytes, extent.non_zeros) + offsets;
        Some(Footprint { peak: of_elements(grown * 8.0), result: of_elements(8.0) })
    }
}

impl EncodedCsr {
    fn row(&self, row: usize) -> (&[u32], &[f32]) {
        let range = self.offsets[row] as usize..self.offsets[row + 1] as usize;
        (&self.columns[range.clone()], &self.values[range])
    }
}

impl RowKernel for EncodedCsr {
    #[inline]
    fn product<const N: usize, C: Count>(&self, row: usize, x: &[[f32; N]], count: &mut C) -> [f32; N] {
        let (columns, values) = self.row(row);
        count.multiply_add(values.len());
        count.factors(values.iter().copied());
        // SAFETY: columns are below `shape.lights` (checked by TransferMatrix, or by `read`), which is x.len().
        unsafe { kernel::sparse_dot(columns, values, x) }
    }

    fn block<const N: usize>(&self, first: usize, x: &[[f32; N]], out: &mut [[f32; N]]) {
        let start = self.offsets[first] as usize;
        let mut ends = [0u32; BLOCK_ROWS];
        let ends = &mut ends[..out.len()];
        // No overflow: 64 rows have at most 2^31 columns, ascending below MAX_LIGHTS in each.
        ends.iter_mut().zip(&self.offsets[first + 1..]).for_each(|(end, &o)| *end = (o as usize - start) as u32);
        // SAFETY: offsets ascend to columns.len() and columns are below `shape.lights`, as above.
        unsafe { kernel::sparse_rows(ends, &self.columns[start..], &self.values[start..], x, out) }
    }
}

impl Encoded for EncodedCsr {
    fn shape(&self) -> Shape {
        self.shape
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        kernel::apply(self, self.shape, lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        let (columns, values) = self.row(row);
        Row::Sparse { columns, values }.gather(out);
    }
    fn flops(&self, light: &[f32]) -> Flops {
        kernel::count(self, self.shape, light)
    }
    fn write(&self, sink: &mut Sink) {
        sink.put("index/offsets", &self.offsets);
        sink.put("index/columns", &self.columns);
        sink.put("weights/values", &self.values);
    }
}

impl Restore for EncodedCsr {
    const TAG: &'static str = "csr.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedCsr> {
        let offsets: Vec<u64> = source.take_exact("index/offsets", shape.rows() + 1)?;
        let columns: Vec<u32> = source.take("index/columns")?;
        let values = source.take_finite("weights/values", columns.len())?;
        let ends = (offsets[0], offsets[shape.rows()]);
        if ends != (0, columns.len() as u64) || offsets.windows(2).any(|w| w[0] > w[1]) {
            return Err(broken("index/offsets", format!("ascending from 0 to {}", columns.len()), format!("{ends:?}")));
        }
        let encoded = EncodedCsr { shape, offsets, columns, values };
        for row in 0..shape.rows() {
            let columns = encoded.row(row).0;
            let ascending = columns.windows(2).all(|w| w[0] < w[1]);
            if !ascending || columns.last().is_some_and(|&c| c as usize >= shape.lights) {
                return Err(broken(
                    "index/columns",
                    format!("ascending columns below {} in row {row}", shape.lights),
                    format!("{:?} …", &columns[..columns.len().min(8)]),
                ));
            }
        }
        Ok(encoded)
    }
}
