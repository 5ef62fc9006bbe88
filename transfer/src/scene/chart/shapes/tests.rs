use super::*;
use crate::scene::chart::Places;
use crate::scene::repair::{Repairs, repair};
use std::collections::HashMap;

const CORNERS: [[f64; 3]; 4] = [[1.0, 2.0, 3.0], [3.0, 2.0, 3.5], [3.0, 3.0, 5.0], [1.0, 3.0, 4.5]];

/// All of them, with their areas where they are known and how far texels' areas may be from one another.
fn shapes(segments: usize) -> Vec<(&'static str, Charted, Option<f64>, [f64; 2])> {
    let [a, b, _, d] = CORNERS.map(DVec3::from);
    let centre = DVec3::new(1.0, -2.0, 0.5);
    let torus_area = 4.0 * PI * PI * 0.8 * 0.3;
    vec![
        (
            "rectangle",
            rectangle(CORNERS.map(DVec3::from), segments).unwrap(),
            Some((b - a).cross(d - a).length()),
            [0.9999, 1.0001],
        ),
        ("sphere", sphere(centre, 0.7, segments), Some(4.0 * PI * 0.49), [0.63, 1.17]),
        ("distorted sphere", distorted_sphere(centre, 0.7, 0.2, segments), None, [0.4, 2.5]),
        ("torus", torus(centre, DVec3::new(1.0, 2.0, 2.0), 0.8, 0.3, [segments; 2]), Some(torus_area), [0.97, 1.03]),
    ]
}

fn position(charted: &Charted, places: &Places, texel: usize) -> DVec3 {
    let place = places.places[texel].unwrap();
    let [a, b, c] = charted.mesh.corners(charted.mesh.faces[place.face as usize]);
    a + f64::from(place.u) * (b - a) + f64::from(place.v) * (c - a)
}

#[test]
fn every_texel_has_a_place_whose_coordinates_are_its_centre() {
    for (name, charted, ..) in shapes(20) {
        charted.check().unwrap();
        for [width, height] in [[1, 1], [2, 3], [64, 64], [61, 40], [20, 20], [256, 1]] {
            let places = charted.places(width, height).unwrap();
            assert_eq!((places.gutter, places.flat), (0, 0), "{name}");
            for (texel, place) in places.places.iter().enumerate() {
                let place = place.unwrap();
                assert!(place.u >= 0.0 && place.v >= 0.0 && place.u + place.v <= 1.0);
                let uv = charted.uv_at(place.face, place.u, place.v);
                let centre = places.texels.centre(texel).map(|t| t as f32);
                assert!(uv.distance(centre.into()) < 1e-5, "{name}: {uv} {centre:?}");
            }
        }
    }
}

#[test]
fn texels_have_equal_areas() {
    for (name, charted, area, [low, high]) in shapes(64) {
        let [least, greatest] = charted.distortion();
        assert!(low <= least && least <= greatest && greatest <= high, "{name}: {least} {greatest}");
        let found = charted.mesh.area();
        assert!(area.is_none_or(|area| (found / area - 1.0).abs() < 3e-3), "{name}: {found} {area:?}");
    }
    // The four triangles around a pole have the area of a square in a circle, 2/π of what they should; the share of faces that are
    // off by much falls with their size.
    let off = |segments: usize| {
        let ball = sphere(DVec3::ZERO, 1.0, segments);
        let (faces, area) = (ball.mesh.faces.len(), ball.mesh.area());
        let ratio = |&face: &[u32; 3]| ball.mesh.area_vector(face).length() * faces as f64 / area;
        assert!((ball.distortion()[0] - 2.0 / PI).abs() < 1e-3);
        ball.mesh.faces.iter().filter(|face| (ratio(face) - 1.0).abs() > 0.03).count() as f64 / faces as f64
    };
    assert!(off(64) < 0.06 && off(128) < 0.5 * off(64), "{} {}", off(64), off(128));
}

#[test]
fn means_over_texels_are_means_over_the_surface() {
    let [ball, torus] = [sphere(DVec3::ZERO, 1.0, 64), torus(DVec3::ZERO, DVec3::Z, 0.8, 0.3, [96, 96])];
    let mean = |charted: &Charted, value: fn(DVec3) -> f64| {
        let places = charted.places(64, 64).unwrap();
        (0..64 * 64).map(|t| value(position(charted, &places, t))).sum::<f64>() / f64::from(64 * 64)
    };
    for value in [|p: DVec3| p.x * p.x, |p: DVec3| p.y * p.y, |p: DVec3| p.z * p.z] {
        assert!((mean(&ball, value) - 1.0 / 3.0).abs() < 1e-3, "{}", mean(&ball, value));
    }
    // ∫ (R + r cos ψ)(R + r cos ψ) dψ / 2πR, the mean distance from the axis; r²/2 that of z².
    let distance = mean(&torus, |p| p.x.hypot(p.y));
    assert!((distance - (0.8 + 0.5 * 0.09 / 0.8)).abs() < 1e-3, "{distance}");
    assert!((mean(&torus, |p| p.z * p.z) - 0.045).abs() < 1e-3);
}

