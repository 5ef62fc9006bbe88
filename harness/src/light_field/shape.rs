//! One shape: its field traced and compressed.

use super::compression::{Compression, compressed};
use prt_transfer::scene::light_field::{self, FieldParams};
use prt_transfer::scene::path::PathTracer;
use prt_transfer::scene::world::Object;
use prt_transfer::{Label, Progress, Registry, TransferMatrix};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// How a shape is sampled and compressed.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Texels, directions and paths.
    pub field: FieldParams,
    /// The method.
    pub method: Label,
}

/// Figures of a shape. The names are a promise to programs that read them.
#[derive(Clone, Debug, Serialize)]
pub struct Shape {
    /// Its name.
    pub shape: String,
    /// What became of its field.
    #[serde(flatten)]
    pub compression: Compression,
    /// Wall clock of tracing, s.
    pub trace_s: f64,
    /// Paths traced.
    pub paths: u64,
    /// Rays of them.
    pub rays: u64,
    /// Paths that were cut to the bound of `--clamp`.
    pub clamped: u64,
    /// Paths that brought no finite radiance and count as none.
    pub not_finite: u64,
    /// Texels beside the chart that hold what is at its rim.
    pub gutter_texels: usize,
    /// Texels that nothing looks up.
    pub unused_texels: usize,
}

/// Texels of a glossy shape for each of its clusters in Table 1.
const TEXELS_OF_CLUSTER: usize = 256;

impl Settings {
    /// The paper's directions, components and texels a cluster for matte and for glossy shapes (Table 1), in its directions of the world.
    pub fn papers(object: &Object, [width, height]: [usize; 2]) -> Settings {
        let base = FieldParams { width, height, ..FieldParams::default() };
        if !object.material.has_lobe() {
            let method = "slf:clusters=1:components=1".parse().expect("a label");
            return Settings { field: FieldParams { around: 32, down: 16, ..base }, method };
        }
        let clusters = (width * height).div_ceil(TEXELS_OF_CLUSTER);
        let label: Label = format!("slf:clusters={clusters}").parse().expect("a label");
        Settings { field: FieldParams { around: 64, down: 32, ..base }, method: label }
    }
}

/// Traces and compresses an object of the tracer's world into `folder`; its figures, and the field as it was traced.
pub fn made(
    tracer: &PathTracer,
    object: usize,
    settings: &Settings,
    registry: &Registry,
    folder: &Path,
    progress: &dyn Progress,
) -> anyhow::Result<(Shape, TransferMatrix)> {
    let name = &tracer.world().objects()[object].name;
    let began = Instant::now();
    let light_field::LightField { matrix, tally, gutter, unused } =
        light_field::light_field(tracer, object, &settings.field, progress)?;
    let trace_s = began.elapsed().as_secs_f64();
    let compression = compressed(&matrix, &settings.method, registry, &folder.join(format!("{name}.prt")), progress)?;
    let shape = Shape {
        shape: name.clone(),
        compression,
        trace_s,
        paths: tally.paths,
        rays: tally.rays,
        clamped: tally.clamped,
        not_finite: tally.not_finite,
        gutter_texels: gutter,
        unused_texels: unused,
    };
    Ok((shape, matrix))
}
