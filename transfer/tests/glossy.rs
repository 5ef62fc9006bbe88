//! Exit radiance against closed forms, symmetries, and a slow computation that shares none of its steps.
#![cfg(feature = "scene")]

use glam::{DVec3, Vec3};
use nalgebra::DMatrix;
use prt_transfer::mesh::Mesh;
use prt_transfer::responses::Coordinates;
use prt_transfer::scene::bounce::{Arrival, Interreflecting, interreflect};
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::dense::{self, DenseSignal};
use prt_transfer::scene::diffuse::diffuse;
use prt_transfer::scene::frames::{self, Frame};
use prt_transfer::scene::glossy::{Glossy, GlossyParams};
use prt_transfer::scene::shapes;
use prt_transfer::scene::signal::{Samples, Sampling, Surface, Visible};
use prt_transfer::sh::{Harmonics, HemisphereSh, Rotation};
use prt_transfer::{LightBasis, Quiet, ResponseBasis, Result, TransferMatrix};
use std::f64::consts::PI;

const SAMPLING: Sampling = Sampling { resolution: 16, supersampling: 1 };

fn glossy(params: &GlossyParams, coordinates: Coordinates, brdf: &str, sampling: &Sampling) -> Glossy {
    Glossy::new(params.clone(), coordinates, &brdf.parse().unwrap(), sampling).unwrap()
}

/// Points on a mesh, or in the open.
struct Points {
    occluders: Occluders,
    positions: Vec<Vec3>,
    frames: Vec<Frame>,
}

impl Points {
    fn of(mesh: &Mesh) -> Points {
        let frames = frames::vertex_frames(mesh).unwrap();
        Points { occluders: Occluders::new(mesh).unwrap(), positions: mesh.positions.clone(), frames }
    }
    fn in_the_open(normals: &[Vec3]) -> Points {
        let frames: Vec<Frame> = normals.iter().map(|&n| Frame::by_axis(n)).collect();
        Points {
            occluders: Occluders::new(&Mesh::default()).unwrap(),
            positions: vec![Vec3::ZERO; frames.len()],
            frames,
        }
    }
    fn surface(&self) -> Surface<'_> {
        Surface { occluders: &self.occluders, points: &self.positions, frames: &self.frames }
    }
    fn matrix(&self, signal: &Glossy) -> TransferMatrix {
        dense::matrix(signal, &self.surface(), &Quiet).unwrap().0
    }
}

fn values(matrix: &TransferMatrix) -> Vec<f64> {
    matrix.as_dense().unwrap().iter().map(|&v| v.into()).collect()
}

fn relative_error(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let squares = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>();
    squares(&mut found.iter().zip(expected).map(|(a, b)| a - b)) / squares(&mut expected.iter().copied())
}

/// Directions z > 0 with weights: Gauss-Legendre in z (Golub and Welsch 1969), uniform in azimuth.
fn hemisphere(rings: usize, around: usize) -> Vec<(DVec3, f64)> {
    let beside = |i: usize| (i + 1) as f64 / (4.0 * ((i + 1) * (i + 1)) as f64 - 1.0).sqrt();
    let jacobi = DMatrix::from_fn(rings, rings, |i, j| if i.abs_diff(j) == 1 { beside(i.min(j)) } else { 0.0 });
    let nodes = jacobi.symmetric_eigen();
    let turn = |a: usize| 2.0 * PI * (a as f64 + 0.5) / around as f64;
    (0..rings * around)
        .map(|k| (0.5 + 0.5 * nodes.eigenvalues[k / around], nodes.eigenvectors[(0, k / around)], turn(k % around)))
        .map(|(z, first, phi)| {
            let radius = (1.0 - z * z).sqrt();
            (DVec3::new(radius * phi.cos(), radius * phi.sin(), z), first * first * 2.0 * PI / around as f64)
        })
        .collect()
}

fn axes(frame: &Frame) -> [[f64; 3]; 3] {
    [frame.tangent, frame.bitangent, frame.normal].map(|axis| axis.as_dvec3().to_array())
}

