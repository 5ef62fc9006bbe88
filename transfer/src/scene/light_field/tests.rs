use super::*;
use crate::progress::Quiet;
use crate::scene::chart::shapes::{rectangle, sphere};
use crate::scene::environment::Environment;
use crate::scene::material::Material;
use crate::scene::path::PathParams;
use crate::scene::world::World;
use glam::DVec3;
use proptest::prelude::*;

const SMALL: FieldParams = FieldParams {
    width: 4,
    height: 4,
    around: 16,
    down: 8,
    supersampling: 2,
    filter: None,
    diffuse: 64,
    horizon: Horizon::Continued,
    frame: Directions::World,
};

fn object(charted: crate::scene::chart::Charted, brdf: &str, emission: f32) -> Object {
    let material = Material { emission: Vec3::splat(emission), ..Material::grey(brdf.parse().unwrap()) };
    Object { name: brdf.into(), mesh: charted.mesh, uv: charted.uv, border: charted.border, material }
}

/// A sphere of some surface under an evenly bright sky.
fn furnace(brdf: &str) -> World {
    let sky = Environment::new(|_| DVec3::ONE, Vec::new());
    World::new(vec![object(sphere(DVec3::ZERO, 1.0, 32), brdf, 0.0)], Some(sky)).unwrap()
}

fn traced(world: &World, params: &FieldParams) -> LightField {
    let tracer = PathTracer::new(world, PathParams::default()).unwrap();
    light_field(&tracer, 0, params, &Quiet).unwrap()
}

fn elements(field: &LightField) -> &[f32] {
    field.matrix.as_dense().unwrap()
}

#[test]
fn a_white_matte_sphere_in_a_white_furnace_is_white_in_every_direction() {
    let world = furnace("lambert:albedo=1");
    let field = traced(&world, &SMALL);
    // Two strategies that are weighed against each other leave some noise even here; a texel has one value in all directions.
    let texels: Vec<f32> = elements(&field).chunks(field.matrix.lights()).map(|row| row[0]).collect();
    assert!(elements(&field).chunks(field.matrix.lights()).all(|row| row.iter().all(|v| *v == row[0])));
    let mean = texels.iter().sum::<f32>() / texels.len() as f32;
    assert!((mean - 1.0).abs() < 0.01 && texels.iter().all(|v| (v - 1.0).abs() < 0.05), "{mean}");
    assert_eq!((field.gutter, field.unused, field.tally.not_finite), (0, 0, 0));
    // Below the horizon nothing leaves an opaque surface.
    let dark = traced(&world, &FieldParams { horizon: Horizon::Dark, ..SMALL });
    let lit = elements(&dark).iter().filter(|v| **v > 0.0).count() as f64 / elements(&dark).len() as f64;
    assert!((0.4..0.6).contains(&lit), "{lit}");
}

#[test]
fn a_glossy_sphere_in_a_white_furnace_shows_the_albedo_of_its_brdf() {
    let brdf = "cook-torrance:roughness=0.4:diffuse=0.2:specular=0.6";
    let world = furnace(brdf);
    let params = FieldParams { supersampling: 4, diffuse: 256, horizon: Horizon::Dark, ..SMALL };
    let (field, grid) = (traced(&world, &params), Grid::new(&params));
    let (known, places): (crate::scene::brdf::Brdf, _) =
        (brdf.parse().unwrap(), world.objects()[0].charted().unwrap().places(4, 4).unwrap());
    let (mut sum, mut count, n) = (0.0, 0, grid.directions.len());
    for (texel, place) in places.places.iter().enumerate() {
        let place = place.unwrap();
        let point = world.point(0, place.face, place.u, place.v);
        for (direction, towards) in grid.directions.iter().enumerate() {
            let cosine = f64::from(point.normal.dot(*towards));
            if cosine > 0.35 {
                let expected = known.albedo(DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine));
                let found = f64::from(elements(&field)[3 * texel * n + direction]);
                assert!((found - expected).abs() < 0.25, "{cosine}: {found} {expected}");
                sum += found - expected;
                count += 1;
            }
        }
    }
    assert!(count > 200 && (sum / f64::from(count)).abs() < 0.01, "{}", sum / f64::from(count));
}

#[test]
fn the_same_field_on_any_number_of_threads_and_another_one_from_another_seed() {
    let world = furnace("phong:diffuse=0.3:specular=0.5");
    let on = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let tracer = PathTracer::new(&world, PathParams { seed, ..PathParams::default() }).unwrap();
        pool.install(|| elements(&light_field(&tracer, 0, &SMALL, &Quiet).unwrap()).to_vec())
    };
    assert_eq!(on(1, 0), on(2, 0));
    assert_ne!(on(1, 0), on(1, 1));
}

