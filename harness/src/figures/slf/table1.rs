//! Table 1: parameters and times of each shape, and of pictures of the scene.

use super::table1_layout::{csv, of_pictures, of_shapes};
use super::{WORLD, world};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::light_field::{Fields, Settings, Shape, made};
use prt_slf::Interpolation;
use prt_transfer::image::{Picture, Tone};
use prt_transfer::params::Value;
use prt_transfer::responses::Directions;
use prt_transfer::scene::camera::{Camera, Film};
use prt_transfer::scene::path::{self, PathParams, PathTracer};
use prt_transfer::scene::{picture, worlds};
use std::path::Path;
use std::time::Instant;

pub(super) const FIGURE: Figure =
    Figure { name: "table1", table: Some("Table 1: sizes and times of each shape, and of pictures"), draw };

/// A line of the paper's table.
pub(super) struct Line {
    pub(super) shape: &'static str,
    /// X, Y, Z and W.
    pub(super) sizes: [usize; 4],
    pub(super) components: usize,
    pub(super) clusters: usize,
    /// Minutes of generating data, seconds of compressing.
    pub(super) minutes: f64,
    pub(super) encode_s: f64,
    /// What stands in for it here.
    pub(super) ours: &'static [&'static str],
}

pub(super) static LINES: [Line; 4] = [
    Line {
        shape: "Walls (average)",
        sizes: [256, 256, 32, 16],
        components: 1,
        clusters: 1,
        minutes: 144.0,
        encode_s: 1.7,
        ours: &["floor", "ceiling", "back-wall", "left-wall", "right-wall", "lamp"],
    },
    Line {
        shape: "Torus",
        sizes: [256, 256, 32, 16],
        components: 1,
        clusters: 1,
        minutes: 58.0,
        encode_s: 1.7,
        ours: &["torus"],
    },
    Line {
        shape: "Blue sphere",
        sizes: [256, 256, 64, 32],
        components: 8,
        clusters: 256,
        minutes: 946.0,
        encode_s: 1440.0,
        ours: &["blue-sphere"],
    },
    Line {
        shape: "Pink sphere",
        sizes: [256, 256, 64, 32],
        components: 8,
        clusters: 256,
        minutes: 832.0,
        encode_s: 1620.0,
        ours: &["pink-sphere"],
    },
];

/// The paper's pictures: seconds from the fields on its processors, minutes of the reference.
pub(super) const PAPERS_PICTURES: [f64; 2] = [16.7, 202.0];

/// Pictures of our own.
pub(super) struct Pictures {
    /// Pixels along a side.
    pub(super) side: usize,
    /// Samples along an edge of a pixel, from fields and of paths.
    pub(super) samples: [usize; 2],
    /// Of paths, s.
    pub(super) paths_s: f64,
    /// By frame.
    pub(super) of_fields: Vec<OfFields>,
}

/// A picture from fields against that of paths.
pub(super) struct OfFields {
    pub(super) frame: Directions,
    pub(super) seconds: f64,
    /// Relative squared error.
    pub(super) error: f64,
    /// In dB.
    pub(super) psnr: f64,
}

/// Texels along a side, pixels along a side, samples along the edge of a pixel of both pictures.
struct Size {
    texels: usize,
    side: usize,
    samples: [usize; 2],
}

const PAPERS: Size = Size { texels: 256, side: 1024, samples: [3, 16] };
const SMALL: Size = Size { texels: 48, side: 256, samples: [3, 4] };

/// The paper's directions, and those in which glossy shapes compress further.
const FRAMES: [Directions; 2] = [Directions::World, Directions::Reflected];

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let size = if stage.is_paper_sized() { PAPERS } else { SMALL };
    let (world, folders) = (world()?, [tempfile::tempdir()?, tempfile::tempdir()?]);
    let tracer = PathTracer::new(&world, PathParams::default())?;
    stage.steps.more(2 * world.objects().len() + 3);
    let mut shapes = Vec::new();
    for (frame, folder) in FRAMES.into_iter().zip(&folders) {
        for (object, of) in world.objects().iter().enumerate() {
            if frame == Directions::World || of.material.has_lobe() {
                shapes.push((frame, shape(stage, &tracer, object, (frame, &size), folder.path())?));
            } else {
                // A matte shape has the same field in both.
                let [from, to] = [&folders[0], folder].map(|f| f.path().join(format!("{}.prt", of.name)));
                std::fs::copy(from, to)?;
            }
            stage.steps.done(1);
        }
    }
    let (pictures, shown) = pictures(stage, &tracer, folders.each_ref().map(|f| f.path()), &size)?;
    Ok(Drawing {
        beside: vec![of_shapes(&shapes), of_pictures(&pictures)],
        tables: vec![("", csv(&shapes, &stage.machine)?)],
        pictures: vec![("-pictures", shown)],
        ..Drawing::default()
    })
}

fn shape(
    stage: &Stage,
    tracer: &PathTracer,
    object: usize,
    (frame, size): (Directions, &Size),
    folder: &Path,
) -> anyhow::Result<Shape> {
    let of = &tracer.world().objects()[object];
    let mut settings = Settings::papers(of, [size.texels; 2]);
    settings.field.frame = frame;
    stage.steps.show(&format!("{}, directions {}", of.name, frame.show()));
    let made = stage.bench.pools.everywhere(|| made(tracer, object, &settings, stage.bench.registry, folder, &Unseen));
    Ok(made?.0)
}

/// Figures of the pictures, and the pictures side by side: from each frame's fields with its error, and of paths.
fn pictures(
    stage: &Stage,
    tracer: &PathTracer,
    folders: [&Path; 2],
    size: &Size,
) -> anyhow::Result<(Pictures, Picture)> {
    let (camera, pools) = (camera(size.side)?, &stage.bench.pools);
    stage.steps.show("picture of paths");
    let began = Instant::now();
    let samples = (size.samples[1] * size.samples[1]) as u32;
    let path::Traced { image: traced, coverage, .. } =
        pools.everywhere(|| path::image(tracer, &camera, samples, |_| [0.0; 3], &Unseen))?;
    let paths_s = began.elapsed().as_secs_f64();
    stage.steps.done(1);
    let stops = traced.automatic_exposure(&coverage)?;
    let (mut of_fields, mut shown) = (Vec::new(), vec![traced.develop(stops, Tone::Clip)]);
    for (frame, folder) in FRAMES.into_iter().zip(folders) {
        stage.steps.show("picture from the fields");
        let fields = Fields::read(folder, tracer.world(), Interpolation::Bilinear)?;
        let look = picture::Shot { camera: &camera, samples: size.samples[0], background: &|_| [0.0; 3] };
        let began = Instant::now();
        let (image, _) = pools.everywhere(|| fields.picture(tracer, &look, &Unseen))?;
        let seconds = began.elapsed().as_secs_f64();
        stage.steps.done(1);
        let error = image.relative_squared_error(&traced, &coverage)?;
        let psnr = image.psnr(&traced, &coverage, stops, Tone::Clip)?;
        of_fields.push(OfFields { frame, seconds, error, psnr });
        shown.extend([image.develop(stops, Tone::Clip), image.error_map(&traced, &coverage, stops)?]);
    }
    let pictures = Pictures { side: size.side, samples: size.samples, paths_s, of_fields };
    Ok((pictures, Picture::beside(&shown)))
}

/// The world's own view.
pub(super) fn camera(side: usize) -> prt_transfer::Result<Camera> {
    let [eye, target] = worlds::find(WORLD)?.view;
    Camera::looking(eye, target, Film { width: side, height: side, field_of_view: 40.0 })
}
