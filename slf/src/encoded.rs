//! A light field as it is stored and relit.

use crate::layout::Layout;
use crate::maps::Maps;
use crate::model::Model;
use crate::{apply, wire};
use ndarray::{ArrayView2, ArrayViewMut2};
use prt_transfer::ids::Ids;
use prt_transfer::numbers::{Numbers, Width};
use prt_transfer::{Encoded, Flops, Restore, Result, Shape, Sink, Source};

/// What `slf` makes of a matrix of m texels, ζ channels and n directions: `F[p, d] ≈ μ[p] + Σ_j U[p, j] V_c(p)[d, j]` (Miandji et al. 2011,
/// Eq. 7), with k components j and the cluster c(p) of η.
///
/// Relighting meets the view maps of every cluster with the light once, `V_cᵀ l`, and then each row:
/// `y_p = μ_p Σ_d l_d + Σ_j U_pj (V_cᵀ l)_j`. That takes
///
/// ```text
/// n additions,  η ζ n k + ζ m (k + 1) multiplications and additions
/// ```
///
/// Numbers of 16 bits have a scale for each component of a cluster's view map, for its weights, and for the means of a cluster's channel:
/// `η ζ k` multiplications more where view or surface maps are scaled, as many again for the products of two scales where both are, and
/// `η ζ` where means are. With `colour=separate` η counts the clusters of one channel, so that η ζ is those of all.
///
/// A number comes back from 16 bits as [`Numbers`] says. With `maps=haar` a file has rounded images and memory single precision.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedSlf {
    pub(crate) layout: Layout,
    /// The cluster of each texel; of each texel and channel where channels are separate.
    pub(crate) ids: Ids,
    /// U.
    pub(crate) surface: Numbers,
    /// V of every cluster.
    pub(crate) views: Numbers,
    /// μ.
    pub(crate) means: Numbers,
    /// How the three are rounded in a file; `None` where they are kept as they are.
    pub(crate) maps: Option<Maps>,
    pub(crate) note: Option<String>,
}

/// How many numbers a light field takes (Eq. 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Γ(U) = ζ m k; m k where channels have their weights in common.
    pub surface: u64,
    /// Γ(V) = η ζ n k.
    pub views: u64,
    /// Γ(μ) = ζ m.
    pub mean: u64,
    /// Γ(χ) = m; ζ m where channels are separate.
    pub ids: u64,
}

impl Counts {
    /// γ.
    pub fn total(&self) -> u64 {
        self.surface + self.views + self.mean + self.ids
    }
}

impl EncodedSlf {
    pub(crate) fn store(model: &Model, surface: Width, views: Width) -> EncodedSlf {
        let layout = model.layout.clone();
        let ids = Ids::pack(&model.members, layout.most_clusters());
        let means = Numbers::store(&model.means, surface, layout.mean_vectors(), layout.vectors_of_means(&ids));
        let surface =
            Numbers::store(&model.surface, surface, layout.surface_vectors(), layout.vectors_of_surface(&ids));
        let views = Numbers::store(&model.views, views, layout.view_vectors(), layout.vectors_of_views());
        EncodedSlf { layout, ids, surface, views, means, maps: None, note: None }
    }

    /// Maps as what their rounded images stand for.
    pub(crate) fn store_rounded(model: &Model, maps: Maps) -> EncodedSlf {
        let layout = model.layout.clone();
        let ids = Ids::pack(&model.members, layout.most_clusters());
        let rounded = |kind: usize, values: &[f32]| {
            Numbers::F32(maps.restored(&layout, kind, &maps.coded(&layout, kind, values)))
        };
        let [surface, views] = [rounded(0, &model.surface), rounded(1, &model.views)];
        let means = rounded(2, &model.means);
        EncodedSlf { layout, ids, surface, views, means, maps: Some(maps), note: None }
    }

    /// With a sentence for the user.
    pub(crate) fn with_note(self, note: String) -> EncodedSlf {
        EncodedSlf { note: Some(note), ..self }
    }

    /// η: clusters; of the channel with most where channels are separate.
    pub fn clusters(&self) -> usize {
        self.layout.most_clusters()
    }

    /// k: components of each cluster.
    pub fn components(&self) -> usize {
        self.layout.components
    }

    /// Channels of clusters: η ζ; where channels are separate the clusters of all.
    pub fn tiles(&self) -> usize {
        self.layout.mean_vectors()
    }

