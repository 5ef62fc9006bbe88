//! Scenes, visibility and the signals that are computed from them.
//!
//! A [`shapes`] scene or a loaded mesh is [`repair`]ed and given [`frames`]; [`bvh::Occluders`] answer which [`directions`] its
//! points see ([`visibility`]); [`mod@biscale`] and [`mod@diffuse`] turn that into transfer matrices. [`lights`] relight them;
//! a [`camera`]'s [`view`] shows radiance at the vertices, and [`mod@reference`] what it should be.

pub mod biscale;
pub mod bvh;
pub mod camera;
pub mod diffuse;
pub mod directions;
mod edges;
pub mod environment;
mod exact;
pub mod frames;
mod grid;
pub mod hemisphere;
pub mod lights;
pub mod ray;
pub mod reference;
pub mod repair;
pub mod resample;
mod room;
mod scattered;
pub mod shapes;
pub mod signal;
mod sky;
mod sweep;
pub mod view;
pub mod visibility;
mod visibility_kernel;
#[cfg(test)]
mod visibility_tests;
