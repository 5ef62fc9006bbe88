//! Radiance on texels and directions.

use prt_transfer::{Encoded, Error, Result, Shape, TransferMatrix};
use rayon::prelude::*;

/// Anything that gives the radiance of texels in directions: an [`crate::EncodedSlf`], or the [`Rows`] themselves.
pub trait RadianceField: Sync {
    /// m.
    fn texels(&self) -> usize;
    /// n.
    fn directions(&self) -> usize;
    /// `Σ_t w_t Σ_d w_d F[t, d]` for red, green and blue; a field of one channel is grey, one of two has its second twice.
    ///
    /// # Panics
    /// A texel or direction that does not exist.
    fn blend(&self, texels: &[(u32, f32)], directions: &[(u32, f32)]) -> [f32; 3];
}

impl<F: RadianceField + ?Sized> RadianceField for &F {
    fn texels(&self) -> usize {
        (**self).texels()
    }
    fn directions(&self) -> usize {
        (**self).directions()
    }
    fn blend(&self, texels: &[(u32, f32)], directions: &[(u32, f32)]) -> [f32; 3] {
        (**self).blend(texels, directions)
    }
}

/// Every element in single precision, texels x channels x directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    shape: Shape,
    values: Vec<f32>,
}

impl Rows {
    /// Row-major values, texels x channels x directions.
    ///
    /// # Errors
    /// Another number of values.
    pub fn new(values: Vec<f32>, shape: Shape) -> Result<Rows> {
        Error::expect_size("values of a light field", shape.rows() * shape.lights, values.len())?;
        Ok(Rows { shape, values })
    }

    /// The elements of a matrix.
    pub fn of(matrix: &TransferMatrix) -> Rows {
        Rows::gathered(matrix.shape(), |row, out| matrix.gather(row, out))
    }

    /// What a codec decodes to.
    pub fn decoded(encoded: &dyn Encoded) -> Rows {
        Rows::gathered(encoded.shape(), |row, out| encoded.row_into(row, out))
    }

    fn gathered(shape: Shape, row: impl Fn(usize, &mut [f32]) + Sync) -> Rows {
        let mut values = vec![0f32; shape.rows() * shape.lights];
        values.par_chunks_mut(shape.lights.max(1)).enumerate().for_each(|(at, out)| row(at, out));
        Rows { shape, values }
    }
}

impl RadianceField for Rows {
    fn texels(&self) -> usize {
        self.shape.samples
    }
    fn directions(&self) -> usize {
        self.shape.lights
    }
    fn blend(&self, texels: &[(u32, f32)], directions: &[(u32, f32)]) -> [f32; 3] {
        std::array::from_fn(|channel| {
            let row = |texel: u32| texel as usize * self.shape.responses + channel.min(self.shape.responses - 1);
            let of_texel = |&(texel, weight): &(u32, f32)| {
                let values = &self.values[row(texel) * self.shape.lights..][..self.shape.lights];
                weight * directions.iter().map(|&(direction, weight)| weight * values[direction as usize]).sum::<f32>()
            };
            texels.iter().map(of_texel).sum()
        })
    }
}
