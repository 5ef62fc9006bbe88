//! Light transforms: changes of the columns, T ≈ C·B, applied before a codec.

use crate::basis::LightBasis;
use crate::codec::Configure;
use crate::error::{Error, Result};
use crate::flops::Flops;
use crate::sections::{Sink, Source};
use ndarray::{ArrayView2, ArrayViewMut2};

/// A light transform's configuration; [`Transform::bind`] fixes it to the basis of a matrix.
pub trait Transform: Configure {
    /// The transform on one basis.
    type Bound: LightTransform + 'static;
    /// Refuses a basis that the transform is not defined on.
    fn bind(&self, basis: &LightBasis) -> Result<Self::Bound>;
    /// As [`Transform::bind`], from what [`LightTransform::write`] wrote.
    fn restore(&self, basis: &LightBasis, source: &mut Source) -> Result<Self::Bound> {
        let _ = source;
        self.bind(basis)
    }
}

/// T ≈ C·B on one basis: B maps light coefficients to those that C's columns multiply.
pub trait LightTransform: Send + Sync {
    /// What C's columns stand for.
    fn output(&self) -> LightBasis;
    /// A row of T becomes a row of C.
    fn row_into(&self, row: &[f32], out: &mut [f32]);
    /// Rows of T (one a row) become rows of C: as [`LightTransform::row_into`] for each, for transforms that do many at once faster.
    fn rows_into(&self, rows: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        for (row, mut out) in rows.outer_iter().zip(out.outer_iter_mut()) {
            self.row_into(row.as_slice().expect(CONTIGUOUS), out.as_slice_mut().expect(CONTIGUOUS));
        }
    }
    /// A row of C becomes a row of T̃ = C·B.
    fn restore_row_into(&self, coefficients: &[f32], out: &mut [f32]);
    /// Rows of C (one a row) become rows of T̃: as [`LightTransform::restore_row_into`] for each, for transforms that do many at once faster.
    fn restore_rows_into(&self, coefficients: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        for (row, mut out) in coefficients.outer_iter().zip(out.outer_iter_mut()) {
            self.restore_row_into(row.as_slice().expect(CONTIGUOUS), out.as_slice_mut().expect(CONTIGUOUS));
        }
    }
    /// `out` (C's columns x channels) = B · `lights` (T's columns x channels). Sizes have been checked.
    fn light_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>);
    /// Operations of [`LightTransform::light_into`] for one channel, counted as it runs.
    fn flops(&self, light: &[f32]) -> Flops;
    /// Bytes that relighting holds in memory besides the sections: what was derived from the label and the basis.
    fn derived_bytes(&self) -> usize {
        0
    }
    /// What was decided on this basis and is not in the label, in a sentence for the user; `None` where there is nothing to say.
    fn note(&self) -> Option<String> {
        None
    }
    /// Whether rows and lights pass unchanged, so that they need not be copied.
    fn is_identity(&self) -> bool {
        false
    }
    /// Sections that [`Transform::restore`] needs besides the label and the basis.
    fn write(&self, sink: &mut Sink) {
        let _ = sink;
    }
}

const CONTIGUOUS: &str = "rows that are transformed are contiguous";

crate::params! {
    /// Columns as they are.
    pub struct IdentityParams: "identity" {}
}

/// C = T.
pub struct Identity(IdentityParams);

impl Configure for Identity {
    type Params = IdentityParams;
    fn new(params: IdentityParams) -> Result<Identity> {
        Ok(Identity(params))
    }
    fn params(&self) -> &IdentityParams {
        &self.0
    }
}

impl Transform for Identity {
    type Bound = BoundIdentity;
    fn bind(&self, basis: &LightBasis) -> Result<BoundIdentity> {
        Ok(BoundIdentity(basis.clone()))
    }
}

/// [`Identity`] on one basis.
pub struct BoundIdentity(LightBasis);

impl LightTransform for BoundIdentity {
    fn output(&self) -> LightBasis {
        self.0.clone()
    }
    fn row_into(&self, row: &[f32], out: &mut [f32]) {
        out.copy_from_slice(row);
    }
    fn restore_row_into(&self, coefficients: &[f32], out: &mut [f32]) {
        out.copy_from_slice(coefficients);
    }
    fn light_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        out.assign(&lights);
    }
    fn flops(&self, _: &[f32]) -> Flops {
        Flops::default()
    }
    fn is_identity(&self) -> bool {
        true
    }
}

/// [`Error::Unsupported`] for a transform on a basis that it is not defined on.
pub fn wrong_basis(transform: &str, expected: &str, basis: &LightBasis) -> Error {
    Error::Unsupported {
        what: format!("light basis for {transform}"),
        expected: expected.into(),
        found: basis.to_string(),
    }
}
