//! Miandji, Kronander and Unger 2011: surface light fields by clustered principal components.

mod bytes;
mod seams;
mod speed;
mod table1;
mod table1_layout;

use super::Paper;
use super::stage::Stage;
use crate::interrupt::Unseen;
use anyhow::Context;
use prt_transfer::TransferMatrix;
use prt_transfer::scene::light_field::{FieldParams, light_field};
use prt_transfer::scene::path::{PathParams, PathTracer};
use prt_transfer::scene::world::World;
use prt_transfer::scene::worlds;

/// Table 1, and what stands behind it.
pub(super) const PAPER: Paper = Paper {
    name: "slf",
    source: "Miandji et al. 2011: surface light fields",
    figures: &[table1::FIGURE, bytes::FIGURE, seams::FIGURE, speed::FIGURE],
    is_full: false,
    scenes: &[],
    notes: &[
        "cornell-spheres stands in for the paper's scene, of which a picture and a table were published: a matte Cornell box with one textured wall,",
        "a torus, and two spheres of roughness 0.02, one distorted. The paper traced photons and gathered, here paths are traced; it timed on a quad-",
        "core Xeon, here all threads are used. Errors are squared errors over the sphere (by solid angle) as parts of the square of the field.",
        "table1: Eq. 5 is the ratio of all numbers of F to those that are stored, whatever their width.",
        "bytes: matte shapes are charted with a dark horizon, the paper's; with a continued one, the default, a matte field is one number a texel.",
        "A textured wall is flat: in every direction the same times its texture, one component, and so exact to rounding but for rounded maps.",
        "seams: second differences of radiance along the texture, root mean square over directions, across borders of clusters and inside of them.",
        "speed: noise is half of the squared difference of two pictures of different seeds, relative to the picture's square.",
    ],
};

/// Where all of it is measured.
const WORLD: &str = "cornell-spheres";

fn world() -> anyhow::Result<World> {
    Ok(worlds::find(WORLD)?.build()?)
}

/// The field of a shape by its name.
fn field(stage: &Stage, world: &World, shape: &str, params: &FieldParams, seed: u64) -> anyhow::Result<TransferMatrix> {
    stage.steps.show(&format!("tracing {shape}"));
    let tracer = PathTracer::new(world, PathParams { seed, ..PathParams::default() })?;
    let object = world.objects().iter().position(|o| o.name == shape).context("a shape of the world")?;
    let traced = stage.bench.pools.everywhere(|| light_field(&tracer, object, params, &Unseen))?;
    stage.steps.done(1);
    Ok(traced.matrix)
}
