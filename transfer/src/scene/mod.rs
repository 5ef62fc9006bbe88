//! Scenes, visibility and the signals that are computed from them.
//!
//! A [`shapes`] scene or a loaded mesh is [`repair`]ed and given [`frames`]; [`bvh::Occluders`] answer which [`directions`] its
//! points see ([`visibility`]); [`mod@biscale`] and [`mod@diffuse`] turn that into transfer matrices. [`lights`] relight them.
//! A [`brdf`] says how a surface scatters, and [`separable`] takes it apart into functions of the view and of the light.

pub mod biscale;
pub mod bounce;
pub mod brdf;
pub mod bvh;
pub mod dense;
pub mod diffuse;
pub mod directions;
mod edges;
pub mod environment;
mod exact;
pub mod frames;
mod grid;
pub mod hemisphere;
pub mod lights;
pub mod moments;
pub mod ray;
pub mod repair;
pub mod resample;
mod room;
mod scattered;
pub mod separable;
pub mod shapes;
pub mod signal;
mod sky;
mod sweep;
pub mod visibility;
mod visibility_kernel;
#[cfg(test)]
mod visibility_tests;