#[test]
fn directions_that_are_reflected_name_the_radiance_of_those_in_the_world() {
    // A smooth sky on a smooth lobe: both grids sample one smooth function, each its own way.
    let sky = Environment::new(|d| DVec3::splat(2.0 + d.x + 0.5 * d.z), Vec::new());
    let brdf = "phong:diffuse=0.2:specular=0.6:exponent=4";
    let world = World::new(vec![object(sphere(DVec3::ZERO, 1.0, 32), brdf, 0.0)], Some(sky)).unwrap();
    let params = FieldParams { around: 32, down: 16, supersampling: 3, horizon: Horizon::Dark, ..SMALL };
    let [straight, reflected] = [Directions::World, Directions::Reflected]
        .map(|frame| traced(&world, &FieldParams { frame, ..params.clone() }));
    assert_eq!(reflected.matrix.responses().to_string(), "texels:4x4:octahedral:reflected");
    let (grid, places) = (Grid::new(&params), world.objects()[0].charted().unwrap().places(4, 4).unwrap());
    let (mut sum, mut square, mut count, n) = (0.0, 0.0, 0.0, grid.directions.len());
    for (texel, place) in places.places.iter().enumerate() {
        let place = place.unwrap();
        let point = world.point(0, place.face, place.u, place.v);
        for (direction, &towards) in grid.directions.iter().enumerate().filter(|(_, d)| d.dot(point.normal) > 0.4) {
            let mirror = grid.cell(mirrored(towards, point.normal));
            let [a, b] = [(&straight, direction), (&reflected, mirror)].map(|(f, d)| elements(f)[3 * texel * n + d]);
            (sum, square, count) = (sum + f64::from(a - b), square + f64::from(a - b).powi(2), count + 1.0);
        }
    }
    assert!(
        count > 1000.0 && (sum / count).abs() < 0.01 && (square / count).sqrt() < 0.15,
        "{} {}",
        sum / count,
        square / count
    );
}

#[test]
fn a_lamp_shines_alike_in_all_directions() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from);
    let lamp = World::new(vec![object(rectangle(corners, 1).unwrap(), "lambert:albedo=0", 3.0)], None).unwrap();
    assert!(elements(&traced(&lamp, &SMALL)).iter().all(|v| *v == 3.0));
}

#[test]
fn parameters_out_of_range_and_objects_without_a_chart_are_refused() {
    let refused = |params: FieldParams| params.check().unwrap_err().to_string();
    assert!(refused(FieldParams { down: 1, ..SMALL }).contains("down"));
    assert!(refused(FieldParams { width: 0, ..SMALL }).contains("from 1 to 4096"));
    assert!(refused(FieldParams { filter: Some(3), ..SMALL }).contains("supersampling=2"));
    let mut bare = object(sphere(DVec3::ZERO, 1.0, 8), "lambert", 0.0);
    bare.uv.clear();
    let world = World::new(vec![bare], None).unwrap();
    let tracer = PathTracer::new(&world, PathParams::default()).unwrap();
    let message = light_field(&tracer, 0, &SMALL, &Quiet).unwrap_err().to_string();
    assert!(message.contains("lambert"), "{message}");
}

#[test]
fn finer_directions_lie_in_their_cells() {
    let grid = Grid::new(&FieldParams { supersampling: 3, filter: Some(3), ..SMALL });
    let mut seen = vec![0u32; grid.directions.len()];
    for (fine, direction) in grid.fine.iter().enumerate() {
        let (cell, number) = grid.cell_of(fine);
        assert_eq!(grid.cell(*direction), cell);
        seen[cell] += 1 << number;
    }
    assert!(seen.iter().all(|seen| *seen == 0b1_1111_1111));
}

proptest! {
    #[test]
    fn the_box_filter_keeps_constants_and_stays_between_the_extremes(s in 1usize..4, more in 0usize..4, seed in 0u64..1000) {
        let params = FieldParams { supersampling: s, filter: Some(s + 2 * more), ..SMALL };
        params.check().unwrap();
        let grid = Grid::new(&params);
        let number = |i: usize| (i as u64 * 2654435761 + seed) as u32 % 1000;
        let fine: Vec<Option<Vec3>> =
            (0..grid.fine.len()).map(|i| (number(i) > 300).then(|| Vec3::new(2.0, number(i) as f32, 0.0))).collect();
        let mut out = vec![None; grid.directions.len()];
        grid.filter(&fine, &mut out);
        for radiance in out.iter().flatten() {
            prop_assert!((radiance.x - 2.0).abs() < 1e-5 && radiance.z == 0.0);
            prop_assert!((300.0..=1000.0).contains(&radiance.y));
        }
        // A box of a cell sees its finer directions and no other.
        if more == 0 {
            let none = |cell: usize| (0..grid.fine.len()).all(|i| grid.cell_of(i).0 != cell || fine[i].is_none());
            prop_assert!((0..out.len()).all(|cell| out[cell].is_none() == none(cell)));
        }
    }

    #[test]
    fn below_the_horizon_a_field_goes_on_without_an_edge(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0) {
        let Some(normal) = Vec3::new(x, y, z).try_normalize() else { return Ok(()) };
        let params = FieldParams { around: 64, down: 32, ..SMALL };
        let grid = Grid::new(&params);
        // A smooth field over the upper half.
        let smooth = |d: Vec3| Vec3::splat(2.0 + d.x + 0.5 * d.y * d.z);
        let mut radiance: Vec<Option<Vec3>> =
            grid.directions.iter().map(|&d| (d.dot(normal) > 0.0).then(|| smooth(d))).collect();
        horizon::continue_below(&grid, normal, &mut radiance);
        for (i, &d) in grid.directions.iter().enumerate() {
            let value = radiance[i].expect("every direction is filled");
            prop_assert!((0.5..3.6).contains(&value.x));
            // Between neighbours the field changes by little more than a smooth one does over a cell or two.
            if (-0.09..0.0).contains(&d.dot(normal)) {
                prop_assert!((value.x - smooth(d).x).abs() < 0.75, "{} {}", value.x, smooth(d).x);
            }
        }
    }
}
