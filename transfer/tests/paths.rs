//! Radiance of the path tracer: furnaces, closed forms, reciprocity, a quadrature.
#![cfg(feature = "scene")]

mod worlds;

use glam::{DVec3, Vec3};
use prt_transfer::mesh::Mesh;
use prt_transfer::random::Random;
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::environment::{Cap, Environment};
use prt_transfer::scene::material::Material;
use prt_transfer::scene::path::{PathParams, PathTracer, Tally};
use prt_transfer::scene::shapes;
use prt_transfer::scene::world::World;
use std::f64::consts::{PI, TAU};
use worlds::{agree, bounces, cube_inside, floor, grey, lamp, mean, object, plate, uniform_sky, up, world};

/// The unit sphere without normals: flat faces.
fn sphere(steps: usize) -> Mesh {
    Mesh { normals: Vec::new(), ..shapes::sphere(steps) }
}

#[test]
fn a_white_convex_object_vanishes_in_a_uniform_sky() {
    let world = world(vec![object("ball", sphere(12), grey("lambert"))], Some(uniform_sky(1.0)));
    let tracer = PathTracer::new(&world, PathParams::default()).unwrap();
    let mut tally = Tally::default();
    for (key, direction) in [Vec3::X, Vec3::new(0.5, 0.5, -0.7), Vec3::new(-0.3, -0.9, 0.1)].into_iter().enumerate() {
        let direction = direction.normalize();
        let aside = 0.6 * direction.any_orthonormal_vector();
        let seen = |k| tracer.incoming(aside - 3.0 * direction, direction, key as u64, k, &mut tally).y.into();
        agree("furnace", mean(2000, seen), 1.0);
    }
    assert_eq!((tally.not_finite, tally.clamped, tally.paths), (0, 0, 6000));
    // The eye's ray, and two at the one point that a path has.
    assert!(tally.rays <= 3 * tally.paths && tally.rays > 2 * tally.paths);
}

#[test]
fn a_plate_in_a_uniform_sky_reflects_its_albedo() {
    for label in [
        "phong:diffuse=0.3:specular=0.6:exponent=60",
        "cook-torrance:roughness=0.02:f0=0.5",
        "cook-torrance:roughness=0.4:diffuse=0.5:specular=0.5",
        "ward:alpha_x=0.1:alpha_y=0.5",
    ] {
        let brdf: Brdf = label.parse().unwrap();
        let world = world(vec![object("plate", floor(1.0), grey(label))], Some(uniform_sky(2.0)));
        let tracer = PathTracer::new(&world, PathParams::default()).unwrap();
        let point = world.point(0, 0, 0.3, 0.3);
        for tilt in [0.0, 0.7, 1.3] {
            let view = up(tilt);
            let local = point.frame().to_local(view).as_dvec3();
            let mut tally = Tally::default();
            let radiance = |k| {
                let lobe = tracer.lobe(&point, view, 1, k, &mut tally);
                f64::from((lobe + tracer.diffuse(&point, 1, k, &mut tally)).x)
            };
            let (found, error) = mean(4000, radiance);
            // Brdf::albedo is exact to 2e-3 of the lobe.
            let expected = 2.0 * brdf.albedo(local);
            assert!((found - expected).abs() < 4.0 * error + 4e-3, "{label} {tilt}: {found} {error} {expected}");
        }
    }
}

#[test]
fn inside_of_a_shining_box_every_reflection_adds_a_power_of_the_albedo() {
    let walls = Material { emission: Vec3::new(1.0, 2.0, 0.0), ..grey("lambert:albedo=0.6") };
    let world = world(vec![object("box", cube_inside(), walls)], None);
    for k in [0, 1, 2, 5, 40] {
        let tracer = PathTracer::new(&world, PathParams { roulette: 2, ..bounces(k) }).unwrap();
        let mut tally = Tally::default();
        let seen = |i| tracer.incoming(Vec3::ZERO, up(0.4), 3, i, &mut tally).x.into();
        let series: f64 = (0..=k as i32).map(|j| 0.6f64.powi(j)).sum();
        agree(&format!("{k} reflections"), mean(20_000, seen), series);
    }
}