#[test]
fn a_lambertian_surface_sends_the_same_radiance_everywhere_which_is_its_irradiance_times_albedo_over_pi() {
    let points = Points::of(&shapes::find("chair").unwrap().build(200).unwrap());
    let light = LightBasis::SphericalHarmonics { order: 5 };
    let irradiance = values(&diffuse(&points.surface(), &SAMPLING, &light, &Quiet).unwrap().0);
    // The cosine is among the functions that arriving light is projected onto from two bands on: nothing of it is lost.
    for incident in [2, 5, 8] {
        let params = GlossyParams { coefficients: 16, incident, light: 5 };
        let found = values(&points.matrix(&glossy(&params, Coordinates::Harmonics, "lambert:albedo=0.6", &SAMPLING)));
        for (exit, irradiance) in found.chunks(16 * 25).zip(irradiance.chunks(25)) {
            for (k, &m) in exit.iter().enumerate() {
                // y_0 = √(1/4π)
                let expected = if k < 25 { 0.6 / PI * irradiance[k] * (4.0 * PI).sqrt() } else { 0.0 };
                assert!((m - expected).abs() < 1e-5, "{k}: {m} {expected}");
            }
        }
    }
}

#[test]
fn the_matrix_is_the_papers_product_with_the_inverse_of_the_gram_matrix() {
    // At order 4 A may be inverted with a loss of 6e3 roundings: equation (1) as it is printed.
    let (brdf, order) = ("phong:specular=0.7:diffuse=0.2:exponent=6", 4);
    let points = Points::of(&shapes::find("blob").unwrap().build(60).unwrap());
    let params = GlossyParams { coefficients: 16, incident: order, light: order };
    let found = values(&points.matrix(&glossy(&params, Coordinates::Harmonics, brdf, &SAMPLING)));
    let (brdf, sh) = (brdf.parse::<Brdf>().unwrap(), Harmonics::new(order).unwrap());
    let at = |direction: DVec3| {
        let mut y = vec![0f64; 16];
        sh.evaluate(direction.to_array(), &mut y);
        DMatrix::from_column_slice(16, 1, &y)
    };
    let nodes = hemisphere(24, 40);
    let evaluated: Vec<DMatrix<f64>> = nodes.iter().map(|node| at(node.0)).collect();
    let mut b = DMatrix::zeros(16, 16);
    for ((v, of_view), y_v) in nodes.iter().zip(&evaluated) {
        let mut reflected = DMatrix::zeros(16, 1);
        for ((s, of_light), y_s) in nodes.iter().zip(&evaluated) {
            reflected += y_s * (brdf.evaluate(*v, *s) * s.z * of_light);
        }
        b += y_v * reflected.transpose() * *of_view;
    }
    let inverse = DMatrix::from_row_slice(16, 16, &HemisphereSh::new(16).unwrap().gram()).try_inverse().unwrap();
    let samples = SAMPLING.samples().unwrap();
    let (mut expected, surface) = (Vec::new(), points.surface());
    for (position, frame) in surface.points.iter().zip(surface.frames) {
        let origin = *position + surface.occluders.offset() * frame.normal;
        let mut transfer = DMatrix::zeros(16, 16);
        for sample in samples.lanes().iter().filter(|s| s.solid_angle > 0.0 && s.direction.dot(frame.normal) > 0.0) {
            if !surface.occluders.occluded(origin, sample.direction) {
                let y = at(sample.direction.as_dvec3());
                transfer += &y * y.transpose() * sample.solid_angle;
            }
        }
        let rotation = Rotation::new(order, axes(frame)).unwrap();
        let mut rotated = vec![0f64; 256];
        rotation.apply_rows(transfer.transpose().as_slice(), &mut rotated, 16).unwrap();
        let product = &inverse * &b * &inverse * DMatrix::from_row_slice(16, 16, &rotated);
        expected.extend(product.transpose().as_slice());
    }
    let error = relative_error(&found, &expected);
    assert!(error < 1e-4, "{error}");
}

