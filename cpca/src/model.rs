//! Clusters and subspaces before they are stored.

use prt_transfer::Shape;

/// An affine subspace: samples near it are `mean + Σ w_j components_j`.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// n = responses x lights numbers.
    pub mean: Vec<f32>,
    /// Components one after the other, n numbers each.
    pub components: Vec<f32>,
}

/// A clustered approximation of a matrix whose samples are vectors of n = responses x lights numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Of the matrix.
    pub shape: Shape,
    /// At least one where there are samples.
    pub clusters: Vec<Cluster>,
    /// The cluster of each sample.
    pub members: Vec<u32>,
    /// The weights of each sample, one for each component of its cluster, sample after sample.
    pub weights: Vec<f32>,
}

impl Model {
    /// Numbers of a sample.
    pub fn dimension(&self) -> usize {
        self.shape.responses * self.shape.lights
    }

    /// Components of a cluster.
    pub fn components(&self, cluster: usize) -> usize {
        self.clusters[cluster].components.len() / self.dimension().max(1)
    }
}
