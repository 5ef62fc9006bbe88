//! The one place where the program learns of worlds: shapes with charts and materials to trace paths in.

use crate::lights;
use crate::scenes::{self, Up};
use anyhow::{bail, ensure};
use glam::{DVec3, Vec3};
use prt_transfer::Result;
use prt_transfer::chart::Charted;
use prt_transfer::io::mesh::read_charted;
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::environment::Environment;
use prt_transfer::scene::lights as environments;
use prt_transfer::scene::material::Material;
use prt_transfer::scene::world::{Object, World};
use prt_transfer::scene::worlds;
use prt_transfer::texels::Border;
use std::path::Path;

/// What lights a mesh and how it reflects; a built-in world has its own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Look<'a> {
    /// A built-in light or a lat-long image.
    pub light: Option<&'a str>,
    /// The reflectance.
    pub brdf: Option<&'a Brdf>,
    /// The axis of a mesh file that points up.
    pub up: Up,
}

/// What a mesh file must bring along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Texture coordinates.
    Charts,
    /// Nothing but triangles.
    Nothing,
}

/// The light of a mesh where nobody says otherwise.
pub const LIGHT: &str = "sky";

/// Every built-in world.
pub fn built_in() -> Vec<scenes::About> {
    worlds::all().iter().map(|w| scenes::About { name: w.name, about: w.about }).collect()
}

/// Whether a scene is a built-in world.
pub fn is_built_in(scene: &str) -> bool {
    worlds::find(scene).is_ok()
}

/// Where one stands to see a built-in world, and what one looks at.
pub fn view(scene: &str) -> Option<[Vec3; 2]> {
    worlds::find(scene).ok().map(|world| world.view)
}

/// A built-in world; or a mesh under a distant light, a built-in scene too where no texture coordinates are needed.
pub fn load(scene: &str, look: Look, needs: Needs) -> anyhow::Result<World> {
    let is_file = Path::new(scene).extension().is_some();
    if is_file || (needs == Needs::Nothing && !is_built_in(scene)) {
        return mesh(scene, look, needs);
    }
    let world = worlds::find(scene)?;
    if look.light.is_some() || look.brdf.is_some() || look.up != Up::Z {
        bail!("--light, --brdf and --up belong to a mesh: {scene} has its own lights and materials");
    }
    Ok(world.build()?)
}

fn mesh(scene: &str, Look { light, brdf, up }: Look, needs: Needs) -> anyhow::Result<World> {
    let (mesh, uv, border) = match needs {
        Needs::Charts => {
            let Charted { mesh, uv, border } = read_charted(scene)?;
            (scenes::upright(mesh, up), uv, border)
        }
        Needs::Nothing => (scenes::load(scene, None, up)?.0, Vec::new(), Border::default()),
    };
    let brdf = brdf.cloned().map_or_else(|| "lambert:albedo=0.7".parse(), Ok)?;
    let name = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    ensure!(!name.is_empty(), "{scene} has no name");
    let object = Object { name, mesh, uv, border, material: Material::grey(brdf) };
    Ok(World::new(vec![object], Some(sky(light.unwrap_or(LIGHT))?))?)
}

/// A distant light to trace paths to.
fn sky(name: &str) -> Result<Environment> {
    if Path::new(name).extension().is_none() {
        return Ok(environments::find(name)?.environment());
    }
    let backdrop = lights::backdrop(name)?;
    Ok(Environment::new(move |d: DVec3| DVec3::from(backdrop(d.to_array()).map(f64::from)), Vec::new()))
}
