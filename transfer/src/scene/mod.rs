//! Scenes, visibility and the signals that are computed from them.
//!
//! A [`shapes`] scene or a loaded mesh is [`repair`]ed and given [`frames`]; [`bvh::Occluders`] answer which
//! [`directions`] its points see ([`visibility`]). A [`brdf`] says how a surface scatters, and [`separable`] takes it
//! apart into functions of the view and of the light. [`mod@biscale`], [`mod@diffuse`], [`glossy`] and [`terms`] turn
//! that into transfer matrices, [`bounce`] lets light go on from point to point. [`lights`] relight them; [`shading`]
//! makes of their responses what a [`camera`]'s [`view`] shows, and [`mod@reference`] is what it should be. A [`world`] is
//! objects of a [`material`] each, some of which shine: [`path`] traces all orders of their light. A [`chart`] lays a surface
//! out in a square, with texels instead of vertices; [`mod@light_field`] is what leaves them in all directions.

pub mod biscale;
pub mod bounce;
pub mod brdf;
pub mod bvh;
pub mod camera;
pub mod chart;
pub mod dense;
pub mod diffuse;
pub mod directions;
mod edges;
pub mod environment;
mod exact;
pub mod frames;
pub mod glossy;
mod grid;
pub mod hemisphere;
pub mod light_field;
pub mod lights;
pub mod material;
pub mod moments;
pub mod path;
pub mod picture;
pub mod ray;
pub mod reference;
mod reflection;
pub mod repair;
pub mod resample;
mod room;
mod scattered;
pub mod separable;
pub mod shading;
pub mod shapes;
pub mod signal;
mod sky;
mod sweep;
pub mod terms;
pub mod view;
pub mod visibility;
mod visibility_kernel;
#[cfg(test)]
mod visibility_tests;
pub mod world;
pub mod worlds;
