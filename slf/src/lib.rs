//! Surface light fields: the radiance that leaves each point of a surface in each direction, compressed, and read anywhere between.
//!
//! Miandji, Kronander and Unger, *Geometry Independent Surface Light Fields for Real Time Rendering of Precomputed Global Illumination*
//! (2011), write down radiance on the texels of a surface in the directions of a sphere. The codec [`Slf`] keeps the mean μ of each row of
//! that matrix (a texel in one colour channel), puts texels into clusters by what is left, and each cluster's residuals into its leading
//! singular vectors: an element is `F[p, d] ≈ μ[p] + Σ_j U[p, j] V_c(p)[d, j]` (Eq. 7), which [`EncodedSlf::element`] computes alone.
//! [`SurfaceLightField`] interpolates between texels and directions without seams (§3.3).
//!
//! | | |
//! | --- | --- |
//! | `colour` | channels share clusters (what the paper's size counts), have their own (its text), or share clusters and weights |
//! | `norm=radiance` | directions count as their solid angles: a latitude-longitude grid has too many at the poles |
//! | `max_error` | the least k, and with `clusters=auto` η, in bytes (Eq. 5) whose decoded error is within a bound; a matte wall has its means alone |
//! | `maps=haar` | a file has maps as rounded Haar images (the paper's future work), memory single precision |
//!
//! Clusters are those of [`prt_cpca`]; singular vectors are of residuals as they are, not around a cluster's mean, by the solver that suits
//! their shape or by the paper's power iteration, corrected. Memory beside the matrix: one copy of it, the residuals.
//!
//! ```
//! use prt_slf::{Clusters, Slf, SlfParams};
//! use prt_transfer::{Codec, Configure, LightBasis, Quiet, TransferMatrix};
//!
//! // 400 texels of 3 channels in 8 x 4 directions: a tinted gleam that moves over a grey surface.
//! let element = |t: usize, c: usize, d: usize| 0.5 + (1 + c) as f32 * (0.2 * d as f32 - 0.01 * t as f32).cos();
//! let values = (0..400 * 96).map(|i| element(i / 96, i / 32 % 3, i % 32)).collect::<Vec<f32>>();
//! let matrix = TransferMatrix::from_dense(values, 1200, 3, LightBasis::LatLong { width: 8, height: 4 })?;
//!
//! let params = SlfParams { clusters: Clusters::Number(4), components: 2, ..Default::default() };
//! let encoded = Slf::new(params)?.encode(&matrix, &Quiet)?;
//! assert!((encoded.element(17, 2, 9) - element(17, 2, 9)).abs() < 1e-4);
//! assert_eq!(encoded.counts().total(), 3 * 400 * 2 + 4 * 3 * 32 * 2 + 3 * 400 + 400); // Eq. 5
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod apply;
mod clusterer;
mod codec;
mod encoded;
mod fit;
mod gram;
mod grouped;
mod haar;
mod images;
mod kernel;
mod layout;
mod maps;
mod model;
mod params;
pub mod reconstruct;
mod residual;
mod search;
mod wire;

pub use codec::Slf;
pub use encoded::{Counts, EncodedSlf};
pub use params::{Colour, Maps, Mode, SlfParams};
pub use prt_cpca::{Clusters, Solver, Start};
pub use prt_transfer::numbers::Width;
pub use prt_transfer::samples::Norm;
pub use reconstruct::{Interpolation, RadianceField, Rows, Sphere, SurfaceLightField, Taps};
