//! Tsai and Shih 2006: what lobes are worth, for lights (Figure 4) and for transfer.

mod bandwidth;
pub(super) mod figure4;
mod lights;
mod restored;

use super::Paper;

/// The paper.
pub(super) const PAPER: Paper = Paper {
    name: "srbf",
    source: "Tsai and Shih 2006: lobes alone; its tables are those of tensor",
    figures: &[lights::FIGURE, bandwidth::FIGURE],
    is_full: false,
    scenes: &[],
    notes: &[
        "lights: numbers kept of a cubemap of 32 x 32 texels a face: 6 for each lobe; 3 for each Haar coefficient (the same ones in R, G and B;",
        "where they stand is not counted, as in the paper) and for each harmonic. Errors are weighted by solid angle, R, G and B together.",
        "bandwidth: 642 lobes on a subdivided icosahedron. The paper's coefficients (lobes) and orthonormal coordinates, as f32 and as f16.",
    ],
};
