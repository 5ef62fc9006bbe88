//! The matrix as points: a vector of responses x lights numbers for each sample.

use crate::codec::Encoded;
use crate::error::Result;
use crate::matrix::TransferMatrix;
use crate::metric::Metric;
use ndarray::{Array2, ArrayView2, Axis};
use rayon::prelude::*;
use std::borrow::Cow;

crate::choices! {
    /// In which coordinates error is measured while compressing.
    pub enum Norm {
        /// Of the matrix as it is: the paper's squared error.
        Coefficients = "coefficients",
        /// Orthonormal ones on both sides, where they are known: squared error of exit radiance over the hemisphere, of light over the sphere.
        Radiance = "radiance",
    }
}

/// Samples as vectors in the coordinates in which error is measured, scaled by a power of two to magnitudes around 1.
pub struct Samples<'a> {
    /// Row-major, count x dimension.
    values: Cow<'a, [f32]>,
    count: usize,
    dimension: usize,
    coordinates: Coordinates,
}

/// The way back to the matrix's own coordinates.
struct Coordinates {
    /// `None` where they are the matrix's own.
    metric: Option<Metric>,
    lights: usize,
    /// Samples are 2^-exponent of what the matrix holds.
    exponent: i32,
}

/// Magnitudes whose squares and sums of squares are neither lost nor infinite stay as they are.
const HARMLESS: std::ops::RangeInclusive<i32> = -32..=32;

impl<'a> Samples<'a> {
    /// Every sample of `matrix`. Dense matrices whose numbers need no other coordinates are borrowed.
    ///
    /// # Errors
    /// Responses that do not exist.
    pub fn of(matrix: &'a TransferMatrix, norm: Norm) -> Result<Samples<'a>> {
        let metric = norm.metric(matrix)?;
        let (shape, exponent) = (matrix.shape(), exponent(matrix));
        let dimension = shape.responses * shape.lights;
        let coordinates = Coordinates { metric, lights: shape.lights, exponent };
        let values = match matrix.as_dense() {
            Some(values) if coordinates.metric.is_none() && exponent == 0 => Cow::Borrowed(values),
            _ => Cow::Owned(coordinates.gathered(matrix, shape.samples, dimension)),
        };
        Ok(Samples { values, count: shape.samples, dimension, coordinates })
    }

    /// Row-major `values`, count x dimension, that are such samples already: their own coordinates, of magnitudes around 1.
    ///
    /// # Panics
    /// Another number of values.
    pub fn of_values(values: &'a [f32], count: usize, dimension: usize) -> Samples<'a> {
        assert_eq!(values.len(), count * dimension, "{count} samples of {dimension} numbers");
        let coordinates = Coordinates { metric: None, lights: dimension, exponent: 0 };
        Samples { values: Cow::Borrowed(values), count, dimension, coordinates }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Numbers of each: responses x lights.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The same, lent, with no way back to the matrix's coordinates.
    pub fn lent(&self) -> Samples<'_> {
        let coordinates = Coordinates { metric: None, lights: self.dimension, exponent: 0 };
        let values = Cow::Borrowed(&self.values[..]);
        Samples { values, count: self.count, dimension: self.dimension, coordinates }
    }

    /// Row-major, count x dimension.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The vector of a sample.
    pub fn row(&self, sample: usize) -> &[f32] {
        &self.values[sample * self.dimension..][..self.dimension]
    }

    /// A vector of these coordinates, in place, in the matrix's own.
    pub fn restore(&self, vector: &mut [f64]) {
        if let Some(metric) = &self.coordinates.metric {
            metric.from_orthonormal(vector, self.coordinates.lights);
        }
    }

    /// As [`Samples::restore`] of a sample responses ⊗ lights, one factor of which this is.
    pub fn restore_lights(&self, lights: &mut [f64]) {
        if let Some(metric) = &self.coordinates.metric {
            metric.lights_from_orthonormal(lights);
        }
    }

    /// The other factor.
    pub fn restore_responses(&self, responses: &mut [f64]) {
        if let Some(metric) = &self.coordinates.metric {
            metric.responses_from_orthonormal(responses);
        }
    }

    /// The power of two that samples are multiplied by in the matrix, as a product of two: each keeps numbers around 1 in range.
    pub fn scales(&self) -> (f64, f64) {
        let half = self.coordinates.exponent / 2;
        (f64::from(half).exp2(), f64::from(self.coordinates.exponent - half).exp2())
    }

    /// As many samples in other coordinates of the same distances, with no way back.
    pub fn with_values(&self, values: Vec<f32>, dimension: usize) -> Samples<'static> {
        let coordinates = Coordinates { metric: None, lights: dimension, exponent: 0 };
        Samples { values: Cow::Owned(values), count: self.count, dimension, coordinates }
    }
}

/// Rows that are decoded at once, about.
const AT_ONCE: usize = 64;

impl Norm {
    /// The metric of a matrix; `None` where error is that of its elements.
    ///
    /// # Errors
    /// Responses that do not exist.
    pub fn metric(self, matrix: &TransferMatrix) -> Result<Option<Metric>> {
        match self {
            Norm::Coefficients => Ok(None),
            Norm::Radiance => Ok(Some(Metric::of(matrix)?).filter(Metric::is_known)),
        }
    }

