//! Radiance between texels and between directions (paper §3.3): from any field of radiance, compressed or not.

mod blend;
mod field;
mod light_field;
mod sphere;

pub use field::{RadianceField, Rows};
pub use light_field::{Interpolation, SurfaceLightField};
pub use sphere::{Sphere, Taps};
