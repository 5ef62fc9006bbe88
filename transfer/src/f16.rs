//! `f16`: half-precision values, the plain rival of every lossy method.
//!
//! One power of two scales the whole matrix so that its largest magnitude lies in [2^14, 2^15): any finite matrix fits, and
//! every value above 2^-28 of the largest keeps a relative precision of 2^-11. Smaller ones keep an absolute precision of
//! 2^-39 of the largest, and may become 0.

use crate::codec::{Codec, Configure, Encoded, Restore};
use crate::error::Result;
use crate::flops::Flops;
use crate::footprint::{Extent, Footprint, by};
use crate::matrix::{Shape, TransferMatrix};
use crate::narrow::{Narrow, Pattern, Values};
use crate::progress::Progress;
use crate::sections::{Sink, Source, broken};
use ndarray::{ArrayView2, ArrayViewMut2};

crate::params! {
    /// Half-precision values, sparse or dense as the matrix is: relative precision 2^-11, error measured and not bounded.
    pub struct F16Params: "f16" {}
}

/// The codec.
pub struct F16(F16Params);

/// Halves, in sparse rows or in full. FLOPs: 2·nnz, or 2·rows·lights.
pub struct EncodedF16(Narrow);

impl Configure for F16 {
    type Params = F16Params;
    fn new(params: F16Params) -> Result<F16> {
        Ok(F16(params))
    }
    fn params(&self) -> &F16Params {
        &self.0
    }
}

impl Codec for F16 {
    type Encoded = EncodedF16;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedF16> {
        if let Some(values) = matrix.as_dense() {
            progress.start("encode", matrix.rows() as u64);
            let encoded = EncodedF16(Narrow::full(matrix.shape(), Values::halves(values)));
            progress.advance(matrix.rows() as u64)?;
            return Ok(encoded);
        }
        let (pattern, values) = Pattern::of(matrix, progress)?;
        Ok(EncodedF16(Narrow::sparse(matrix.shape(), pattern, Values::halves(&values))))
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        if !extent.sparse {
            let result = by(2.0, extent.cells());
            return Some(Footprint { peak: result, result });
        }
        // As `compact`, with values of two bytes.
        let of_rows = by(24.0, extent.rows());
        Some(Footprint { peak: by(9.0, extent.non_zeros) + of_rows, result: by(6.0, extent.non_zeros) + of_rows })
    }
}

impl Encoded for EncodedF16 {
    fn shape(&self) -> Shape {
        self.0.shape()
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        self.0.apply_into(lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        self.0.row_into(row, out);
    }
    fn flops(&self, light: &[f32]) -> Flops {
        self.0.flops(light)
    }
    fn write(&self, sink: &mut Sink) {
        self.0.write(sink);
    }
}

impl Restore for EncodedF16 {
    const TAG: &'static str = "f16.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedF16> {
        let narrow = Narrow::read(shape, source)?;
        if !narrow.is_half() {
            return Err(broken("header/layout", "form 1, halves", "another form"));
        }
        Ok(EncodedF16(narrow))
    }
}
