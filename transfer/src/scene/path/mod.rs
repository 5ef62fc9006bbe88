//! Path tracing: all orders of light in a [`World`], without bias.
//!
//! The radiance that a point x reflects towards v is L = ∫ ρ(v, s) L_in(x, s) (n·s) dω_s (Kajiya, "The Rendering Equation", 1986). At every
//! point of a path it is estimated twice: with a direction towards a light, drawn from all that shines (`lights`), and with a direction
//! drawn from the BRDF (`scattering`), which also is where the path goes on. The power heuristic weighs the two (Veach and Guibas,
//! "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995). Numbers come from a scrambled Sobol sequence
//! (`sequence`); the same key and index give the same sample.
//!
//! What is not physical: origins of rays are lifted off the surface ([`Occluders::offset`]), and with interpolated normals light above a
//! face but below the horizon of its normal is lost.
//!
//! [`World`]: super::world::World
//! [`Occluders::offset`]: super::bvh::Occluders::offset

mod choice;
mod image;
mod lights;
mod params;
mod scattering;
mod sequence;
mod sky;
mod tally;
#[cfg(test)]
mod tests;
mod tracer;
mod triangles;

pub use image::{MAX_SAMPLES, Traced, image};
pub use params::PathParams;
pub use tally::Tally;
pub use tracer::PathTracer;
