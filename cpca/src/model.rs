//! Clusters and subspaces before they are stored.

use prt_transfer::{Error, Result, Shape};

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
    /// Of a matrix without elements.
    pub(crate) fn empty(shape: Shape) -> Model {
        let nothing = Cluster { mean: vec![0.0; shape.responses * shape.lights], components: Vec::new() };
        let clusters = if shape.samples == 0 { Vec::new() } else { vec![nothing] };
        Model { shape, clusters, members: vec![0; shape.samples], weights: Vec::new() }
    }

    /// Numbers of a sample.
    pub fn dimension(&self) -> usize {
        self.shape.responses * self.shape.lights
    }

    /// Components of a cluster.
    pub fn components(&self, cluster: usize) -> usize {
        self.clusters[cluster].components.len() / self.dimension().max(1)
    }

    /// Refuses a model whose parts do not fit each other or hold a number that is not finite, or one with more
    /// clusters than samples or components than numbers of a sample.
    ///
    /// # Errors
    /// The part and what would fit.
    pub fn check(&self) -> Result<()> {
        let (n, samples) = (self.dimension(), self.shape.samples);
        let clusters = self.clusters.len();
        if clusters < samples.min(1) || clusters > samples.max(1) {
            return Err(unfit("clusters of the model", format!("1 to {samples}, the samples"), clusters));
        }
        for (k, cluster) in self.clusters.iter().enumerate() {
            Error::expect_size(format!("mean of cluster {k}"), n, cluster.mean.len())?;
            let (count, whole) = (cluster.components.len(), self.components(k) * n);
            Error::expect_size(format!("components of cluster {k}, whole multiples of {n} numbers"), whole, count)?;
            if self.components(k) > n {
                return Err(unfit(format!("components of cluster {k}"), format!("at most {n}"), self.components(k)));
            }
        }
        Error::expect_size("clusters of samples", samples, self.members.len())?;
        if let Some(sample) = self.members.iter().position(|&k| k as usize >= clusters) {
            return Err(unfit(
                format!("cluster of sample {sample}"),
                format!("below {clusters}"),
                self.members[sample],
            ));
        }
        let weights: usize = self.members.iter().map(|&k| self.components(k as usize)).sum();
        Error::expect_size("weights", weights, self.weights.len())?;
        let numbers = self.clusters.iter().flat_map(|c| c.mean.iter().chain(&c.components)).chain(&self.weights);
        match numbers.copied().find(|v| !v.is_finite()) {
            Some(value) => Err(unfit("means, components and weights", "finite numbers", value)),
            None => Ok(()),
        }
    }
}

fn unfit(what: impl Into<String>, expected: impl Into<String>, found: impl ToString) -> Error {
    Error::Unsupported { what: what.into(), expected: expected.into(), found: found.to_string() }
}
