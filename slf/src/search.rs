//! The fewest bytes within an error bound.
//!
//! For given clusters the least k is known from the spectra: error equals their tail energies (Eq. 4). The number of clusters η is doubled
//! while bytes fall. What rounding adds is measured on what is decoded, and k gives way to it.

use crate::clusterer::Clusterer;
use crate::codec::Task;
use crate::encoded::EncodedSlf;
use crate::grouped::Grouped;
use crate::params::{Maps, Mode, SlfParams};
use crate::residual::weights;
use prt_cpca::Clusters;
use prt_transfer::{Encoded, Params, Result, linalg};
use rayon::prelude::*;

/// Most clusters that are tried.
const MOST_CLUSTERS: usize = 512;
/// Numbers of clusters are doubled until so many in turn take more bytes than the best.
const PATIENCE: usize = 2;
/// Eigenvalues of larger matrices are not computed while the number of clusters is looked for.
const MOST_EIGENVALUES: usize = 3000;
/// Most components for which clusters are refined by approximation error.
const MOST_REFINED: usize = 16;
/// Times that k gives way.
const ATTEMPTS: usize = 8;

/// Clusters, and what each number of components leaves of them.
struct Choice {
    grouped: Grouped,
    /// Σ over clusters and channels of the squared singular values from the `k`th on.
    tails: Vec<f64>,
    /// The least that leaves little enough.
    components: usize,
    bytes: f64,
}

impl Choice {
    /// The least k that leaves no more than `allowed`; all components where none does.
    fn least(&self, allowed: f64) -> usize {
        self.tails.iter().position(|tail| *tail <= allowed).unwrap_or(self.most())
    }

    fn most(&self) -> usize {
        self.tails.len() - 1
    }
}

/// The smallest light field whose decoded error is within `bound`.
pub(crate) fn bounded(task: &Task, clusterer: &mut Clusterer, bound: f64) -> Result<EncodedSlf> {
    let noise = if task.params.maps == Maps::Haar { task.params.noise } else { 0.0 };
    let allowed = bound * task.residual.energy / (1.0 + noise);
    let mut least = f64::INFINITY;
    if task.residual.square() <= allowed {
        // Means do: a matte surface.
        let whole = Grouped::whole(task.residual.fields(), task.residual.shape.samples);
        let encoded = task.stored(&task.fitted(&whole, 0)?);
        let (error, energy) = decoded_error(task, &encoded);
        if error <= bound * energy {
            return Ok(encoded);
        }
    }
    let choice = chosen(task, clusterer, allowed)?;
    let mut components = choice.components;
    for _ in 0..ATTEMPTS {
        let encoded = task.stored(&task.fitted(&choice.grouped, components)?);
        let (error, whole) = decoded_error(task, &encoded);
        if error <= bound * whole {
            return Ok(encoded);
        }
        least = least.min(error / whole);
        if components == choice.most() {
            break;
        }
        // What is there beside the tails, and a little more.
        let besides = (error / whole * task.residual.energy - choice.tails[components]).max(0.0);
        components = choice.least(allowed - 1.1 * besides).max(components + 1);
    }
    let least = format!("at least {least:e}, which storing components as asked for leaves");
    Err(SlfParams::refuse("max_error", bound, least))
}

/// Clusters and components before anything is rounded.
fn chosen(task: &Task, clusterer: &mut Clusterer, allowed: f64) -> Result<Choice> {
    let best = match task.params.clusters {
        Clusters::Number(number) => choice(task, clusterer.grouped(number, Mode::Static, 0)?, allowed)?,
        Clusters::Auto => number_of_clusters(task, clusterer, allowed)?,
    };
    if task.params.mode == Mode::Static {
        return Ok(best);
    }
    let (clusters, components) = (most(&best.grouped), best.components.clamp(1, MOST_REFINED));
    let refined = choice(task, clusterer.grouped(clusters, Mode::Iterative, components)?, allowed)?;
    Ok(if refined.bytes < best.bytes { refined } else { best })
}

