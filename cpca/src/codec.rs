//! The codecs `vq`, `pca` and `cpca`: one search with more or less to choose.

use crate::bounded::{Bounded, bounded};
use crate::encoded::EncodedCpca;
use crate::engine::{Clustering, Engine, Plan};
use crate::finish::finish;
use crate::footprint;
use crate::model::Model;
use crate::params::{Allocation, Clusters, CpcaParams, Mode, PcaParams, Solver, Start, VqParams};
use crate::{Norm, Width};
use prt_transfer::footprint::by;
use prt_transfer::samples::Samples;
use prt_transfer::{Codec, Configure, Error, Extent, Footprint, Params, Progress, Result, TransferMatrix};

/// Most clusters.
const MAX_CLUSTERS: usize = 1 << 16;
/// Most components of a cluster.
const MAX_COMPONENTS: usize = 4096;
/// Most sweeps.
const MAX_SWEEPS: usize = 1000;
/// Sweeps of LBG where nobody says otherwise, and of each number of components.
const SWEEPS: usize = 20;
const SWEEPS_OF_EACH: usize = 10;

/// Vector quantisation.
pub struct Vq(VqParams);

/// Principal components of all samples.
pub struct Pca(PcaParams);

/// Clustered principal components.
pub struct Cpca(CpcaParams);

/// What the three have in common.
pub(crate) struct Task {
    pub(crate) plan: Plan,
    /// `None` where their number is to be found.
    pub(crate) clusters: Option<usize>,
    pub(crate) solver: Solver,
    pub(crate) norm: Norm,
    pub(crate) weights: Width,
    pub(crate) representatives: Width,
}

impl Configure for Vq {
    type Params = VqParams;
    fn new(params: VqParams) -> Result<Vq> {
        let VqParams { clusters, sweeps, .. } = params;
        in_range::<VqParams>("clusters", clusters, 1, MAX_CLUSTERS)?;
        in_range::<VqParams>("sweeps", sweeps, 1, MAX_SWEEPS)?;
        Ok(Vq(params))
    }
    fn params(&self) -> &VqParams {
        &self.0
    }
}

impl Configure for Pca {
    type Params = PcaParams;
    fn new(params: PcaParams) -> Result<Pca> {
        in_range::<PcaParams>("components", params.components, 0, MAX_COMPONENTS)?;
        a_bound::<PcaParams>(params.max_error)?;
        Ok(Pca(params))
    }
    fn params(&self) -> &PcaParams {
        &self.0
    }
}

impl Configure for Cpca {
    type Params = CpcaParams;
    fn new(params: CpcaParams) -> Result<Cpca> {
        in_range::<CpcaParams>("components", params.components, 0, MAX_COMPONENTS)?;
        in_range::<CpcaParams>("sweeps", params.sweeps.unwrap_or(SWEEPS), 1, MAX_SWEEPS)?;
        a_bound::<CpcaParams>(params.max_error)?;
        match params.clusters {
            Clusters::Number(clusters) => in_range::<CpcaParams>("clusters", clusters, 1, MAX_CLUSTERS)?,
            Clusters::Auto if params.max_error.is_none() => {
                return Err(CpcaParams::refuse("clusters", "auto", "a number without max_error"));
            }
            Clusters::Auto => {}
        }
        Ok(Cpca(params))
    }
    fn params(&self) -> &CpcaParams {
        &self.0
    }
}

fn in_range<P: Params>(name: &str, value: usize, least: usize, most: usize) -> Result<()> {
    let fits = (least..=most).contains(&value);
    if fits { Ok(()) } else { Err(P::refuse(name, value, format!("from {least} to {most}"))) }
}

fn a_bound<P: Params>(bound: Option<f64>) -> Result<()> {
    match bound.filter(|e| !(*e > 0.0 && *e <= 1.0)) {
        Some(bound) => Err(P::refuse("max_error", bound, "above 0, to 1")),
        None => Ok(()),
    }
}

impl Codec for Vq {
    type Encoded = EncodedCpca;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCpca> {
        let VqParams { clusters, sweeps, start, seed, norm, representatives } = self.0;
        let plan = Plan { sweeps, start, seed, ..Plan::new(clusters, 0) };
        let (solver, weights) = (Solver::Auto, Width::F32);
        Task { plan, clusters: Some(clusters), solver, norm, weights, representatives }.encode(matrix, progress)
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        let clusters = self.0.clusters as u64;
        let result = footprint::result(extent, clusters, 0, (Width::F32, self.0.representatives));
        Some(Footprint { peak: footprint::searched(extent) + 2 * result, result })
    }
}

impl Codec for Pca {
    type Encoded = EncodedCpca;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCpca> {
        let PcaParams { components, solver, norm, weights, representatives, max_error } = self.0;
        let plan = Plan { sweeps: 1, ..Plan::new(1, components) };
        let task = Task { plan, clusters: Some(1), solver, norm, weights, representatives };
        match max_error {
            None => task.encode(matrix, progress),
            Some(bound) => task.encode_bounded::<PcaParams>(matrix, bound, progress),
        }
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        let PcaParams { components, weights, representatives, max_error, .. } = self.0;
        let components = if max_error.is_some() { footprint::rank(extent) } else { components as u64 };
        let result = footprint::result(extent, 1, components, (weights, representatives));
        let solved = footprint::solved(extent, components);
        let peak = if max_error.is_some() { footprint::bounded(extent) } else { solved };
        Some(Footprint { peak: peak + result, result })
    }
}

