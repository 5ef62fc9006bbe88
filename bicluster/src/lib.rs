//! Biclustering of sparse transfer matrices: rows that have light coefficients in common share their sum.
//!
//! Sun, Hou, Zhou, Ren, Zhou and Shi, *All-Frequency Bi-Scale Radiance Transfer*, cover a matrix with biclusters: columns K with
//! a value t_k each, and rows that contain them. A bicluster's sum Σ t_k x_k is computed once and added to all of its rows, so that l columns and r rows cost r + 2l - 1
//! operations in place of 2rl; what does not fit is a residual, and the next bicluster is looked for in that (their §IV and
//! Algorithm 1, `levels=1`). Sums can be shared in turn: `levels=2` biclusters the memberships of rows in biclusters, and
//! `levels=all`, the default, merges pairs of symbols until no two are shared by enough rows. All are exact for any finite
//! `f32`; a bound on the error, `max_error`, buys fewer sums.
//!
//! Rows that are equal are stored once, rows that lie in one region of the lights make a block and blocks are compressed on
//! their own, on all cores, with the same bytes on any number of threads. The result never takes more memory or operations than
//! the sparse matrix in narrow widths ([`prt_transfer::compact`]).
//!
//! ```
//! use ndarray::Array2;
//! use prt_bicluster::{Bicluster, BiclusterParams};
//! use prt_transfer::{Codec, Configure, Encoded, LightBasis, Quiet, TransferMatrix};
//!
//! // 400 windows of 32 lights each, on 256 lights.
//! let rows = 0..400usize;
//! let columns = rows.clone().flat_map(|r| { let start = r * 7 % 225; start as u32..start as u32 + 32 }).collect();
//! let offsets = (0..=400).map(|r| 32 * r).collect();
//! let matrix = TransferMatrix::from_csr(offsets, columns, vec![1.0; 12_800], 1, LightBasis::Plain { lights: 256 })?;
//!
//! let encoded = Bicluster::new(BiclusterParams::default())?.encode(&matrix, &Quiet)?;
//! let (light, mut responses) = (Array2::ones((256, 1)), Array2::zeros((400, 1)));
//! encoded.apply_into(light.view(), responses.view_mut())?;
//! assert!(responses.iter().all(|&y| y == 32.0));
//! assert!(encoded.flops(&[1.0; 256]).total() < 2_560); // a tenth of the plain product's 25,600
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod approximate;
mod archive;
mod block;
mod codec;
mod distinct;
mod encoded;
mod growth;
mod kernel;
mod lay_out;
mod listing;
mod nested;
mod pairs;
mod params;
mod places;
mod planes;
mod regions;
mod sums;
mod symbols;
mod wire;

pub use codec::Bicluster;
pub use encoded::EncodedBicluster;
pub use params::{BiclusterParams, Levels, Objective, Seeds};