/// Irradiance from a polygon of radiance 1 whose corners run counter-clockwise seen from the point, on a surface of this normal that has
/// all of it above its horizon: Lambert's formula, ½ Σ Θ (n · unit normal of the triangle of point and edge).
fn lambert_formula(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let rays: Vec<DVec3> = corners.iter().map(|corner| (corner - point).normalize()).collect();
    let next = rays.iter().cycle().skip(1);
    rays.iter()
        .zip(next)
        .map(|(a, b)| 0.5 * a.angle_between(*b) * normal.dot(a.cross(*b).normalize()))
        .sum::<f64>()
        .abs()
}

#[test]
fn a_rectangle_lights_a_diffuse_floor_as_lambert_says_also_half_hidden() {
    let source = plate(Vec3::new(-0.5, -0.4, 1.0), 0.9 * Vec3::Y, Vec3::new(1.1, 0.0, 0.3));
    let blind = plate(Vec3::new(-9.0, -9.0, 0.3), 18.0 * Vec3::Y, 9.0 * Vec3::X);
    let corners: Vec<DVec3> = source.positions.iter().map(|p| p.as_dvec3()).collect();
    let ground = object("floor", floor(2.0), grey("lambert:albedo=0.7"));
    let lit = object("lamp", source, lamp(Vec3::new(3.0, 1.0, 0.0)));
    let open = world(vec![ground.clone(), lit.clone()], None);
    let hidden = world(vec![ground, lit, object("blind", blind, grey("lambert"))], None);
    // Weights that put the point at x = 0, and one elsewhere.
    for (weights, world, half) in [([0.1, 0.7], &open, false), ([0.0, 0.5], &open, false), ([0.0, 0.5], &hidden, true)]
    {
        let point = world.point(0, 0, weights[0], weights[1]);
        // From x = 0 the blind hides the part of the source with x < 0.
        let edge = |a: usize, b: usize| corners[a].lerp(corners[b], 0.5 / 1.1);
        let seen = if half { vec![edge(0, 3), edge(1, 2), corners[2], corners[3]] } else { corners.clone() };
        let expected = 3.0 * 0.7 / PI * lambert_formula(point.position.as_dvec3(), DVec3::Z, &seen);
        let tracer = PathTracer::new(world, bounces(1)).unwrap();
        let mut tally = Tally::default();
        let sample = |k| tracer.diffuse(&point, 5, k, &mut tally).x.into();
        let (found, error) = mean(40_000, sample);
        assert!(error < 5e-3 * expected, "worth comparing: {error} {expected}");
        // Rays are lifted by 1e-4 of the world.
        assert!(
            (found - expected).abs() < 4.0 * error + 1e-3 * expected,
            "{weights:?} {half}: {found} {error} {expected}"
        );
    }
}

/// Radiance reflected towards a local view at z up: background by a fine grid, caps by closed forms of a constant BRDF over each.
fn quadrature(brdf: &Brdf, view: DVec3, background: impl Fn(DVec3) -> f64, caps: &[(Cap, f64)]) -> f64 {
    let (rings, sectors) = (1000, 2000);
    let mut sum = 0.0;
    for ring in 0..rings {
        let z = (f64::from(ring) + 0.5) / f64::from(rings);
        let sine = (1.0 - z * z).sqrt();
        for sector in 0..sectors {
            let (y, x) = (TAU * (f64::from(sector) + 0.5) / f64::from(sectors)).sin_cos();
            let light = DVec3::new(sine * x, sine * y, z);
            sum += brdf.evaluate(view, light) * z * background(light);
        }
    }
    sum *= TAU / f64::from(rings) / f64::from(sectors);
    // ∫ cos θ dω over a cap above the horizon is π sin² r · cos of its centre.
    let of_cap = |(cap, more): &(Cap, f64)| {
        PI * cap.radius.sin().powi(2) * cap.centre.z * brdf.evaluate(view, cap.centre) * more
    };
    sum + caps.iter().map(of_cap).sum::<f64>()
}

