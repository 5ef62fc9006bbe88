//! The three phases of clustered tensor approximation (Tsai and Shih 2006, §5.2).

mod assign;
mod basis;
mod elbg;
mod lines;
mod phases;
mod products;
mod shared;
mod slabs;

pub(crate) use basis::Ranks;
pub(crate) use shared::MOST_ROWS;
pub(crate) use slabs::Slabs;

use crate::params::Start;
use crate::tucker;
use basis::Basis;
use ndarray::Array2;
use phases::{Search, alone};
use prt_transfer::{Progress, Result};
use shared::Shared;

/// What the search is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) clusters: usize,
    pub(crate) view: usize,
    pub(crate) ranks: Ranks,
    /// Clusters of each sample.
    pub(crate) members: usize,
    pub(crate) sweeps: usize,
    pub(crate) refine: usize,
    pub(crate) start: Start,
    pub(crate) seed: u64,
}

/// A sweep of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Which phase it belongs to.
    pub phase: Phase,
    /// Rank of the samples in it.
    pub rank: usize,
    /// Relative squared error behind it, in the coordinates of the phase.
    pub error: f64,
    /// Samples that it moved to another cluster.
    pub moved: usize,
}

/// A phase of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Samples move to the cluster that keeps most of them (§5.2.3), in the light coordinates that hold nearly everything.
    Clustering,
    /// Bases are fitted to the clusters, the view basis too (§5.2.4).
    Approximation,
    /// Samples move into several clusters.
    Sharing,
}

/// What the search found, in the coordinates of the samples.
pub(crate) struct Found {
    /// U_viewᵀ: R_view x responses.
    pub(crate) view: Array2<f32>,
    pub(crate) bases: Vec<Basis>,
    /// Clusters of each sample.
    pub(crate) memberships: usize,
    /// The clusters of each sample, sample after sample.
    pub(crate) members: Vec<u32>,
    /// For each membership the weights of the cluster.
    pub(crate) weights: Vec<Vec<f32>>,
    /// Squared error, and the square of all samples.
    pub(crate) square: f64,
    pub(crate) whole: f64,
    pub(crate) history: Vec<Sweep>,
    /// Whether all phases ended by themselves.
    pub(crate) converged: bool,
}

/// Light coordinates of the clustering phase may leave out this part of the energy.
const LEFT_OUT: f64 = 2e-3;
/// Samples that decide on those coordinates.
const DECIDING: usize = 4096;

/// Bases and clusters for a tensor of samples x responses x lights.
pub(crate) fn search(tensor: &Slabs, plan: &Plan, progress: &dyn Progress) -> Result<Found> {
    progress.start("tensor approximation", (2 + plan.sweeps + 2 * plan.refine) as u64);
    let whole: f64 = tensor.squares().iter().sum();
    let view = first_view(tensor, plan.view)?;
    let reduced = tensor.in_views(view.view());
    let head = light_head(&reduced, progress)?;
    let mut search = Search { plan, progress, whole, history: Vec::new(), converged: true };
    let mut state = match &head {
        Some(head) => search.clustered(&reduced.with_lights(head.view()))?,
        None => search.clustered(&reduced)?,
    };
    if let Some(head) = &head {
        state.bases.iter_mut().for_each(|basis| basis.light = products::times(basis.light.view(), head.view()));
    }
    let (view, reduced) = search.approximated(tensor, reduced, view, &mut state)?;
    let shared = if plan.members > 1 && state.bases.len() > 1 {
        search.shared(&reduced, state)?
    } else {
        alone(&reduced, state)
    };
    let Search { history, converged, .. } = search;
    let Shared { bases, memberships, members, weights, kept } = shared;
    let square = (whole - kept).max(0.0);
    Ok(Found { view, bases, memberships, members, weights, square, whole, history, converged })
}

/// U_viewᵀ with all other bases the identity (Eq. 14); the identity itself where the rank is not below the number of responses.
fn first_view(tensor: &Slabs, rank: usize) -> Result<Array2<f32>> {
    if rank >= tensor.views {
        return Ok(Array2::eye(tensor.views));
    }
    Ok(products::leading_of_gram(&tensor.gram_of_views(), rank)?.single())
}

/// Light coordinates (a row each) that hold nearly all of some of the samples; `None` where they would hardly be fewer.
fn light_head(slabs: &Slabs, progress: &dyn Progress) -> Result<Option<Array2<f32>>> {
    let head = tucker::leading_rows(slabs.some(DECIDING).by_light(), LEFT_OUT, progress)?;
    let fewer = head.filter(|head| 4 * head.nrows() <= 3 * slabs.lights);
    Ok(fewer.map(|head| head.mapv(|v| v as f32)))
}
