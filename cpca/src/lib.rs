//! Clustered principal components of radiance transfer.

pub mod model;
mod params;
mod random;
pub mod solver;

pub use model::{Cluster, Model};
pub use params::{Allocation, Clusters, CpcaParams, Mode, Norm, PcaParams, Solver, Start, VqParams, Width};