    /// Squared error of what is decoded, and squared norm.
    ///
    /// # Errors
    /// As [`Norm::metric`].
    pub fn error_of(self, encoded: &dyn Encoded, matrix: &TransferMatrix) -> Result<(f64, f64)> {
        let (shape, metric) = (matrix.shape(), self.metric(matrix)?);
        let square = |rows: &mut [f64]| match &metric {
            Some(metric) => metric.square_of(rows, shape.lights),
            None => rows.iter().map(|v| v * v).sum(),
        };
        let of_sample = |decoded: ArrayView2<f32>, exact: &mut [f32], sample: usize| {
            let (mut errors, mut whole) = (Vec::new(), Vec::new());
            for (response, decoded) in decoded.outer_iter().enumerate() {
                matrix.gather(sample * shape.responses + response, exact);
                errors.extend(decoded.iter().zip(&*exact).map(|(d, e)| f64::from(*d) - f64::from(*e)));
                whole.extend(exact.iter().map(|e| f64::from(*e)));
            }
            (square(&mut errors), square(&mut whole))
        };
        let count = AT_ONCE.div_ceil(shape.responses);
        let task = |task: usize| {
            let samples = task * count..shape.samples.min((task + 1) * count);
            let mut decoded = Array2::zeros((samples.len() * shape.responses, shape.lights));
            encoded.rows_into(samples.start * shape.responses, decoded.view_mut());
            let (mut exact, of_samples) =
                (vec![0f32; shape.lights], decoded.axis_chunks_iter(Axis(0), shape.responses));
            samples.zip(of_samples).map(|(sample, rows)| of_sample(rows, &mut exact, sample)).collect::<Vec<_>>()
        };
        // Sums do not depend on the number of threads: they are of samples, in their order.
        let sums: Vec<(f64, f64)> = (0..shape.samples.div_ceil(count)).into_par_iter().flat_map_iter(task).collect();
        Ok(sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1)))
    }
}

impl Coordinates {
    fn gathered(&self, matrix: &TransferMatrix, samples: usize, dimension: usize) -> Vec<f32> {
        let mut values = vec![0f32; samples * dimension];
        let (responses, scale) = (matrix.shape().responses, f64::from(-self.exponent).exp2());
        values.par_chunks_mut(dimension.max(1)).enumerate().for_each_init(Vec::new, |wide, (sample, out)| {
            for (response, row) in out.chunks_mut(self.lights.max(1)).enumerate() {
                matrix.gather(sample * responses + response, row);
            }
            wide.clear();
            wide.extend(out.iter().map(|v| f64::from(*v) * scale));
            if let Some(metric) = &self.metric {
                metric.to_orthonormal(wide, self.lights);
            }
            out.iter_mut().zip(wide).for_each(|(v, w)| *v = *w as f32);
        });
        values
    }
}

/// The sum of squares, in double precision.
pub fn square(vector: &[f32]) -> f64 {
    // Strands that become vectors.
    let mut sums = [0f64; 8];
    let (chunks, rest) = vector.as_chunks::<8>();
    for chunk in chunks {
        for i in 0..8 {
            sums[i] += f64::from(chunk[i]).powi(2);
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>()
}

/// The power of two of the largest magnitude, 0 where that is harmless: what samples are divided by.
pub fn exponent(matrix: &TransferMatrix) -> i32 {
    let largest = (0..matrix.rows())
        .into_par_iter()
        .map(|row| matrix.row(row).non_zeros().fold(0f32, |largest, (_, v)| largest.max(v.abs())))
        .reduce(|| 0.0, f32::max);
    match largest {
        0.0 => 0,
        _ => Some(f64::from(largest).log2().floor() as i32).filter(|e| !HARMLESS.contains(e)).unwrap_or(0),
    }
}