impl Codec for Cpca {
    type Encoded = EncodedCpca;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCpca> {
        let CpcaParams { clusters, components, mode, sweeps, start, seed, .. } = self.0;
        let CpcaParams { allocation, solver, norm, weights, representatives, max_error, .. } = self.0;
        let number = match clusters {
            Clusters::Number(number) => Some(number),
            Clusters::Auto => None,
        };
        let plan = Plan {
            mode,
            start,
            seed,
            allocation,
            sweeps: sweeps_of(mode, sweeps),
            ..Plan::new(number.unwrap_or(1), components)
        };
        let task = Task { plan, clusters: number, solver, norm, weights, representatives };
        match max_error {
            None => task.encode(matrix, progress),
            Some(bound) => task.encode_bounded::<CpcaParams>(matrix, bound, progress),
        }
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        let CpcaParams { clusters, components, mode, weights, representatives, max_error, .. } = self.0;
        let components = components as u64;
        if max_error.is_some() {
            let result = footprint::result(extent, 1, footprint::rank(extent), (weights, representatives));
            return Some(Footprint { peak: footprint::bounded(extent) + result, result });
        }
        let clusters = match clusters {
            Clusters::Number(number) => number as u64,
            Clusters::Auto => 1,
        };
        let result = footprint::result(extent, clusters, components, (weights, representatives));
        // A few clusters are solved at once, the largest of them several times as large as the mean.
        let share = (3.0 * rayon::current_num_threads() as f64 / clusters as f64).min(1.0);
        let solved = by(share, footprint::solved(extent, components));
        let sweeps = if mode == Mode::Adaptive { by(12.0, extent.cells()) } else { 0 };
        Some(Footprint { peak: footprint::searched(extent) + solved + sweeps + 2 * result, result })
    }
}

/// Sweeps at most, where they are not given those that are usual.
pub(crate) fn sweeps_of(mode: Mode, sweeps: Option<usize>) -> usize {
    sweeps.unwrap_or(if mode == Mode::Static { SWEEPS } else { SWEEPS_OF_EACH })
}

/// Refuses more samples than ids of 32 bits name.
pub(crate) fn check_count(samples: &Samples) -> Result<()> {
    let (limit, found) = (u64::from(u32::MAX), samples.count() as u64);
    let fits = found <= limit;
    if fits { Ok(()) } else { Err(Error::TooLarge { what: "samples to cluster".into(), limit, found }) }
}

impl Plan {
    pub(crate) fn new(clusters: usize, components: usize) -> Plan {
        let (mode, start, allocation) = (Mode::Static, Start::PlusPlus, Allocation::Bytes);
        Plan { clusters, components, mode, sweeps: SWEEPS, start, seed: 0, allocation, bytes: (4, 4) }
    }
}

impl Task {
    fn encode(mut self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCpca> {
        let samples = self.samples(matrix)?;
        if samples.values().is_empty() {
            return Ok(EncodedCpca::store(&Model::empty(matrix.shape()), self.weights, self.representatives));
        }
        let engine = Engine::new(samples.lent(), progress)?;
        progress.start("cluster", self.plan.steps());
        let clustering = engine.search(&self.plan)?;
        self.stored(&samples, matrix, &clustering, progress)
    }

    fn encode_bounded<P: Params>(
        mut self,
        matrix: &TransferMatrix,
        bound: f64,
        progress: &dyn Progress,
    ) -> Result<EncodedCpca> {
        let samples = self.samples(matrix)?;
        if samples.values().is_empty() {
            return self.encode(matrix, progress);
        }
        match bounded(&self, matrix, &samples, bound, progress)? {
            Bounded::Kept(encoded) => Ok(*encoded),
            Bounded::Missed(error) => {
                let least = format!("at least {error:e}, which storing every component as asked for leaves");
                Err(P::refuse("max_error", bound, least))
            }
        }
    }

    /// The samples, and what their numbers take in the plan.
    fn samples<'a>(&mut self, matrix: &'a TransferMatrix) -> Result<Samples<'a>> {
        let samples = Samples::of(matrix, self.norm)?;
        check_count(&samples)?;
        self.plan.bytes = (self.weights.bytes(), self.representatives.bytes() * samples.dimension());
        Ok(samples)
    }

    pub(crate) fn stored(
        &self,
        samples: &Samples,
        matrix: &TransferMatrix,
        clustering: &Clustering,
        progress: &dyn Progress,
    ) -> Result<EncodedCpca> {
        progress.start("fit", clustering.groups.len() as u64);
        let model = finish(samples, matrix.shape(), clustering, &*self.solver.watched(progress), progress)?;
        Ok(EncodedCpca::store(&model, self.weights, self.representatives))
    }
}
