//! The ideally diffuse surface (Lambert, Photometria, 1760): radiance is the same in every direction.

use super::check;
use crate::codec::Configure;
use crate::error::Result;
use std::f64::consts::FRAC_1_PI;

crate::params! {
    /// Ideally diffuse, the same radiance in every direction (Lambert 1760).
    pub struct LambertParams: "lambert" {
        /// Part of the light that is reflected, from 0 to 1.
        albedo: f64 = 1.0,
    }
}

/// ρ = albedo / π.
#[derive(Clone, Debug, PartialEq)]
pub struct Lambert(LambertParams);

impl Configure for Lambert {
    type Params = LambertParams;
    fn new(params: LambertParams) -> Result<Lambert> {
        check::<LambertParams>("albedo", params.albedo, 0.0, 1.0)?;
        Ok(Lambert(params))
    }
    fn params(&self) -> &LambertParams {
        &self.0
    }
}

impl Lambert {
    pub(super) fn evaluate(&self) -> f64 {
        self.0.albedo * FRAC_1_PI
    }
}
