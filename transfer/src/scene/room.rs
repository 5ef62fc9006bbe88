//! A room with windows and small lamps, seen from its middle: a light of several small, very bright sources.

use super::environment::{Cap, Environment};
use glam::DVec3;
use std::f64::consts::PI;

/// Half the room's width and depth; heights of floor and ceiling from the eye. Metres.
const HALF: [f64; 2] = [3.2, 2.4];
const FLOOR: f64 = -1.3;
const CEILING: f64 = 1.4;

/// Radiance behind the windows, from their lower edge to their upper: garden and sky, in daylight.
const OUTSIDE: [DVec3; 2] = [DVec3::new(14.0, 18.0, 9.0), DVec3::new(60.0, 80.0, 110.0)];
/// What comes from everywhere in the room after many reflections (radiance of a white wall).
const AMBIENT: DVec3 = DVec3::new(0.30, 0.27, 0.22);

/// A small sphere that shines.
struct Lamp {
    /// From the eye, metres.
    centre: DVec3,
    /// Metres.
    radius: f64,
    radiance: DVec3,
}

const LAMPS: [Lamp; 4] = [
    Lamp { centre: DVec3::new(0.9, 0.5, 1.15), radius: 0.04, radiance: DVec3::new(9.0e3, 7.4e3, 5.0e3) },
    Lamp { centre: DVec3::new(-2.6, -1.7, 0.1), radius: 0.03, radiance: DVec3::new(1.4e4, 1.0e4, 5.6e3) },
    Lamp { centre: DVec3::new(2.7, -1.9, 0.3), radius: 0.03, radiance: DVec3::new(1.2e4, 9.2e3, 5.4e3) },
    Lamp { centre: DVec3::new(-1.2, 2.0, -0.2), radius: 0.015, radiance: DVec3::new(2.0e4, 1.9e4, 1.8e4) },
];

/// A rectangle on a wall: axis of its normal (0 or 1), sign of the wall, interval along the other horizontal axis, and of z.
struct Panel {
    wall: (usize, f64),
    along: [f64; 2],
    z: [f64; 2],
    /// Reflectance; `None` for a window.
    colour: Option<DVec3>,
}

const PANELS: [Panel; 6] = [
    Panel { wall: (0, 1.0), along: [-1.7, -0.5], z: [-0.4, 1.0], colour: None },
    Panel { wall: (0, 1.0), along: [0.2, 1.4], z: [-0.4, 1.0], colour: None },
    Panel { wall: (1, 1.0), along: [0.6, 1.5], z: [-0.1, 0.9], colour: None },
    // Door, bookcase, picture.
    Panel { wall: (0, -1.0), along: [0.4, 1.4], z: [FLOOR, 0.8], colour: Some(DVec3::new(0.25, 0.13, 0.06)) },
    Panel { wall: (1, -1.0), along: [-1.6, 0.8], z: [FLOOR, 0.6], colour: Some(DVec3::new(0.09, 0.06, 0.05)) },
    Panel { wall: (1, 1.0), along: [-2.4, -1.4], z: [0.0, 0.7], colour: Some(DVec3::new(0.10, 0.16, 0.30)) },
];

/// Bars that part a window in the middle, half their width in metres.
const BAR: f64 = 0.025;

/// The room, relative radiance: a white wall in its ambient light is about 0.3.
pub(super) fn environment() -> Environment {
    let caps = LAMPS
        .iter()
        .map(|lamp| Cap {
            centre: lamp.centre.normalize(),
            radius: (lamp.radius / lamp.centre.length()).asin(),
            radiance: lamp.radiance.to_array(),
        })
        .collect();
    Environment::new(background, caps)
}

