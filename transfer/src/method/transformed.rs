//! What a light transform makes of a matrix, shared by all methods that begin with it.

use super::{Compressed, Method, transform_rows};
use crate::error::{Error, Result};
use crate::label::Stage;
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::transform::LightTransform;
use std::sync::Arc;

/// C of T ≈ C·B and B: made once, it is compressed by any codec.
pub struct Transformed {
    stage: Stage,
    transform: Arc<dyn LightTransform>,
    /// None where C = T, which need not be copied.
    coefficients: Option<TransferMatrix>,
}

impl Transformed {
    /// The light transform.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }
    /// B.
    pub fn transform(&self) -> &dyn LightTransform {
        &*self.transform
    }
    /// C, where it is not T.
    pub fn coefficients(&self) -> Option<&TransferMatrix> {
        self.coefficients.as_ref()
    }
}

impl Method {
    /// What the method's light transform makes of `matrix`.
    pub fn transformed(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Transformed> {
        let transform: Arc<dyn LightTransform> = self.bind(matrix.basis())?.into();
        let coefficients = match transform.is_identity() {
            true => None,
            false => Some(transform_rows(matrix, &*transform, progress)?),
        };
        Ok(Transformed { stage: self.label.transform.clone(), transform, coefficients })
    }

    /// As [`Method::encode`] of `matrix`, given what the light transform made of it.
    ///
    /// # Errors
    /// What another transform made.
    pub fn encode_transformed(
        &self,
        matrix: &TransferMatrix,
        transformed: &Transformed,
        progress: &dyn Progress,
    ) -> Result<Compressed> {
        if transformed.stage != self.label.transform {
            return Err(Error::Unsupported {
                what: format!("transformed matrix for {}", self.label),
                expected: self.label.transform.to_string(),
                found: transformed.stage.to_string(),
            });
        }
        let encoded = self.codec.encode(transformed.coefficients().unwrap_or(matrix), progress)?;
        Ok(self.compressed(matrix, matrix.basis(), transformed.transform.clone(), encoded))
    }
}
