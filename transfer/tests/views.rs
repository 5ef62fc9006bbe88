//! Views of meshes and their reference, against closed forms and against each other.
#![cfg(feature = "scene")]

use glam::Vec3;
use ndarray::{Array2, ArrayView2};
use prt_transfer::basis::Direction;
use prt_transfer::image::Image;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::camera::{Camera, Film};
use prt_transfer::scene::diffuse::diffuse;
use prt_transfer::scene::frames::{Frame, vertex_frames};
use prt_transfer::scene::reference::{Reference, Reflectance};
use prt_transfer::scene::shading::towards;
use prt_transfer::scene::signal::{Sampling, Surface};
use prt_transfer::scene::view::View;
use prt_transfer::scene::{lights, shapes};
use prt_transfer::{LightBasis, Quiet};
use std::f64::consts::PI;

const FILM: Film = Film { width: 48, height: 36, field_of_view: 40.0 };

/// The view of a mesh from the front, a little to the side and from above.
fn seen(mesh: &Mesh, film: Film, samples: usize) -> View {
    let camera = Camera::framing(mesh, 30.0, 20.0, film).unwrap();
    View::cast(mesh, &Occluders::new(mesh).unwrap(), camera, samples, &Quiet).unwrap()
}

fn black(_: Direction) -> [f32; 3] {
    [0.0; 3]
}

fn lambert(albedo: f32) -> impl Fn(Vec3, Vec3) -> f32 + Sync {
    move |_, _| albedo / PI as f32
}

fn reference(mesh: &Mesh, view: &View, resolution: usize, light: ArrayView2<f32>, brdf: &Reflectance) -> Image {
    let (occluders, frames) = (Occluders::new(mesh).unwrap(), vertex_frames(mesh).unwrap());
    let surface = Surface { occluders: &occluders, points: &mesh.positions, frames: &frames };
    let sampling = Sampling { resolution, supersampling: 1 };
    Reference { surface, sampling, light, brdf }.image(view, black, &Quiet).unwrap()
}

fn uniform(resolution: usize, colour: [f32; 3]) -> Array2<f32> {
    Array2::from_shape_fn((6 * resolution * resolution, 3), |(_, c)| colour[c])
}

#[test]
fn a_linear_function_of_position_is_seen_as_it_is() {
    let mesh = shapes::find("temple").unwrap().build(900).unwrap();
    let function = |p: Vec3| [p.x + 2.0, 0.5 * p.y - p.z, 3.0 - p.x - 4.0 * p.z];
    let colours: Vec<_> = mesh.positions.iter().map(|&p| function(p)).collect();
    let (view, occluders) = (seen(&mesh, FILM, 1), Occluders::new(&mesh).unwrap());
    let image = view.interpolate(&colours, black).unwrap();
    let coverage = view.coverage();
    assert!(coverage.iter().filter(|&&c| c == 1.0).count() > 200);
    for (i, (pixel, covered)) in image.pixels.iter().zip(coverage).enumerate() {
        let (eye, (x, y)) = (view.camera().eye(), (i % FILM.width, i / FILM.width));
        let direction = view.camera().ray(x as f64 + 0.5, y as f64 + 0.5).as_vec3();
        let hit = occluders.nearest(eye, direction);
        assert_eq!(hit.is_some(), covered == 1.0);
        let expected = hit.map_or([0.0; 3], |hit| function(eye + hit.t * direction));
        assert!(pixel.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{pixel:?} {expected:?}");
    }
}

#[test]
fn a_pixel_is_the_mean_of_its_samples() {
    let mesh = shapes::find("blob").unwrap().build(500).unwrap();
    let colours: Vec<_> = mesh.normals.iter().map(|n| (*n + 1.0).to_array()).collect();
    let background = |d: Direction| d.map(|c| c as f32 + 2.0);
    let image = |film, samples| seen(&mesh, film, samples).interpolate(&colours, background).unwrap();
    // The same samples as pixels of a film twice as fine: halves and doubles are exact in binary.
    let (mean, fine) = (image(FILM, 2), image(Film { width: 96, height: 72, ..FILM }, 1));
    for (i, pixel) in mean.pixels.iter().enumerate() {
        let at = |dx: usize, dy: usize| fine.pixels[(2 * (i / 48) + dy) * 96 + 2 * (i % 48) + dx].map(f64::from);
        let samples = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let expected = [0, 1, 2].map(|c| (samples.iter().map(|s| s[c]).sum::<f64>() / 4.0) as f32);
        assert_eq!(*pixel, expected, "pixel {i}");
    }
}

#[test]
fn a_surface_of_the_background_s_colour_cannot_be_seen() {
    let mesh = shapes::find("teapot").unwrap().build(400).unwrap();
    let colour = [0.3, 1.0, 7.0];
    let view = seen(&mesh, FILM, 3);
    let image = view.interpolate(&vec![colour; mesh.positions.len()], |_| colour).unwrap();
    let difference = |p: &[f32; 3]| p.iter().zip(colour).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f32::max);
    assert!(image.pixels.iter().map(difference).fold(0.0, f32::max) < 1e-6);
    let coverage = view.coverage();
    assert!(coverage.contains(&0.0) && coverage.contains(&1.0) && coverage.iter().any(|c| *c > 0.0 && *c < 1.0));
}

