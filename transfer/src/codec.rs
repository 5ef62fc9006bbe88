//! The contract that every compression method keeps. Size, files, error and charts follow from it.

use crate::error::Result;
use crate::flops::Flops;
use crate::footprint::{Extent, Footprint};
use crate::matrix::{Shape, TransferMatrix};
use crate::params::Params;
use crate::progress::Progress;
use crate::sections::{Sink, Source};
use ndarray::{ArrayView2, ArrayViewMut2};

/// Anything with checked parameters: constructed means valid.
pub trait Configure: Sized + Send + Sync + 'static {
    /// Its parameters.
    type Params: Params;
    /// The only door: refuses what is out of range.
    fn new(params: Self::Params) -> Result<Self>;
    /// What it was made with.
    fn params(&self) -> &Self::Params;
}

/// A compression method.
pub trait Codec: Configure {
    /// What it makes of a matrix.
    type Encoded: Encoded + Restore + 'static;
    /// Compresses `matrix`. The same input and parameters give the same bytes on any number of threads.
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Self::Encoded>;
    /// What [`Codec::encode`] of such a matrix takes in memory on rayon's current pool, so that what does not fit can be refused before it is
    /// begun; `None` where nobody has measured it.
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        let _ = extent;
        None
    }
}

/// A compressed matrix: relights without being decompressed.
pub trait Encoded: Send + Sync {
    /// Samples, responses and lights of the matrix that it stands for.
    fn shape(&self) -> Shape;
    /// Relights: `out` (rows x channels) = T̃ · `lights` (lights x channels), on rayon's current pool. Sizes are checked.
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()>;
    /// Reconstructs one row, zeros included; `out.len()` = lights.
    fn row_into(&self, row: usize, out: &mut [f32]);
    /// Reconstructs rows from `first` on, one a row of `out` (rows x lights): as [`Encoded::row_into`] for each, to rounding, for codecs that
    /// do many at once faster.
    fn rows_into(&self, first: usize, mut out: ArrayViewMut2<f32>) {
        for (i, mut out) in out.outer_iter_mut().enumerate() {
            self.row_into(first + i, out.as_slice_mut().expect("rows that are reconstructed are contiguous"));
        }
    }
    /// Operations of relighting with one light (one channel, `light.len()` = lights), counted by the kernel as it runs.
    fn flops(&self, light: &[f32]) -> Flops;
    /// Writes everything that [`Restore::read`] needs besides the shape, section by section.
    fn write(&self, sink: &mut Sink);
    /// Writes what relighting holds in memory, array by array, where that is not what [`Encoded::write`] writes: a codec may
    /// keep a shorter form in the file and derive the rest from it.
    fn hold(&self, sink: &mut Sink) {
        self.write(sink);
    }
    /// What was found while compressing and is neither in the label nor in a file, in a sentence for the user; `None` where there is nothing
    /// to say.
    fn note(&self) -> Option<String> {
        None
    }
}

/// The way back from sections.
pub trait Restore: Sized {
    /// Names the layout in a file; changes when the layout does.
    const TAG: &'static str;
    /// Reads what [`Encoded::write`] wrote. Bytes are untrusted: whatever is accepted can be used without a panic.
    fn read(shape: Shape, source: &mut Source) -> Result<Self>;
}
