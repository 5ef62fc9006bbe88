//! Clustered principal components of radiance transfer.

mod apply;
pub mod d3dx;
mod encoded;
mod ids;
mod kernel;
mod layout;
pub mod model;
mod numbers;
mod params;
mod wire;

pub use encoded::EncodedCpca;
pub use model::{Cluster, Model};
pub use params::{Allocation, Clusters, CpcaParams, Mode, Norm, PcaParams, Solver, Start, VqParams, Width};