#[test]
fn direct_light_of_a_sky_with_caps_is_that_of_a_quadrature() {
    let background = |d: DVec3| 0.2 + d.z.max(0.0).powi(3) + f64::from(u8::from(d.x > 0.3 && d.z > 0.1));
    let cap = |centre: DVec3, radius, radiance: f64| Cap { centre, radius, radiance: [radiance; 3] };
    let sun = cap(DVec3::new(-0.6, 0.0, 0.8), 0.01, 2000.0);
    let moon = cap(DVec3::new(0.0, 0.8, 0.6), 0.05, 40.0);
    let below = cap(DVec3::NEG_Z, 0.2, 10.0);
    let more = [sun, moon].map(|cap| (cap, cap.radiance[0] - background(cap.centre)));
    for label in ["lambert:albedo=0.8", "cook-torrance:roughness=0.3:diffuse=0.3:specular=0.7", "phong:exponent=20"] {
        let sky = Environment::new(move |d| DVec3::splat(background(d)), vec![sun, moon, below]);
        let world = world(vec![object("plate", floor(1.0), grey(label))], Some(sky));
        let tracer = PathTracer::new(&world, bounces(1)).unwrap();
        let point = world.point(0, 0, 0.3, 0.3);
        let view = up(0.5);
        let local = point.frame().to_local(view).as_dvec3();
        assert!((local - view.as_dvec3()).length() < 1e-6, "local coordinates are those of the world here");
        let expected = quadrature(&label.parse().unwrap(), local, background, &more);
        let mut tally = Tally::default();
        let radiance = |k| {
            let diffuse = tracer.diffuse(&point, 2, k, &mut tally);
            f64::from((diffuse + tracer.lobe(&point, view, 2, k, &mut tally)).z)
        };
        let (found, error) = mean(60_000, radiance);
        assert!((found - expected).abs() < 4.0 * error + 2e-3 * expected, "{label}: {found} {error} {expected}");
        assert!(error < 0.02 * expected, "worth comparing: {error} {expected}");
    }
}

/// A plate A, a plate B, both looking up, and what throws light from one to the other.
fn exchange(shining: &str) -> World {
    let plate_at = |x: f32| plate(Vec3::new(x, -0.6, 0.0), 0.8 * Vec3::X, 1.2 * Vec3::Y);
    let patch = |name: &str, x: f32| {
        let emission = if name == shining { Vec3::ONE } else { Vec3::ZERO };
        object(name, plate_at(x), Material { emission, ..grey("lambert:albedo=0.5") })
    };
    let ceiling = plate(Vec3::new(-1.5, -1.0, 1.6), 2.0 * Vec3::Y, 3.0 * Vec3::X);
    let mut ball = sphere(5);
    ball.positions.iter_mut().for_each(|p| *p = 0.4 * *p + Vec3::new(-0.3, 0.1, 0.8));
    let mut ground = floor(2.0);
    ground.positions.iter_mut().for_each(|p| p.z = -0.2);
    World::new(
        vec![
            patch("A", -1.3),
            patch("B", 0.4),
            object("ceiling", ceiling, grey("lambert:albedo=0.8")),
            object("ball", ball, grey("cook-torrance:roughness=0.2:diffuse=0.2:specular=0.8")),
            object("floor", ground, grey("ward:alpha_x=0.2:alpha_y=0.4:diffuse=0.3:specular=0.6")),
        ],
        None,
    )
    .unwrap()
}

#[test]
fn what_b_receives_of_a_is_what_a_receives_of_b() {
    let received = |from: &str, by: usize| {
        let world = exchange(from);
        let tracer = PathTracer::new(&world, bounces(8)).unwrap();
        let (mut tally, mut random) = (Tally::default(), Random(11));
        mean(120_000, |k| {
            let root = random.uniform().sqrt();
            let (u, v) = (1.0 - root, root * random.uniform());
            let point = world.point(by, k % 2, u as f32, v as f32);
            tracer.diffuse(&point, 1, k, &mut tally).x.into()
        })
    };
    let [(to_b, error_b), (to_a, error_a)] = [received("A", 1), received("B", 0)];
    assert!(error_a.max(error_b) < 0.02 * to_a && to_a > 0.0, "{to_a} {error_a} {to_b} {error_b}");
    assert!((to_b - to_a).abs() < 4.0 * error_a.hypot(error_b), "{to_b} ± {error_b}, {to_a} ± {error_a}");
}
