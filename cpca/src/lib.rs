//! Clustered principal components of radiance transfer.

pub mod coherence;
pub mod model;
mod params;

pub use model::{Cluster, Model};
pub use params::{Allocation, Clusters, CpcaParams, Mode, Norm, PcaParams, Solver, Start, VqParams, Width};
