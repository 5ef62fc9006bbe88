use super::*;
use crate::texels::{Border, Texels};
use glam::DVec3;
use proptest::prelude::*;
use std::f64::consts::PI;

fn sphere(place: [f64; 2]) -> DVec3 {
    square_to_sphere(place).into()
}

/// A unit direction, most of them near a plane of two axes or near an axis.
fn direction() -> impl Strategy<Value = DVec3> {
    let along = || (-1.0f64..1.0, 0u32..12).prop_map(|(x, power)| x * 0.1f64.powi(power as i32));
    (along(), along(), along()).prop_map(|(x, y, z)| DVec3::new(x, y, z).normalize())
}

proptest! {
    #[test]
    fn every_direction_comes_back_from_its_place(d in direction()) {
        let place = sphere_to_square(d.to_array());
        prop_assert!(place.iter().all(|t| (0.0..=1.0).contains(t)), "{place:?}");
        prop_assert!(sphere(place).distance(d) < 1e-7, "{d} {place:?} {}", sphere(place));
    }

    #[test]
    fn every_place_comes_back_from_its_direction(x in 0.0f64..1.0, y in 0.0f64..1.0) {
        let d = sphere([x, y]);
        prop_assert!((d.length() - 1.0).abs() < 1e-14);
        let back = sphere_to_square(d.to_array());
        prop_assert!((back[0] - x).abs().max((back[1] - y).abs()) < 1e-7, "{back:?}");
    }

    #[test]
    fn area_is_solid_angle_and_counter_clockwise_stays_so(x in 0.0f64..1.0, y in 0.0f64..1.0) {
        let h = 1e-5;
        // Not across an edge of the octahedron.
        let ([u, v], near) = ([x, y].map(|t| 2.0 * t - 1.0), |t: f64| t.abs() < 4.0 * h);
        prop_assume!(!(near(u) || near(v) || near(u.abs() + v.abs() - 1.0) || near(u.abs() - 1.0) || near(v.abs() - 1.0)));
        let slope = |a: [f64; 2], b: [f64; 2]| (sphere(b) - sphere(a)) / (2.0 * h);
        let area = slope([x - h, y], [x + h, y]).cross(slope([x, y - h], [x, y + h])).dot(sphere([x, y]));
        prop_assert!((area / (4.0 * PI) - 1.0).abs() < 1e-4, "{area}");
    }

    #[test]
    fn places_that_are_one_point_have_one_direction(t in 0.0f64..1.0) {
        // Halves of an edge that are exactly each other's mirror.
        let t = 0.5 + 0.5 * t;
        let s = 1.0 - t;
        for edge in [0.0, 1.0] {
            prop_assert_eq!(sphere([edge, t]), sphere([edge, s]));
            prop_assert_eq!(sphere([t, edge]), sphere([s, edge]));
        }
    }

    #[test]
    fn near_places_have_near_directions(x in 0.0f64..1.0, y in 0.0f64..1.0, angle in 0.0f64..6.3, step in 0.0f64..0.1) {
        let other = [x + step * angle.cos(), y + step * angle.sin()].map(|t: f64| t.clamp(0.0, 1.0));
        prop_assert!(sphere([x, y]).distance(sphere(other)) < 9.0 * step);
    }
}

#[test]
fn the_middle_is_the_top_the_corners_are_the_bottom_and_the_edges_have_the_axes_in_their_middles() {
    for (place, d) in [
        ([0.5, 0.5], DVec3::Z),
        ([1.0, 0.5], DVec3::X),
        ([0.5, 1.0], DVec3::Y),
        ([0.0, 0.5], DVec3::NEG_X),
        ([0.5, 0.0], DVec3::NEG_Y),
        ([0.0, 0.0], DVec3::NEG_Z),
        ([1.0, 1.0], DVec3::NEG_Z),
    ] {
        assert!(sphere(place).distance(d) < 1e-15, "{place:?} {}", sphere(place));
    }
}

/// Interpolation of a smooth function on the sphere from texels of the square: the error at a place.
fn error(side: usize, place: [f64; 2]) -> f64 {
    let value = |[x, y, z]: [f64; 3]| (x + 2.0 * y * z).sin() + z * z - 0.5 * y;
    let texels = Texels { width: side, height: side, border: Border::Octahedral };
    let taps = texels.taps(place.map(|t| t as f32));
    let found: f64 = taps.iter().map(|&(t, w)| value(square_to_sphere(texels.centre(t as usize))) * f64::from(w)).sum();
    (found - value(square_to_sphere(place.map(|t| f64::from(t as f32))))).abs()
}

/// The greatest error at places that are at least `margin` away from every edge of the octahedron.
fn worst(side: usize, margin: f64) -> f64 {
    let n = 400;
    let places = (0..=n).flat_map(|i| (0..=n).map(move |j| [i, j].map(|k| f64::from(k) / f64::from(n))));
    let inside = |place: &[f64; 2]| {
        let [u, v] = place.map(|t| (2.0 * t - 1.0).abs());
        [u, v, 1.0 - u, 1.0 - v, (u + v - 1.0).abs()].iter().all(|&t| t >= margin)
    };
    places.filter(inside).map(|place| error(side, place)).fold(0.0, f64::max)
}

#[test]
fn texels_interpolate_to_the_second_order_within_faces_of_the_octahedron_and_to_the_first_everywhere() {
    // The edges and the corners of the square are among the places.
    let [coarse, fine] = [32, 128].map(|side| worst(side, 0.0));
    assert!(fine < 0.3 * coarse && fine < 0.05, "{coarse} {fine}");
    let [coarse, fine] = [32, 128].map(|side| worst(side, 0.15));
    assert!(fine < coarse / 12.0 && fine < 1e-3, "{coarse} {fine}");
}
