//! Each strategy alone, and both together, have one expectation.

use super::lights::{Lights, Source};
use super::sequence::Sequence;
use super::*;
use crate::mesh::Mesh;
use crate::scene::environment::{Cap, Environment};
use crate::scene::lights;
use crate::scene::material::Material;
use crate::scene::world::{Object, World};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// A glossy floor under a lamp and a sky with a large cap.
fn world(label: &str) -> World {
    let plate = |corner: Vec3, a: Vec3, b: Vec3| Mesh {
        positions: vec![corner, corner + a, corner + a + b, corner + b],
        normals: Vec::new(),
        faces: vec![[0, 1, 2], [0, 2, 3]],
    };
    let object = |name: &str, mesh, emission| {
        let material = Material { emission, ..Material::grey(label.parse().unwrap()) };
        Object { name: name.into(), mesh, uv: Vec::new(), border: Default::default(), material }
    };
    let cap = Cap { centre: DVec3::new(0.6, 0.0, 0.8), radius: 0.3, radiance: [20.0, 10.0, 5.0] };
    let sky = Environment::new(|d| DVec3::splat(1.0 + 0.5 * d.x), vec![cap]);
    let floor = plate(Vec3::new(-1.0, -1.0, 0.0), 2.0 * Vec3::X, 2.0 * Vec3::Y);
    let lamp = plate(Vec3::new(-0.9, -0.5, 0.8), Vec3::Y, Vec3::X);
    let objects = vec![object("floor", floor, Vec3::ZERO), object("lamp", lamp, Vec3::new(2.0, 4.0, 8.0))];
    World::new(objects, Some(sky)).unwrap()
}

#[test]
fn lights_alone_and_reflectance_alone_and_both_agree() {
    for label in ["lambert:albedo=0.8", "cook-torrance:roughness=0.4:diffuse=0.3:specular=0.7"] {
        let world = world(label);
        let point = world.point(0, 0, 0.3, 0.4);
        let view = Vec3::new(0.5, 0.2, 1.0).normalize();
        for bounces in [1, 3] {
            let results = [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0, 3.0]].map(|efforts| {
                let mut tracer = PathTracer::new(&world, PathParams { bounces, ..PathParams::default() }).unwrap();
                tracer.efforts = efforts;
                let (n, mut tally) = (40_000, Tally::default());
                let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
                for k in 0..n {
                    let diffuse = tracer.diffuse(&point, 4, k, &mut tally);
                    let sample = (diffuse + tracer.lobe(&point, view, 4, k, &mut tally)).as_dvec3();
                    sum += sample;
                    squares += sample * sample;
                }
                let mean = sum / f64::from(n);
                (mean, (squares / f64::from(n) - mean * mean) / f64::from(n))
            });
            let (both, variance) = results[0];
            for (alone, other) in &results[1..] {
                for channel in 0..3 {
                    let error = (variance[channel] + other[channel]).sqrt();
                    assert!(error < 0.02 * both[channel]);
                    assert!((alone[channel] - both[channel]).abs() < 4.0 * error, "{label} {bounces}: {results:?}");
                }
                assert!(variance.element_sum() <= 1.05 * other.element_sum(), "{label}: {results:?}");
            }
        }
    }
}

#[test]
fn directions_to_the_sky_have_the_density_that_is_told() {
    let black = |caps| Environment::new(|_| DVec3::ZERO, caps);
    let caps = [(DVec3::X, 0.3, 7.0), (DVec3::NEG_Z, 1.2, 1.0), (DVec3::new(0.0, 0.6, 0.8), 0.02, 0.0)];
    let caps = caps.map(|(centre, radius, radiance)| Cap { centre, radius, radiance: [radiance; 3] });
    let built_in = |name: &str| lights::find(name).unwrap().environment();
    let lit = Environment::new(|d| DVec3::splat(0.01 + d.x.max(0.0).powi(8)), caps.to_vec());
    // The last sends light only from two caps, of which one has all of z < -cos 1.2 and the other is beyond x = cos 0.3.
    for (sky, of_caps) in
        [(built_in("sky"), false), (built_in("room"), false), (lit, false), (black(caps.to_vec()), true)]
    {
        let floor = world("lambert").objects()[0].clone();
        let world = World::new(vec![floor], Some(sky)).unwrap();
        let lights = Lights::of(&world).unwrap();
        let n = 1 << 16;
        let mut sums = [0.0; 3];
        for k in 0..n {
            let towards = lights.sample(DVec3::ZERO, Sequence::new(1, 2, k).light(1), 0.0).unwrap();
            assert!(matches!(towards.source, Source::Sky) && towards.direction.is_normalized());
            assert_eq!(towards.density, lights.density_of_sky(towards.direction));
            let d = towards.direction;
            let values = [1.0, d.z * d.z, (10.0 * (d.dot(DVec3::X) - 1.0)).exp()];
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value / towards.density / f64::from(n));
        }
        let area = |radius: f64| 2.0 * PI * (1.0 - radius.cos());
        if of_caps {
            assert!((sums[0] / (area(0.3) + area(1.2)) - 1.0).abs() < 1e-3, "{sums:?}");
            continue;
        }
        // ∫ 1, ∫ z² and ∫ exp(10 (x - 1)) over the sphere.
        let expected = [4.0 * PI, 4.0 * PI / 3.0, PI / 5.0 * (1.0 - (-20.0f64).exp())];
        for (found, expected) in sums.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.01, "{sums:?} {expected}");
        }
    }
}
