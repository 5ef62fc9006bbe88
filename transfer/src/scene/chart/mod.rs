//! Charts of surfaces and the texels on them: where each texel's centre lies on a surface (Miandji et al. 2011, section 3.1).
//!
//! A [`Charted`] mesh is read from a file or one of the [`shapes`], whose texels have equal areas but for those of the
//! distorted sphere. [`sphere`] is the map of the square onto all directions that spheres are charted by.

mod gutter;
mod places;
pub mod shapes;
pub mod sphere;
mod triangle;

pub use crate::chart::Charted;
pub use places::{Place, Places};