#[test]
fn more_bands_of_arriving_light_come_nearer_to_reflecting_all_of_it() {
    let brdf: Brdf = "cook-torrance:roughness=0.3:f0=0.5".parse().unwrap();
    let points = Points::of(&shapes::find("blob").unwrap().build(40).unwrap());
    let (exit, light) = (HemisphereSh::new(24).unwrap(), Harmonics::new(5).unwrap());
    let (samples, surface) = (SAMPLING.samples().unwrap(), points.surface());
    // d_i = ∫ q_i(v) ∫ ρ(v, s) s_z V(s) y_j(s) ds dv, ray by ray.
    let views: Vec<(DVec3, Vec<f64>)> = hemisphere(24, 40)
        .into_iter()
        .map(|(v, weight)| {
            let mut q = vec![0f64; 24];
            exit.evaluate_orthonormal(v.to_array(), &mut q);
            (v, q.into_iter().map(|q| q * weight).collect())
        })
        .collect();
    let mut expected = Vec::new();
    for (position, frame) in surface.points.iter().zip(surface.frames) {
        let origin = *position + surface.occluders.offset() * frame.normal;
        let mut exact = vec![0f64; 24 * 25];
        for sample in samples.lanes().iter().filter(|s| s.solid_angle > 0.0 && s.direction.dot(frame.normal) > 0.0) {
            if surface.occluders.occluded(origin, sample.direction) {
                continue;
            }
            let (s, mut y) = (frame.to_local(sample.direction).as_dvec3(), vec![0f64; 25]);
            light.evaluate(sample.direction.as_dvec3().to_array(), &mut y);
            let mut towards = vec![0f64; 24];
            for (v, q) in &views {
                let rho = brdf.evaluate(*v, s);
                towards.iter_mut().zip(q).for_each(|(t, q)| *t += rho * q);
            }
            for (row, towards) in exact.chunks_mut(25).zip(&towards) {
                let weight = towards * s.z * sample.solid_angle;
                row.iter_mut().zip(&y).for_each(|(m, y)| *m += weight * y);
            }
        }
        expected.extend(exact);
    }
    let error = |incident| {
        let params = GlossyParams { coefficients: 24, incident, light: 5 };
        relative_error(
            &values(&points.matrix(&glossy(&params, Coordinates::Orthonormal, &brdf.to_string(), &SAMPLING))),
            &expected,
        )
    };
    let errors = [2, 4, 5, 6].map(error);
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
    // What is left is the quadrature of this test.
    assert!(errors[3] < 2e-3, "{errors:?}");
}

#[test]
fn coordinates_are_two_names_of_one_function() {
    let points = Points::of(&shapes::find("blob").unwrap().build(50).unwrap());
    for coefficients in [16, 24, 25, 64] {
        let params = GlossyParams { coefficients, ..GlossyParams::default() };
        let [mut harmonics, orthonormal] = [Coordinates::Harmonics, Coordinates::Orthonormal]
            .map(|c| values(&points.matrix(&glossy(&params, c, "cook-torrance", &SAMPLING))));
        let sh = HemisphereSh::new(coefficients).unwrap();
        harmonics.chunks_mut(coefficients * 25).for_each(|sample| sh.to_orthonormal(sample).unwrap());
        let error = relative_error(&harmonics, &orthonormal);
        assert!(error < 1e-8, "{coefficients}: {error}");
    }
}

#[test]
fn the_transfer_of_a_sphere_turns_with_the_light() {
    // Every point of a convex surface sees the same in its own frame: M_p = M R_p.
    let normals: Vec<Vec3> = (0..9)
        .map(|i| (i as f32 / 4.5 - 0.9, 2.4 * i as f32))
        .map(|(z, phi)| Vec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z))
        .collect();
    let points = Points::in_the_open(&normals);
    // The horizon is cut at the samples, which is all of the error that there is: it halves with the distance between
    // them.
    let params = GlossyParams { coefficients: 16, incident: 3, light: 3 };
    let fine = Sampling { resolution: 64, supersampling: 3 };
    let found = values(&points.matrix(&glossy(&params, Coordinates::Orthonormal, "cook-torrance", &fine)));
    let local: Vec<Vec<f64>> = found
        .chunks(16 * 9)
        .zip(&points.frames)
        .map(|(matrix, frame)| {
            // The columns of M = M_p R_pᵀ: each row of M_p is turned into the local frame.
            let (rotation, mut out) = (Rotation::new(3, axes(frame)).unwrap(), vec![0f64; 9]);
            let turned = |row: &[f64]| {
                rotation.apply(row, &mut out).unwrap();
                out.clone()
            };
            matrix.chunks(9).flat_map(turned).collect()
        })
        .collect();
    for matrix in &local[1..] {
        let error = relative_error(matrix, &local[0]).sqrt();
        assert!(error < 1e-4, "{error}");
    }
}

#[test]
fn a_mirror_symmetric_scene_has_mirror_symmetric_transfer() {
    // The same scene and points mirrored in y: light of m < 0 changes its sign.
    let mesh = shapes::find("teapot").unwrap().build(150).unwrap();
    let mirror = |v: &Vec3| Vec3::new(v.x, -v.y, v.z);
    let mirrored = Mesh {
        positions: mesh.positions.iter().map(mirror).collect(),
        normals: mesh.normals.iter().map(mirror).collect(),
        faces: mesh.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(),
    };
    let (points, mut image) = (Points::of(&mesh), Points::of(&mirrored));
    // Frames mirrored as well, and right-handed again by turning the second axis: local y changes its sign.
    image.frames = (points.frames.iter())
        .map(|f| Frame { tangent: mirror(&f.tangent), bitangent: -mirror(&f.bitangent), normal: mirror(&f.normal) })
        .collect();
    let params = GlossyParams { coefficients: 25, ..GlossyParams::default() };
    let signal = glossy(&params, Coordinates::Harmonics, "cook-torrance:diffuse=0.3:specular=0.7", &SAMPLING);
    let [ours, theirs] = [&points, &image].map(|p| values(&p.matrix(&signal)));
    let sign = |k: usize| {
        let l = k.isqrt();
        if k < l * l + l { -1.0 } else { 1.0 }
    };
    for (at, (a, b)) in ours.iter().zip(&theirs).enumerate() {
        let (row, column) = (at / 25 % 25, at % 25);
        assert!((a - sign(row) * sign(column) * b).abs() < 1e-6 * (1.0 + a.abs()), "{at}: {a} {b}");
    }
}

