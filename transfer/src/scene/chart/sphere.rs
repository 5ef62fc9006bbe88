//! The square as a sphere: the equal-area octahedral map of Clarberg, "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD"
//! (2008).
//!
//! The square is the octahedron |x| + |y| + |z| = 1 unfolded around its top, with the bottom in all four corners: each edge is
//! folded in its middle and sewn to itself, which is [`Border::Octahedral`](crate::texels::Border::Octahedral). Equal areas of the
//! square are equal solid angles; counter-clockwise in the square is counter-clockwise seen from outside. The map is smooth within
//! each face of the octahedron and only continuous across its edges (the axes of the square, the lines between the middles of
//! its edges, and the edges): a function that is smooth on the sphere is interpolated to the second order of a texel's size
//! within faces, and to the first across their edges.

use std::f64::consts::FRAC_PI_4;

/// The unit direction at a place of the unit square, that of the nearest place for one outside. Places that are one point of the
/// octahedron have directions of the same bits.
pub fn square_to_sphere(place: [f64; 2]) -> [f64; 3] {
    let [x, y] = place.map(|t| (2.0 * t - 1.0).clamp(-1.0, 1.0));
    unfolded(x, y)
}

/// [`square_to_sphere`] of the place ((x + 1)/2, (y + 1)/2).
pub(super) fn unfolded(x: f64, y: f64) -> [f64; 3] {
    let (u, v) = (x.abs(), y.abs());
    let top = u + v <= 1.0;
    // r is the distance from the nearer pole, φ = π/4 (1 + (v - u)/r) the angle from the x axis; a ring of constant r has area
    // 4r of the square, and z = 1 - r² makes its solid angle 4π r.
    let r = if top { u + v } else { (1.0 - u) + (1.0 - v) };
    let slant = if r > 0.0 { ((v - u) / r).clamp(-1.0, 1.0) } else { 0.0 };
    // Sines of both angles, so that both are 0 where they should be.
    let [sine, cosine] = [1.0 + slant, 1.0 - slant].map(|angle| (FRAC_PI_4 * angle).sin());
    let z = if top { 1.0 - r * r } else { r * r - 1.0 };
    let across = r * (2.0 - r * r).sqrt();
    // + 0 takes the sign from a zero.
    [(across * cosine).copysign(x) + 0.0, (across * sine).copysign(y) + 0.0, z + 0.0]
}

/// The place in the unit square of a direction of unit length: the inverse of [`square_to_sphere`], but for places that are one
/// point.
pub fn sphere_to_square([x, y, z]: [f64; 3]) -> [f64; 2] {
    // r² = 1 - |z|, without the digits that this loses near the poles.
    let r = (x.hypot(y) / (1.0 + z.abs()).sqrt()).min(1.0);
    let slant = y.abs().atan2(x.abs()) / FRAC_PI_4 - 1.0;
    let (u, v) = (0.5 * r * (1.0 - slant), 0.5 * r * (1.0 + slant));
    let (u, v) = if z < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
    [u.copysign(x), v.copysign(y)].map(|t| 0.5 * (t + 1.0))
}

#[cfg(test)]
mod tests;
