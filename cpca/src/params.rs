//! What `vq`, `pca` and `cpca` can be asked for.

use prt_transfer::numbers::Width;
use prt_transfer::params::Value;
use prt_transfer::samples::Norm;

prt_transfer::choices! {
    /// How clusters and their subspaces are found.
    pub enum Mode {
        /// Clusters by distance to their mean, then components in each (paper §4.1).
        Static = "static",
        /// Clusters by distance to their subspace, components introduced one by one (paper §4.2).
        Iterative = "iterative",
        /// As iterative, then components move to the clusters where they save most (paper §4.3).
        Adaptive = "adaptive",
    }
}

prt_transfer::choices! {
    /// Where the search for clusters starts.
    pub enum Start {
        /// Samples drawn at random, as in the paper.
        Random = "random",
        /// Samples drawn with a probability that grows with their distance from those drawn before (k-means++).
        PlusPlus = "plusplus",
        /// One cluster, of which the one with the most error is split until there are enough.
        Splitting = "splitting",
    }
}

prt_transfer::choices! {
    /// How the leading components of a cluster are computed.
    pub enum Solver {
        /// By size and conditioning.
        Auto = "auto",
        /// Deflated power iteration in single precision (Miandji et al. 2011, Algorithm 1, corrected).
        Power = "power",
        /// Block Krylov iteration with Rayleigh-Ritz, until the residual is small.
        Krylov = "krylov",
        /// All eigenpairs of the smaller Gram matrix.
        Gram = "gram",
        /// Thin singular value decomposition.
        Svd = "svd",
    }
}

prt_transfer::choices! {
    /// What adaptive allocation divides a component's gain by.
    pub enum Allocation {
        /// The weights that it takes, one for each member of the cluster (paper §4.3).
        Paper = "paper",
        /// The bytes that it takes, weights and representative.
        Bytes = "bytes",
    }
}

/// How many clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clusters {
    /// So many, or as many as there are distinct samples.
    Number(usize),
    /// As many as make the smallest file that keeps the error bound.
    Auto,
}

impl Value for Clusters {
    fn parse(text: &str) -> Option<Self> {
        if text == "auto" { Some(Clusters::Auto) } else { text.parse().ok().map(Clusters::Number) }
    }
    fn show(&self) -> String {
        match self {
            Clusters::Number(number) => number.to_string(),
            Clusters::Auto => "auto".into(),
        }
    }
    fn expected() -> String {
        "auto or a whole number".into()
    }
}

prt_transfer::params! {
    /// Vector quantisation (LBG): one representative for all samples of a cluster.
    pub struct VqParams: "vq" {
        /// Clusters, 1 to 65536; no more than there are distinct samples.
        clusters: usize = 256,
        /// Sweeps of the LBG algorithm at most, 1 to 1000.
        sweeps: usize = 20,
        /// Where clusters start: random, plusplus or splitting.
        start: Start = Start::PlusPlus,
        /// Of what is drawn.
        seed: u64 = 0,
        /// Error that is minimised: coefficients (of the matrix) or radiance (orthonormal coordinates).
        norm: Norm = Norm::Coefficients,
        /// Representatives are stored as f32, f16 or i16.
        representatives: Width = Width::F32,
    }
}

prt_transfer::params! {
    /// Principal components of all samples at once: mean and components, and a weight for each component and sample.
    pub struct PcaParams: "pca" {
        /// Components beside the mean, 0 to 4096; no more than the rank.
        components: usize = 8,
        /// Eigen-solver: auto, power, krylov, gram or svd.
        solver: Solver = Solver::Auto,
        /// Error that is minimised: coefficients (of the matrix) or radiance (orthonormal coordinates).
        norm: Norm = Norm::Coefficients,
        /// Weights are stored as f32, f16 or i16.
        weights: Width = Width::F32,
        /// Mean and components are stored as f32, f16 or i16.
        representatives: Width = Width::F32,
        /// Bound on Σ(T-T̃)²/ΣT² of what is decoded, in the norm, above 0 to 1: the fewest components that keep it, in place of `components`.
        max_error: Option<f64> = None,
    }
}

prt_transfer::params! {
    /// Clustered principal components: samples in clusters, each with its mean and components.
    pub struct CpcaParams: "cpca" {
        /// Clusters, 1 to 65536, no more than there are distinct samples; auto with max_error.
        clusters: Clusters = Clusters::Number(256),
        /// Components of each cluster beside its mean, 0 to 4096, no more than its rank; their mean number where they are adaptive.
        components: usize = 8,
        /// static, iterative or adaptive.
        mode: Mode = Mode::Static,
        /// Sweeps at most, 1 to 1000: in all (static), for each number of components (iterative), of reallocation too (adaptive); none = 20 (static) or 10.
        sweeps: Option<usize> = None,
        /// Where clusters start: random, plusplus or splitting.
        start: Start = Start::PlusPlus,
        /// Of what is drawn.
        seed: u64 = 0,
        /// What a component's gain is divided by in mode=adaptive: paper (its weights) or bytes (weights and representative).
        allocation: Allocation = Allocation::Bytes,
        /// Eigen-solver of the components that are stored: auto, power, krylov, gram or svd.
        solver: Solver = Solver::Auto,
        /// Error that is minimised: coefficients (of the matrix) or radiance (orthonormal coordinates).
        norm: Norm = Norm::Coefficients,
        /// Weights are stored as f32, f16 or i16.
        weights: Width = Width::F32,
        /// Means and components are stored as f32, f16 or i16.
        representatives: Width = Width::F32,
        /// Bound on Σ(T-T̃)²/ΣT² of what is decoded, in the norm, above 0 to 1: the components that keep it in the smallest file, in place of `components`.
        max_error: Option<f64> = None,
    }
}
