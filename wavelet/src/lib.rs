//! Wavelets for precomputed radiance transfer: the `haar` light transform and the `truncate` codec.
//!
//! In an orthonormal basis that suits the signal few coefficients carry nearly all of it, and keeping the largest is the best
//! approximation of so many terms. [`Haar`] is such a basis on the six faces of a cubemap; [`Truncate`] keeps the largest
//! coefficients of each row, or of the whole matrix within an error bound. Together they are the non-linear wavelet approximation
//! of Ng, Ramamoorthi and Hanrahan, *All-Frequency Shadows Using Non-linear Wavelet Lighting Approximation* (2003); either works
//! with other codecs and transforms.
//!
//! ```
//! use ndarray::Array2;
//! use prt_transfer::{Configure, LightBasis, Method, Quiet, TransferMatrix};
//! use prt_wavelet::{Haar, HaarParams, Truncate, TruncateParams};
//!
//! // Two responses to a cubemap of 6 x 4 x 4 texels: its upper half, and all of it.
//! let row = |r: usize| (0..96).map(move |k| if r == 1 || k % 16 < 8 { 0.1 } else { 0.0 });
//! let values = (0..2).flat_map(row).collect();
//! let matrix = TransferMatrix::from_dense(values, 2, 1, LightBasis::Cubemap { resolution: 4 })?;
//!
//! let truncate = Truncate::new(TruncateParams { terms: Some(12), ..Default::default() })?;
//! let method = Method::new(Haar::new(HaarParams::default())?, truncate);
//! let compressed = method.encode(&matrix, &Quiet)?;
//!
//! let (light, mut responses) = (Array2::ones((96, 1)), Array2::zeros((2, 1)));
//! compressed.apply_into(light.view(), responses.view_mut())?;
//! assert!((responses[[0, 0]] - 4.8f32).abs() < 1e-5 && (responses[[1, 0]] - 9.6f32).abs() < 1e-5);
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod columns;
mod encoded;
mod haar;
mod keep;
mod largest;
mod pyramid;
mod rows;
mod select;
mod stored;
mod threshold;
mod truncate;
mod wire;

pub use encoded::EncodedTruncate;
pub use haar::{BoundHaar, Haar, HaarParams, Scale};
pub use select::LightSelect;
pub use truncate::{Order, Truncate, TruncateParams};
