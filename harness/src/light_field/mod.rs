//! `prt slf`: the surface light field of each shape of a world, traced and compressed.

mod arguments;
mod compression;
mod csv;
mod fields;
mod shape;
mod table;

use crate::progress::Bar;
use crate::registry::registry;
use crate::worlds::{self, Look, Needs};
use crate::{cache, machine::Machine, terminal};
use crate::{files, interrupt};
use anyhow::{bail, ensure};
use arguments::of_shape;
pub use arguments::{LightField, LookArguments, Paths};
pub use compression::{Compression, Counts, as_slf, compressed};
pub use csv::of as csv_of;
pub use fields::{Field, Fields};
use prt_transfer::responses::Directions;
use prt_transfer::scene::light_field::{FieldParams, places};
use prt_transfer::scene::path::PathTracer;
use prt_transfer::scene::world::{Object, World};
pub use shape::{Settings, Shape, made};

impl LookArguments {
    /// As [`worlds::load`] takes it.
    pub fn look(&self) -> Look<'_> {
        Look { light: self.light.as_deref(), brdf: self.brdf.as_ref(), up: self.up }
    }
}

/// Runs the command.
pub fn run(arguments: &LightField, threads: usize) -> anyhow::Result<()> {
    let world = worlds::load(&arguments.scene, arguments.look.look(), Needs::Charts)?;
    let chosen = chosen(arguments, &world)?;
    let registry = registry();
    // All of them before the first path, so that a mistake in the last is told at once.
    let settings =
        chosen.iter().map(|&i| arguments.settings(&world.objects()[i])).collect::<anyhow::Result<Vec<_>>>()?;
    for (&object, settings) in chosen.iter().zip(&settings) {
        places(&world.objects()[object], &settings.field)?;
        registry.method(&settings.method)?;
    }
    let folder = cache::make(arguments.output.clone())?;
    let tracer = PathTracer::new(&world, arguments.paths.params())?;
    let bar = Bar::default();
    let mut shapes = Vec::new();
    let names: Vec<&str> = chosen.iter().map(|&i| world.objects()[i].name.as_str()).collect();
    for (&object, settings) in chosen.iter().zip(&settings) {
        let keep = arguments.keep.then(|| folder.join(format!("{}.npy", world.objects()[object].name)));
        let made = made(&tracer, object, settings, &registry, &folder, &bar);
        let (shape, matrix) = interrupt::keeping(made, || interrupt::parts(&names, shapes.len(), "shapes", &folder))?;
        if let Some(path) = keep {
            files::write_matrix(&path, &matrix)?;
        }
        shapes.push(shape);
    }
    drop(bar);
    let machine = Machine::here(threads);
    files::write_beside(&folder.join("shapes.csv"), &csv::of(&shapes, &machine)?)?;
    if arguments.json {
        return terminal::say_json(&serde_json::json!({ "shapes": shapes, "machine": machine }));
    }
    terminal::say(table::of(&shapes))?;
    terminal::say(format!("\nprt render {} --slf {} -o picture.png draws it", arguments.scene, folder.display()))
}

/// The shapes that are asked for, all of them where none is.
fn chosen(arguments: &LightField, world: &World) -> anyhow::Result<Vec<usize>> {
    let names: Vec<&str> = world.objects().iter().map(|o| o.name.as_str()).collect();
    let all_named = [
        arguments.shapes.iter().map(String::as_str).collect::<Vec<_>>(),
        arguments.texels.iter().filter_map(|p| p.shape.as_deref()).collect(),
        arguments.directions.iter().filter_map(|p| p.shape.as_deref()).collect(),
        arguments.method.iter().filter_map(|p| p.shape.as_deref()).collect(),
    ];
    if let Some(unknown) = all_named.iter().flatten().find(|name| !names.contains(name)) {
        bail!("there is no shape {unknown} in {}: it has {}", arguments.scene, names.join(", "));
    }
    let wanted = |name: &&str| arguments.shapes.is_empty() || arguments.shapes.iter().any(|s| s == name);
    let chosen: Vec<usize> = (0..names.len()).filter(|&i| wanted(&names[i])).collect();
    ensure!(!chosen.is_empty(), "{} has no shape", arguments.scene);
    Ok(chosen)
}

impl LightField {
    /// What is asked for an object: as in the paper, where nobody says otherwise; but directions of its lobe are reflected, and as important as
    /// they are large.
    fn settings(&self, object: &Object) -> anyhow::Result<Settings> {
        let [width, height] =
            *of_shape(&self.texels, &object.name).unwrap_or(if self.paper { &[256; 2] } else { &[128; 2] });
        let papers = Settings::papers(object, [width, height]);
        let [around, down] =
            *of_shape(&self.directions, &object.name).unwrap_or(&[papers.field.around, papers.field.down]);
        let field = FieldParams {
            width,
            height,
            around,
            down,
            supersampling: self.supersampling,
            filter: self.filter,
            diffuse: self.diffuse_paths,
            horizon: self.horizon,
            frame: self.frame.unwrap_or(if self.paper { Directions::World } else { Directions::Reflected }),
        };
        let method = match of_shape(&self.method, &object.name) {
            Some(method) => method.parse()?,
            None if self.paper || !object.material.has_lobe() => papers.method,
            None => format!("{}:norm=radiance", papers.method).parse()?,
        };
        Ok(Settings { field, method })
    }
}
