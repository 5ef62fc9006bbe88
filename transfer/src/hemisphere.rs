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
