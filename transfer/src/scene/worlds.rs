//! Built-in worlds to trace paths in: shapes with charts, materials and lights.
//!
//! `cornell-spheres` is the scene of Miandji, Kronander and Unger (2011, Figure 3 and Table 1), as far as it can be told from its picture: a
//! matte Cornell box whose left wall has a fine texture and two triangles only, a matte torus, and two spheres with lobes of roughness 0.02, one
//! of them distorted.

use super::chart::Charted;
use super::chart::shapes::{distorted_sphere, rectangle, sphere, torus};
use super::material::{Material, Texture};
use super::world::{Object, World};
use crate::error::{Error, Result};
use glam::{DVec3, Vec2, Vec3};

/// A world that is built in.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name, as in `prt slf cornell-spheres`.
    pub name: &'static str,
    /// One sentence on what it is.
    pub about: &'static str,
    /// Where one stands to see it, and what one looks at.
    pub view: [Vec3; 2],
    build: fn() -> Result<World>,
}

static WORLDS: [BuiltIn; 2] = [
    BuiltIn {
        name: "cornell-spheres",
        about: "Cornell box with a textured wall, a torus and two glossy spheres, one distorted (Miandji et al. 2011)",
        view: [Vec3::new(0.0, -4.0, 0.0), Vec3::ZERO],
        build: cornell_spheres,
    },
    BuiltIn {
        name: "glossy-sphere",
        about: "a metal sphere of roughness 0.1 on a matte floor under a small lamp: the smallest world with a lobe",
        view: [Vec3::new(0.0, -3.0, 0.9), Vec3::new(0.0, 0.0, -0.1)],
        build: glossy_sphere,
    },
];

/// Every built-in world.
pub fn all() -> &'static [BuiltIn] {
    &WORLDS
}

/// The world of this name, if there is one.
///
/// # Errors
/// No world of this name.
pub fn find(name: &str) -> Result<&'static BuiltIn> {
    let known = || WORLDS.iter().map(|w| w.name).collect::<Vec<_>>().join(", ");
    WORLDS.iter().find(|w| w.name == name).ok_or_else(|| Error::Unknown {
        what: "world",
        name: name.into(),
        known: known(),
    })
}

impl BuiltIn {
    /// The world itself. It is z up, open towards -y.
    ///
    /// # Errors
    /// None that a test has not seen: what is built in is valid.
    pub fn build(&self) -> Result<World> {
        (self.build)()
    }
}

/// Segments of a sphere around its square, and of the torus along its ring and around its tube.
const ROUND: usize = 96;
const RING: [usize; 2] = [160, 64];

fn matte(colour: Vec3) -> Result<Material> {
    Ok(Material { diffuse: Texture::Uniform(colour), ..Material::grey("lambert".parse()?) })
}

fn glossy(colour: Vec3, brdf: &str) -> Result<Material> {
    Ok(Material { diffuse: Texture::Uniform(colour), specular: colour, ..Material::grey(brdf.parse()?) })
}

fn object(name: &str, charted: Charted, material: Material) -> Object {
    let Charted { mesh, uv, border } = charted;
    Object { name: name.into(), mesh, uv, border, material }
}

/// A quadrilateral of a single cell, counter-clockwise seen from its front.
fn wall(name: &str, corners: [[f64; 3]; 4], material: Material) -> Result<Object> {
    Ok(object(name, rectangle(corners.map(DVec3::from), 1)?, material))
}