#[test]
fn a_white_plane_in_a_furnace_vanishes_and_so_does_a_sphere_but_for_its_facets() {
    let plane = Mesh {
        positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.5)).into(),
        normals: vec![Vec3::Z; 4],
        faces: vec![[0, 1, 2], [0, 2, 3]],
    };
    let colour = [1.0, 2.0, 0.5];
    let (light, brdf) = (uniform(16, colour), lambert(0.8));
    for (mesh, tolerance) in [(plane, 1e-3), (shapes::sphere(24), 6e-3)] {
        let view = seen(&mesh, FILM, 2);
        let image = reference(&mesh, &view, 16, light.view(), &brdf);
        let whole: Vec<_> = image.pixels.iter().zip(view.coverage()).filter(|(_, c)| *c == 1.0).collect();
        assert!(whole.len() > 100);
        for (pixel, _) in whole {
            let errors = pixel.iter().zip(colour).map(|(found, l)| (found / (0.8 * l) - 1.0).abs());
            assert!(errors.fold(0.0, f32::max) < tolerance, "{pixel:?}");
        }
    }
}

#[test]
fn light_of_one_texel_is_weighted_by_cosine_solid_angle_and_brdf() {
    // A floor, seen from above; ρ depends on both directions and on the tangent.
    let floor = Mesh {
        positions: vec![Vec3::new(-9.0, -9.0, 0.0), Vec3::new(9.0, -9.0, 0.0), Vec3::new(0.0, 9.0, 0.0)],
        normals: vec![Vec3::Z; 3],
        faces: vec![[0, 1, 2]],
    };
    let basis = LightBasis::Cubemap { resolution: 8 };
    let (directions, angles) = (basis.directions().unwrap(), basis.solid_angles().unwrap());
    let texel = directions.iter().position(|d| d[2] > 0.4 && d[0] > 0.5 && d[1] < -0.2).unwrap();
    let mut light = Array2::zeros((384, 3));
    light[[texel, 1]] = 5.0;
    let brdf = |out: Vec3, incoming: Vec3| 1.0 + out.x * incoming.y - out.y * incoming.x + 2.0 * out.z;
    let frames = [Frame { tangent: Vec3::Y, bitangent: Vec3::NEG_X, normal: Vec3::Z }; 3];
    let sampling = Sampling { resolution: 8, supersampling: 3 };
    let (view, occluders) = (seen(&floor, FILM, 1), Occluders::new(&floor).unwrap());
    let surface = Surface { occluders: &occluders, points: &floor.positions, frames: &frames };
    let reference = Reference { surface, sampling, light: light.view(), brdf: &brdf };
    let image = reference.image(&view, |_| [-1.0; 3], &Quiet).unwrap();
    let d = Vec3::from_array(directions[texel].map(|c| c as f32));
    for (i, pixel) in image.pixels.iter().enumerate().filter(|(_, p)| p[0] != -1.0) {
        let ray = view.camera().ray((i % 48) as f64 + 0.5, (i / 48) as f64 + 0.5).as_vec3();
        // Local coordinates by hand: x is the world's y, y its -x.
        let expected = (1.0 + -ray.y * -d.x - ray.x * d.y - 2.0 * ray.z) * d.z * 5.0 * angles[texel] as f32;
        assert!((pixel[1] / expected - 1.0).abs() < 0.02, "{} {expected}", pixel[1]);
        assert_eq!((pixel[0], pixel[2]), (0.0, 0.0));
    }
}

/// Radiance at the vertices of a Lambertian surface, by the signal.
fn diffuse_colours(mesh: &Mesh, resolution: usize, light: ArrayView2<f32>, albedo: f32) -> Vec<[f32; 3]> {
    let (occluders, frames) = (Occluders::new(mesh).unwrap(), vertex_frames(mesh).unwrap());
    let surface = Surface { occluders: &occluders, points: &mesh.positions, frames: &frames };
    let sampling = Sampling { resolution, supersampling: 1 };
    let (matrix, _) = diffuse(&surface, &sampling, &LightBasis::Cubemap { resolution }, &Quiet).unwrap();
    let mut out = Array2::zeros((matrix.rows(), 3));
    matrix.apply_into(light, out.view_mut()).unwrap();
    out.outer_iter().map(|y| [y[0], y[1], y[2]].map(|y| albedo / PI as f32 * y)).collect()
}

