//! Texels into clusters by their residuals.

use crate::grouped::Grouped;
use crate::params::{Mode, SlfParams};
use crate::residual::Residual;
use prt_cpca::{Grouper, Grouping};
use prt_transfer::{Progress, Result};

/// Finds clusters of one light field, as often as it is asked to.
pub(crate) struct Clusterer<'a> {
    params: &'a SlfParams,
    residual: &'a Residual,
    progress: &'a dyn Progress,
    /// Of each field; made when they are first needed.
    groupers: Vec<Grouper<'a>>,
}

impl<'a> Clusterer<'a> {
    pub(crate) fn new(params: &'a SlfParams, residual: &'a Residual, progress: &'a dyn Progress) -> Clusterer<'a> {
        Clusterer { params, residual, progress, groupers: Vec::new() }
    }

    /// So many clusters in each field, or as many as there are distinct texels.
    pub(crate) fn grouped(&mut self, clusters: usize, mode: Mode, components: usize) -> Result<Grouped> {
        let (fields, texels) = (self.residual.fields(), self.residual.shape.samples);
        if self.residual.dimension() == 0 || texels == 0 || clusters == 1 {
            return Ok(Grouped::whole(fields, texels));
        }
        if self.groupers.is_empty() {
            let of = |field| Grouper::new(self.residual.samples(field), self.progress);
            self.groupers = (0..fields).map(of).collect::<Result<_>>()?;
        }
        let SlfParams { sweeps, start, seed, .. } = *self.params;
        let mode = match mode {
            Mode::Static => prt_cpca::Mode::Static,
            Mode::Iterative => prt_cpca::Mode::Iterative,
        };
        let grouping = Grouping { clusters, components, mode, sweeps, start, seed };
        Ok(Grouped::of(self.groupers.iter().map(|g| g.groups(&grouping)).collect::<Result<_>>()?, texels))
    }
}
