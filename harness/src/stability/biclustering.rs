//! Where biclusters, runs and narrow integers fail: many values, no pattern, nothing to share.

use super::study::Study;
use super::{columns, scatter, values, vertices};
use crate::signal::{Signal, Spec};
use prt_transfer::LightBasis;

pub(super) const STUDY: Study = Study {
    name: "biclustering",
    methods: &["csr", "compact", "runs", "bicluster"],
    scene: "blob",
    spec: || Spec::new(Signal::Biscale, LightBasis::Cubemap { resolution: 32 }),
    sweeps: &[values::SWEEP, scatter::SWEEP, vertices::SWEEP, columns::SWEEP],
};
