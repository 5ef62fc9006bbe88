//! Clusters and their bases before they are stored.

use ndarray::Array2;
use prt_transfer::{Error, Result, Shape};

/// Bases of a cluster (Tsai and Shih 2006, §5.2.1).
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// U_lightᵀ: R_light x lights.
    pub light: Array2<f32>,
    /// V: R_vert x (R_view · R_light), each row uf⁻¹ of a matrix of R_view x R_light.
    pub dual: Array2<f32>,
}

/// A clustered tensor approximation: `T_x ≈ U_view uf⁻¹(Vᵀ W_x) U_lightᵀ` with the bases of the cluster of sample x (Eq. 18), or the sum
/// of several of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Of the matrix.
    pub shape: Shape,
    /// U_view: responses x R_view; `None` where it is the identity.
    pub view: Option<Array2<f32>>,
    /// At least one where there are samples.
    pub clusters: Vec<Cluster>,
    /// Clusters of each sample.
    pub memberships: usize,
    /// The clusters of each sample, sample after sample.
    pub members: Vec<u32>,
    /// The weights W_x of each sample, R_vert for each of its clusters, sample after sample.
    pub weights: Vec<f32>,
}

impl Model {
    /// Of a matrix without elements.
    pub(crate) fn empty(shape: Shape) -> Model {
        let nothing = Cluster { light: Array2::zeros((0, shape.lights)), dual: Array2::zeros((0, 0)) };
        let clusters = if shape.samples == 0 { Vec::new() } else { vec![nothing] };
        let members = vec![0; shape.samples];
        Model { shape, view: None, clusters, memberships: 1, members, weights: Vec::new() }
    }

    /// R_view.
    pub fn views(&self) -> usize {
        self.view.as_ref().map_or(self.shape.responses, Array2::ncols)
    }

    /// Refuses a model whose parts do not fit each other or hold a number that is not finite.
    ///
    /// # Errors
    /// The part and what would fit.
    pub fn check(&self) -> Result<()> {
        let (samples, clusters) = (self.shape.samples, self.clusters.len());
        if clusters < samples.min(1) || clusters > samples.max(1) {
            return Err(unfit("clusters of the model", format!("1 to {samples}, the samples"), clusters));
        }
        if self.views() < self.shape.responses.min(1) {
            return Err(unfit("views", format!("1 to {}", self.shape.responses), self.views()));
        }
        if let Some(view) = &self.view {
            Error::expect_size("rows of the view basis", self.shape.responses, view.nrows())?;
        }
        for (k, cluster) in self.clusters.iter().enumerate() {
            Error::expect_size(format!("lights of cluster {k}"), self.shape.lights, cluster.light.ncols())?;
            if cluster.dual.nrows() > 0 {
                let columns = self.views() * cluster.light.nrows();
                Error::expect_size(format!("columns of the dual basis of cluster {k}"), columns, cluster.dual.ncols())?;
            }
        }
        if self.memberships == 0 || self.memberships > clusters.max(1) {
            return Err(unfit("clusters of a sample", format!("1 to {clusters}"), self.memberships));
        }
        Error::expect_size("clusters of samples", samples * self.memberships, self.members.len())?;
        if let Some(at) = self.members.iter().position(|&k| k as usize >= clusters) {
            return Err(unfit("cluster of a sample", format!("below {clusters}"), self.members[at]));
        }
        let weights: usize = self.members.iter().map(|&k| self.clusters[k as usize].dual.nrows()).sum();
        Error::expect_size("weights", weights, self.weights.len())?;
        let bases = self.clusters.iter().flat_map(|c| c.light.iter().chain(&c.dual));
        match bases.chain(self.view.iter().flatten()).chain(&self.weights).find(|v| !v.is_finite()) {
            Some(value) => Err(unfit("bases and weights", "finite numbers", value)),
            None => Ok(()),
        }
    }
}

fn unfit(what: impl Into<String>, expected: impl Into<String>, found: impl ToString) -> Error {
    Error::Unsupported { what: what.into(), expected: expected.into(), found: found.to_string() }
}
