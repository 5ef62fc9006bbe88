//! The one place where the program learns of scenes.

use clap::ValueEnum;
use glam::Vec3;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::repair::{Repairs, repair};
use prt_transfer::scene::shapes;
use prt_transfer::{Error, Result, io};
use serde::Serialize;
use std::path::Path;

/// A built-in scene or light.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// Its name.
    pub name: &'static str,
    /// A sentence.
    pub about: &'static str,
}

/// Every built-in scene.
pub fn scenes() -> Vec<About> {
    shapes::all().iter().map(|s| About { name: s.name, about: s.about }).collect()
}

/// Which axis of a mesh file points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Up {
    /// The mesh is turned about x.
    Y,
    /// As everywhere here.
    #[default]
    Z,
}

/// The mesh of a built-in scene with about `vertices` vertices, or of a mesh file, which has its own; repaired: its
/// vertices are the samples of its matrices.
pub fn load(scene: &str, vertices: Option<usize>, up: Up) -> Result<(Mesh, Repairs)> {
    repair(mesh(scene, vertices, up)?).map_err(|e| e.in_file(scene))
}

/// A mesh file by its extension, or a built-in scene.
fn mesh(scene: &str, vertices: Option<usize>, up: Up) -> Result<Mesh> {
    let refuse = |what: &str, expected: &str, found: String| {
        Err(Error::Unsupported { what: format!("{what} of {scene}"), expected: expected.into(), found })
    };
    if Path::new(scene).extension().is_none() {
        let shape = shapes::find(scene)?;
        return match up {
            Up::Z => shape.build(vertices.unwrap_or(shape.default_vertices)),
            Up::Y => refuse("upward axis", "z, as of every built-in scene", "y".into()),
        };
    }
    if let Some(vertices) = vertices {
        return refuse("vertices", "its own, which a mesh file keeps", vertices.to_string());
    }
    Ok(upright(io::mesh::read(scene)?, up))
}

/// A mesh with the axis that points up in its file as z.
pub fn upright(mesh: Mesh, up: Up) -> Mesh {
    if up == Up::Y { mesh.turned(|v| Vec3::new(v.x, -v.z, v.y)) } else { mesh }
}
