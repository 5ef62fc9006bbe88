//! Built-in scenes: no file, no download, any density.
//!
//! | name | what it tests |
//! | --- | --- |
//! | `teapot` | smooth parts that nearly touch; the field's mascot |
//! | `cornell-box` | a room open on one side: flat walls, soft occlusion |
//! | `two-polygons` | one shadow on one plane, as in Sloan, Hall, Hart and Snyder 2003, figure 6 |
//! | `temple`, `chair` | flat walls and repeated columns or boards: the best case for biclustering |
//! | `bumpy-sphere`, `blob` | curved everywhere, no two rows alike: the worst case |

mod chair;
mod cornell;
pub(in crate::scene) mod flat;
mod lattice;
mod polygons;
mod radial;
mod teapot;
mod teapot_table;
mod temple;

use crate::error::{Error, Result};
use crate::mesh::Mesh;
pub use radial::sphere;

/// Most vertices that [`Scene::build`] is asked for.
pub const MAX_VERTICES: usize = 1 << 24;

/// A scene that is built in.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Its name, as in `prt bench --scene teapot`.
    pub name: &'static str,
    /// One sentence on what it is.
    pub about: &'static str,
    /// What of a compression method it shows.
    pub suits: &'static str,
    /// Vertices that a first look should ask for.
    pub default_vertices: usize,
    /// Every edge belongs to two faces: nothing is open, so that the volume is that of the solid.
    pub closed: bool,
    /// The mesh with about `steps` segments along its longest way; its vertices grow as steps².
    tessellate: fn(usize) -> Mesh,
}

/// Every built-in scene.
pub fn all() -> &'static [Scene] {
    &SCENES
}

/// The scene of this name.
pub fn find(name: &str) -> Result<&'static Scene> {
    SCENES.iter().find(|s| s.name == name).ok_or_else(|| Error::Unknown {
        what: "scene",
        name: name.into(),
        known: SCENES.map(|s| s.name).join(", "),
    })
}

impl Scene {
    /// The tessellation whose number of vertices is closest to `vertices`: within a fifth from 500 vertices on, within a
    /// tenth from 10,000 on; the coarsest there is where that has more. The mesh is z up, centred on the origin, and
    /// its longest side runs from -1 to 1; normals are unit, hard edges have split vertices, and
    /// [`crate::scene::repair::repair`] finds nothing to do.
    ///
    /// # Errors
    /// More than [`MAX_VERTICES`].
    pub fn build(&self, vertices: usize) -> Result<Mesh> {
        if vertices > MAX_VERTICES {
            return Err(Error::TooLarge {
                what: format!("vertices of scene {}", self.name),
                limit: MAX_VERTICES as u64,
                found: vertices as u64,
            });
        }
        // Bracket the target between a tessellation below it and one above, then bisect. The first guess comes from
        // vertices ∝ steps², so that a few meshes are built, and only about as large as the one wanted.
        let mut below = (1, (self.tessellate)(1));
        let distance = |mesh: &Mesh| mesh.positions.len().abs_diff(vertices);
        let larger = |steps: usize, mesh: &Mesh| {
            let growth = (vertices as f64 / mesh.positions.len() as f64).sqrt();
            ((steps as f64 * growth) as usize + 1).clamp(2 * steps, 16 * steps)
        };
        while below.1.positions.len() < vertices {
            let steps = larger(below.0, &below.1);
            let mut above = (steps, (self.tessellate)(steps));
            if above.1.positions.len() < vertices {
                below = above;
                continue;
            }
            while above.0 - below.0 > 1 {
                let steps = below.0.midpoint(above.0);
                let middle = (steps, (self.tessellate)(steps));
                if middle.1.positions.len() < vertices { below = middle } else { above = middle }
            }
            let closest = if distance(&above.1) < distance(&below.1) { above.1 } else { below.1 };
            return Ok(closest.fitted());
        }
        Ok(below.1.fitted())
    }
}

