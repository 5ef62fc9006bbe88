//! Scenes, visibility and signals.

pub mod environment;
pub mod frames;
pub mod lights;
pub mod repair;
pub mod resample;
mod room;
pub mod shapes;
mod sky;