/// Radiance of the wall, floor, ceiling or window that a ray from the eye meets.
fn background(d: DVec3) -> DVec3 {
    let bounds = DVec3::new(HALF[0], HALF[1], if d.z < 0.0 { -FLOOR } else { CEILING });
    let distances = (bounds / d.abs()).to_array();
    let axis = (0..3).fold(0, |best, i| if distances[i] < distances[best] { i } else { best });
    let (point, mut normal) = (distances[axis] * d, DVec3::ZERO);
    normal[axis] = -d[axis].signum();
    match panel_at(point, axis) {
        Some(Panel { colour: None, z: [low, high], .. }) => {
            OUTSIDE[0].lerp(OUTSIDE[1], ((point.z - low) / (high - low)).powi(2))
        }
        Some(Panel { colour: Some(colour), .. }) => *colour * lit(point, normal),
        None => wall_colour(axis, d.z) * lit(point, normal),
    }
}

fn panel_at(point: DVec3, axis: usize) -> Option<&'static Panel> {
    PANELS.iter().find(|panel| {
        let within = |[low, high]: [f64; 2], c: f64| low < c && c < high;
        if panel.wall.0 != axis || panel.wall.1 != point[axis].signum() {
            return false;
        }
        let along = point[1 - axis];
        let bar = |[low, high]: [f64; 2], c: f64| (c - low.midpoint(high)).abs() < BAR;
        let barred = panel.colour.is_none() && (bar(panel.along, along) || bar(panel.z, point.z));
        within(panel.along, along) && within(panel.z, point.z) && !barred
    })
}

fn wall_colour(axis: usize, z: f64) -> DVec3 {
    match (axis, z < 0.0) {
        (2, true) => DVec3::new(0.34, 0.22, 0.13),
        (2, false) => DVec3::splat(0.82),
        _ => DVec3::new(0.72, 0.68, 0.58),
    }
}

/// Irradiance over π at a point of a wall: ambient light, the lamps and the windows, unshadowed.
fn lit(point: DVec3, normal: DVec3) -> DVec3 {
    let lamps: DVec3 = LAMPS
        .iter()
        .map(|lamp| {
            let to = lamp.centre - point;
            // A sphere of constant radiance: E = π L (r / distance)² cos.
            lamp.radiance * (lamp.radius / to.length()).powi(2) * (to.dot(normal) / to.length()).max(0.0)
        })
        .sum();
    let windows: DVec3 = PANELS
        .iter()
        .filter(|panel| panel.colour.is_none())
        .map(|panel| {
            let (axis, sign) = panel.wall;
            let mut centre = DVec3::new(0.0, 0.0, panel.z[0].midpoint(panel.z[1]));
            centre[axis] = sign * HALF[axis];
            centre[1 - axis] = panel.along[0].midpoint(panel.along[1]);
            let area = (panel.along[1] - panel.along[0]) * (panel.z[1] - panel.z[0]);
            let to = centre - point;
            let (cosine, at_window) =
                ((to.dot(normal) / to.length()).max(0.0), (sign * to[axis] / to.length()).max(0.0));
            // The window as one small source, its distance kept from vanishing beside it.
            OUTSIDE[0].midpoint(OUTSIDE[1]) * area * cosine * at_window / (PI * (to.length_squared() + area))
        })
        .sum();
    AMBIENT + lamps + windows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lamps_hang_in_the_room_and_apart() {
        for (i, lamp) in LAMPS.iter().enumerate() {
            let c = lamp.centre;
            assert!(c.x.abs() < HALF[0] && c.y.abs() < HALF[1] && (FLOOR..CEILING).contains(&c.z));
            for other in &LAMPS[..i] {
                assert!(c.normalize().dot(other.centre.normalize()) < 0.99);
            }
        }
    }

    #[test]
    fn the_range_exceeds_ten_thousand() {
        let image = environment().image(512, 256).unwrap();
        let mut values: Vec<f32> = image.pixels.iter().map(|p| p[1]).collect();
        values.sort_by(f32::total_cmp);
        let (least, median, most) = (values[0], values[values.len() / 2], values[values.len() - 1]);
        assert!(least > 0.0 && most / least > 1e4 && most / median > 1e3, "{least} {median} {most}");
        // Windows fill a visible part of the view.
        let bright = values.iter().filter(|&&v| v > 10.0).count() as f64 / values.len() as f64;
        assert!((0.02..0.2).contains(&bright), "{bright}");
    }
}