const SCENES: [Scene; 7] = [
    Scene {
        name: "teapot",
        about: "Utah teapot, Martin Newell 1975, from its 32 bicubic Bézier patches",
        suits: "smooth surfaces with cavities; the default",
        default_vertices: 2_500,
        closed: false,
        tessellate: teapot::tessellate,
    },
    Scene {
        name: "cornell-box",
        about: "Cornell box from the measurements published with it (1985), open to the front",
        suits: "flat walls in soft shadow: rows that vary slowly over each wall",
        default_vertices: 2_500,
        closed: false,
        tessellate: cornell::tessellate,
    },
    Scene {
        name: "two-polygons",
        about: "one square that shadows another, after figure 6 of Sloan et al. 2003",
        suits: "a single moving shadow edge: how a method spends clusters",
        default_vertices: 2_500,
        closed: false,
        tessellate: polygons::tessellate,
    },
    Scene {
        name: "temple",
        about: "Greek temple: stepped base, a row of columns around a cella, gabled roof",
        suits: "flat walls and repeated columns: the best case for biclustering",
        default_vertices: 8_000,
        closed: true,
        tessellate: temple::tessellate,
    },
    Scene {
        name: "chair",
        about: "chair of flat boards",
        suits: "flat boards that shadow each other: a good case for biclustering",
        default_vertices: 3_000,
        closed: true,
        tessellate: chair::tessellate,
    },
    Scene {
        name: "bumpy-sphere",
        about: "sphere with rounded bumps",
        suits: "curved everywhere, no two normals alike: a bad case for biclustering",
        default_vertices: 2_500,
        closed: true,
        tessellate: radial::bumpy_sphere,
    },
    Scene {
        name: "blob",
        about: "rabbit-like blob with two long ears",
        suits: "curved, with deep shadows between the ears: the worst case for biclustering",
        default_vertices: 2_500,
        closed: true,
        tessellate: radial::blob,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::repair::{Repairs, repair};
    use glam::Vec3;
    use std::collections::HashMap;

    #[test]
    fn every_scene_comes_close_to_the_vertices_it_is_asked_for() {
        for scene in all() {
            let least = scene.build(0).unwrap().positions.len();
            for (vertices, tolerance) in [(500, 0.2), (1500, 0.2), (4000, 0.2), (10_000, 0.1), (23_456, 0.1)] {
                let found = scene.build(vertices).unwrap().positions.len();
                let off = found.abs_diff(vertices) as f64 / vertices as f64;
                assert!(
                    off <= tolerance || (least > vertices && found == least),
                    "{}: {found} for {vertices}",
                    scene.name
                );
            }
            assert!(scene.default_vertices > least, "{}: {least}", scene.name);
            assert!(scene.build(MAX_VERTICES + 1).is_err());
        }
    }

    #[test]
    fn no_tessellation_between_is_closer() {
        for scene in all() {
            let [mesh, next] = [12, 13].map(|steps| (scene.tessellate)(steps).positions.len());
            assert!(mesh < next, "{}: {mesh} {next}", scene.name);
            assert_eq!(scene.build(mesh).unwrap().positions.len(), mesh, "{}", scene.name);
            assert_eq!(scene.build(mesh + (next - mesh) / 3).unwrap().positions.len(), mesh, "{}", scene.name);
        }
    }

    #[test]
    fn repair_has_nothing_to_do() {
        for scene in all() {
            for vertices in [0, 700, 5000] {
                let mesh = scene.build(vertices).unwrap();
                let (repaired, repairs) = repair(mesh.clone()).unwrap();
                assert_eq!(repairs, Repairs::default(), "{}: {repairs}", scene.name);
                assert!(repaired == mesh, "{}", scene.name);
            }
        }
    }

    #[test]
    fn meshes_are_centred_and_fill_the_unit_cube() {
        for scene in all() {
            let (low, high) = scene.build(1000).unwrap().bounds().unwrap();
            assert!((low + high).length() < 1e-5 && (high.max_element() - 1.0).abs() < 1e-5, "{}", scene.name);
        }
    }

    /// How often each edge, told by its positions and in the order of its face, occurs.
    fn edges(mesh: &Mesh) -> HashMap<[[u32; 3]; 2], usize> {
        let place = |v: u32| (mesh.positions[v as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut edges = HashMap::new();
        for &[a, b, c] in &mesh.faces {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                *edges.entry([place(a), place(b)]).or_default() += 1;
            }
        }
        edges
    }

    #[test]
    fn closed_scenes_are_watertight_and_face_outward_at_every_density() {
        for scene in all().iter().filter(|s| s.closed) {
            for vertices in [0, 1000, 9000] {
                let mesh = scene.build(vertices).unwrap();
                let edges = edges(&mesh);
                for ([a, b], &count) in edges.iter().map(|(edge, count)| (*edge, count)) {
                    assert_ne!(a, b);
                    assert_eq!((count, edges.get(&[b, a]).copied()), (1, Some(1)), "{}: {a:?} {b:?}", scene.name);
                }
                assert!(mesh.volume() > 0.1, "{}: {}", scene.name, mesh.volume());
            }
        }
    }

    #[test]
    fn no_edge_belongs_to_more_than_two_faces() {
        for scene in all() {
            assert!(edges(&scene.build(3000).unwrap()).values().all(|&n| n == 1), "{}", scene.name);
        }
    }

    #[test]
    fn normals_are_unit_and_on_the_side_of_their_faces() {
        for scene in all() {
            let mesh = scene.build(3000).unwrap();
            assert!(mesh.normals.iter().all(|n| n.is_normalized()));
            for &face in &mesh.faces {
                let normal = mesh.area_vector(face).normalize();
                let least =
                    face.map(|v| normal.dot(mesh.normals[v as usize].as_dvec3())).into_iter().fold(1.0, f64::min);
                assert!(least > 0.2, "{}: {least} at {:?}", scene.name, mesh.corners(face));
            }
        }
    }

    #[test]
    fn scenes_are_found_by_name_and_unknown_names_list_them() {
        for scene in all() {
            assert_eq!(find(scene.name).unwrap().name, scene.name);
        }
        assert!(find("dragon").unwrap_err().to_string().contains("teapot, cornell-box"));
    }

    #[test]
    fn building_twice_gives_the_same_bits() {
        for scene in all() {
            assert!(scene.build(1234).unwrap() == scene.build(1234).unwrap(), "{}", scene.name);
        }
    }
}
