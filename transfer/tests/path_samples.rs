//! Samples and pictures of the path tracer: what they add up to, on which sides, on how many threads, and what is refused or counted.
#![cfg(feature = "scene")]

mod worlds;

use glam::{DVec3, Vec2, Vec3};
use prt_transfer::Quiet;
use prt_transfer::scene::camera::{Camera, Film};
use prt_transfer::scene::environment::{Cap, Environment};
use prt_transfer::scene::material::{Material, Texture};
use prt_transfer::scene::path::{PathParams, PathTracer, Tally, image};
use prt_transfer::scene::world::{Object, SurfacePoint, World};
use prt_transfer::scene::{lights, shapes};
use std::f64::consts::PI;
use worlds::{agree, bounces, cube_inside, floor, grey, lamp, mean, object, plate, uniform_sky, up, world};

/// A small room under the built-in sky, with a textured floor and a glossy ball with interpolated normals.
fn room() -> World {
    let pattern = |uv: Vec2| Vec3::splat(if (uv * 4.0).floor().element_sum() % 2.0 == 0.0 { 0.8 } else { 0.2 });
    let ground = Object {
        uv: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        ..object("floor", floor(1.5), Material { diffuse: Texture::Pattern(pattern), ..grey("lambert") })
    };
    let mut ball = shapes::sphere(8);
    ball.positions.iter_mut().for_each(|p| *p = 0.5 * *p + 0.6 * Vec3::Z);
    let gold = Material {
        diffuse: Texture::Uniform(Vec3::new(0.9, 0.5, 0.1)),
        specular: Vec3::new(1.0, 0.8, 0.3),
        emission: Vec3::new(0.0, 0.0, 0.5),
        ..grey("cook-torrance:roughness=0.15:diffuse=0.4:specular=0.6")
    };
    let shade = plate(Vec3::new(-1.0, -1.0, 1.8), Vec3::Y, Vec3::X);
    let sky = lights::find("sky").unwrap().environment();
    world(
        vec![ground, object("ball", ball, gold), object("shade", shade, lamp(Vec3::new(40.0, 20.0, 10.0)))],
        Some(sky),
    )
}

fn first_hit(world: &World, origin: Vec3, direction: Vec3) -> SurfacePoint {
    world.met(&world.occluders().nearest(origin, direction).unwrap())
}

#[test]
fn what_arrives_is_emission_and_diffuse_part_and_lobe_of_the_first_hit() {
    let world = room();
    let tracer = PathTracer::new(&world, bounces(6)).unwrap();
    let eye = Vec3::new(0.3, -3.0, 1.2);
    for (key, target) in
        [Vec3::new(0.1, -0.4, 0.7), Vec3::new(0.2, 0.0, 1.0), Vec3::new(0.6, -0.7, 0.0)].iter().enumerate()
    {
        let (direction, mut tally) = ((target - eye).normalize(), Tally::default());
        let point = first_hit(&world, eye, direction);
        let emission = world.objects()[point.object as usize].material.emission;
        for channel in 0..3 {
            let n = 30_000;
            let whole = mean(n, |k| tracer.incoming(eye, direction, key as u64, k, &mut tally)[channel].into());
            let parts = mean(n, |k| {
                let diffuse = tracer.diffuse(&point, 7 + key as u64, k, &mut tally);
                let lobe = tracer.lobe(&point, -direction, 7 + key as u64, k, &mut tally);
                (emission + diffuse + lobe)[channel].into()
            });
            agree("parts", (parts.0, whole.1.hypot(parts.1)), whole.0);
            assert!(whole.1 < 0.05 * whole.0, "worth comparing: {whole:?}");
        }
    }
}

#[test]
fn pictures_are_the_same_bits_on_one_thread_and_on_two() {
    let world = room();
    let tracer = PathTracer::new(&world, bounces(5)).unwrap();
    let film = Film { width: 24, height: 18, field_of_view: 50.0 };
    let camera = Camera::looking(Vec3::new(0.3, -3.0, 1.2), Vec3::new(0.0, 0.0, 0.5), film).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| image(&tracer, &camera, 8, |_| [0.0, 0.5, 1.0], &Quiet).unwrap())
    };
    let [one, two] = [on(1), on(2)];
    assert_eq!((one.image, one.tally), (two.image.clone(), two.tally));
    assert_eq!(one.coverage, two.coverage);
    assert_eq!(two.tally.paths, 24 * 18 * 8);
    assert!(two.coverage.contains(&0.0) && two.coverage.contains(&1.0));
    for (pixel, _) in two.image.pixels.iter().zip(&two.coverage).filter(|(_, c)| **c == 0.0) {
        assert_eq!(*pixel, [0.0, 0.5, 1.0], "the background is seen as it is");
    }
    assert!(image(&tracer, &camera, 0, |_| [0.0; 3], &Quiet).is_err());
    assert!(image(&tracer, &camera, 1, |_| [f32::NAN; 3], &Quiet).is_err());
}

