//! Light that surfaces send to each other: nothing is lost, nothing comes from nowhere.
#![cfg(feature = "scene")]

use prt_transfer::mesh::Mesh;
use prt_transfer::scene::bounce::{Arrival, Bounced, Interreflecting, interreflect};
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::dense::DenseSignal;
use prt_transfer::scene::diffuse::Diffuse;
use prt_transfer::scene::frames;
use prt_transfer::scene::shapes;
use prt_transfer::scene::signal::{Samples, Sampling, Surface, Visible};
use prt_transfer::{LightBasis, Quiet, ResponseBasis, Result, TransferMatrix};
use std::f64::consts::PI;

const GATHER: Sampling = Sampling { resolution: 32, supersampling: 0 };
const CONSTANT: LightBasis = LightBasis::SphericalHarmonics { order: 1 };

fn bounced(mesh: &Mesh, signal: &dyn Interreflecting, bounces: usize) -> Bounced {
    let (occluders, frames) = (Occluders::new(mesh).unwrap(), frames::vertex_frames(mesh).unwrap());
    let surface = Surface { occluders: &occluders, points: &mesh.positions, frames: &frames };
    interreflect(signal, &surface, mesh, &GATHER, bounces, &Quiet).unwrap()
}

/// A closed scene seen from the other side.
fn turned_inside_out(mesh: Mesh) -> Mesh {
    let normals = mesh.normals.iter().map(|n| -n).collect();
    Mesh { normals, faces: mesh.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..mesh }
}

/// Surfaces that all send out the same radiance, 1, and reflect as `Diffuse` does.
struct Glowing(Diffuse);

impl DenseSignal for Glowing {
    fn basis(&self) -> LightBasis {
        self.0.basis()
    }
    fn responses(&self) -> ResponseBasis {
        self.0.responses()
    }
    fn samples(&self) -> &Samples {
        self.0.samples()
    }
    fn rows_into(&self, _: &Surface, _: usize, _: &Visible, out: &mut [f32]) -> Result<()> {
        out.fill(PI as f32);
        Ok(())
    }
}

impl Interreflecting for Glowing {
    fn bounce_into(&self, s: &Surface, point: usize, a: &[Arrival], leaving: &[f32], out: &mut [f32]) -> Result<()> {
        self.0.bounce_into(s, point, a, leaving, out)
    }
}

fn diffuse(albedo: f64) -> Diffuse {
    Diffuse::new(&Sampling { resolution: 32, supersampling: 0 }, &CONSTANT).unwrap().with_albedo(albedo).unwrap()
}

/// Irradiance of every vertex under light of radiance 1 from everywhere.
fn irradiance(matrix: &TransferMatrix) -> Vec<f64> {
    let constant = (4.0 * PI).sqrt();
    matrix.as_dense().unwrap().iter().map(|&t| constant * f64::from(t)).collect()
}

#[test]
fn a_closed_white_furnace_keeps_its_energy() {
    let mesh = turned_inside_out(shapes::find("bumpy-sphere").unwrap().build(500).unwrap());
    for (albedo, bounces) in [(1.0, 3), (0.5, 3)] {
        let found = bounced(&mesh, &Glowing(diffuse(albedo)), bounces);
        for (bounce, energy) in found.energies.iter().enumerate() {
            let expected = found.energies[0] * f64::powi(albedo, 2 * bounce as i32);
            assert!((energy / expected - 1.0).abs() < 4e-3, "bounce {bounce}: {energy} {expected}");
        }
        // Not only in the mean: every vertex has π, and albedo times it, and so on.
        let expected: f64 = (0..=bounces as i32).map(|b| PI * f64::powi(albedo, b)).sum();
        for (vertex, &total) in found.matrix.as_dense().unwrap().iter().enumerate() {
            assert!((f64::from(total) / expected - 1.0).abs() < 8e-3, "vertex {vertex}: {total} {expected}");
        }
    }
}

#[test]
fn under_light_from_everywhere_a_white_scene_becomes_invisible_geometrically() {
    let mesh = shapes::find("blob").unwrap().build(600).unwrap();
    let worst = |bounces| {
        let irradiance = irradiance(&bounced(&mesh, &diffuse(1.0), bounces).matrix);
        irradiance.iter().map(|e| (1.0 - e / PI).abs()).fold(0.0, f64::max)
    };
    let missing: Vec<f64> = [0, 1, 2, 3, 16].map(worst).into();
    assert!(missing[0] > 0.3, "somewhere a blob is in its own shadow: {missing:?}");
    assert!(missing.windows(2).all(|pair| pair[1] < 0.8 * pair[0]), "{missing:?}");
    assert!(missing[4] < 2e-2, "{missing:?}");
}

#[test]
fn black_surfaces_and_the_backs_of_others_send_nothing() {
    let scene = shapes::find("bumpy-sphere").unwrap().build(300).unwrap();
    let black = bounced(&scene, &diffuse(0.0), 2);
    assert!(black.energies[0] > 0.0 && black.energies[1..] == [0.0, 0.0]);
    assert!(black.matrix.as_dense() == bounced(&scene, &diffuse(0.0), 0).matrix.as_dense());
    // The back of what encloses it sends nothing.
    let back = Mesh { normals: turned_inside_out(scene.clone()).normals, ..scene };
    let found = bounced(&back, &Glowing(diffuse(1.0)), 1);
    assert_eq!(found.energies[1], 0.0);
    assert!(diffuse(1.0).with_albedo(1.1).is_err());
}

#[test]
fn bounces_are_the_same_on_any_number_of_threads() {
    let mesh = shapes::find("chair").unwrap().build(300).unwrap();
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bounced(&mesh, &diffuse(0.8), 2))
    });
    assert!(one.matrix == three.matrix && one.energies == three.energies);
}
