//! Clustered principal components of radiance transfer.

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
mod groups;
mod head;
mod ids;
mod kernel;
mod layout;
pub mod model;
mod numbers;
mod params;
mod random;
mod refit;
mod residual;
mod samples;
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
pub use model::{Cluster, Model};
pub use params::{Allocation, Clusters, CpcaParams, Mode, Norm, PcaParams, Solver, Start, VqParams, Width};
