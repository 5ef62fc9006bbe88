//! All-frequency bi-scale radiance transfer by biclustering: Tables I and II, and what can be measured of Figure 6.

mod figure6;
mod quantity;
mod scenes;
mod tables;

use super::{Figure, Paper};
use crate::labels::{self, BASELINE};
use crate::signal::{Signal, Spec};
use prt_transfer::LightBasis;

/// Tables I and II, and Figure 6.
pub(super) const PAPER: Paper = Paper {
    name: "biclustering",
    source: "all-frequency bi-scale radiance transfer by biclustering",
    figures: &[
        Figure {
            name: "table1",
            table: Some("Table I: operations and storage of the test scenes"),
            draw: |stage| tables::draw(stage, &scenes::TABLE_1),
        },
        Figure {
            name: "table2",
            table: Some("Table II: the same of one model at three densities"),
            draw: |stage| tables::draw(stage, &scenes::TABLE_2),
        },
        figure6::FIGURE,
    ],
    is_full: true,
    scenes: &["bunny", "teapot", "armor", "chair", "temple", "bunny_12k", "bunny_35k"],
    notes: &[
        "Visibility in 8 x 8 local directions of 6 x 32 x 32 texels, 2 x 2 rays a texel. Meshes of the paper were not published.",
        "MFLOP, % FLOP: operations of relighting one channel, and of the sparse product's 2·nnz; MB, % dense, % compact: memory of relighting, indices",
        "included, as it is (10^6 bytes), of the dense matrix at 1 byte an element and of compact sparse rows, with which speedup compares too.",
    ],
};

fn spec() -> Spec {
    Spec::new(Signal::Biscale, LightBasis::Cubemap { resolution: 32 })
}

/// What is measured when nobody says otherwise.
const METHODS: [&str; 3] = ["bicluster", "runs", BASELINE];

/// The user's methods or the usual ones.
fn methods(stage: &super::stage::Stage) -> prt_transfer::Result<Vec<String>> {
    labels::with_baseline(stage.bench.registry, &stage.chosen.methods, &METHODS, BASELINE)
}

#[cfg(test)]
mod tests;