#[test]
fn glossy_light_bounces_as_diffuse_light_does_where_the_surface_is_diffuse() {
    let mesh = shapes::find("blob").unwrap().build(200).unwrap();
    let (points, gather) = (Points::of(&mesh), Sampling { resolution: 16, supersampling: 0 });
    let light = LightBasis::SphericalHarmonics { order: 3 };
    let params = GlossyParams { coefficients: 9, incident: 4, light: 3 };
    let signal = glossy(&params, Coordinates::Orthonormal, "lambert:albedo=0.7", &SAMPLING);
    let glossy = interreflect(&signal, &points.surface(), &mesh, &gather, 3, &Quiet).unwrap();
    let signal = prt_transfer::scene::diffuse::Diffuse::new(&SAMPLING, &light).unwrap().with_albedo(0.7).unwrap();
    let diffuse = interreflect(&signal, &points.surface(), &mesh, &gather, 3, &Quiet).unwrap();
    assert!(diffuse.energies[1] > 1e-3 * diffuse.energies[0], "a blob lights itself");
    let constant = (2.0 * PI).sqrt();
    let irradiance = values(&diffuse.matrix);
    let expected: Vec<f64> = irradiance.chunks(9).flat_map(|row| row.iter().map(|e| 0.7 / PI * e * constant)).collect();
    let found: Vec<f64> = values(&glossy.matrix).chunks(81).flat_map(|m| m[..9].to_vec()).collect();
    let error = relative_error(&found, &expected);
    assert!(error < 1e-10, "{error}");
}

/// Surfaces that all send out radiance 1 in every direction, and reflect as a glossy surface does.
struct Glowing(Glossy);

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
        // 1 = √2π q_0
        out[0] = (2.0 * PI).sqrt() as f32;
        Ok(())
    }
}

impl Interreflecting for Glowing {
    fn bounce_into(&self, s: &Surface, point: usize, a: &[Arrival], leaving: &[f32], out: &mut [f32]) -> Result<()> {
        self.0.bounce_into(s, point, a, leaving, out)
    }
}

#[test]
fn in_a_closed_glossy_furnace_every_point_sends_out_its_albedo() {
    let mesh = shapes::find("bumpy-sphere").unwrap().build(150).unwrap();
    let inside = Mesh {
        normals: mesh.normals.iter().map(|n| -n).collect(),
        faces: mesh.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        ..mesh
    };
    let (points, gather) = (Points::of(&inside), Sampling { resolution: 32, supersampling: 0 });
    let brdf: Brdf = "cook-torrance:roughness=0.2:f0=0.6:diffuse=0.2:specular=0.8".parse().unwrap();
    let params = GlossyParams { coefficients: 9, incident: 4, light: 1 };
    let signal = Glowing(glossy(&params, Coordinates::Orthonormal, &brdf.to_string(), &SAMPLING));
    let bounced = interreflect(&signal, &points.surface(), &inside, &gather, 1, &Quiet).unwrap();
    let (sh, mut expected) = (HemisphereSh::new(9).unwrap(), [0f64; 9]);
    for (v, weight) in hemisphere(24, 20) {
        let mut q = vec![0f64; 9];
        sh.evaluate_orthonormal(v.to_array(), &mut q);
        expected.iter_mut().zip(q).for_each(|(e, q)| *e += weight * q * brdf.albedo(v));
    }
    for (vertex, rows) in values(&bounced.matrix).chunks(9).enumerate() {
        // Without the glow itself.
        let reflected: Vec<f64> =
            rows.iter().enumerate().map(|(i, m)| if i == 0 { m - (2.0 * PI).sqrt() } else { *m }).collect();
        let error = relative_error(&reflected, &expected).sqrt();
        assert!(error < 2e-2, "vertex {vertex}: {error}");
    }
}
