//! The vocabulary of precomputed radiance transfer (PRT) compression.
//!
//! A scene turns incoming light into outgoing light by one linear operator **T**. Here it is a [`TransferMatrix`]: one
//! row per response of a sample, one column per light coefficient of a [`LightBasis`]. A [`Codec`] compresses the
//! matrix; what it returns is [`Encoded`]: it relights without being decompressed, reconstructs any row, counts its own
//! floating-point operations and writes itself section by section, which is the only source of sizes. A
//! [`LightTransform`] changes the columns first. A [`Method`] is one of each, named by a [`Label`] such as
//! `haar+truncate:terms=64`.
//!
//! | feature | adds |
//! | --- | --- |
//! | (none) | the vocabulary, and the exact codecs [`dense`], [`csr`], [`compact`], [`runs`], [`visibility`] and half precision [`f16`](mod@f16) |
//! | `io` | files: `.prt`, `.npz`, `.npy`, `.mtx`, `.ply`, `.obj`, `.exr`, `.hdr`, `.png` |
//! | `linalg` | large dense products and decompositions, by faer |
//! | `scene` | meshes, built-in scenes and lights, visibility, BRDFs, the signals `biscale`, `diffuse`, `glossy` and `terms`, pictures of them |

pub mod basis;
#[cfg(any(feature = "io", feature = "scene"))]
pub mod chart;
pub mod codec;
pub mod compact;
pub mod csr;
pub mod dense;
pub mod error;
pub mod f16;
pub mod flops;
pub mod footprint;
pub mod groups;
pub mod hemisphere;
pub mod ids;
#[cfg(any(feature = "io", feature = "scene"))]
pub mod image;
#[cfg(feature = "io")]
pub mod io;
pub mod kernel;
pub mod label;
#[cfg(feature = "linalg")]
pub mod linalg;
pub mod matrix;
#[cfg(any(feature = "io", feature = "scene"))]
pub mod mesh;
pub mod method;
pub mod metric;
mod narrow;
pub mod numbers;
pub mod params;
pub mod progress;
pub mod quadrature;
pub mod random;
pub mod responses;
pub mod runs;
pub mod samples;
#[cfg(feature = "scene")]
pub mod scene;
pub mod sections;
pub mod sh;
pub mod texels;
pub mod transform;
pub mod visibility;

pub use basis::LightBasis;
pub use codec::{Codec, Configure, Encoded, Restore};
pub use error::{Error, Result};
pub use flops::{Count, Flops, NoCount, Tally};
pub use footprint::{Extent, Footprint};
pub use label::{Label, Stage};
pub use matrix::{Row, Shape, TransferMatrix};
pub use method::{Compressed, Method, Registry};
pub use metric::Metric;
pub use params::{Field, Params};
pub use progress::{Progress, Quiet};
pub use responses::ResponseBasis;
pub use sections::{Section, Sink, Source};
pub use transform::{LightTransform, Transform};