    /// How memory holds the surface map (and the mean map), and the view maps.
    pub fn widths(&self) -> [Width; 2] {
        [self.surface.width(), self.views.width()]
    }

    /// The cluster of a texel, for a channel: where channels are not separate the same for all.
    pub fn cluster_of(&self, texel: usize, channel: usize) -> usize {
        let fields = self.layout.fields();
        self.ids.at(texel * fields + channel % fields) as usize
    }

    /// The numbers that Eq. 5 counts.
    pub fn counts(&self) -> Counts {
        Counts {
            surface: self.surface.len() as u64,
            views: self.views.len() as u64,
            mean: self.means.len() as u64,
            ids: (self.layout.shape.samples * self.layout.fields()) as u64,
        }
    }

    /// ζ m n over the numbers that Eq. 5 counts.
    pub fn ratio(&self) -> f64 {
        (self.layout.shape.rows() * self.layout.shape.lights) as f64 / self.counts().total().max(1) as f64
    }

    /// Eq. 7 for one element, in k multiplications.
    pub fn element(&self, texel: usize, channel: usize, direction: usize) -> f32 {
        let layout = &self.layout;
        let (cluster, place) = layout.cluster(&self.ids, texel, channel);
        let (weight, view) =
            (layout.weight(texel, channel), layout.view(cluster, direction) + place * layout.components);
        let term = |j: usize| self.scaled_weight(weight, cluster, place, j) * f64::from(self.views.stored(view + j));
        rounded((0..layout.components).fold(self.mean(texel, channel), |sum, j| sum + term(j)))
    }

    /// μ of a row.
    pub(crate) fn mean(&self, texel: usize, channel: usize) -> f64 {
        let (cluster, place) = self.layout.cluster(&self.ids, texel, channel);
        let scale = self.means.scale(cluster * self.layout.channels() + place);
        f64::from(self.means.stored(texel * self.layout.shape.responses + channel)) * f64::from(scale)
    }

    /// The `j`th of the weights from `first` on times the scale of what it multiplies.
    fn scaled_weight(&self, first: usize, cluster: usize, place: usize, j: usize) -> f64 {
        let scales = self.scales(cluster, place, j);
        f64::from(self.surface.stored(first + j)) * scales[0] * scales[1]
    }

    /// The scales of a component's weights and of its numbers in a channel.
    pub(crate) fn scales(&self, cluster: usize, place: usize, j: usize) -> [f64; 2] {
        let (k, vectors) = (self.layout.components, self.layout.vectors());
        let weight = self.surface.scale((cluster * vectors + place.min(vectors - 1)) * k + j);
        let view = self.views.scale((cluster * self.layout.channels() + place) * k + j);
        [f64::from(weight), f64::from(view)]
    }
}

/// A sum of double precision in the range of `f32`.
pub(crate) fn rounded(sum: f64) -> f32 {
    sum.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

impl Encoded for EncodedSlf {
    fn shape(&self) -> Shape {
        self.layout.shape
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        apply::apply(self, lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        let layout = &self.layout;
        let (texel, channel) = (row / layout.shape.responses, row % layout.shape.responses);
        let (cluster, place) = layout.cluster(&self.ids, texel, channel);
        let weight = layout.weight(texel, channel);
        let weights = (0..layout.components).map(|j| self.scaled_weight(weight, cluster, place, j));
        let (weights, mean) = (weights.collect::<Vec<f64>>(), self.mean(texel, channel));
        for (direction, y) in out.iter_mut().enumerate() {
            let view = layout.view(cluster, direction) + place * layout.components;
            let terms = weights.iter().enumerate().map(|(j, w)| w * f64::from(self.views.stored(view + j)));
            *y = rounded(terms.fold(mean, |sum, term| sum + term));
        }
    }
    fn flops(&self, light: &[f32]) -> Flops {
        apply::flops(self, light)
    }
    fn write(&self, sink: &mut Sink) {
        wire::write(self, sink);
    }
    fn hold(&self, sink: &mut Sink) {
        wire::hold(self, sink);
    }
    fn note(&self) -> Option<String> {
        self.note.clone()
    }
}

impl Restore for EncodedSlf {
    const TAG: &'static str = "slf.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedSlf> {
        wire::read(shape, source)
    }
}
