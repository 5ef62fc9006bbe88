//! What turns light into responses: a transfer matrix, exact or compressed.

use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use prt_transfer::{Compressed, LightBasis, ResponseBasis, Result, Shape, TransferMatrix};

/// A matrix that is asked the same things whether it is compressed or not.
pub trait Operator: Sync {
    /// Samples, responses, lights.
    fn shape(&self) -> Shape;
    /// What the columns stand for.
    fn basis(&self) -> &LightBasis;
    /// What the responses of a sample stand for.
    fn responses(&self) -> &ResponseBasis;
    /// `out` (rows x channels) = T · `lights` (lights x channels).
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()>;
    /// Rows of T from `first` on, one a row of `out` (rows x lights).
    fn rows_into(&self, first: usize, out: ArrayViewMut2<f32>);

    /// T · `lights`, rows x channels.
    fn relit(&self, lights: ArrayView2<f32>) -> Result<Array2<f32>> {
        let mut out = Array2::zeros((self.shape().rows(), lights.ncols()));
        self.apply_into(lights, out.view_mut())?;
        Ok(out)
    }
}

impl Operator for TransferMatrix {
    fn shape(&self) -> Shape {
        self.shape()
    }
    fn basis(&self) -> &LightBasis {
        self.basis()
    }
    fn responses(&self) -> &ResponseBasis {
        self.responses()
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        self.apply_into(lights, out)
    }
    fn rows_into(&self, first: usize, mut out: ArrayViewMut2<f32>) {
        for (row, mut out) in (first..).zip(out.outer_iter_mut()) {
            self.gather(row, out.as_slice_mut().expect("rows that are gathered are contiguous"));
        }
    }
}

impl Operator for Compressed {
    fn shape(&self) -> Shape {
        self.shape()
    }
    fn basis(&self) -> &LightBasis {
        self.basis()
    }
    fn responses(&self) -> &ResponseBasis {
        self.responses()
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        self.apply_into(lights, out)
    }
    fn rows_into(&self, first: usize, out: ArrayViewMut2<f32>) {
        self.rows_into(first, out);
    }
}
