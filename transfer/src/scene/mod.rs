//! Scenes, visibility and signals.

pub mod bvh;
pub mod directions;
mod edges;
mod exact;
mod grid;
pub mod ray;
mod scattered;
mod sweep;
pub mod visibility;
mod visibility_kernel;
#[cfg(test)]
mod visibility_tests;
