//! Spherical radial basis functions (Tsai and Shih 2006, sections 4 and 5).
//!
//! A lobe is a [`Kernel`] of the angle to its centre, and rotating a sum of lobes is rotating their centres. Transfer is projected onto
//! lobes on a subdivided icosahedron, the same for every row: the light transform [`Srbf`]. A light is a sum of scattered ones, a
//! [`ScatteredLight`], fitted by `fit` (with the feature of that name). Where both meet, inner products of lobes relight without texels:
//! [`BoundSrbf::interpolation`]. A [`Sampler`] draws directions from a scattered light.
//!
//! ```
//! use prt_srbf::{Centers, Kernel, Lobe, Sampler, ScatteredLight, Srbf, SrbfParams};
//! use prt_transfer::{Configure, LightBasis, Transform};
//!
//! let lobe = Lobe { centre: [0.0, 0.6, 0.8], bandwidth: 30.0 };
//! let light = ScatteredLight::new(Kernel::Gaussian, vec![lobe], ndarray::array![[2.0, 1.5, 1.0]])?;
//! assert!(light.radiance([0.0, 0.6, 0.8])[0] == 2.0);
//! assert!(Sampler::new(&light).density([0.0, 0.6, 0.8]) > 1.0);
//!
//! // Coefficients of the light for transfer in 42 lobes: A L (Eq. 12).
//! let transfer = Srbf::new(SrbfParams { centers: Centers::Count(42), ..SrbfParams::default() })?;
//! let transfer = transfer.bind(&LightBasis::Cubemap { resolution: 16 })?;
//! let lit = transfer.light_of(&light)?;
//! assert_eq!(lit.dim(), (42, 3));
//! # Ok::<(), prt_transfer::Error>(())
//! ```
#![forbid(unsafe_code)]

mod exponential;
#[cfg(feature = "fit")]
pub mod fit;
pub mod icosphere;
pub mod kernel;
mod legendre;
pub mod light;
pub mod lobe;
pub mod sampler;
mod transform;

pub use kernel::Kernel;
pub use light::ScatteredLight;
pub use lobe::Lobe;
pub use sampler::Sampler;
pub use transform::{BoundSrbf, Centers, Coordinates, Ridge, Srbf, SrbfParams};
