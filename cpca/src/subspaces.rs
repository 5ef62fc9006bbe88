//! The clusters while they are being looked for: affine subspaces.

/// A mean and components for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct Subspaces {
    dimension: usize,
    subspaces: Vec<Subspace>,
}

/// `mean + span(components)`
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Subspace {
    pub(crate) mean: Vec<f32>,
    /// Orthonormal, one after the other.
    pub(crate) components: Vec<f32>,
}

impl Subspaces {
    pub(crate) fn new(dimension: usize, subspaces: Vec<Subspace>) -> Subspaces {
        Subspaces { dimension, subspaces }
    }

    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    pub(crate) fn len(&self) -> usize {
        self.subspaces.len()
    }

    pub(crate) fn of(&self, cluster: usize) -> &Subspace {
        &self.subspaces[cluster]
    }

    pub(crate) fn set(&mut self, cluster: usize, subspace: Subspace) {
        self.subspaces[cluster] = subspace;
    }

    pub(crate) fn push(&mut self, subspace: Subspace) {
        self.subspaces.push(subspace);
    }

    pub(crate) fn all(&self) -> &[Subspace] {
        &self.subspaces
    }

    /// Components of a cluster.
    pub(crate) fn components(&self, cluster: usize) -> usize {
        self.subspaces[cluster].components.len() / self.dimension.max(1)
    }
}
