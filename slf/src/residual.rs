//! Rows less their means: `G = F - μ` (Eq. 3).

use crate::layout::fields;
use crate::params::Colour;
use prt_transfer::samples::{Norm, Samples, exponent, square};
use prt_transfer::{Shape, TransferMatrix};
use rayon::prelude::*;

/// The residuals of a light field, in coordinates in which error is the plain sum of squares, over a power of two.
pub(crate) struct Residual {
    pub(crate) shape: Shape,
    /// Fields one after the other; of each, texels x channels x directions.
    values: Vec<f32>,
    /// μ of each row, as in the matrix.
    pub(crate) means: Vec<f32>,
    /// √w_d of each direction; none where all count the same.
    roots: Option<Vec<f64>>,
    fields: usize,
    exponent: i32,
    /// Σ w F², over the square of the power of two.
    pub(crate) energy: f64,
}

impl Residual {
    /// Of a matrix.
    ///
    /// With weights w_d of mean 1 the mean that leaves least is `μ = Σ w F / Σ w`, and the coordinates are `√w (F - μ)`.
    pub(crate) fn of(matrix: &TransferMatrix, norm: Norm, colour: Colour) -> Residual {
        let (shape, exponent) = (matrix.shape(), exponent(matrix));
        let (m, n, fields) = (shape.samples, shape.lights, fields(colour, shape));
        let weights = weights(matrix, norm);
        let roots: Option<Vec<f64>> = weights.as_ref().map(|w| w.iter().map(|w| w.sqrt()).collect());
        let (scale, whole) = (f64::from(-exponent).exp2(), weights.as_ref().map_or(n as f64, |w| w.iter().sum()));
        let mut values = vec![0f32; shape.rows() * n];
        let row_of = |at: usize| if fields == 1 { at } else { at % m * shape.responses + at / m };
        let each = values.par_chunks_mut(n.max(1)).enumerate().map(|(at, out)| {
            matrix.gather(row_of(at), out);
            let (sum, energy) = sums(out, weights.as_deref(), scale);
            let mean = (sum / whole) as f32;
            let less = |f: &f32| (f64::from(*f) - f64::from(mean)) * scale;
            match &roots {
                None => out.iter_mut().for_each(|f| *f = less(f) as f32),
                Some(roots) => out.iter_mut().zip(roots).for_each(|(f, root)| *f = (less(f) * root) as f32),
            }
            (mean, energy)
        });
        let each: Vec<(f32, f64)> = each.collect();
        let mut means = vec![0f32; shape.rows()];
        each.iter().enumerate().for_each(|(at, (mean, _))| means[row_of(at)] = *mean);
        let energy = each.iter().map(|(_, energy)| energy).sum();
        Residual { shape, values, means, roots, fields, exponent, energy }
    }

    pub(crate) fn fields(&self) -> usize {
        self.fields
    }

    /// Numbers of a texel in a field.
    pub(crate) fn dimension(&self) -> usize {
        self.shape.responses / self.fields * self.shape.lights
    }

    /// Texels x numbers of a texel.
    pub(crate) fn field(&self, field: usize) -> &[f32] {
        let size = self.shape.samples * self.dimension();
        &self.values[field * size..(field + 1) * size]
    }

    /// What is clustered in a field.
    pub(crate) fn samples(&self, field: usize) -> Samples<'_> {
        Samples::of_values(self.field(field), self.shape.samples, self.dimension())
    }

    /// Σ G².
    pub(crate) fn square(&self) -> f64 {
        let squares: Vec<f64> = self.values.par_chunks(1 << 16).map(square).collect();
        squares.iter().sum()
    }

    /// What a number of a vector over directions is in the matrix: over √w_d.
    pub(crate) fn restored(&self, direction: usize, value: f64) -> f64 {
        self.roots.as_ref().map_or(value, |roots| value / roots[direction])
    }

    /// The power of two that residuals are multiplied by in the matrix, as a product of two for weights and vectors: each keeps numbers
    /// around 1 in range.
    pub(crate) fn scales(&self) -> (f64, f64) {
        let half = self.exponent / 2;
        (f64::from(half).exp2(), f64::from(self.exponent - half).exp2())
    }
}

/// Σ w F and Σ w (s F)².
fn sums(row: &[f32], weights: Option<&[f64]>, scale: f64) -> (f64, f64) {
    // Strands that become vectors.
    const LANES: usize = 8;
    let (mut sum, mut energy) = ([0f64; LANES], [0f64; LANES]);
    for (i, values) in row.chunks(LANES).enumerate() {
        let weights = weights.map(|w| &w[i * LANES..]);
        for (lane, f) in values.iter().enumerate() {
            let (w, f) = (weights.map_or(1.0, |w| w[lane]), f64::from(*f));
            sum[lane] += w * f;
            energy[lane] += w * (f * scale).powi(2);
        }
    }
    (sum.iter().sum(), energy.iter().sum())
}

/// Weights of directions, of mean 1; none where all count the same.
pub(crate) fn weights(matrix: &TransferMatrix, norm: Norm) -> Option<Vec<f64>> {
    match norm {
        Norm::Coefficients => None,
        Norm::Radiance => matrix.responses().light_weights(matrix.basis()),
    }
}
