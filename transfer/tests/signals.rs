//! Signals against closed forms and an independent, slow computation.
#![cfg(feature = "scene")]

use glam::Vec3;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::biscale::biscale;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::diffuse::diffuse;
use prt_transfer::scene::frames::{self, Frame};
use prt_transfer::scene::hemisphere::LocalDirections;
use prt_transfer::scene::shapes;
use prt_transfer::scene::signal::{Sampling, Surface};
use prt_transfer::{LightBasis, Quiet, TransferMatrix, sh};
use std::f64::consts::PI;

/// A mesh's matrix by one of the signals.
fn with_surface<T>(mesh: &Mesh, signal: impl FnOnce(&Surface) -> T) -> T {
    let (occluders, frames) = (Occluders::new(mesh).unwrap(), frames::vertex_frames(mesh).unwrap());
    signal(&Surface { occluders: &occluders, points: &mesh.positions, frames: &frames })
}

/// Points that see everything above their horizon.
fn unshadowed<T>(normals: &[Vec3], signal: impl FnOnce(&Surface) -> T) -> T {
    let occluders = Occluders::new(&Mesh::default()).unwrap();
    let points = vec![Vec3::ZERO; normals.len()];
    let frames: Vec<Frame> = normals.iter().map(|&n| Frame::by_axis(n)).collect();
    signal(&Surface { occluders: &occluders, points: &points, frames: &frames })
}

fn normals() -> Vec<Vec3> {
    [[0., 0., 1.], [1., 0., 0.], [0., -1., 0.], [0.3, -0.5, 0.8], [-0.7, 0.1, -0.2]]
        .map(|n| Vec3::from(n).normalize())
        .to_vec()
}

#[test]
fn unshadowed_diffuse_has_the_band_factors_of_the_clamped_cosine() {
    let basis = LightBasis::SphericalHarmonics { order: 5 };
    let sampling = Sampling { resolution: 32, supersampling: 2 };
    let (matrix, _) = unshadowed(&normals(), |s| diffuse(s, &sampling, &basis, &Quiet).unwrap());
    // T_lm = A_l Y_lm(n), Ramamoorthi and Hanrahan 2001.
    let factors = [PI, 2.0 * PI / 3.0, PI / 4.0, 0.0, -PI / 24.0];
    for (row, normal) in normals().iter().enumerate() {
        let (mut t, mut y) = (vec![0f32; 25], vec![0f64; 25]);
        matrix.gather(row, &mut t);
        sh::evaluate(5, normal.to_array().map(f64::from), &mut y).unwrap();
        for k in 0..25 {
            let expected = factors[(k as f64).sqrt() as usize] * y[k];
            assert!((f64::from(t[k]) - expected).abs() < 2e-3, "row {row}, coefficient {k}: {} {expected}", t[k]);
        }
    }
}

#[test]
fn uniform_light_gives_irradiance_pi_where_nothing_shadows_and_less_where_something_does() {
    let basis = LightBasis::Cubemap { resolution: 16 };
    let sampling = Sampling { resolution: 16, supersampling: 1 };
    let irradiance =
        |matrix: &TransferMatrix, row: usize| -> f64 { matrix.row(row).non_zeros().map(|(_, t)| f64::from(t)).sum() };
    let (open, _) = unshadowed(&normals(), |s| diffuse(s, &sampling, &basis, &Quiet).unwrap());
    for row in 0..open.rows() {
        assert!((irradiance(&open, row) - PI).abs() < 5e-3);
    }
    let scene = shapes::find("temple").unwrap().build(600).unwrap();
    let (shadowed, _) = with_surface(&scene, |s| diffuse(s, &sampling, &basis, &Quiet).unwrap());
    let all: Vec<f64> = (0..shadowed.rows()).map(|row| irradiance(&shadowed, row)).collect();
    assert!(all.iter().all(|e| (-1e-6..PI + 5e-3).contains(e)));
    assert!(all.iter().any(|e| *e < 0.5 * PI), "somewhere a temple is in its own shadow");
}

