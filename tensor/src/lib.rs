//! Tensor approximation of radiance transfer.
//!
//! Transfer of a glossy scene is a tensor: samples x responses x lights (vertices x views x lights). [`tucker`] decomposes such arrays, of any
//! number of modes, into a small core and a factor for each mode. *All-Frequency Precomputed Radiance Transfer using Spherical Radial Basis
//! Functions and Clustered Tensor Approximation* (Tsai and Shih 2006) groups samples into clusters with bases of their own, so that relighting
//! needs few operations for each sample: `T_x ≈ U_view uf⁻¹(Vᵀ W_x) U_lightᵀ`.
//!
//! | codec | |
//! | --- | --- |
//! | [`Cta`] | clusters with a light basis and a dual sample basis each, one view basis (§5.2); samples in one cluster or in several |
//! | [`TuckerCodec`] | `tucker`: one decomposition of all samples, by ranks or within an error bound |
//!
//! Both give an [`EncodedCta`]. Squared error counts in the coordinates that they are given: behind `srbf` or `haar:scale=sphere` it is error over the
//! sphere.
//!
//! # The search of `cta`
//!
//! 1. The view basis from mode 1 of the tensor (Eq. 14), and light coordinates of all samples that leave out 0.2 % of the energy: clusters are
//!    looked for in these, bases fitted in whole.
//! 2. Clusters around lines through the origin, then around subspaces of 2, 4, 8 … dimensions (or the paper's ELBG). A sweep fits the bases of each
//!    cluster (the alternation of De Lathauwer et al. 2000b) and moves samples to the cluster that keeps most of them (Eq. 16 to 18); between sweeps over all
//!    clusters only the eight best of each sample are tried. It ends where a sweep over all lowers the error by less than 0.02 %.
//! 3. All bases are fitted anew with the view basis (Eq. 19), the dual ones last: their rows are the leading right singular vectors of the
//!    members in the other bases, the polar factor that Eq. 16 asks for. With members fewer than the rank, or alike, there are fewer rows.
//! 4. With `members=K` samples move into K clusters each.
//!
//! Same matrix, parameters and seed give the same bytes on any number of threads; what is drawn depends on samples and not on their order.
//!
//! ```
//! use ndarray::Array2;
//! use prt_tensor::{Cta, CtaParams};
//! use prt_transfer::{Codec, Configure, Encoded, LightBasis, Quiet, TransferMatrix};
//!
//! // 200 samples of 4 responses on two sheets, 25 light coefficients.
//! let element = |x: usize, k: usize, l: usize| (0.02 * (x + 9 * k) as f32 + (1 + x % 2) as f32 * 0.3 * l as f32).sin();
//! let values = (0..200 * 100).map(|i| element(i / 100, i / 25 % 4, i % 25)).collect::<Vec<f32>>();
//! let matrix = TransferMatrix::from_dense(values, 800, 4, LightBasis::SphericalHarmonics { order: 5 })?;
//!
//! let params = CtaParams { clusters: 2, view: 2, light: 2, sample: 2, ..Default::default() };
//! let encoded = Cta::new(params)?.encode(&matrix, &Quiet)?;
//! let (light, mut relit, mut exact) = (Array2::ones((25, 3)), Array2::zeros((800, 3)), Array2::zeros((800, 3)));
//! encoded.apply_into(light.view(), relit.view_mut())?;
//! matrix.apply_into(light.view(), exact.view_mut())?;
//! assert!(relit.iter().zip(&exact).all(|(a, b): (&f32, &f32)| (a - b).abs() < 1e-2));
//! assert!(encoded.flops(&[1.0; 25]).total() < 8_000); // the plain product takes 40,000
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod apply;
mod codec;
mod encoded;
mod footprint;
mod global;
mod kernel;
mod layout;
mod model;
mod params;
mod reconstruct;
mod search;
mod steps;
pub mod tucker;
mod wire;

pub use codec::{Approximation, Cta};
pub use encoded::EncodedCta;
pub use global::TuckerCodec;
pub use model::{Cluster, Model};
pub use params::{CtaParams, Start, Storage, TuckerCodecParams};
pub use search::{Phase, Sweep};
