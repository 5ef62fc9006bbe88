//! Biclustering of sparse transfer matrices.

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