fn cornell_spheres() -> Result<World> {
    const WHITE: Vec3 = Vec3::new(0.74, 0.73, 0.70);
    const GREEN: Vec3 = Vec3::new(0.16, 0.45, 0.14);
    let textured = Material { diffuse: Texture::Pattern(tiles), ..matte(WHITE)? };
    let lamp = Material { emission: Vec3::new(17.0, 14.0, 10.0), ..matte(Vec3::ZERO)? };
    let metal = "cook-torrance:roughness=0.02:f0=0.9:diffuse=0.15:specular=0.85";
    let (blue, pink) = (Vec3::new(0.28, 0.45, 0.95), Vec3::new(0.95, 0.45, 0.60));
    let (a, b) = (-1.0, 1.0);
    let l = 0.3;
    let objects = vec![
        wall("floor", [[a, a, a], [b, a, a], [b, b, a], [a, b, a]], matte(WHITE)?)?,
        wall("ceiling", [[a, a, b], [a, b, b], [b, b, b], [b, a, b]], matte(WHITE)?)?,
        wall("back-wall", [[a, b, a], [b, b, a], [b, b, b], [a, b, b]], matte(WHITE)?)?,
        wall("left-wall", [[a, a, a], [a, b, a], [a, b, b], [a, a, b]], textured)?,
        wall("right-wall", [[b, b, a], [b, a, a], [b, a, b], [b, b, b]], matte(GREEN)?)?,
        wall("lamp", [[-l, -l, 0.98], [-l, l, 0.98], [l, l, 0.98], [l, -l, 0.98]], lamp)?,
        object(
            "torus",
            torus(DVec3::new(0.05, -0.25, -0.86), DVec3::Z, 0.34, 0.14, RING),
            matte(Vec3::new(0.75, 0.55, 0.2))?,
        ),
        object("blue-sphere", sphere(DVec3::new(-0.45, 0.3, -0.58), 0.42, ROUND), glossy(blue, metal)?),
        object("pink-sphere", distorted_sphere(DVec3::new(0.5, 0.35, -0.52), 0.42, 0.12, ROUND), glossy(pink, metal)?),
    ];
    World::new(objects, None)
}

fn glossy_sphere() -> Result<World> {
    let lamp = Material { emission: Vec3::splat(30.0), ..matte(Vec3::ZERO)? };
    let metal = glossy(Vec3::new(0.9, 0.75, 0.5), "cook-torrance:roughness=0.1:f0=0.9:diffuse=0.1:specular=0.9")?;
    let objects = vec![
        wall(
            "floor",
            [[-2.0, -2.0, -0.5], [2.0, -2.0, -0.5], [2.0, 2.0, -0.5], [-2.0, 2.0, -0.5]],
            matte(Vec3::splat(0.6))?,
        )?,
        wall("lamp", [[0.6, -0.9, 1.5], [0.6, -0.3, 1.5], [1.2, -0.3, 1.5], [1.2, -0.9, 1.5]], lamp)?,
        object("sphere", sphere(DVec3::ZERO, 0.5, ROUND), metal),
    ];
    World::new(objects, None)
}

/// Tiles with rings in them, eight along each side of the wall.
fn tiles(uv: Vec2) -> Vec3 {
    const COLOURS: [Vec3; 3] = [Vec3::new(0.75, 0.30, 0.18), Vec3::new(0.80, 0.72, 0.55), Vec3::new(0.20, 0.22, 0.35)];
    let cell = (8.0 * uv).floor();
    let radius = (8.0 * uv - cell - 0.5).length();
    let odd = (cell.x + cell.y) as i64 & 1;
    match radius {
        r if (0.26..0.40).contains(&r) => COLOURS[2],
        _ => COLOURS[odd as usize],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_world_is_built_and_has_a_light_and_charts() {
        for built_in in all() {
            let world = find(built_in.name).unwrap().build().unwrap();
            let lights = world.objects().iter().filter(|o| o.material.emission != Vec3::ZERO).count();
            assert!(lights == 1 && world.objects().iter().all(|o| o.uv.len() == o.mesh.positions.len()));
        }
        assert!(find("nowhere").is_err_and(|e| e.to_string().contains("cornell-spheres")));
    }

    #[test]
    fn the_walls_of_the_box_face_into_it_and_nothing_sticks_out() {
        let world = find("cornell-spheres").unwrap().build().unwrap();
        for object in &world.objects()[..5] {
            let inward = |&face: &[u32; 3]| -object.mesh.corners(face)[0].dot(object.mesh.area_vector(face));
            assert!(object.mesh.faces.iter().all(|face| inward(face) > 0.0), "{}", object.name);
        }
        let (low, high) = world.mesh().bounds().unwrap();
        assert!(low.min_element() >= -1.0 && high.max_element() <= 1.0, "{low} {high}");
    }
}
