//! Clusters alone, for codecs that fit something else to them than affine subspaces.

use crate::codec::{check_count, sweeps_of};
use crate::engine::{Engine, Plan};
use crate::params::{Mode, Start};
use prt_transfer::groups::Groups;
use prt_transfer::samples::Samples;
use prt_transfer::{Progress, Result};

/// Which clusters are looked for; each as the parameter of the same name of [`crate::CpcaParams`].
#[derive(Clone, Copy, Debug)]
pub struct Grouping {
    /// How many, or as many as there are distinct samples.
    pub clusters: usize,
    /// Components of the subspaces that samples are told apart by, unless `mode` is static.
    pub components: usize,
    /// By distance to means or to subspaces.
    pub mode: Mode,
    /// At most; `None` = 20 (static) or 10 for each number of components.
    pub sweeps: Option<usize>,
    /// Where clusters start.
    pub start: Start,
    /// Of what is drawn.
    pub seed: u64,
}

/// Finds clusters of the same samples again and again: what bounds distances is computed once.
pub struct Grouper<'a> {
    engine: Engine<'a>,
    progress: &'a dyn Progress,
}

impl<'a> Grouper<'a> {
    /// For these samples.
    ///
    /// # Errors
    /// More than 2^32 - 1 of them.
    pub fn new(samples: Samples<'a>, progress: &'a dyn Progress) -> Result<Grouper<'a>> {
        check_count(&samples)?;
        Ok(Grouper { engine: Engine::new(samples, progress)?, progress })
    }

    /// Samples by cluster; a cluster may be empty.
    ///
    /// # Errors
    /// Where progress asks to stop.
    pub fn groups(&self, grouping: &Grouping) -> Result<Groups> {
        let Grouping { clusters, components, mode, sweeps, start, seed } = *grouping;
        let sweeps = sweeps_of(mode, sweeps);
        let plan = Plan { mode, sweeps, start, seed, ..Plan::new(clusters, components) };
        self.progress.start("cluster", plan.steps());
        Ok(self.engine.search(&plan)?.groups)
    }
}