/// η: doubled until it does not pay.
fn number_of_clusters(task: &Task, clusterer: &mut Clusterer, allowed: f64) -> Result<Choice> {
    let (texels, numbers) = (task.residual.shape.samples, task.residual.dimension());
    let (mut best, mut dearer) = (None::<Choice>, 0);
    for clusters in (0..=MOST_CLUSTERS.ilog2()).map(|power| 1usize << power) {
        if clusters > texels || dearer == PATIENCE {
            break;
        }
        if (texels / clusters).min(numbers) > MOST_EIGENVALUES {
            continue;
        }
        let grouped = clusterer.grouped(clusters, Mode::Static, 0)?;
        let distinct = most(&grouped);
        let found = choice(task, grouped, allowed)?;
        if best.as_ref().is_none_or(|best| found.bytes < best.bytes) {
            (best, dearer) = (Some(found), 0);
        } else {
            dearer += 1;
        }
        if distinct < clusters {
            break;
        }
    }
    match best {
        Some(best) => Ok(best),
        None => choice(task, clusterer.grouped(MOST_CLUSTERS.min(texels), Mode::Static, 0)?, allowed),
    }
}

/// η of clusters.
fn most(grouped: &Grouped) -> usize {
    grouped.fields.iter().map(|groups| groups.len()).max().unwrap_or(0)
}

/// The least k for given clusters, and the bytes that it takes (Eq. 5).
fn choice(task: &Task, grouped: Grouped, allowed: f64) -> Result<Choice> {
    let layout = grouped.layout(task.residual, task.params.colour, 0);
    let of = |part| linalg::eigenvalues(grouped.rows(task.residual, &layout, part).gram().view());
    let spectra: Vec<Vec<f64>> = grouped.parts(&layout).par_iter().map(of).collect::<Result<_>>()?;
    let rank = spectra.iter().map(Vec::len).max().unwrap_or(0);
    let mut tails = vec![0.0; rank + 1];
    for (j, square) in spectra.iter().flat_map(|squares| squares.iter().enumerate()) {
        tails[j] += square.max(0.0);
    }
    (0..rank).rev().for_each(|j| tails[j] += tails[j + 1]);
    let mut choice = Choice { grouped, tails, components: 0, bytes: 0.0 };
    choice.components = choice.least(allowed);
    let layout = choice.grouped.layout(task.residual, task.params.colour, choice.components);
    let of_surface = (layout.surface_numbers() + layout.shape.rows()) * task.params.surface.bytes();
    let of_views = layout.view_numbers() * task.params.views.bytes();
    let of_ids = choice.grouped.members.len() as f64 * (most(&choice.grouped).max(1) as f64).log2().ceil() / 8.0;
    choice.bytes = (of_surface + of_views) as f64 + of_ids;
    Ok(choice)
}

/// Σ w (T-T̃)² of what is decoded, and Σ w T².
fn decoded_error(task: &Task, encoded: &EncodedSlf) -> (f64, f64) {
    let (shape, weights) = (task.matrix.shape(), weights(task.matrix, task.params.norm));
    let of_row = |(decoded, exact): &mut (Vec<f32>, Vec<f32>), row: usize| {
        encoded.row_into(row, decoded);
        task.matrix.gather(row, exact);
        decoded.iter().zip(exact.iter()).enumerate().fold((0.0, 0.0), |(error, whole), (i, (d, e))| {
            let (w, d, e) = (weights.as_ref().map_or(1.0, |w| w[i]), f64::from(*d), f64::from(*e));
            (error + w * (d - e).powi(2), whole + w * e * e)
        })
    };
    let buffers = || (vec![0f32; shape.lights], vec![0f32; shape.lights]);
    // Sums do not depend on the number of threads: they are of rows, in their order.
    let sums: Vec<(f64, f64)> = (0..shape.rows()).into_par_iter().map_init(buffers, of_row).collect();
    sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
}
