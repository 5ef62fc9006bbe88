//! The codec `tucker`: one Tucker decomposition of samples x responses x lights.

use crate::encoded::EncodedCta;
use crate::footprint;
use crate::model::{Cluster, Model};
use crate::params::TuckerCodecParams;
use crate::tucker::{Algorithm, Decomposer, Ranks, Tucker, TuckerParams};
use ndarray::{Array2, ArrayViewD, Ix3};
use prt_transfer::footprint::{Extent, Footprint, by};
use prt_transfer::samples::Samples;
use prt_transfer::{Codec, Configure, Params, Progress, Result, Shape, TransferMatrix};

/// Highest ranks.
const MAX_RANK: usize = 65_536;
/// Most sweeps.
const MAX_SWEEPS: usize = 1000;
/// The least bound that ranks can be found for.
const LEAST_ERROR: f64 = 1e-12;
/// Where a decomposition is exact, its numbers may still add this part of the matrix's square.
const LEAST_ADDED: f64 = 1e-9;
/// Times that the ranks give way to what rounding adds.
const ATTEMPTS: usize = 6;

/// One Tucker decomposition of all samples.
pub struct TuckerCodec(TuckerCodecParams);

impl Configure for TuckerCodec {
    type Params = TuckerCodecParams;
    fn new(params: TuckerCodecParams) -> Result<TuckerCodec> {
        let in_range = |name: &str, value: usize, most: usize| {
            let fits = (1..=most).contains(&value);
            if fits { Ok(()) } else { Err(TuckerCodecParams::refuse(name, value, format!("from 1 to {most}"))) }
        };
        in_range("view", params.view, MAX_RANK)?;
        in_range("light", params.light, MAX_RANK)?;
        in_range("sample", params.sample, MAX_RANK)?;
        in_range("sweeps", params.sweeps, MAX_SWEEPS)?;
        if let Some(bound) = params.max_error.filter(|bound| !(LEAST_ERROR..=1.0).contains(bound)) {
            return Err(TuckerCodecParams::refuse("max_error", bound, format!("from {LEAST_ERROR:e} to 1")));
        }
        let TuckerCodecParams { view, light, sample, .. } = TuckerCodecParams::default();
        if let Some(bound) = params.max_error
            && [params.view, params.light, params.sample] != [view, light, sample]
        {
            return Err(TuckerCodecParams::refuse("max_error", bound, "none where view, light or sample is given"));
        }
        if !(params.noise > 0.0 && params.noise <= 1.0) {
            return Err(TuckerCodecParams::refuse("noise", params.noise, "above 0, to 1"));
        }
        Ok(TuckerCodec(params))
    }
    fn params(&self) -> &TuckerCodecParams {
        &self.0
    }
}

impl TuckerCodec {
    fn decomposed(&self, tensor: ArrayViewD<f32>, ranks: Ranks, progress: &dyn Progress) -> Result<Tucker> {
        let TuckerCodecParams { mode: algorithm, sweeps, seed, .. } = self.0;
        let params = TuckerParams { algorithm, ranks, sweeps, seed, ..TuckerParams::default() };
        Decomposer::new(params)?.decompose(tensor, progress)
    }

    fn stored(&self, samples: &Samples, shape: Shape, tucker: &Tucker) -> EncodedCta {
        let (of_weights, of_bases) = samples.scales();
        let scale = (of_weights * of_bases).powi(2);
        let error = tucker.energy() * tucker.relative_error();
        let added = (self.0.noise * error).max(LEAST_ADDED * tucker.energy()) * scale;
        let model = model(samples, shape, tucker);
        EncodedCta::store_scaled(&model, self.0.numbers, added, of_bases).with_note(self.told(tucker))
    }

    fn told(&self, tucker: &Tucker) -> String {
        let (ranks, report) = (tucker.ranks(), tucker.report());
        let of_modes = format!("ranks {} (samples) x {} (responses) x {} (lights)", ranks[0], ranks[1], ranks[2]);
        let swamp = if report.swamp() { ", of which many lowered it very little: a swamp" } else { "" };
        let end = match (self.0.mode, report.converged) {
            (Algorithm::Hooi, true) => format!("; converged in {} sweeps{swamp}", report.sweeps.len()),
            (Algorithm::Hooi, false) => format!("; not converged in {} sweeps{swamp}", report.sweeps.len()),
            (_, true) => String::new(),
            (_, false) => "; singular vectors of large modes have not converged".into(),
        };
        format!("{of_modes}: relative squared error {:.3e} before rounding{end}", tucker.relative_error())
    }
}

