//! `dense`: every element as f32, the size that compression is measured against.

use crate::codec::{Codec, Configure, Encoded, Restore};
use crate::error::Result;
use crate::flops::{Count, Flops, Tally};
use crate::footprint::{Extent, Footprint, by};
use crate::kernel;
use crate::matrix::{Shape, TransferMatrix};
use crate::progress::Progress;
use crate::sections::{Sink, Source};
use ndarray::{ArrayView2, ArrayViewMut2};

crate::params! {
    /// Every element as f32, zeros included. Exact.
    pub struct DenseParams: "dense" {}
}

/// The codec.
pub struct Dense(DenseParams);

/// Row-major elements, rows x lights. FLOPs: 2·rows·lights.
pub struct EncodedDense {
    shape: Shape,
    values: Vec<f32>,
}

impl Configure for Dense {
    type Params = DenseParams;
    fn new(params: DenseParams) -> Result<Dense> {
        Ok(Dense(params))
    }
    fn params(&self) -> &DenseParams {
        &self.0
    }
}

impl Codec for Dense {
    type Encoded = EncodedDense;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedDense> {
        progress.start("encode", matrix.rows() as u64);
        let mut values = vec![0f32; matrix.rows() * matrix.lights()];
        for (row, out) in values.chunks_mut(matrix.lights().max(1)).enumerate() {
            matrix.gather(row, out);
            progress.advance(1)?;
        }
        Ok(EncodedDense { shape: matrix.shape(), values })
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        let result = by(4.0, extent.cells());
        Some(Footprint { peak: result, result })
    }
}

impl Encoded for EncodedDense {
    fn shape(&self) -> Shape {
        self.shape
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        kernel::dense::apply(&self.values, self.shape, lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        out.copy_from_slice(&self.values[row * self.shape.lights..][..self.shape.lights]);
    }
    fn flops(&self, _: &[f32]) -> Flops {
        // The kernel multiplies by every element, whatever the light.
        let mut tally = Tally::default();
        tally.multiply_add(self.values.len());
        tally.factors(self.values.iter().copied());
        tally.0
    }
    fn write(&self, sink: &mut Sink) {
        sink.put("weights/values", &self.values);
    }
}

impl Restore for EncodedDense {
    const TAG: &'static str = "dense.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedDense> {
        let values = source.take_finite("weights/values", shape.rows() * shape.lights)?;
        Ok(EncodedDense { shape, values })
    }
}
