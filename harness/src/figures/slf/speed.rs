//! Noise against time: pictures from fields and of paths.

use super::table1::camera;
use super::{WORLD, world};
use crate::charts::curves::{Curves, Dot, Plane};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::light_field::{Fields, Settings, made};
use crate::machine::Machine;
use crate::number::short;
use crate::table::aligned;
use prt_slf::Interpolation;
use prt_transfer::image::Image;
use prt_transfer::responses::Directions;
use prt_transfer::scene::camera::Camera;
use prt_transfer::scene::path::{self, PathParams, PathTracer};
use prt_transfer::scene::picture::Shot;
use prt_transfer::scene::world::World;
use std::path::Path;
use std::time::Instant;

pub(super) const FIGURE: Figure = Figure { name: "speed", table: None, draw };

/// Samples along the edge of a pixel.
const OF_FIELDS: [usize; 3] = [1, 2, 3];
const OF_PATHS: [usize; 5] = [1, 2, 4, 8, 16];

/// Two pictures of different seeds.
struct Pair {
    images: [Image; 2],
    coverage: Vec<f32>,
    /// Of one of them, s.
    seconds: f64,
}

struct Outcome {
    fields: bool,
    samples: usize,
    seconds: f64,
    noise: f64,
    /// Against the mean of the two pictures of most paths; none for those themselves.
    error: Option<f64>,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let (texels, side, paths) =
        if stage.is_paper_sized() { (128, 512, &OF_PATHS[..]) } else { (32, 192, &OF_PATHS[..4]) };
    let (world, folders) = (world()?, [tempfile::tempdir()?, tempfile::tempdir()?]);
    stage.steps.more(2 * world.objects().len() + OF_FIELDS.len() + paths.len());
    for (seed, folder) in folders.iter().enumerate() {
        trace(stage, &world, seed as u64, texels, folder.path())?;
    }
    let camera = camera(side)?;
    let of_paths = paths.iter().map(|&n| paths_at(stage, &world, &camera, n)).collect::<anyhow::Result<Vec<_>>>()?;
    let best = of_paths.last().map(|pair| mean(&pair.images));
    let mut outcomes = Vec::new();
    for (&n, pair) in paths.iter().zip(&of_paths) {
        let other = best.as_ref().filter(|_| n != paths[paths.len() - 1]);
        outcomes.push(Outcome { fields: false, ..outcome(n, pair, other)? });
    }
    for n in OF_FIELDS {
        let pair = fields_at(stage, &world, &camera, n, folders.each_ref().map(|f| f.path()))?;
        outcomes.push(Outcome { fields: true, ..outcome(n, &pair, best.as_ref())? });
    }
    Ok(Drawing {
        text: table(&outcomes),
        tables: vec![("", csv(&outcomes, &stage.machine)?)],
        chart: Some(chart(side, texels, &outcomes)),
        measured: true,
        ..Drawing::default()
    })
}

/// Fields of all shapes.
fn trace(stage: &Stage, world: &World, seed: u64, texels: usize, folder: &Path) -> anyhow::Result<()> {
    let tracer = PathTracer::new(world, PathParams { seed, ..PathParams::default() })?;
    for (object, of) in world.objects().iter().enumerate() {
        stage.steps.show(&format!("{}, seed {seed}", of.name));
        let mut settings = Settings::papers(of, [texels; 2]);
        settings.field.frame = Directions::Reflected;
        stage.bench.pools.everywhere(|| made(&tracer, object, &settings, stage.bench.registry, folder, &Unseen))?;
        stage.steps.done(1);
    }
    Ok(())
}

fn paths_at(stage: &Stage, world: &World, camera: &Camera, n: usize) -> anyhow::Result<Pair> {
    stage.steps.show(&format!("paths, {} a pixel", n * n));
    let (mut images, mut coverage, began) = (Vec::new(), Vec::new(), Instant::now());
    for seed in [0, 1] {
        let tracer = PathTracer::new(world, PathParams { seed, ..PathParams::default() })?;
        let image = || path::image(&tracer, camera, (n * n) as u32, |_| [0.0; 3], &Unseen);
        let traced = stage.bench.pools.everywhere(image)?;
        coverage = traced.coverage;
        images.push(traced.image);
    }
    pair(images, coverage, began.elapsed().as_secs_f64() / 2.0, stage)
}

