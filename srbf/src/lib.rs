//! Spherical radial basis functions (Tsai and Shih 2006, sections 4 and 5).
#![forbid(unsafe_code)]

mod exponential;
#[cfg(feature = "fit")]
pub mod fit;
#[cfg(feature = "fit")]
mod icosphere;
pub mod kernel;
mod legendre;
pub mod light;
pub mod lobe;
pub mod sampler;

pub use kernel::Kernel;
pub use light::ScatteredLight;
pub use lobe::Lobe;
pub use sampler::Sampler;
