//! Clustered principal components of radiance transfer.
//!
//! Sloan, Hall, Hart and Snyder, *Clustered Principal Components for Precomputed Radiance Transfer* (2003), take the transfer
//! matrix of each surface sample as a point, group the points into clusters and approximate each cluster by an affine subspace,
//! `x_p ≈ x_0 + Σ_j w_p^j x_j`. A light meets the few representatives x_j of a cluster; a sample only adds up n' results.
//!
//! | codec | |
//! | --- | --- |
//! | [`Vq`] | clusters with a mean each (LBG) |
//! | [`Pca`] | one cluster with components |
//! | [`Cpca`] | both: `mode=static` (§4.1), `iterative` (§4.2), `adaptive` (§4.3), or with `max_error` the smallest model within a bound |
//!
//! Every sample is with the nearest of all subspaces, exactly: what is nearest by the explicit residual in double precision. Bounds in
//! a few leading coordinates, and distances that cannot have changed since the last sweep, leave a small part of them to compute.
//! The same matrix and parameters give the same bytes on any number of threads. A matrix with fewer distinct samples than clusters, or
//! clusters of a rank below the number of components, has the exact smaller model.
//!
//! [`solver`] has the eigen-solvers, [`coherence`] rearranges clusters on a mesh (§5), [`d3dx`] reads and writes the compressed buffers
//! of Direct3D 9.
//!
//! ```
//! use ndarray::Array2;
//! use prt_cpca::{Clusters, Cpca, CpcaParams, Mode};
//! use prt_transfer::{Codec, Configure, Encoded, LightBasis, Quiet, TransferMatrix};
//!
//! // 300 samples on two curved sheets, 16 light coefficients.
//! let element = |p: usize, k: usize| ((0.02 * p as f32 + k as f32).sin() + (p % 2 * k) as f32).into();
//! let values = (0..300 * 16).map(|i| element(i / 16, i % 16)).collect::<Vec<f32>>();
//! let matrix = TransferMatrix::from_dense(values, 300, 1, LightBasis::SphericalHarmonics { order: 4 })?;
//!
//! let params = CpcaParams { clusters: Clusters::Number(4), components: 2, mode: Mode::Iterative, ..Default::default() };
//! let encoded = Cpca::new(params)?.encode(&matrix, &Quiet)?;
//! let (light, mut relit, mut exact) = (Array2::ones((16, 3)), Array2::zeros((300, 3)), Array2::zeros((300, 3)));
//! encoded.apply_into(light.view(), relit.view_mut())?;
//! matrix.apply_into(light.view(), exact.view_mut())?;
//! assert!(relit.iter().zip(&exact).all(|(a, b): (&f32, &f32)| (a - b).abs() < 1e-2));
//! assert!(encoded.flops(&[1.0; 16]).total() < 2_000); // the plain product takes 9,600
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod allocate;
mod apply;
mod assign;
mod bounded;
mod bounds;
mod codec;
pub mod coherence;
pub mod d3dx;
mod encoded;
mod engine;
mod finish;
mod footprint;
mod grouping;

mod head;

mod kernel;
mod layout;
pub mod model;

mod params;
mod refit;
mod residual;

mod shift;
pub mod solver;
mod spectra;
mod split;
mod start;
mod subspaces;
mod sweeps;
mod wire;

pub use codec::{Cpca, Pca, Vq};
pub use encoded::EncodedCpca;
pub use grouping::{Grouper, Grouping};
pub use model::{Cluster, Model};
pub use params::{Allocation, Clusters, CpcaParams, Mode, PcaParams, Solver, Start, VqParams};
pub use prt_transfer::numbers::Width;
pub use prt_transfer::samples::Norm;
