//! What a path tracer can be told.

use crate::error::Result;
use crate::params::Params;

crate::params! {
    /// Paths of light from point to point, without bias unless clamped.
    pub struct PathParams: "path" {
        /// Most reflections of a path: 0 leaves only what shines, 1 direct light.
        bounces: usize = 32,
        /// Reflections after which paths that carry little end at random (Russian roulette).
        roulette: usize = 3,
        /// Largest luminance in W/m²/sr that one sample of reflected light may add, above 0; brighter ones are darkened, which is biased.
        clamp: Option<f64> = None,
        /// Another seed gives another picture of the same expectation.
        seed: u64 = 0,
    }
}

impl PathParams {
    pub(super) fn check(&self) -> Result<()> {
        match self.clamp {
            Some(clamp) if !(clamp > 0.0 && clamp.is_finite()) => {
                Err(PathParams::refuse("clamp", clamp, "above 0 and finite, or none"))
            }
            _ => Ok(()),
        }
    }
}