#[test]
fn pictures_of_precomputed_transfer_approach_the_reference_as_the_mesh_is_refined() {
    let light = lights::find("room").unwrap().environment().texels(&LightBasis::Cubemap { resolution: 16 }).unwrap();
    let brdf = lambert(0.5);
    let errors = [300, 1200, 4800].map(|vertices| {
        let mesh = shapes::find("blob").unwrap().build(vertices).unwrap();
        let colours = diffuse_colours(&mesh, 16, light.view(), 0.5);
        let view = seen(&mesh, FILM, 2);
        let image = view.interpolate(&colours, black).unwrap();
        let reference = reference(&mesh, &view, 16, light.view(), &brdf);
        image.relative_squared_error(&reference, &view.coverage()).unwrap()
    });
    assert!(errors[0] < 0.05 && errors.windows(2).all(|pair| pair[1] < 0.5 * pair[0]), "{errors:?}");
}

#[test]
fn any_number_of_threads_gives_the_same_images() {
    let mesh = shapes::find("teapot").unwrap().build(300).unwrap();
    let (light, brdf) = (uniform(8, [1.0, 0.3, 0.1]), lambert(1.0));
    let colours: Vec<_> = mesh.normals.iter().map(|n| n.to_array()).collect();
    let both = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let view = seen(&mesh, FILM, 2);
            (view.interpolate(&colours, black).unwrap(), reference(&mesh, &view, 8, light.view(), &brdf))
        })
    };
    assert!(both(1) == both(2));
}

#[test]
fn an_eye_below_the_horizon_is_raised_to_it() {
    let frame = Frame::by_axis(Vec3::new(0.2, -0.3, 0.9).normalize());
    for world in [Vec3::X, Vec3::NEG_Z, 3.0 * Vec3::Y, frame.normal, -frame.normal] {
        let local = towards(&frame, world);
        assert!(local.is_normalized() && local.z > 0.0);
        let (unit, azimuth) = (frame.to_local(world.normalize()), Vec3::new(1.0, 1.0, 0.0) * local);
        assert!(unit.z < 0.1 || (local - unit).length() < 1e-6);
        assert!(azimuth.dot(unit) >= -1e-6, "the azimuth stays");
    }
}

#[test]
fn what_does_not_fit_the_mesh_is_refused() {
    let (mesh, other) = (shapes::sphere(2), shapes::sphere(9));
    let camera = Camera::framing(&mesh, 0.0, 0.0, FILM).unwrap();
    let occluders = Occluders::new(&other).unwrap();
    let message = |result: prt_transfer::Result<Image>| result.unwrap_err().to_string();
    let foreign = View::cast(&mesh, &occluders, camera.clone(), 1, &Quiet).err().unwrap().to_string();
    assert!(foreign.contains("of 80 faces"), "{foreign}");
    assert!(View::cast(&other, &occluders, camera, 17, &Quiet).is_err());
    let view = seen(&mesh, FILM, 1);
    let mut colours = vec![[1.0; 3]; mesh.positions.len()];
    colours[5][2] = f32::NAN;
    assert!(message(view.interpolate(&colours, black)).contains("row 5, column 2"));
    assert!(message(view.interpolate(&colours[1..], black)).contains("expected 42, found 41"));
    assert!(message(view.interpolate(&vec![[1.0; 3]; 42], |_| [f32::INFINITY; 3])).contains("pixel"));
    let (frames, sampling) = (vertex_frames(&mesh).unwrap(), Sampling { resolution: 4, supersampling: 0 });
    let (light, brdf, points) = (uniform(5, [1.0; 3]), lambert(1.0), &mesh.positions);
    let refused = |surface: Surface, expected: &str| {
        let reference = Reference { surface, sampling: sampling.clone(), light: light.view(), brdf: &brdf };
        let said = message(reference.image(&view, black, &Quiet));
        assert!(said.contains(expected), "{said}");
    };
    refused(Surface { occluders: &occluders, points, frames: &frames }, "expected 96, found 150");
    refused(Surface { occluders: &occluders, points: &points[1..], frames: &frames }, "expected 42, found 41");
    refused(Surface { occluders: &occluders, points, frames: &frames[1..] }, "expected 42, found 41");
}
