//! Biclustering of sparse transfer matrices.

mod growth;
mod params;

pub use params::{Levels, Objective, Seeds};
