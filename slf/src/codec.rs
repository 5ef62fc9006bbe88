//! The codec `slf`.

use crate::clusterer::Clusterer;
use crate::encoded::EncodedSlf;
use crate::fit::fit;
use crate::grouped::Grouped;
use crate::maps;
use crate::model::Model;
use crate::params::{Maps, SlfParams};
use crate::residual::Residual;
use crate::search;
use prt_cpca::Clusters;
use prt_transfer::footprint::{Extent, Footprint, by};
use prt_transfer::numbers::Width;
use prt_transfer::{Codec, Configure, Error, Params, Progress, Result, TransferMatrix};

/// Most clusters.
const MAX_CLUSTERS: usize = 1 << 16;
/// Most components of a cluster.
const MAX_COMPONENTS: usize = 4096;
/// Most sweeps.
const MAX_SWEEPS: usize = 1000;
/// Where a model is exact, rounding may still add this part of the matrix's square.
const LEAST_ADDED: f64 = 1e-9;

/// Surface light fields.
pub struct Slf(SlfParams);

/// A light field that is being compressed.
pub(crate) struct Task<'a> {
    pub(crate) params: &'a SlfParams,
    pub(crate) matrix: &'a TransferMatrix,
    pub(crate) residual: &'a Residual,
    pub(crate) progress: &'a dyn Progress,
}

impl Configure for Slf {
    type Params = SlfParams;
    fn new(params: SlfParams) -> Result<Slf> {
        let in_range = |name: &str, value: usize, least: usize, most: usize| {
            let fits = (least..=most).contains(&value);
            if fits { Ok(()) } else { Err(SlfParams::refuse(name, value, format!("from {least} to {most}"))) }
        };
        in_range("components", params.components, 0, MAX_COMPONENTS)?;
        in_range("sweeps", params.sweeps.unwrap_or(1), 1, MAX_SWEEPS)?;
        match params.clusters {
            Clusters::Number(clusters) => in_range("clusters", clusters, 1, MAX_CLUSTERS)?,
            Clusters::Auto if params.max_error.is_none() => return Err(auto_without_bound()),
            Clusters::Auto => {}
        }
        let part = |name: &str, value: f64| match value > 0.0 && value <= 1.0 {
            true => Ok(()),
            false => Err(SlfParams::refuse(name, value, "above 0, to 1")),
        };
        params.max_error.map_or(Ok(()), |bound| part("max_error", bound))?;
        part("noise", params.noise)?;
        if params.maps == Maps::Haar && (params.surface, params.views) != (Width::F32, Width::F32) {
            return Err(SlfParams::refuse("maps", "haar", "plain where surface or views are not f32"));
        }
        Ok(Slf(params))
    }
    fn params(&self) -> &SlfParams {
        &self.0
    }
}

fn auto_without_bound() -> Error {
    SlfParams::refuse("clusters", "auto", "a number without max_error")
}

impl Codec for Slf {
    type Encoded = EncodedSlf;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedSlf> {
        let SlfParams { clusters, components, colour, norm, .. } = self.0;
        progress.start("mean", 1);
        let residual = Residual::of(matrix, norm, colour);
        progress.advance(1)?;
        let task = Task { params: &self.0, matrix, residual: &residual, progress };
        let mut clusterer = Clusterer::new(&self.0, &residual, progress);
        match (self.0.max_error, clusters) {
            (Some(bound), _) => search::bounded(&task, &mut clusterer, bound),
            (None, Clusters::Number(number)) => {
                let grouped = clusterer.grouped(number, self.0.mode, components)?;
                Ok(task.stored(&task.fitted(&grouped, components)?))
            }
            (None, Clusters::Auto) => Err(auto_without_bound()),
        }
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // Texels less their means, clustered; the bases of every cluster, in double precision while they are found.
        let SlfParams { clusters, components, max_error, surface, views, .. } = self.0;
        let (samples, lights) = (extent.shape.samples as u64, extent.shape.lights as u64);
        let responses = extent.shape.responses as u64;
        let (clusters, components) = match (max_error, clusters) {
            (None, Clusters::Number(clusters)) => ((clusters as u64).min(samples), components as u64),
            _ => (1, lights),
        };
        let components = components.min(lights).min(samples);
        let result = by(surface.bytes() as f64, samples * responses * (components + 1))
            + by(views.bytes() as f64, clusters * responses * lights * components)
            + by(16.0, samples);
        let searched = if max_error.is_some() { 28.0 } else { 14.0 };
        Some(Footprint { peak: by(searched, extent.cells()) + by(2.0, result), result })
    }
}

impl Task<'_> {
    /// The model of given clusters.
    pub(crate) fn fitted(&self, grouped: &Grouped, components: usize) -> Result<Model> {
        fit(self.residual, grouped, self.params.colour, components, self.params.solver, self.progress)
    }

    pub(crate) fn stored(&self, model: &Model) -> EncodedSlf {
        let SlfParams { surface, views, noise, .. } = *self.params;
        let stored = match self.params.maps {
            Maps::Plain => EncodedSlf::store(model, surface, views),
            Maps::Haar => {
                let allowed = (noise * model.left).max(LEAST_ADDED * model.energy);
                EncodedSlf::store_rounded(model, maps::Maps::of(model, maps::sizes(self.matrix), allowed))
            }
        };
        stored.with_note(told(model))
    }
}

/// What was found, for the user.
fn told(model: &Model) -> String {
    let (clusters, components) = (model.layout.most_clusters(), model.layout.components);
    let error = if model.energy > 0.0 { model.left / model.energy } else { 0.0 };
    format!("η = {clusters}, k = {components}: relative squared error {error:.2e} before rounding")
}