#[test]
fn pictures_and_samples_of_another_seed_agree_in_the_mean_only() {
    let world = room();
    let point = first_hit(&world, Vec3::new(0.3, -3.0, 1.2), Vec3::new(0.0, 3.0, -0.5));
    let of_seed = |seed| {
        let tracer = PathTracer::new(&world, PathParams { seed, ..bounces(3) }).unwrap();
        mean(20_000, |k| tracer.diffuse(&point, 0, k, &mut Tally::default()).y.into())
    };
    let [one, two] = [of_seed(0), of_seed(1)];
    assert_ne!(one, two);
    agree("another seed", (one.0, one.1.hypot(two.1)), two.0);
}

#[test]
fn the_back_of_a_surface_is_black_and_ends_a_path() {
    let both = Material { emission: Vec3::ONE, ..grey("lambert") };
    let world = world(vec![object("plate", floor(1.0), both)], Some(uniform_sky(1.0)));
    let tracer = PathTracer::new(&world, PathParams::default()).unwrap();
    let mut tally = Tally::default();
    assert_eq!(tracer.incoming(-Vec3::Z, Vec3::Z, 0, 0, &mut tally), Vec3::ZERO);
    assert_eq!((tally.paths, tally.rays), (1, 1));
    assert!(tracer.incoming(Vec3::Z, -Vec3::Z, 0, 0, &mut tally).x >= 1.0);
    assert_eq!(tracer.incoming(Vec3::Z, Vec3::Z, 0, 0, &mut tally), Vec3::ONE, "the sky");
    let point = world.point(0, 0, 0.2, 0.2);
    assert_eq!(tracer.lobe(&point, -Vec3::Z, 0, 0, &mut tally), Vec3::ZERO);
}

#[test]
fn light_below_the_horizon_of_the_normal_or_of_the_face_is_refused_and_the_diffuse_part_is_seen_from_above_the_face() {
    let mut leaning = floor(1.0);
    leaning.normals = vec![Vec3::new(0.8, 0.0, 0.6); 4];
    let sun = |x: f64, z: f64| {
        let cap = Cap { centre: DVec3::new(x, 0.0, z).normalize(), radius: 0.02, radiance: [1e3; 3] };
        Environment::new(|_| DVec3::ZERO, vec![cap])
    };
    let reflected = |sky: Environment, view: Vec3| {
        let glossy = grey("cook-torrance:roughness=0.5:diffuse=0.5:specular=0.5");
        let world = world(vec![object("plate", leaning.clone(), glossy)], Some(sky));
        let tracer = PathTracer::new(&world, PathParams::default()).unwrap();
        let (point, mut tally) = (world.point(0, 0, 0.3, 0.3), Tally::default());
        assert!((point.normal - Vec3::new(0.8, 0.0, 0.6)).length() < 1e-6 && point.geometric == Vec3::Z);
        let diffuse = mean(1000, |k| tracer.diffuse(&point, 0, k, &mut tally).x.into()).0;
        let whole = mean(1000, |k| tracer.incoming(point.position + view, -view, 0, k, &mut tally).x.into()).0;
        let lobe = mean(1000, |k| tracer.lobe(&point, view, 0, k, &mut tally).x.into()).0;
        [diffuse, lobe, whole]
    };
    let (ahead, behind) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.8, 0.0, 0.3).normalize());
    let cosine = DVec3::new(0.8, 0.0, 0.6).dot(DVec3::new(1.0, 0.0, 1.0).normalize());
    let expected = 0.5 / PI * 1e3 * PI * 0.02f64.sin().powi(2) * cosine;
    let [diffuse, lobe, whole] = reflected(sun(1.0, 1.0), ahead);
    assert!((diffuse / expected - 1.0).abs() < 1e-2, "{diffuse} {expected}");
    assert!(lobe > 0.1 * diffuse && (whole / (diffuse + lobe) - 1.0).abs() < 1e-2, "{whole} {diffuse} {lobe}");
    let [diffuse, lobe, whole] = reflected(sun(1.0, 1.0), behind);
    assert!(lobe == 0.0 && (whole / diffuse - 1.0).abs() < 1e-2 && (diffuse / expected - 1.0).abs() < 1e-2);
    // Above the face but behind the normal's horizon, and the reverse.
    assert_eq!(reflected(sun(-0.8, 0.3), ahead), [0.0; 3]);
    assert_eq!(reflected(sun(0.9, -0.1), ahead), [0.0; 3]);
}

