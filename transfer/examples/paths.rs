//! Paths and rays per second of the path tracer: a glossy teapot in a diffuse room under a lamp, then under the sky.
//!
//!     cargo run --release -p prt-transfer --features scene --example paths -- [VERTICES] [SAMPLES]

// A program may print.
#![allow(clippy::print_stdout)]

use glam::Vec3;
use prt_transfer::Quiet;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::camera::{Camera, Film};
use prt_transfer::scene::material::{Material, Texture};
use prt_transfer::scene::path::{PathParams, PathTracer, image};
use prt_transfer::scene::world::{Object, World};
use prt_transfer::scene::{lights, shapes};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<usize> = std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    let number = |place: usize, otherwise| arguments.get(place).copied().unwrap_or(otherwise);
    let (vertices, samples) = (number(0, 20_000), number(1, 64) as u32);
    for light in ["lamp", "sky"] {
        let world = world(vertices, light)?;
        let tracer = PathTracer::new(&world, PathParams { bounces: 8, ..PathParams::default() })?;
        let film = Film { width: 160, height: 120, field_of_view: 40.0 };
        let camera = Camera::looking(Vec3::new(0.0, -3.2, 0.4), Vec3::ZERO, film)?;
        let start = Instant::now();
        let traced = image(&tracer, &camera, samples, |_| [0.0; 3], &Quiet)?;
        let seconds = start.elapsed().as_secs_f64();
        let (paths, rays) = (traced.tally.paths as f64, traced.tally.rays as f64);
        println!(
            "{light}: {:.2} M paths/s, {:.2} M rays/s on {} threads, {:.1} rays a path, mean {:.4}",
            paths / seconds / 1e6,
            rays / seconds / 1e6,
            rayon::current_num_threads(),
            rays / paths,
            traced.image.pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / traced.image.pixels.len() as f64
        );
    }
    Ok(())
}

fn world(vertices: usize, light: &str) -> Result<World, Box<dyn Error>> {
    let grey = |label: &str| -> Result<Material, prt_transfer::Error> { Ok(Material::grey(label.parse()?)) };
    let object = |name: &str, mesh, material| Object {
        name: name.into(),
        mesh,
        uv: Vec::new(),
        border: Default::default(),
        material,
    };
    let gold = Material {
        diffuse: Texture::Uniform(Vec3::new(0.8, 0.4, 0.1)),
        ..grey("cook-torrance:roughness=0.2:diffuse=0.5:specular=0.5")?
    };
    let mut teapot = shapes::find("teapot")?.build(vertices)?;
    teapot.positions.iter_mut().for_each(|p| *p = 0.6 * *p - 0.2 * Vec3::Z);
    let mut objects = vec![
        object("room", shapes::find("cornell-box")?.build(vertices)?, grey("lambert:albedo=0.7")?),
        object("teapot", teapot, gold),
    ];
    if light == "sky" {
        return Ok(World::new(objects, Some(lights::find("sky")?.environment()))?);
    }
    let positions = [[-0.3, -0.3], [-0.3, 0.3], [0.3, 0.3], [0.3, -0.3]].map(|[x, y]| Vec3::new(x, y, 0.9)).into();
    let lamp = Mesh { positions, normals: Vec::new(), faces: vec![[0, 1, 2], [0, 2, 3]] };
    objects.push(object("lamp", lamp, Material { emission: Vec3::splat(10.0), ..grey("lambert:albedo=0")? }));
    Ok(World::new(objects, None)?)
}
