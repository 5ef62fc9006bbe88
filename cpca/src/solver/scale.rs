//! Powers of two that bring the elements of a matrix near 1, and back.

use ndarray::{Array2, ArrayView2};
use prt_transfer::{Error, Result};

/// The exponent of the largest element; none where all are zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale(Option<i32>);

impl Scale {
    /// The matrix over a power of two, so that its largest element has a magnitude from 1 to 2; row-major.
    ///
    /// # Errors
    /// An element that is not finite.
    pub(crate) fn normalise(matrix: ArrayView2<f64>) -> Result<(Scale, Array2<f64>)> {
        if let Some(((row, col), &value)) = matrix.indexed_iter().find(|(_, v)| !v.is_finite()) {
            return Err(Error::NotFinite { row, col, value });
        }
        let largest = matrix.iter().fold(0f64, |largest, v| largest.max(v.abs()));
        let scale = Scale((largest > 0.0).then(|| exponent(largest)));
        let mut normal = Array2::zeros(matrix.dim());
        normal.assign(&matrix);
        if let Some(exponent) = scale.0 {
            // One exact factor, or two where 2^-exponent is no number.
            let [first, second] = halves(-exponent);
            normal.mapv_inplace(|v| v * first * second);
        }
        Ok((scale, normal))
    }

    pub(crate) fn is_zero(self) -> bool {
        self.0.is_none()
    }

    /// A number that grows as the `power`-th power of the matrix, of the matrix as it was.
    ///
    /// # Errors
    /// One beyond the range of `f64`.
    pub(crate) fn restore(self, number: f64, power: i32) -> Result<f64> {
        let restored = (0..power).fold(number, |number, _| {
            let [first, second] = halves(self.0.unwrap_or(0));
            number * first * second
        });
        if restored.is_finite() { Ok(restored) } else { Err(beyond(number, power * self.0.unwrap_or(0))) }
    }
}

/// Two powers of two whose product is 2^exponent, for exponents of magnitude below 2000.
fn halves(exponent: i32) -> [f64; 2] {
    [2f64.powi(exponent / 2), 2f64.powi(exponent - exponent / 2)]
}

/// The e for which a positive number is 2^e to 2^(e+1).
fn exponent(number: f64) -> i32 {
    let biased = |number: f64| (number.to_bits() >> 52) as i32;
    match biased(number) {
        // Subnormal.
        0 => biased(number * 2f64.powi(64)) - 1023 - 64,
        normal => normal - 1023,
    }
}

fn beyond(number: f64, exponent: i32) -> Error {
    Error::Unsupported {
        what: "square of a singular value".into(),
        expected: "below 2^1024".into(),
        found: format!("{number}·2^{exponent}"),
    }
}
