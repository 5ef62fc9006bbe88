//! Tensor approximation of radiance transfer.

mod apply;
mod assign;
mod basis;
mod codec;
mod elbg;
mod encoded;
mod global;
mod kernel;
mod layout;
mod model;
mod params;
mod products;
mod search;
mod slabs;
mod soft;
mod start;
mod steps;
pub mod tucker;
mod wire;

pub use codec::{Approximation, Cta};
pub use encoded::EncodedCta;
pub use global::TuckerCodec;
pub use model::{Cluster, Model};
pub use params::{CtaParams, Start, Storage, TuckerCodecParams};
pub use search::{Phase, Sweep};
