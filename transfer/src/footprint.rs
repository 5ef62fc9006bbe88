//! What compressing a matrix takes in memory, told before the matrix is read.

use crate::matrix::{Shape, TransferMatrix};

/// A matrix as far as it is known before its elements are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Samples, responses, lights.
    pub shape: Shape,
    /// Elements that are not 0, as far as that can be told.
    pub non_zeros: u64,
    /// Whether it is held by its non-zeros alone.
    pub sparse: bool,
}

/// Bytes that compressing holds beside the matrix: estimates from above, of matrices as scenes have them seldom more than twice what it
/// comes to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Footprint {
    /// The most at once, the result included.
    pub peak: u64,
    /// The result alone.
    pub result: u64,
}

impl Footprint {
    /// Of what nobody has the memory for.
    pub const BOUNDLESS: Footprint = Footprint { peak: MOST, result: MOST };
}

impl Extent {
    /// Whether the elements alone are more than anyone has.
    pub fn is_boundless(&self) -> bool {
        self.cells() > MOST_CELLS
    }
    /// Of a matrix that is there.
    pub fn of(matrix: &TransferMatrix) -> Extent {
        Extent { shape: matrix.shape(), non_zeros: matrix.non_zeros() as u64, sparse: matrix.is_sparse() }
    }
    /// Rows.
    pub fn rows(&self) -> u64 {
        self.shape.samples as u64 * self.shape.responses as u64
    }
    /// Elements, zeros included.
    pub fn cells(&self) -> u64 {
        self.rows().saturating_mul(self.shape.lights as u64)
    }
    /// Whether few elements are not 0, as those of visibility by local direction: such values are alike, and their forms small.
    pub fn is_thin(&self) -> bool {
        self.sparse && self.cells() > THIN.saturating_mul(self.non_zeros)
    }
    /// Bytes of the matrix itself.
    pub fn bytes(&self) -> u64 {
        if self.sparse { by(8.0, self.non_zeros) + by(8.0, self.rows()) } else { by(4.0, self.cells()) }
    }
}

/// Elements for each of a thin matrix that is not 0.
const THIN: u64 = 16;

/// More bytes than anyone has; sums of a few of them are numbers still.
const MOST: u64 = 1 << 58;

/// Elements of a matrix that is told of: a file's header may claim more, and no product of sizes of one that has no more overflows.
const MOST_CELLS: u64 = 1 << 50;

/// So many bytes for each of a number of things, 2⁵⁸ at most.
pub fn by(bytes: f64, number: u64) -> u64 {
    ((bytes * number as f64) as u64).min(MOST)
}
