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
    /// A row of T; `out.len()` = lights.
    fn row_into(&self, row: usize, out: &mut [f32]);

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
    fn row_into(&self, row: usize, out: &mut [f32]) {
        self.gather(row, out);
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
    fn row_into(&self, row: usize, out: &mut [f32]) {
        self.row_into(row, out);
    }
}