#[test]
fn cubemap_transfer_projects_to_spherical_harmonics_transfer() {
    let mesh = shapes::find("blob").unwrap().build(200).unwrap();
    let cubemap = LightBasis::Cubemap { resolution: 32 };
    let sampling = Sampling { resolution: 32, supersampling: 1 };
    let order = 4;
    let (texels, harmonics) = with_surface(&mesh, |s| {
        let harmonics = LightBasis::SphericalHarmonics { order };
        (diffuse(s, &sampling, &cubemap, &Quiet).unwrap().0, diffuse(s, &sampling, &harmonics, &Quiet).unwrap().0)
    });
    // Relighting with the light Y_i, both ways.
    let directions = cubemap.directions().unwrap();
    for row in 0..texels.rows() {
        let (mut expected, mut y, mut t) = (vec![0f64; 16], vec![0f64; 16], vec![0f32; 16]);
        for (k, value) in texels.row(row).non_zeros() {
            sh::evaluate(order, directions[k], &mut y).unwrap();
            expected.iter_mut().zip(&y).for_each(|(e, y)| *e += f64::from(value) * y);
        }
        harmonics.gather(row, &mut t);
        for (e, t) in expected.iter().zip(&t) {
            assert!((e - f64::from(*t)).abs() < 2e-3);
        }
    }
}

#[test]
fn biscale_values_are_dyadic_and_the_rows_of_a_vertex_share_its_visibility() {
    let mesh = shapes::find("blob").unwrap().build(150).unwrap();
    let (edge, m) = (4, 1);
    let sampling = Sampling { resolution: 8, supersampling: m };
    let (matrix, traced) = with_surface(&mesh, |s| biscale(s, &sampling, edge, &Quiet).unwrap());
    assert_eq!(matrix.shape().samples, mesh.positions.len());
    assert_eq!(matrix.shape().responses, edge * edge);
    let (mut fractions, mut total) = (vec![0f32; matrix.lights()], 0.0);
    for vertex in 0..mesh.positions.len() {
        fractions.fill(0.0);
        for j in 0..edge * edge {
            for (k, value) in matrix.row(vertex * edge * edge + j).non_zeros() {
                assert!([0.25, 0.5, 0.75, 1.0].contains(&value));
                fractions[k] += value;
            }
        }
        // A texel belongs to one local direction.
        assert!(fractions.iter().all(|f| *f <= 1.0));
        total += fractions.iter().sum::<f32>();
    }
    assert!(4.0 * total <= traced.rays as f32, "no more visible samples than rays");
    assert!(4.0 * total >= 0.5 * traced.rays as f32, "a blob sees most of its surroundings");
}

#[test]
fn biscale_equals_a_texel_by_texel_computation() {
    let edge = 8;
    let sampling = Sampling { resolution: 8, supersampling: 1 };
    let (matrix, _) = unshadowed(&normals(), |s| biscale(s, &sampling, edge, &Quiet).unwrap());
    let cells = LocalDirections::new(edge).unwrap();
    let vectors = |resolution| {
        let directions = LightBasis::Cubemap { resolution }.directions().unwrap();
        directions.into_iter().map(|d| Vec3::from_array(d.map(|c| c as f32))).collect::<Vec<_>>()
    };
    let (centres, fine) = (vectors(8), vectors(16));
    for (vertex, &normal) in normals().iter().enumerate() {
        let frame = Frame::by_axis(normal);
        let mut expected = vec![0f32; edge * edge * 384];
        for (i, _) in fine.iter().enumerate().filter(|(_, d)| d.dot(normal) > 0.0) {
            let (face, row, column) = (i / 256, i / 16 % 16, i % 16);
            let texel = face * 64 + row / 2 * 8 + column / 2;
            let local = frame.to_local(centres[texel]);
            // The nearest direction of the hemisphere: a centre below the horizon is nearest where its azimuth meets it.
            let local = if local.z < 0.0 { local.with_z(0.0).normalize() } else { local };
            let cosines = cells.directions().iter().map(|c| c.dot(local));
            let nearest = cosines.enumerate().fold((0, f32::MIN), |best, c| if c.1 > best.1 { c } else { best }).0;
            expected[nearest * 384 + texel] += 0.25;
        }
        let mut found = vec![0f32; expected.len()];
        for j in 0..edge * edge {
            matrix.gather(vertex * edge * edge + j, &mut found[j * 384..][..384]);
        }
        // Samples on the horizon may fall either way by rounding.
        let differing = expected.iter().zip(&found).filter(|(a, b)| a != b).count();
        assert!(differing <= 8, "vertex {vertex}: {differing} elements differ");
    }
}
