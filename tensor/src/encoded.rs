//! Clusters and their bases as they are stored and relit.

use crate::layout::{Layout, Place};
use crate::model::{Cluster, Model};
use crate::params::Storage;
use crate::{apply, steps, wire};
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use prt_transfer::ids::Ids;
use prt_transfer::numbers::{Numbers, Width};
use prt_transfer::{Encoded, Flops, Restore, Result, Shape, Sink, Source};

/// What `cta` and `tucker` make of a matrix: `T_x ≈ U_view uf⁻¹(Vᵀ W_x) U_lightᵀ` with the bases of the cluster of sample x (Tsai and Shih
/// 2006, Eq. 18), or the sum of such terms over the clusters of a sample.
///
/// Relighting follows the paper's §6. For each cluster the light meets its light basis, `L' = U_lightᵀ l`, and its dual basis: column j of R
/// is `uf⁻¹(V_j) L'`. A sample adds up the columns, `R W_x`, and the view basis turns them into responses. With samples x, their m clusters
/// c(x), K responses and R_view = v that takes, in multiplications and as many additions,
///
/// ```text
/// Σ_c R_light,c (lights + R_vert,c v)  +  Σ_x Σ_c(x) R_vert,c v  +  samples K v
/// ```
///
/// or, where this is less, the view basis meets the columns: `Σ_c R_vert,c v K + Σ_x Σ_c(x) R_vert,c K` in place of the last two terms. A view
/// basis that is the identity takes nothing. Numbers of 16 bits have a scale for each row of a light basis, each row of a dual basis
/// and the weights that meet it: `Σ_c R_light,c + R_vert,c (v + 1)` multiplications more.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedCta {
    pub(crate) shape: Shape,
    pub(crate) layout: Layout,
    pub(crate) ids: Ids,
    /// U_view, responses x R_view; `None` where it is the identity.
    pub(crate) view: Option<Array2<f32>>,
    /// Rows of light bases.
    pub(crate) light: Numbers,
    /// Rows of dual bases.
    pub(crate) dual: Numbers,
    /// Sample after sample. Those that meet one row of a dual basis share a scale.
    pub(crate) weights: Numbers,
    pub(crate) note: Option<String>,
}

impl EncodedCta {
    /// Stores a model with orthonormal light bases. `added` is what `Storage::Coded` may add to its squared error.
    ///
    /// # Panics
    /// A model that [`Model::check`] refuses.
    pub fn store(model: &Model, storage: Storage, added: f64) -> EncodedCta {
        EncodedCta::store_scaled(model, storage, added, 1.0)
    }

    /// As [`EncodedCta::store`], light bases being `of_bases` times orthonormal ones.
    pub(crate) fn store_scaled(model: &Model, storage: Storage, added: f64, of_bases: f64) -> EncodedCta {
        if let Err(error) = model.check() {
            panic!("no valid model: {error}");
        }
        let samples = model.shape.samples;
        let ids = Ids::pack(&model.members, model.clusters.len());
        let ranks: Vec<[usize; 2]> = model.clusters.iter().map(|c| [c.light.nrows(), c.dual.nrows()]).collect();
        let layout = Layout::of(&ranks, model.views(), model.memberships, samples, &ids);
        let light: Vec<f32> = model.clusters.iter().flat_map(|c| &c.light).copied().collect();
        let dual: Vec<f32> = model.clusters.iter().flat_map(|c| &c.dual).copied().collect();
        let of_light = rows_of_lights(layout.end().light, model.shape.lights);
        let [light, dual, weights] = match width(storage) {
            Some(width) => [
                Numbers::store(&light, width, layout.end().light, of_light),
                Numbers::store(&dual, width, layout.end().sample, layout.rows_of_duals()),
                Numbers::store(&model.weights, width, layout.end().sample, layout.rows_of_weights(samples, &ids)),
            ],
            None => {
                let steps = steps::of(model, &layout, &ids, added, of_bases);
                [
                    Numbers::store_coarse(&light, &steps.light, of_light),
                    Numbers::store_coarse(&dual, &steps.dual, layout.rows_of_duals()),
                    Numbers::store_coarse(&model.weights, &steps.weights, layout.rows_of_weights(samples, &ids)),
                ]
            }
        };
        EncodedCta { shape: model.shape, layout, ids, view: model.view.clone(), light, dual, weights, note: None }
    }

    /// The model that is stored, in single precision.
    pub fn model(&self) -> Model {
        let samples = self.shape.samples;
        let light = self.light.decode(rows_of_lights(self.layout.end().light, self.shape.lights));
        let dual = self.dual.decode(self.layout.rows_of_duals());
        let cut = |values: &[f32], first: usize, rows: usize, columns: usize| {
            Array2::from_shape_vec((rows, columns), values[first..first + rows * columns].to_vec()).expect("whole rows")
        };
        let cluster = |place: &Place| Cluster {
            light: cut(&light, place.light * self.shape.lights, place.light_rank, self.shape.lights),
            dual: cut(&dual, place.dual, place.sample_rank, self.layout.views * place.light_rank),
        };
        Model {
            shape: self.shape,
            view: self.view.clone(),
            clusters: self.layout.places().iter().map(cluster).collect(),
            memberships: self.layout.memberships,
            members: (0..samples * self.layout.memberships).map(|at| self.ids.at(at)).collect(),
            weights: self.weights.decode(self.layout.rows_of_weights(samples, &self.ids)),
        }
    }

    /// With a sentence for the user.
    pub(crate) fn with_note(self, note: String) -> EncodedCta {
        EncodedCta { note: Some(note), ..self }
    }
}

/// `None` for [`Storage::Coded`].
fn width(storage: Storage) -> Option<Width> {
    match storage {
        Storage::F32 => Some(Width::F32),
        Storage::F16 => Some(Width::F16),
        Storage::I16 => Some(Width::I16),
        Storage::Coded => None,
    }
}

/// The row of the light bases that each of their numbers belongs to.
pub(crate) fn rows_of_lights(rows: usize, lights: usize) -> impl Iterator<Item = usize> + Clone {
    (0..rows).flat_map(move |row| std::iter::repeat_n(row, lights))
}

impl Encoded for EncodedCta {
    fn shape(&self) -> Shape {
        self.shape
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        apply::apply(self, lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        self.rows_into(row, ArrayViewMut2::from_shape((1, out.len()), out).expect("a row of itself"));
    }
    fn rows_into(&self, first: usize, out: ArrayViewMut2<f32>) {
        self.reconstruct(first, out);
    }
    fn flops(&self, light: &[f32]) -> Flops {
        apply::flops(self, light)
    }
    fn write(&self, sink: &mut Sink) {
        wire::write(self, sink);
        self.layout.write(sink);
    }
    fn hold(&self, sink: &mut Sink) {
        wire::hold(self, sink);
        self.layout.hold(sink);
    }
    fn note(&self) -> Option<String> {
        self.note.clone()
    }
}

impl Restore for EncodedCta {
    const TAG: &'static str = "cta.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedCta> {
        wire::read(shape, source)
    }
}
