//! Small worlds for the tests of the path tracer, and means of samples.

use glam::{DVec3, Vec3};
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::environment::Environment;
use prt_transfer::scene::material::Material;
use prt_transfer::scene::path::PathParams;
use prt_transfer::scene::world::{Object, World};

pub(crate) fn grey(label: &str) -> Material {
    Material::grey(label.parse().unwrap())
}

pub(crate) fn lamp(emission: Vec3) -> Material {
    Material { emission, ..grey("lambert:albedo=0") }
}

pub(crate) fn object(name: &str, mesh: Mesh, material: Material) -> Object {
    Object { name: name.into(), mesh, uv: Vec::new(), border: Default::default(), material }
}

/// A parallelogram, its front where `a` turns to `b` counter-clockwise.
pub(crate) fn plate(corner: Vec3, a: Vec3, b: Vec3) -> Mesh {
    Mesh {
        positions: vec![corner, corner + a, corner + a + b, corner + b],
        normals: Vec::new(),
        faces: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// The plane z = 0 from -half to half, seen from above.
pub(crate) fn floor(half: f32) -> Mesh {
    plate(Vec3::new(-half, -half, 0.0), 2.0 * half * Vec3::X, 2.0 * half * Vec3::Y)
}

/// Six walls of the cube from -1 to 1 that face inward.
pub(crate) fn cube_inside() -> Mesh {
    let mut cube = Mesh::default();
    for (a, b) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)] {
        for (a, b) in [(a, b), (b, a)] {
            let wall = plate(-a - b - a.cross(b), 2.0 * a, 2.0 * b);
            let first = cube.positions.len() as u32;
            cube.positions.extend(wall.positions);
            cube.faces.extend(wall.faces.iter().map(|face| face.map(|v| v + first)));
        }
    }
    cube
}

pub(crate) fn world(objects: Vec<Object>, sky: Option<Environment>) -> World {
    World::new(objects, sky).unwrap()
}

pub(crate) fn uniform_sky(radiance: f64) -> Environment {
    Environment::new(move |_| DVec3::splat(radiance), Vec::new())
}

pub(crate) fn bounces(bounces: usize) -> PathParams {
    PathParams { bounces, ..PathParams::default() }
}

/// The mean of `n` samples and its standard error, were they independent; the sequence does better.
pub(crate) fn mean(n: u32, mut sample: impl FnMut(u32) -> f64) -> (f64, f64) {
    let (sum, squares) = (0..n).map(&mut sample).fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
    let (n, mean) = (f64::from(n), sum / f64::from(n));
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

pub(crate) fn up(from: f32) -> Vec3 {
    Vec3::new(from.sin(), 0.0, from.cos())
}

#[track_caller]
pub(crate) fn agree(what: &str, (found, error): (f64, f64), expected: f64) {
    assert!(
        (found - expected).abs() <= 4.0 * error + 1e-5 * expected.abs(),
        "{what}: {found} ± {error}, not {expected}"
    );
}