fn fields_at(stage: &Stage, world: &World, camera: &Camera, n: usize, folders: [&Path; 2]) -> anyhow::Result<Pair> {
    stage.steps.show(&format!("fields, {} a pixel", n * n));
    let tracer = PathTracer::new(world, PathParams::default())?;
    let (mut images, mut coverage, mut seconds) = (Vec::new(), Vec::new(), 0.0);
    for folder in folders {
        let fields = Fields::read(folder, world, Interpolation::Bilinear)?;
        let shot = Shot { camera, samples: n, background: &|_| [0.0; 3] };
        let began = Instant::now();
        let (image, covered) = stage.bench.pools.everywhere(|| fields.picture(&tracer, &shot, &Unseen))?;
        seconds += 0.5 * began.elapsed().as_secs_f64();
        coverage = covered;
        images.push(image);
    }
    pair(images, coverage, seconds, stage)
}

fn pair(images: Vec<Image>, coverage: Vec<f32>, seconds: f64, stage: &Stage) -> anyhow::Result<Pair> {
    stage.steps.done(1);
    let images = <[Image; 2]>::try_from(images).map_err(|_| anyhow::anyhow!("two seeds make two pictures"))?;
    Ok(Pair { images, coverage, seconds })
}

/// Half of the squared difference is the variance of one.
fn outcome(n: usize, pair: &Pair, best: Option<&Image>) -> anyhow::Result<Outcome> {
    let [a, b] = &pair.images;
    let noise = 0.5 * a.relative_squared_error(b, &pair.coverage)?;
    let error = best.map(|best| a.relative_squared_error(best, &pair.coverage)).transpose()?;
    Ok(Outcome { fields: false, samples: n * n, seconds: pair.seconds, noise, error })
}

fn mean([a, b]: &[Image; 2]) -> Image {
    let mixed = a.pixels.iter().zip(&b.pixels).map(|(a, b)| std::array::from_fn(|c| 0.5 * (a[c] + b[c])));
    Image { width: a.width, height: a.height, pixels: mixed.collect() }
}

/// How many times as long paths take for the noise of a picture from fields, if their noise goes on falling with 1/samples.
fn ratio(outcomes: &[Outcome], fields: &Outcome) -> Option<f64> {
    let most = outcomes.iter().rfind(|o| !o.fields)?;
    Some(most.seconds * (most.noise / fields.noise) / fields.seconds)
}

fn chart(side: usize, texels: usize, outcomes: &[Outcome]) -> Curves {
    let curve = |fields: bool, figure: fn(&Outcome) -> Option<f64>| {
        let dot = |o: &Outcome| Dot { x: o.seconds, y: figure(o).unwrap_or(f64::NAN), label: o.samples.to_string() };
        outcomes.iter().filter(|o| o.fields == fields).map(dot).collect()
    };
    let plane = |upwards: &str, figure: fn(&Outcome) -> Option<f64>| Plane {
        upwards: upwards.into(),
        across: "seconds of the picture".into(),
        curves: vec![curve(true, figure), curve(false, figure)],
        references: Vec::new(),
    };
    Curves {
        title: "Pictures from surface light fields and of paths".into(),
        subject: format!("{WORLD} · {side} x {side} pixels · {texels} x {texels} texels a shape"),
        remark: Some("labels: samples a pixel".into()),
        names: vec!["fields".into(), "paths".into()],
        apart: true,
        planes: vec![
            plane("noise: variance / square", |o| Some(o.noise)),
            plane("error: against the most paths", |o| o.error),
        ],
    }
}

fn table(outcomes: &[Outcome]) -> String {
    let titles = ["picture", "samples", "seconds", "noise", "error", "paths for this noise"];
    let lines = outcomes.iter().map(|o| {
        let kind = if o.fields { "fields" } else { "paths" };
        let times = if o.fields { ratio(outcomes, o).map(|r| format!("{} times as long", short(r))) } else { None };
        let figures = [short(o.seconds), short(o.noise), o.error.map_or("-".into(), short)];
        let head = [kind.to_string(), o.samples.to_string()];
        head.into_iter().chain(figures).chain([times.unwrap_or_else(|| "-".into())]).collect()
    });
    format!("\nPictures: noise and time\n{}", aligned(&titles, lines))
}

fn csv(outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["picture", "samples", "seconds", "noise", "error", "machine"])?;
    for o in outcomes {
        writer.write_record([
            (if o.fields { "fields" } else { "paths" }).to_string(),
            o.samples.to_string(),
            o.seconds.to_string(),
            o.noise.to_string(),
            o.error.map(|e| e.to_string()).unwrap_or_default(),
            machine.line(),
        ])?;
    }
    Ok(writer.into_inner()?)
}
