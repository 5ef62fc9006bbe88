//! `prt precompute`: the transfer matrix of a scene.

use crate::progress::Bar;
use crate::signal::{Signal, Spec};
use crate::{files, number, scenes, terminal};
use anyhow::bail;
use clap::Args;
use prt_transfer::LightBasis;
use prt_transfer::scene::repair::Repairs;
use std::path::PathBuf;

/// Arguments of `prt precompute`.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  prt precompute teapot --signal biscale -o teapot.npz\n  prt precompute bunny.ply --signal diffuse --basis sh:5 -o bunny.npy"
)]
pub struct Precompute {
    /// A built-in scene (`prt scenes` lists them) or a mesh (.ply, .obj)
    #[arg(value_name = "SCENE|MESH")]
    pub scene: String,
    /// What to compute
    #[arg(long)]
    pub signal: Signal,
    /// Light basis: cubemap:EDGE, or sh:ORDER for diffuse
    #[arg(long, default_value = "cubemap:32")]
    pub basis: LightBasis,
    /// Vertices of a built-in scene, about [default: the scene's own, see prt scenes]; a mesh keeps its own
    #[arg(long, value_name = "N", value_parser = count(1, 100_000_000))]
    pub vertices: Option<usize>,
    /// Visibility is sampled with 2^m x 2^m rays for each texel
    #[arg(long, value_name = "m", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=4))]
    pub supersampling: u32,
    /// Local directions of biscale: D x D over the hemisphere [default: 8]
    #[arg(long, value_name = "D", value_parser = count(1, 64))]
    pub local_directions: Option<usize>,
    /// Where to write the matrix: .npz or .mtx (sparse), .npy (dense)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Print shape, non-zeros, rays and seconds as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// A whole number within a range.
fn count(least: usize, most: usize) -> impl Fn(&str) -> Result<usize, String> + Clone {
    move |text| match text.parse() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(format!("expected a whole number from {least} to {most}")),
    }
}

/// Runs the command.
pub fn run(arguments: &Precompute) -> anyhow::Result<()> {
    let Precompute { scene, signal, basis, vertices, supersampling, local_directions, output, json } = arguments;
    if *signal == Signal::Diffuse && local_directions.is_some() {
        bail!("--local-directions belongs to --signal biscale; diffuse has one response for each vertex");
    }
    let usual = Spec::new(*signal, basis.clone());
    let local_directions = local_directions.unwrap_or(usual.local_directions);
    let spec = Spec { supersampling: *supersampling, local_directions, ..usual };
    let bar = Bar::default();
    let scenes::Precomputed { matrix, repairs, traced, seconds } = scenes::precompute(scene, *vertices, &spec, &bar)?;
    drop(bar);
    files::write_matrix(output, &matrix)?;
    let (shape, non_zeros) = (matrix.shape(), matrix.non_zeros());
    let rate = (traced.rays as f64 / traced.seconds.max(1e-9)) as u64;
    if *json {
        return terminal::say_json(&serde_json::json!({
            "samples": shape.samples, "responses": shape.responses, "lights": shape.lights,
            "non_zeros": non_zeros, "rays": traced.rays, "rays_per_second_and_core": rate, "repairs": repairs.to_string(),
            "seconds": seconds,
        }));
    }
    let (rows, lights, non_zeros) = (shape.rows(), shape.lights, number::count(non_zeros as u64));
    let (rays, rate, seconds) = (number::count(traced.rays), number::count(rate), number::short(seconds));
    if repairs != Repairs::default() {
        terminal::say(format!("mesh: {repairs}"))?;
    }
    terminal::say(format!(
        "{rows} x {lights}, {non_zeros} non-zeros, {rays} rays ({rate} rays/s a core), precomputed in {seconds} s"
    ))
}
