//! Local directions of the hemisphere above a surface point: centres of cells of equal solid angle.

use std::f32::consts::FRAC_PI_4;

/// The concentric map of Shirley and Chiu (1997) from the square \[-1, 1\]² to the unit disk; it keeps areas.
pub fn concentric_disk(u: f32, v: f32) -> (f32, f32) {
    let (radius, angle) = match (u, v) {
        (0.0, 0.0) => return (0.0, 0.0),
        _ if u.abs() > v.abs() => (u, FRAC_PI_4 * v / u),
        _ => (v, 2.0 * FRAC_PI_4 - FRAC_PI_4 * u / v),
    };
    (radius * angle.cos(), radius * angle.sin())
}

/// The unit direction above the disk point `(x, y)` of the Lambert equal-area projection: the disk is the hemisphere z ≥ 0.
pub fn equal_area_hemisphere(x: f32, y: f32) -> [f32; 3] {
    // With r² = x² + y², z = 1 - r² makes dω = 2 dA, the same everywhere.
    let r2 = x * x + y * y;
    let scale = (2.0 - r2).max(0.0).sqrt();
    [x * scale, y * scale, 1.0 - r2]
}

/// Most cells along an edge of the square.
pub const MAX_EDGE: usize = 64;

/// `edge`² unit directions, z along the normal, at the centres of cells of equal solid angle: index `row * edge + column` of
/// the concentric square.
pub fn local_directions(edge: usize) -> Vec<[f32; 3]> {
    let centre = |i: usize| (2 * i + 1) as f32 / edge as f32 - 1.0;
    (0..edge * edge)
        .map(|k| concentric_disk(centre(k % edge), centre(k / edge)))
        .map(|(x, y)| equal_area_hemisphere(x, y))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places in the square off its diagonals.
    fn places() -> impl Iterator<Item = (f32, f32)> {
        let at = |i: i32| (2 * i + 1) as f32 / 32.0;
        (-16..16).flat_map(move |i| (-16..16).map(move |j| (at(i), at(j)))).filter(|(u, v)| u.abs() != v.abs())
    }

    #[test]
    fn squares_become_circles_turn_with_them_and_keep_their_area() {
        for (u, v) in places() {
            let (x, y) = concentric_disk(u, v);
            assert!((x.hypot(y) - u.abs().max(v.abs())).abs() < 1e-6, "{u} {v}: radius {}", x.hypot(y));
            // A quarter turn and a reflection.
            let [turned, mirrored] = [concentric_disk(-v, u), concentric_disk(u, -v)];
            for ([a, b], [c, d]) in [([turned.0, turned.1], [-y, x]), ([mirrored.0, mirrored.1], [x, -y])] {
                assert!((a - c).abs() < 1e-6 && (b - d).abs() < 1e-6, "{u} {v}");
            }
            // The determinant of the map is that of the square onto the disk, 4 onto π.
            let step = 1.0 / 64.0;
            let slope = |[du, dv]: [f32; 2]| {
                let [ahead, behind] = [1.0, -1.0].map(|s| concentric_disk(u + s * du, v + s * dv));
                [(ahead.0 - behind.0) / (2.0 * step), (ahead.1 - behind.1) / (2.0 * step)]
            };
            let ([a, b], [c, d]) = (slope([step, 0.0]), slope([0.0, step]));
            assert!((a * d - b * c - FRAC_PI_4).abs() < 0.02, "{u} {v}: {}", a * d - b * c);
        }
        assert_eq!(concentric_disk(0.0, 0.0), (0.0, 0.0));
        assert_eq!(concentric_disk(1.0, 0.0), (1.0, 0.0));
    }

    #[test]
    fn heights_are_those_of_equal_area_and_directions_are_of_unit_length() {
        for (u, v) in places() {
            let (x, y) = concentric_disk(u, v);
            let [a, b, z] = equal_area_hemisphere(x, y);
            // The cap above z has the area 2π (1 - z), of 2π, as the disk within r has π r² of π.
            assert!((z - (1.0 - x * x - y * y)).abs() < 1e-6 && (a * a + b * b + z * z - 1.0).abs() < 1e-6);
            assert!((a * y - b * x).abs() < 1e-6 && a * x + b * y >= 0.0, "{u} {v}: another azimuth");
        }
        assert_eq!(equal_area_hemisphere(0.0, 0.0), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn cells_are_in_rows_and_cover_the_hemisphere_evenly() {
        let quadrants = local_directions(2).iter().map(|d| [d[0] > 0.0, d[1] > 0.0]).collect::<Vec<_>>();
        assert_eq!(quadrants, [[false, false], [true, false], [false, true], [true, true]]);
        let directions = local_directions(256);
        let mean = |f: fn([f64; 3]) -> f64| {
            let values = directions.iter().map(|d| f(d.map(f64::from)));
            values.sum::<f64>() / directions.len() as f64
        };
        // Of a uniform density.
        for (found, exact) in [
            (mean(|[x, _, _]| x), 0.0),
            (mean(|[_, y, _]| y), 0.0),
            (mean(|[_, _, z]| z), 1.0 / 2.0),
            (mean(|[_, _, z]| z * z), 1.0 / 3.0),
            (mean(|[x, _, _]| x * x), 1.0 / 3.0),
            (mean(|[x, y, _]| x * y), 0.0),
        ] {
            assert!((found - exact).abs() < 1e-4, "{found} for {exact}");
        }
    }
}
