//! Clusters and subspaces as they are stored and relit.

use crate::layout::Layout;
use crate::model::{Cluster, Model};
use crate::{apply, wire};
use ndarray::{ArrayView2, ArrayViewMut2};
use prt_transfer::ids::Ids;
use prt_transfer::numbers::Numbers;
use prt_transfer::numbers::Width;
use prt_transfer::{Encoded, Flops, Restore, Result, Shape, Sink, Source};

/// What `vq`, `pca` and `cpca` make of a matrix: `x_p ≈ x_0 + Σ_j w_p^j x_j` with the mean x_0 and the n'_k components
/// x_j of the cluster of sample p (Sloan et al. 2003, §3.3).
///
/// Relighting follows the paper's §6. First the light meets the representatives, `R_j = X_j l`, then each sample adds
/// up those of its cluster, `e_p = R_0 + Σ_j w_p^j R_j`. With n = responses x lights that takes
///
/// ```text
/// Σ_k (1 + n'_k) n + Σ_p n'_c(p) responses      multiplications and additions
/// ```
///
/// Numbers of 16 bits have a scale for each representative, and for the weights of each component within its cluster.
/// Scales are applied to R: so many multiplications more as R has numbers (`Σ_k (1 + n'_k) responses` with scaled
/// representatives, `Σ_k n'_k responses` with scaled weights only), and `Σ_k n'_k` for the products of two scales where
/// both are scaled. The second stage costs the same for every width.
///
/// A number comes back exactly from f32. From i16 it is off by no more than half the scale of its vector, which is at
/// most 1 + 2^-8 times the 32767th part of the vector's largest magnitude; from f16 by 2^-11 of itself, or 2^-39 of
/// that largest magnitude if this is more. Where rounding to nearest would leave the range of f32, it goes towards 0.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedCpca {
    pub(crate) shape: Shape,
    pub(crate) layout: Layout,
    pub(crate) ids: Ids,
    /// Mean and components, cluster after cluster: n numbers each.
    pub(crate) representatives: Numbers,
    /// Sample after sample. Those of one component in one cluster share a scale.
    pub(crate) weights: Numbers,
    pub(crate) superclusters: Option<Vec<u32>>,
}

/// Elements of a row that are reconstructed together.
const ELEMENTS: usize = 64;

impl EncodedCpca {
    /// Stores a model.
    ///
    /// # Panics
    /// A model that [`Model::check`] refuses.
    pub fn store(model: &Model, weights: Width, representatives: Width) -> EncodedCpca {
        if let Err(error) = model.check() {
            panic!("no valid model: {error}");
        }
        let (n, samples) = (model.dimension(), model.shape.samples);
        let ids = Ids::pack(&model.members, model.clusters.len());
        let components: Vec<u32> = (0..model.clusters.len()).map(|k| model.components(k) as u32).collect();
        let layout = Layout::of(&components, samples, &ids);
        let values: Vec<f32> =
            model.clusters.iter().flat_map(|c| c.mean.iter().chain(&c.components)).copied().collect();
        let vectors = layout.vectors();
        let representatives = Numbers::store(&values, representatives, vectors, vector_of(vectors, n));
        let of_weights = layout.components_of_weights(samples, &ids);
        let weights = Numbers::store(&model.weights, weights, vectors - layout.clusters(), of_weights);
        EncodedCpca { shape: model.shape, layout, ids, representatives, weights, superclusters: None }
    }

    /// The model that is stored, in single precision.
    pub fn model(&self) -> Model {
        let (n, samples) = (self.dimension(), self.shape.samples);
        let values = self.representatives.decode(vector_of(self.layout.vectors(), n));
        let cluster = |k: usize| {
            let first = self.layout.first_vector(k) * n;
            let own = &values[first..first + (1 + self.layout.components(k)) * n];
            Cluster { mean: own[..n].to_vec(), components: own[n..].to_vec() }
        };
        Model {
            shape: self.shape,
            clusters: (0..self.layout.clusters()).map(cluster).collect(),
            members: (0..samples).map(|p| self.ids.at(p)).collect(),
            weights: self.weights.decode(self.layout.components_of_weights(samples, &self.ids)),
        }
    }

    /// How weights and representatives are stored.
    pub fn widths(&self) -> [Width; 2] {
        [self.weights.width(), self.representatives.width()]
    }

    /// How many clusters there are.
    pub fn clusters(&self) -> usize {
        self.layout.clusters()
    }

    /// The supercluster of each cluster (Sloan et al. 2003, §5), where they have been formed.
    pub fn superclusters(&self) -> Option<&[u32]> {
        self.superclusters.as_deref()
    }

    /// With the supercluster of each cluster.
    ///
    /// # Errors
    /// Another number of them than there are clusters.
    pub fn with_superclusters(self, superclusters: Vec<u32>) -> Result<EncodedCpca> {
        prt_transfer::Error::expect_size("superclusters, one for each cluster", self.clusters(), superclusters.len())?;
        Ok(EncodedCpca { superclusters: Some(superclusters), ..self })
    }

    fn dimension(&self) -> usize {
        self.shape.responses * self.shape.lights
    }

    /// The weight at `at` of the `component`th of all components.
    fn weight(&self, at: usize, component: usize) -> f64 {
        f64::from(self.weights.stored(at)) * f64::from(self.weights.scale(component))
    }
}

/// The representative that each of their numbers belongs to.
pub(crate) fn vector_of(vectors: usize, dimension: usize) -> impl Iterator<Item = usize> + Clone {
    (0..vectors).flat_map(move |vector| std::iter::repeat_n(vector, dimension))
}

impl Encoded for EncodedCpca {
    fn shape(&self) -> Shape {
        self.shape
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        apply::apply(self, lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        let (sample, response) = (row / self.shape.responses, row % self.shape.responses);
        let (n, lights) = (self.dimension(), self.shape.lights);
        let cluster = self.ids.at(sample) as usize;
        let (vector, weight) = (self.layout.first_vector(cluster), self.layout.first_weight(sample, &self.ids));
        for (block, out) in out.chunks_mut(ELEMENTS).enumerate() {
            // In double precision, so that no sum of finite numbers overflows on its way.
            let mut sums = [0f64; ELEMENTS];
            for j in 0..=self.layout.components(cluster) {
                let scale = f64::from(self.representatives.scale(vector + j));
                let factor = scale * if j == 0 { 1.0 } else { self.weight(weight + j - 1, vector - cluster + j - 1) };
                let first = (vector + j) * n + response * lights + block * ELEMENTS;
                let terms = (first..first + out.len()).map(|at| f64::from(self.representatives.stored(at)));
                sums.iter_mut().zip(terms).for_each(|(sum, x)| *sum += factor * x);
            }
            let (least, most) = (f64::from(f32::MIN), f64::from(f32::MAX));
            out.iter_mut().zip(sums).for_each(|(y, sum)| *y = sum.clamp(least, most) as f32);
        }
    }
    fn flops(&self, light: &[f32]) -> Flops {
        apply::flops(self, light)
    }
    fn write(&self, sink: &mut Sink) {
        wire::write(self, sink);
        self.layout.write(sink);
    }
    fn hold(&self, sink: &mut Sink) {
        wire::write(self, sink);
        self.layout.hold(sink);
    }
}

impl Restore for EncodedCpca {
    const TAG: &'static str = "cpca.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedCpca> {
        wire::read(shape, source)
    }
}
