//! Promises of the visibility engine: closed forms, identities, and second computations.

use super::bvh::Occluders;
use super::directions::{Directions, tests::each};
use super::exact;
use super::sweep::Sweep;
use super::visibility_kernel::{Portable, Task};
use crate::basis::LightBasis;
use crate::error::Error;
use crate::mesh::Mesh;
use glam::{EulerRot, Quat, Vec3};
use proptest::prelude::*;
use std::f64::consts::PI;

fn mesh(positions: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Mesh {
    Mesh { positions, normals: vec![], faces }
}

/// An octahedron whose triangles are split in four `levels` times, blown up to the unit sphere.
fn sphere(levels: usize) -> Mesh {
    let mut positions = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut faces: Vec<[u32; 3]> = (0..8)
        .map(|k| [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2)])
        .map(|[x, y, z]| if (x + y + z) % 2 == 0 { [x, y, z] } else { [y, x, z] })
        .collect();
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
            })
            .collect();
    }
    mesh(positions, faces)
}

/// A box with corners at ±half; `walls` of its six (-x, +x, -y, +y, -z, +z).
fn cuboid(half: Vec3, walls: std::ops::Range<usize>) -> Mesh {
    let positions = (0..8).map(|k| half * Vec3::new(sign(k), sign(k >> 1), sign(k >> 2))).collect();
    let quads = [[0u32, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    mesh(positions, quads[walls].iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

fn sign(bit: u32) -> f32 {
    if bit & 1 == 0 { -1.0 } else { 1.0 }
}

fn masks(occluders: &Occluders, origin: Vec3, normal: Vec3, directions: &Directions) -> Vec<u64> {
    let mut out = vec![!0; directions.tiles()];
    let rays = occluders.visible(origin, normal, directions, &mut out);
    let above = each(directions).filter(|&(_, _, d)| d.dot(normal) > 0.0).count();
    assert_eq!(rays, above as u64);
    out
}

fn count(masks: &[u64]) -> u32 {
    masks.iter().map(|m| m.count_ones()).sum()
}

/// Visible solid angle from the origin upward, by texels of a 6 x 128 x 128 cubemap.
fn solid_angle(mesh: &Mesh) -> f64 {
    let directions = Directions::cubemap(128, 1).unwrap();
    let angles = LightBasis::Cubemap { resolution: 128 }.solid_angles().unwrap();
    // Turned, so that no border runs along the texels, all of whose centres would then err to the same side.
    let turn = Quat::from_euler(EulerRot::XYZ, 0.4, 0.7, 0.2);
    let turned = Mesh { positions: mesh.positions.iter().map(|&p| turn * p).collect(), ..mesh.clone() };
    let (occluders, up) = (Occluders::new(&turned).unwrap(), turn * Vec3::Z);
    let out = masks(&occluders, up * -occluders.offset(), up, &directions);
    directions.indices(&out).map(|k| angles[k]).sum()
}

/// A texel is 0.016 rad wide: borders of a few radians, met by texel centres on either side, average out far below this.
const DISCRETISATION: f64 = 0.005;

#[test]
fn a_convex_mesh_sees_its_whole_hemisphere_from_every_vertex() {
    let sphere = sphere(3);
    let occluders = Occluders::new(&sphere).unwrap();
    let directions = Directions::cubemap(16, 2).unwrap();
    let points: Vec<_> = sphere.positions.iter().map(|&p| (p, p)).collect();
    let rays = occluders.visible_from(&points, &directions, |k, masks| {
        assert!(each(&directions).all(|(tile, bit, d)| (masks[tile] >> bit & 1 == 1) == (d.dot(points[k].1) > 0.0)));
    });
    assert!((rays.unwrap() as f64 / (points.len() * directions.count()) as f64 - 0.5).abs() < 0.01);
}

#[test]
fn a_point_under_a_disk_sees_the_rest_of_the_hemisphere() {
    let n = 512;
    for (height, radius) in [(0.5f32, 1.0f32), (1.0, 0.25), (0.01, 1.0)] {
        let rim = (0..n).map(|k| std::f32::consts::TAU * k as f32 / n as f32);
        let mut positions: Vec<_> = rim.map(|a| Vec3::new(radius * a.cos(), radius * a.sin(), height)).collect();
        positions.push(Vec3::Z * height);
        let disk = mesh(positions, (0..n).map(|k| [k, (k + 1) % n, n]).collect());
        let expected = 2.0 * PI * f64::from(height) / f64::from(height).hypot(f64::from(radius));
        assert!(
            (solid_angle(&disk) - expected).abs() < DISCRETISATION,
            "{height} {radius}: {} {expected}",
            solid_angle(&disk)
        );
    }
}

#[test]
fn a_point_between_two_planes_sees_the_gap() {
    // Squares of half width a at heights ±h: the upper one takes 4 asin(a² / (a² + h²)) of the upper hemisphere.
    for (a, h) in [(1.0, 1.0), (10.0, 0.5), (1.0, 0.01)] {
        let planes = cuboid(Vec3::new(a, a, h), 4..6);
        let (a, h) = (f64::from(a), f64::from(h));
        let expected = 2.0 * PI - 4.0 * (a * a / (a * a + h * h)).asin();
        assert!(
            (solid_angle(&planes) - expected).abs() < DISCRETISATION,
            "{a} {h}: {} {expected}",
            solid_angle(&planes)
        );
    }
}

#[test]
fn a_point_in_a_box_sees_its_opening_and_nothing_else() {
    let half = Vec3::new(0.5, 0.75, 0.6);
    let [a, b, h] = half.to_array().map(f64::from);
    let expected = 4.0 * (a * b / (h * (a * a + b * b + h * h).sqrt())).atan();
    assert!((solid_angle(&cuboid(half, 0..5)) - expected).abs() < DISCRETISATION);
    assert_eq!(solid_angle(&cuboid(half, 0..6)), 0.0);
}

#[test]
fn an_empty_mesh_sees_everything() {
    let directions = Directions::cubemap(5, 3).unwrap();
    for mesh in [Mesh::default(), mesh(vec![Vec3::ONE; 3], vec![[0, 1, 2]]), mesh(vec![Vec3::X], vec![[0, 0, 0]])] {
        let occluders = Occluders::new(&mesh).unwrap();
        let [up, down] =
            [1.0, -1.0].map(|s| masks(&occluders, Vec3::ZERO, s * Vec3::new(0.12, 0.31, 0.94), &directions));
        assert!(up.iter().zip(&down).enumerate().all(|(tile, (u, d))| u ^ d == directions.filled(tile)));
        assert!(occluders.nearest(Vec3::ZERO, Vec3::X).is_none());
    }
}

/// Coordinates and origins on a coarse lattice: edges in line with the origin, faces edge-on, corners on the axes, doubled and
/// collinear triangles come up all the time.
fn lattice() -> impl Strategy<Value = (Mesh, Vec3)> {
    let point = || prop::array::uniform3(-8i8..=8).prop_map(|p| Vec3::from_array(p.map(|x| f32::from(x) / 4.0)));
    (prop::collection::vec(point(), 3..60), prop::collection::vec(prop::array::uniform3(0usize..60), 1..60), point())
        .prop_map(|(positions, faces, origin)| {
            let faces = faces.iter().map(|f| f.map(|i| (i % positions.len()) as u32)).collect();
            (mesh(positions, faces), origin)
        })
}

fn soup() -> impl Strategy<Value = (Mesh, Vec3)> {
    let point = || prop::array::uniform3(-1f32..1.0).prop_map(Vec3::from_array);
    (prop::collection::vec((point(), point(), point()), 1..80), 0.02f32..1.0, point()).prop_map(
        |(corners, size, origin)| {
            let positions = corners.iter().flat_map(|&(a, b, c)| [a, a + size * b, a + size * c]).collect();
            (mesh(positions, (0..corners.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect()), origin)
        },
    )
}

fn normal() -> impl Strategy<Value = Vec3> {
    prop_oneof![
        prop::array::uniform3(-1f32..1.0).prop_map(|n| Vec3::from_array(n).normalize_or(Vec3::Z)),
        prop::sample::select(vec![Vec3::X, Vec3::NEG_Y, Vec3::Z]),
    ]
}

/// What `visible` promises, by trying every triangle with every direction, exactly.
fn exhaustive(mesh: &Mesh, occluders: &Occluders, origin: Vec3, normal: Vec3, directions: &Directions) -> Vec<u64> {
    let origin = (origin + occluders.offset() * normal) * occluders.scale;
    let triangles = || mesh.faces.iter().map(|f| f.map(|i| mesh.positions[i as usize] * occluders.scale - origin));
    let mut out = vec![0; directions.tiles()];
    for (tile, bit, d) in each(directions) {
        out[tile] |= u64::from(d.dot(normal) > 0.0 && !triangles().any(|t| exact::hits(t, d))) << bit;
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn batches_single_rays_and_every_instruction_set_agree_with_exhaustive_search(
        (mesh, origin) in prop_oneof![lattice(), soup()], normal in normal(), side in 1usize..12,
    ) {
        let occluders = Occluders::new(&mesh).unwrap();
        let grid = Directions::cubemap(side, 2).unwrap();
        let list: Vec<_> = each(&grid).map(|(_, _, d)| d).collect();
        for directions in [grid, Directions::new(&list).unwrap()] {
            let expected = exhaustive(&mesh, &occluders, origin, normal, &directions);
            prop_assert_eq!(&masks(&occluders, origin, normal, &directions), &expected);

            let lifted = origin + occluders.offset() * normal;
            let mut out = vec![0; directions.tiles()];
            let scaled = lifted * occluders.scale;
            let sweep = Sweep { occluders: &occluders, directions: &directions, origin: scaled, normal, out: &mut out };
            sweep.run::<Portable>();
            prop_assert_eq!(&out, &expected);

            for (tile, bit, d) in each(&directions).filter(|&(_, _, d)| d.dot(normal) > 0.0) {
                prop_assert_eq!(occluders.occluded(lifted, d), expected[tile] >> bit & 1 == 0);
            }
        }
    }

    /// Second way: Möller and Trumbore's test in f64, for rays that pass no edge closely.
    #[test]
    fn the_nearest_hit_is_that_of_moeller_and_trumbore((mesh, origin) in soup(), direction in normal()) {
        let occluders = Occluders::new(&mesh).unwrap();
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        let mut nearest = f64::INFINITY;
        for face in &mesh.faces {
            let [a, b, c] = face.map(|i| mesh.positions[i as usize].as_dvec3());
            let (e1, e2, s) = (b - a, c - a, o - a);
            let (p, q) = (d.cross(e2), s.cross(e1));
            let det = e1.dot(p);
            let (u, v, t) = (s.dot(p) / det, d.dot(q) / det, e2.dot(q) / det);
            let inner = u.min(v).min(1.0 - u - v);
            prop_assume!(inner.abs() > 1e-3 && det.abs() > 1e-5);
            if inner > 0.0 && t > 0.0 {
                nearest = nearest.min(t);
            }
        }
        let hit = occluders.nearest(origin, 3.0 * direction);
        prop_assert_eq!(hit.is_some(), nearest.is_finite());
        prop_assert_eq!(hit.is_some(), occluders.occluded(origin, direction));
        if let Some(hit) = hit {
            prop_assert!((f64::from(hit.t) * 3.0 - nearest).abs() < 1e-5 * (1.0 + nearest));
            let [a, b, c] = mesh.faces[hit.face as usize].map(|i| mesh.positions[i as usize]);
            let point = a + hit.u * (b - a) + hit.v * (c - a);
            prop_assert!(point.distance(origin + hit.t * 3.0 * direction) < 1e-4);
        }
    }

    /// Rays aimed, as well as f32 can, at vertices and at points of edges of a closed surface around the origin.
    #[test]
    fn no_ray_leaks_through_an_edge_or_a_vertex(
        origin in prop::array::uniform3(-0.5f32..0.5), lumps in prop::collection::vec(0.8f32..1.2, 66),
        weights in prop::collection::vec(prop_oneof![Just(0.0f32), 0f32..1.0], 384), boxed in any::<bool>(),
    ) {
        let mut mesh = if boxed { cuboid(Vec3::ONE, 0..6) } else { sphere(2) };
        mesh.positions.iter_mut().zip(&lumps).for_each(|(p, lump)| *p *= lump);
        let occluders = Occluders::new(&mesh).unwrap();
        let origin = Vec3::from_array(origin);
        let edges = mesh.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let towards: Vec<Vec3> = edges
            .zip(&weights)
            .map(|((a, b), &w)| mesh.positions[a as usize].lerp(mesh.positions[b as usize], w) - origin)
            .collect();
        for &d in &towards {
            prop_assert!(occluders.occluded(origin, d));
            prop_assert!(occluders.nearest(origin, d).is_some());
        }
        let directions = Directions::new(&towards).unwrap();
        for normal in [Vec3::Z, Vec3::NEG_Z, Vec3::X] {
            prop_assert_eq!(count(&masks(&occluders, origin, normal, &directions)), 0);
        }
    }

    #[test]
    fn order_orientation_and_degenerate_triangles_change_nothing((mesh, origin) in soup(), normal in normal()) {
        let directions = Directions::cubemap(9, 1).unwrap();
        let expected = masks(&Occluders::new(&mesh).unwrap(), origin, normal, &directions);
        let mut other = mesh.clone();
        other.faces.iter_mut().for_each(|face| face.swap(0, 2));
        other.faces.reverse();
        for k in 0..mesh.positions.len() as u32 {
            other.faces.extend([[k, k, k], [k, 0, k]]);
            let [a, b] = [mesh.positions[k as usize], mesh.positions[0]];
            other.positions.push((a + b) / 2.0);
            other.faces.push([k, 0, other.positions.len() as u32 - 1]);
        }
        prop_assert_eq!(masks(&Occluders::new(&other).unwrap(), origin, normal, &directions), expected);
    }

    #[test]
    fn scale_and_place_change_at_most_a_few_rays_along_edges(
        (mesh, origin) in soup(), normal in normal(), power in -90i32..=90, shift in prop::array::uniform3(-100f32..100.0),
    ) {
        let directions = Directions::cubemap(12, 2).unwrap();
        let moved = |map: &dyn Fn(Vec3) -> Vec3| {
            let mesh = Mesh { positions: mesh.positions.iter().map(|&p| map(p)).collect(), ..mesh.clone() };
            masks(&Occluders::new(&mesh).unwrap(), map(origin), normal, &directions)
        };
        let here = moved(&|p| p);
        let differ = |there: Vec<u64>| -> u32 { here.iter().zip(&there).map(|(a, b)| (a ^ b).count_ones()).sum() };
        prop_assert_eq!(differ(moved(&|p| p * 2f32.powi(power))), 0);
        prop_assert!(differ(moved(&|p| p * 1e-3)) <= 2);
        prop_assert!(differ(moved(&|p| p * 1e3)) <= 2);
        // Coordinates near 100 are rounded by 4e-6: 1e-4 of a texel or so, over some thousands of texels.
        prop_assert!(differ(moved(&|p| p + Vec3::from_array(shift))) <= 12);
    }
}

#[test]
fn planes_and_needles_are_traced_like_anything_else() {
    // Boxes without thickness, and a hundred triangles with one and the same centre.
    let flat = sphere(3);
    let mut flat = mesh(flat.positions.iter().map(|p| Vec3::new(p.x, p.y, 0.25)).collect(), flat.faces);
    let copies = flat.faces[0];
    flat.faces.extend([copies; 100]);
    let occluders = Occluders::new(&flat).unwrap();
    let directions = Directions::cubemap(10, 1).unwrap();
    for origin in [Vec3::ZERO, Vec3::new(0.1, 0.2, 0.25), Vec3::new(3.0, 0.0, 0.25)] {
        let expected = exhaustive(&flat, &occluders, origin, Vec3::X, &directions);
        assert_eq!(masks(&occluders, origin, Vec3::X, &directions), expected);
    }
    assert!(occluders.occluded(Vec3::ZERO, Vec3::Z));
    assert!(!occluders.occluded(Vec3::ZERO, Vec3::NEG_Z));
}

#[test]
fn bad_input_is_refused_with_its_place() {
    let bad = mesh(vec![Vec3::ZERO, Vec3::new(0.0, f32::NAN, 0.0)], vec![]);
    assert!(matches!(Occluders::new(&bad), Err(Error::NotFinite { row: 1, col: 1, .. })));
    let bad = mesh(vec![Vec3::ZERO], vec![[0, 0, 1]]);
    assert!(matches!(Occluders::new(&bad), Err(Error::TooLarge { limit: 0, found: 1, .. })));
    let infinite = Vec3::new(0.0, 0.0, f32::INFINITY);
    assert!(matches!(Directions::new(&[Vec3::X, infinite]), Err(Error::NotFinite { row: 1, col: 2, .. })));
    assert!(matches!(Directions::new(&[Vec3::ZERO]), Err(Error::Parameter { .. })));
    assert!(matches!(Directions::cubemap(0, 2), Err(Error::Parameter { .. })));
    assert!(matches!(Directions::cubemap(usize::MAX, 3), Err(Error::TooLarge { .. })));
    let occluders = Occluders::new(&Mesh::default()).unwrap();
    let directions = Directions::cubemap(1, 1).unwrap();
    let refused = occluders.visible_from(&[(Vec3::ZERO, infinite)], &directions, |_, _| ());
    assert!(matches!(refused, Err(Error::NotFinite { row: 0, col: 5, .. })));
}
