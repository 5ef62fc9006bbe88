//! `compact`: exact, in the narrowest widths that the matrix allows.
//!
//! Row lengths and columns take 1, 2 or 4 bytes. Values are multiples of a power of two in 1 or 2 bytes (supersampled
//! visibility is: k/4), codes of 1 or 2 bytes into a table of the distinct values, halves, or `f32`: whichever is exact and
//! smallest. A matrix without enough zeros to pay for its columns is stored in full, in the same forms.

use crate::codec::{Codec, Configure, Encoded, Restore};
use crate::error::Result;
use crate::flops::Flops;
use crate::footprint::{Extent, Footprint, by};
use crate::matrix::{Shape, TransferMatrix};
use crate::narrow::Narrow;
use crate::progress::Progress;
use crate::sections::{Sink, Source};
use ndarray::{ArrayView2, ArrayViewMut2};

crate::params! {
    /// Sparse rows, or all elements, in the narrowest exact integers, table codes or floats. Exact.
    pub struct CompactParams: "compact" {}
}

/// The codec.
pub struct Compact(CompactParams);

/// Elements in narrow widths. FLOPs: 2 for each stored element, which are the non-zeros or, in a full matrix, all.
pub struct EncodedCompact(Narrow);

impl Configure for Compact {
    type Params = CompactParams;
    fn new(params: CompactParams) -> Result<Compact> {
        Ok(Compact(params))
    }
    fn params(&self) -> &CompactParams {
        &self.0
    }
}

impl Codec for Compact {
    type Encoded = EncodedCompact;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCompact> {
        Ok(EncodedCompact(Narrow::exact(matrix, progress)?))
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // Columns and table codes beside the elements, of a dense matrix all of its elements too.
        let of_rows = by(24.0, extent.rows());
        let (peak, result) = match extent.is_thin() {
            true => (by(9.0, extent.non_zeros), by(8.0, extent.non_zeros)),
            false => (by(12.0, extent.non_zeros) + by(6.4, extent.cells()), by(4.0, extent.cells())),
        };
        Some(Footprint { peak: peak + of_rows, result: result + of_rows })
    }
}

impl Encoded for EncodedCompact {
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

impl Restore for EncodedCompact {
    const TAG: &'static str = "compact.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedCompact> {
        Ok(EncodedCompact(Narrow::read(shape, source)?))
    }
}