/// Ranks as one cluster: rows of the core are orthogonal, so that their directions are the dual basis, and their norms go to the weights.
fn model(samples: &Samples, shape: Shape, tucker: &Tucker) -> Model {
    if tucker.core().is_empty() {
        return Model::empty(shape);
    }
    let core = tucker.core().view().into_dimensionality::<Ix3>().expect("three modes");
    let [of_samples, of_views, of_lights] = [0, 1, 2].map(|mode| &tucker.factors()[mode]);
    let (of_weights, of_bases) = samples.scales();
    let rank = core.dim().0;
    let norms: Vec<f64> = core.outer_iter().map(|slice| slice.iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
    let dual = core.to_shape((rank, core.len() / rank.max(1))).expect("rows of views x lights").into_owned();
    let dual = Array2::from_shape_fn(dual.dim(), |(j, at)| (dual[[j, at]] / norms[j]) as f32);
    let mut light = of_lights.t().as_standard_layout().into_owned();
    light.outer_iter_mut().for_each(|mut row| samples.restore_lights(row.as_slice_mut().expect("rows are contiguous")));
    let mut view = of_views.t().as_standard_layout().into_owned();
    view.outer_iter_mut()
        .for_each(|mut row| samples.restore_responses(row.as_slice_mut().expect("rows are contiguous")));
    let weights = of_samples
        .outer_iter()
        .flat_map(|row| row.iter().zip(&norms).map(|(u, norm)| (u * norm * of_weights) as f32).collect::<Vec<f32>>());
    Model {
        shape,
        weights: weights.collect(),
        view: Some(view.t().mapv(|v| v as f32).as_standard_layout().into_owned()),
        clusters: vec![Cluster { light: light.mapv(|v| (v * of_bases) as f32), dual }],
        memberships: 1,
        members: vec![0; shape.samples],
    }
}

impl Codec for TuckerCodec {
    type Encoded = EncodedCta;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedCta> {
        let shape = matrix.shape();
        if shape.rows() * shape.lights == 0 {
            return Ok(EncodedCta::store(&Model::empty(shape), self.0.numbers, 0.0));
        }
        let TuckerCodecParams { view, light, sample, norm, max_error, .. } = self.0;
        let samples = Samples::of(matrix, norm)?;
        let tensor = ArrayViewD::from_shape(vec![shape.samples, shape.responses, shape.lights], samples.values());
        let tensor = tensor.expect("whole samples");
        progress.start("decompose", 1);
        let Some(bound) = max_error else {
            let tucker = self.decomposed(tensor, Ranks::Given(vec![sample, view, light]), progress)?;
            return Ok(self.stored(&samples, shape, &tucker));
        };
        let (mut allowed, mut least) = (bound, f64::INFINITY);
        for _ in 0..ATTEMPTS {
            let tucker = self.decomposed(tensor.view(), Ranks::MaxError(allowed), progress)?;
            let encoded = self.stored(&samples, shape, &tucker);
            let (error, whole) = norm.error_of(&encoded, matrix)?;
            if error <= bound * whole {
                return Ok(encoded);
            }
            least = least.min(error / whole);
            // What rounding adds, and a little more; at least a tenth.
            let added = 1.1 * (error / whole - tucker.relative_error()).max(0.0);
            allowed = (bound - added).min(0.9 * allowed).max(LEAST_ERROR);
        }
        let expected = format!("at least {least:.1e}, or wider numbers");
        Err(TuckerCodecParams::refuse("max_error", bound, expected))
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // The tensor in double precision, and the eigenproblem of the larger of its modes, of what those before it left.
        let TuckerCodecParams { view, light, sample, mode, max_error, .. } = self.0;
        let Shape { samples, responses, lights } = extent.shape;
        let ranks = match max_error {
            Some(_) => [samples, responses, lights].map(|n| n.div_ceil(2)),
            None => [sample.min(samples), view.min(responses), light.min(lights)],
        };
        let result = footprint::result(extent, 1, ranks);
        let all = mode == Algorithm::Hosvd || max_error.is_some();
        let left = if all { samples * responses } else { ranks[0] * ranks[1] };
        let gram = footprint::gram(samples, responses * lights).max(footprint::gram(lights, left));
        let solved = if mode == Algorithm::Randomised {
            by(17.0, extent.cells())
        } else {
            by(10.0, extent.cells()) + by(7.0, gram)
        };
        Some(Footprint { peak: solved + result, result })
    }
}
