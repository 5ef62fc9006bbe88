//! The codec `cta`.

use crate::encoded::EncodedCta;
use crate::footprint;
use crate::model::{Cluster, Model};
use crate::params::CtaParams;
use crate::search::{Found, MOST_ROWS, Plan, Ranks, Slabs, Sweep, search};
use ndarray::Array2;
use prt_transfer::footprint::{Extent, Footprint, by};
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Codec, Configure, Params, Progress, Result, Shape, TransferMatrix};

/// Most clusters.
const MAX_CLUSTERS: usize = 1 << 16;
/// Highest ranks.
const MAX_RANK: usize = 4096;
/// Most clusters of a sample.
const MAX_MEMBERS: usize = 16;
/// Most sweeps.
const MAX_SWEEPS: usize = 1000;
/// Where a model is exact, its numbers may still add this part of the matrix's square.
const LEAST_ADDED: f64 = 1e-9;

/// Clustered tensor approximation.
pub struct Cta(CtaParams);

/// A model and how it was found.
#[derive(Clone, Debug)]
pub struct Approximation {
    /// In the coordinates of the matrix.
    pub model: Model,
    /// Sweep by sweep.
    pub history: Vec<Sweep>,
    /// Whether the search ended by itself, not at the most sweeps.
    pub converged: bool,
    /// Squared error Σ(T-T̃)² in the coordinates in which it was minimised, before numbers are stored.
    pub square: f64,
    /// ΣT² in the same coordinates.
    pub energy: f64,
    /// Light bases are so many times orthonormal ones: not 1 where elements are very large or small.
    pub of_bases: f64,
}

impl Approximation {
    /// Of a matrix of zeros.
    fn empty(shape: Shape) -> Approximation {
        let model = Model::empty(shape);
        Approximation { model, history: Vec::new(), converged: true, square: 0.0, energy: 0.0, of_bases: 1.0 }
    }
}

impl Configure for Cta {
    type Params = CtaParams;
    fn new(params: CtaParams) -> Result<Cta> {
        let in_range = |name: &str, value: usize, least: usize, most: usize| {
            let fits = (least..=most).contains(&value);
            if fits { Ok(()) } else { Err(CtaParams::refuse(name, value, format!("from {least} to {most}"))) }
        };
        in_range("clusters", params.clusters, 1, MAX_CLUSTERS)?;
        in_range("view", params.view, 1, MAX_RANK)?;
        in_range("light", params.light, 1, MAX_RANK)?;
        in_range("sample", params.sample, 1, MAX_RANK)?;
        in_range("members", params.members, 1, MAX_MEMBERS)?;
        in_range("sweeps", params.sweeps, 0, MAX_SWEEPS)?;
        in_range("refine", params.refine, 1, MAX_SWEEPS)?;
        if params.members > 1 && params.clusters * params.sample > MOST_ROWS {
            let expected =
                format!("at most {}, {MOST_ROWS} / clusters, where members is above 1", MOST_ROWS / params.clusters);
            return Err(CtaParams::refuse("sample", params.sample, expected));
        }
        if !(params.noise > 0.0 && params.noise <= 1.0) {
            return Err(CtaParams::refuse("noise", params.noise, "above 0, to 1"));
        }
        Ok(Cta(params))
    }
    fn params(&self) -> &CtaParams {
        &self.0
    }
}

impl Cta {
    /// The model of a matrix, and how it was found.
    ///
    /// # Errors
    /// Responses that do not exist, or a search that was cancelled.
    pub fn approximate(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Approximation> {
        let shape = matrix.shape();
        if shape.rows() * shape.lights == 0 {
            return Ok(Approximation::empty(shape));
        }
        let samples = Samples::of(matrix, self.0.norm)?;
        if samples.values().iter().all(|v| *v == 0.0) {
            return Ok(Approximation::empty(shape));
        }
        let tensor = Slabs::lent(samples.values(), [shape.samples, shape.responses, shape.lights]);
        let CtaParams { clusters, view, light, sample, members, sweeps, refine, start, seed, .. } = self.0;
        let ranks = Ranks { light, sample };
        let found = search(&tensor, &Plan { clusters, view, ranks, members, sweeps, refine, start, seed }, progress)?;
        Ok(finish(&samples, shape, found))
    }
}

/// The model in the matrix's coordinates, without clusters that nobody is in.
fn finish(samples: &Samples, shape: Shape, found: Found) -> Approximation {
    let Found { view, bases, memberships, members, weights, square, whole, history, converged } = found;
    let (of_weights, of_bases) = samples.scales();
    let groups = Groups::of(&members, bases.len());
    let kept: Vec<usize> = (0..bases.len()).filter(|&k| !groups.of_cluster(k).is_empty()).collect();
    let mut numbers = vec![0u32; bases.len()];
    kept.iter().zip(0..).for_each(|(&k, number)| numbers[k] = number);
    let cluster = |&k: &usize| Cluster {
        light: restored(&bases[k].light, of_bases, |row| samples.restore_lights(row)),
        dual: bases[k].dual.clone(),
    };
    let view = restored(&view, 1.0, |row| samples.restore_responses(row)).t().as_standard_layout().into_owned();
    let model = Model {
        shape,
        view: Some(view).filter(|view| *view != Array2::<f32>::eye(shape.responses)),
        clusters: kept.iter().map(cluster).collect(),
        memberships,
        members: members.into_iter().map(|k| numbers[k as usize]).collect(),
        weights: weights.into_iter().flatten().map(|w| (f64::from(w) * of_weights) as f32).collect(),
    };
    let scale = (of_weights * of_bases).powi(2);
    Approximation { model, history, converged, square: square * scale, energy: whole * scale, of_bases }
}

/// Rows taken back to the coordinates of the matrix.
fn restored(rows: &Array2<f32>, scale: f64, restore: impl Fn(&mut [f64])) -> Array2<f32> {
    let mut restored = rows.mapv(f64::from);
    for mut row in restored.outer_iter_mut() {
        restore(row.as_slice_mut().expect("rows are contiguous"));
    }
    restored.mapv(|v| (v * scale) as f32)
}

impl Codec for Cta {
    type Encoded = EncodedCta;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCta> {
        let found = self.approximate(matrix, progress)?;
        let added = (self.0.noise * found.square).max(LEAST_ADDED * found.energy);
        let encoded = EncodedCta::store_scaled(&found.model, self.0.numbers, added, found.of_bases);
        Ok(encoded.with_note(told(&found)))
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // Samples, and what the light bases begin with, in double precision.
        let CtaParams { clusters, view, light, sample, members, .. } = self.0;
        let result = footprint::result(
            extent,
            clusters.min(extent.shape.samples),
            [sample * members.min(clusters), view, light],
        );
        let lights = extent.shape.lights as u64;
        let basis = by(8.0, lights * lights.min(extent.rows()));
        Some(Footprint { peak: by(4.0, extent.cells()) + by(5.6, basis) + 2 * result, result })
    }
}

/// The search in a sentence.
fn told(found: &Approximation) -> String {
    let clusters = found.model.clusters.len();
    let (Some(first), Some(last)) = (found.history.first(), found.history.last()) else {
        return format!("{clusters} clusters");
    };
    let end = if found.converged { "converged" } else { "not converged: more sweeps or refine would lower it" };
    format!(
        "{clusters} clusters in {} sweeps: relative squared error {:.4} after the first, {:.4} after the last, before rounding; {end}",
        found.history.len(),
        first.error,
        last.error
    )
}
