//! Spherical radial basis functions (Tsai and Shih 2006, sections 4 and 5).
//!
//! A lobe is a [`Kernel`] of the angle to its centre. Rotating a sum of lobes is rotating their centres.
#![forbid(unsafe_code)]

pub mod icosphere;
pub mod kernel;
mod legendre;
mod transform;

pub use kernel::Kernel;
pub use transform::{BoundSrbf, Centers, Coordinates, Ridge, Srbf, SrbfParams};