#[test]
fn samples_are_darkened_and_counted_only_when_asked() {
    let world = room();
    let point = first_hit(&world, Vec3::new(0.3, -3.0, 1.2), Vec3::new(0.0, 3.0, -0.5));
    let run = |clamp| {
        let tracer = PathTracer::new(&world, PathParams { clamp, ..bounces(4) }).unwrap();
        let mut tally = Tally::default();
        let brightest = (0..2000).map(|k| tracer.diffuse(&point, 0, k, &mut tally)).map(brightness).fold(0.0, f32::max);
        (brightest, tally)
    };
    let (free, tally) = run(None);
    assert!(tally.clamped == 0 && free > 4.0, "{free}");
    let (bound, tally) = run(Some(2.0));
    assert!(tally.clamped > 0 && (bound - 2.0).abs() < 1e-5, "{bound}");
    assert_eq!(run(Some(1e6)).1.clamped, 0);
    assert!(PathTracer::new(&world, PathParams { clamp: Some(0.0), ..bounces(4) }).is_err());
}

fn brightness(colour: Vec3) -> f32 {
    prt_transfer::image::tone::luminance(colour.to_array())
}

#[test]
fn a_texture_that_is_no_number_is_counted_and_never_spreads() {
    let broken = Material { diffuse: Texture::Pattern(|_| Vec3::NAN), ..grey("lambert") };
    let walls = Material { emission: Vec3::ONE, ..grey("lambert:albedo=0.5") };
    let mut small = floor(0.2);
    small.positions.iter_mut().for_each(|p| p.z = -0.5);
    let world = world(vec![object("box", cube_inside(), walls), object("patch", small, broken)], None);
    let tracer = PathTracer::new(&world, bounces(4)).unwrap();
    let mut tally = Tally::default();
    assert_eq!(tracer.incoming(Vec3::ZERO, -Vec3::Z, 0, 0, &mut tally), Vec3::ZERO, "it emits nothing");
    assert_eq!(tally.not_finite, 1);
    let point = world.point(0, 3, 0.3, 0.3);
    let all = (0..1000).map(|k| tracer.diffuse(&point, 0, k, &mut tally)).fold(Vec3::ZERO, |sum, x| sum + x);
    assert!(all.is_finite() && all.x > 300.0 && (2..500).contains(&tally.not_finite), "{all} {tally:?}");
}

#[test]
fn zero_area_faces_and_a_world_in_the_dark_give_finite_radiance() {
    let mut mesh = floor(1.0);
    mesh.positions.extend([Vec3::new(-0.5, 0.0, 0.5), Vec3::new(0.0, 0.0, 0.5), Vec3::new(0.5, 0.0, 0.5)]);
    mesh.faces.extend([[4, 5, 6], [4, 4, 6]]);
    let dark = world(vec![object("dark", mesh.clone(), grey("phong:diffuse=0.5:specular=0.5"))], None);
    let tracer = PathTracer::new(&dark, PathParams::default()).unwrap();
    let mut tally = Tally::default();
    for k in 0..100 {
        assert_eq!(tracer.incoming(Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 0.0, -1.0), 0, k, &mut tally), Vec3::ZERO);
    }
    let shining = Material { emission: Vec3::ONE, ..grey("phong:diffuse=0.5:specular=0.5") };
    let bright = world(vec![object("bright", mesh, shining)], Some(uniform_sky(1.0)));
    let tracer = PathTracer::new(&bright, PathParams::default()).unwrap();
    for face in 0..4 {
        let point = bright.point(0, face, 0.3, 0.3);
        for k in 0..50 {
            assert!(tracer.diffuse(&point, 0, k, &mut tally).is_finite());
            assert!(tracer.lobe(&point, up(0.3), 0, k, &mut tally).is_finite());
        }
    }
    assert_eq!(tally.not_finite, 0);
}
