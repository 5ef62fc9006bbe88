//! From a matrix to clusters: the three modes of the paper, and the smallest model within a bound.

use crate::allocate::{Prices, down_to, price, within};
use crate::head::Head;
use crate::params::{Allocation, Mode, Start};
use crate::spectra::{Spectrum, spectra};
use crate::sweeps::{Search, State};
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Progress, Result};

/// What the search is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) clusters: usize,
    pub(crate) components: usize,
    pub(crate) mode: Mode,
    pub(crate) sweeps: usize,
    pub(crate) start: Start,
    pub(crate) seed: u64,
    pub(crate) allocation: Allocation,
    /// Of stored numbers: of one weight, and of one vector.
    pub(crate) bytes: (usize, usize),
}

/// Who belongs together, and how many components each cluster has.
pub(crate) struct Clustering {
    pub(crate) groups: Groups,
    pub(crate) components: Vec<usize>,
}

/// A clustering that keeps a bound.
pub(crate) struct Bargain {
    pub(crate) clustering: Clustering,
    /// Error that its spectra leave.
    pub(crate) left: f64,
    /// Of everything that is stored.
    pub(crate) bytes: f64,
    /// Weights of all samples.
    pub(crate) weights: usize,
}

impl Plan {
    fn prices(&self, allocation: Allocation) -> Prices {
        Prices::of(allocation, self.bytes.0, self.bytes.1)
    }

    /// Sweeps at most.
    pub(crate) fn steps(&self) -> u64 {
        let of_components = match self.mode {
            Mode::Static => 0,
            Mode::Iterative => self.components,
            Mode::Adaptive => self.components + 1,
        };
        (self.sweeps * (1 + of_components)) as u64
    }
}

/// What an allocation leaves.
fn tails(spectra: &[Spectrum], components: &[usize]) -> f64 {
    spectra.iter().zip(components).map(|(s, c)| s.tail(*c)).sum()
}

/// Clusters of samples.
pub(crate) struct Engine<'a> {
    samples: Samples<'a>,
    head: Head,
    progress: &'a dyn Progress,
}

impl<'a> Engine<'a> {
    /// Samples that lie in few dimensions are looked at in those: distances change by no more than [`crate::head::NULL`] says.
    pub(crate) fn new(samples: Samples<'a>, progress: &'a dyn Progress) -> Result<Engine<'a>> {
        let (samples, head) = Head::of(&samples)?.alone(samples);
        Ok(Engine { samples, head, progress })
    }

    /// Clusters and components as planned.
    pub(crate) fn search(&self, plan: &Plan) -> Result<Clustering> {
        let mut state = self.begin(plan)?;
        let mut components = vec![plan.components; state.subspaces.len()];
        if plan.mode != Mode::Static {
            self.introduce(&mut state, plan)?;
        }
        if plan.mode == Mode::Adaptive {
            let prices = plan.prices(plan.allocation);
            components = self.adapt(&mut state, plan.sweeps, |spectra| {
                let even = spectra.iter().map(|s| plan.components as f64 * prices.component(s.members)).sum();
                let components = within(spectra, prices, even);
                (tails(spectra, &components), components)
            })?;
        }
        Ok(Clustering { groups: self.groups(&state), components })
    }

    /// As [`Engine::search`], with the cheapest components that leave no more than `error`.
    pub(crate) fn search_down_to(&self, plan: &Plan, error: f64) -> Result<Bargain> {
        let mut state = self.begin(plan)?;
        let mut best = self.bargain(self.groups(&state), plan, error)?;
        let mut compare = |found: Bargain| {
            if found.bytes < best.bytes {
                best = found;
            }
        };
        if plan.mode != Mode::Static {
            self.introduce(&mut state, plan)?;
            compare(self.bargain(self.groups(&state), plan, error)?);
        }
        if plan.mode == Mode::Adaptive {
            let prices = plan.prices(Allocation::Bytes);
            self.adapt(&mut state, plan.sweeps, |spectra| {
                let components = down_to(spectra, prices, error);
                (price(spectra, &components, prices), components)
            })?;
            compare(self.bargain(self.groups(&state), plan, error)?);
        }
        Ok(best)
    }

    /// The cheapest components of given clusters that leave no more than `error`.
    pub(crate) fn bargain(&self, groups: Groups, plan: &Plan, error: f64) -> Result<Bargain> {
        let prices = plan.prices(Allocation::Bytes);
        let spectra = spectra(&self.samples, &groups)?;
        let components = down_to(&spectra, prices, error);
        let ids = self.samples.count() as f64 * (groups.len() as f64).log2().ceil() / 8.0;
        let bytes = price(&spectra, &components, prices) + ids;
        let weights = spectra.iter().zip(&components).map(|(s, c)| s.members * c).sum();
        Ok(Bargain {
            left: tails(&spectra, &components),
            bytes,
            weights,
            clustering: Clustering { groups, components },
        })
    }

    /// LBG: clusters by distance to their means.
    fn begin(&self, plan: &Plan) -> Result<State> {
        let search = self.sweeper();
        let means = search.start(plan.clusters, plan.start, plan.seed)?;
        let clusters = means.len();
        let mut state = search.begin(means)?;
        search.sweeps(&mut state, &vec![0; clusters], plan.sweeps - 1)?;
        Ok(state)
    }

    /// Components one by one, with sweeps by approximation error for each number (paper §4.2).
    fn introduce(&self, state: &mut State, plan: &Plan) -> Result<()> {
        for components in 1..=plan.components {
            self.sweeper().sweeps(state, &vec![components; state.subspaces.len()], plan.sweeps)?;
        }
        Ok(())
    }

    /// Sweeps with components as `allocate` gives them, with what is to be least (paper §4.3); the best of them.
    fn adapt(
        &self,
        state: &mut State,
        sweeps: usize,
        allocate: impl Fn(&[Spectrum]) -> (f64, Vec<usize>),
    ) -> Result<Vec<usize>> {
        let (mut least, mut best) = allocate(&spectra(&self.samples, &self.groups(state))?);
        let (mut kept, mut components) = (state.clone(), best.clone());
        for _ in 0..sweeps {
            if self.sweeper().sweep(state, &components)? == 0 {
                break;
            }
            let score;
            (score, components) = allocate(&spectra(&self.samples, &self.groups(state))?);
            if score < least {
                (least, best, kept) = (score, components.clone(), state.clone());
            }
        }
        *state = kept;
        Ok(best)
    }

    fn groups(&self, state: &State) -> Groups {
        Groups::of(&state.assignment.members, state.subspaces.len())
    }

    fn sweeper(&self) -> Search<'_> {
        Search { samples: &self.samples, head: &self.head, progress: self.progress }
    }
}
