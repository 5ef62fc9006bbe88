//! A compressed light field before it is stored.

use crate::layout::Layout;

/// Maps in single precision.
pub(crate) struct Model {
    pub(crate) layout: Layout,
    /// The cluster of each texel in each field.
    pub(crate) members: Vec<u32>,
    /// μ of each row.
    pub(crate) means: Vec<f32>,
    /// U, as the layout says.
    pub(crate) surface: Vec<f32>,
    /// V of every cluster, as the layout says.
    pub(crate) views: Vec<f32>,
    /// Squared length of each component, where directions count as their weights.
    pub(crate) vector: f64,
    /// Σ(T-T̃)² that is left.
    pub(crate) left: f64,
    /// ΣT².
    pub(crate) energy: f64,
}