#[test]
fn normals_are_unit_vectors_across_the_surface_on_the_side_of_their_faces() {
    for (name, charted, ..) in shapes(48) {
        let mesh = &charted.mesh;
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6), "{name}");
        for &face in &mesh.faces {
            let normal = mesh.area_vector(face).normalize();
            let least = face.map(|v| normal.dot(mesh.normals[v as usize].as_dvec3())).into_iter().fold(1.0, f64::min);
            assert!(least > 0.97, "{name}: {least}");
        }
    }
}

#[test]
fn normals_of_the_distorted_sphere_are_across_its_tangents() {
    let point = |d: DVec3| d * (1.0 + 0.3 * dents(d).0);
    let shape = distorted_sphere(DVec3::ZERO, 1.0, 0.3, 10);
    for (&p, &n) in shape.mesh.positions.iter().zip(&shape.mesh.normals) {
        let (d, h) = (p.as_dvec3().normalize(), 1e-4);
        assert!(point(d).distance(p.as_dvec3()) < 1e-6);
        let (a, b) = d.any_orthonormal_pair();
        for t in [a, b] {
            let tangent = (point((d + h * t).normalize()) - point((d - h * t).normalize())).normalize();
            assert!(tangent.dot(n.as_dvec3()).abs() < 1e-5);
        }
    }
}

#[test]
fn dents_stay_within_one_and_are_no_small_thing() {
    let heights: Vec<f64> = sphere(DVec3::ZERO, 1.0, 40).mesh.positions.iter().map(|d| dents(d.as_dvec3()).0).collect();
    let (low, high) = heights.iter().fold((0.0, 0.0), |(low, high), &h| (h.min(low), h.max(high)));
    assert!((-1.0..-0.6).contains(&low) && (0.6..1.0).contains(&high), "{low} {high}");
}

#[test]
fn closed_shapes_are_watertight_by_the_bits_of_their_positions_and_face_outward() {
    for (name, charted, ..) in shapes(12).into_iter().filter(|(name, ..)| *name != "rectangle") {
        let mesh = &charted.mesh;
        let place = |v: u32| (mesh.positions[v as usize] + glam::Vec3::ZERO).to_array().map(f32::to_bits);
        let mut edges = HashMap::new();
        for &[a, b, c] in &mesh.faces {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                *edges.entry([place(a), place(b)]).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|([a, b], n)| (*n, edges.get(&[*b, *a])) == (1, Some(&1))), "{name}");
        assert!(mesh.volume() > 0.1, "{name}");
        assert_eq!(repair(mesh.clone()).unwrap().1, Repairs::default(), "{name}");
    }
}

#[test]
fn few_or_odd_segments_are_rounded_up() {
    assert_eq!(sphere(DVec3::ZERO, 1.0, 0).mesh.faces.len(), 8);
    assert_eq!(sphere(DVec3::ZERO, 1.0, 3), sphere(DVec3::ZERO, 1.0, 4));
    assert_eq!(torus(DVec3::ZERO, DVec3::X, 1.0, 0.5, [0, 1]).mesh.faces.len(), 18);
    assert_eq!(rectangle(CORNERS.map(DVec3::from), 0).unwrap().mesh.faces.len(), 2);
}

#[test]
fn the_angle_around_a_tube_encloses_its_share_of_the_area() {
    for e in [0.0, 0.1, 0.5, 0.9, 0.999] {
        for v in [0.0, 1e-9, 0.1, 0.25, 0.4, 0.499, 0.5, 0.7, 0.999] {
            let angle = around_tube(v, e);
            assert!(((angle + e * angle.sin()) / TAU - v).abs() < 1e-14, "{e} {v} {angle}");
        }
    }
}

#[test]
fn corners_that_are_no_convex_quadrilateral_are_refused() {
    let corners = CORNERS.map(DVec3::from);
    let refused = |i: usize, p: DVec3| {
        let mut corners = corners;
        corners[i] = p;
        rectangle(corners, 4).unwrap_err().to_string()
    };
    for message in
        [refused(2, corners[0]), refused(1, corners[2]), refused(0, DVec3::NAN), refused(3, corners[1] + 1e-3)]
    {
        assert!(message.contains("rectangle: expected corners of a convex quadrilateral, found [DVec3("), "{message}");
    }
    // A quadrilateral that is not a parallelogram has texels of different areas.
    let trapezium = rectangle([corners[0], corners[1], corners[2], corners[3].lerp(corners[2], 0.5)], 64).unwrap();
    let [least, greatest] = trapezium.distortion();
    assert!(least < 0.7 && greatest > 1.3, "{least} {greatest}");
}
