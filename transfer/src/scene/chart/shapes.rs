//! Built-in charted shapes, all of which fill the square: every texel has a place.

use super::{Charted, sphere::unfolded};
use crate::chart::refused;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::scene::shapes::flat::add_patch;
use crate::texels::Border;
use glam::{DVec3, Vec2};
use std::f64::consts::{PI, TAU};

/// The bilinear patch of four corners, counter-clockwise seen from the front, which are the corners (0, 0), (1, 0), (1, 1) and
/// (0, 1) of the chart: cut into `segments`² quadrilaterals, at least one. Equal areas of a parallelogram are equal areas of its
/// chart.
///
/// # Errors
/// Corners that are NaN or infinite, or that are not those of a convex quadrilateral (which need not be quite flat).
pub fn rectangle(corners: [DVec3; 4], segments: usize) -> Result<Charted> {
    let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
    let turns_left = |i: usize| {
        let [before, here, after] = [3, 0, 1].map(|k| corners[(i + k) % 4]);
        (here - before).cross(after - here).dot(normal) > 0.0
    };
    if !(0..4).all(turns_left) {
        return Err(refused("rectangle".into(), "corners of a convex quadrilateral", format!("{corners:?}")));
    }
    let segments = segments.max(1);
    let mut mesh = Mesh::default();
    add_patch(&mut mesh, corners, segments, segments);
    Charted::new(mesh, lattice([segments; 2]), Border::Clamp)
}

/// A sphere of `segments` along each edge of the square, rounded up to an even number, at least 2. Its poles are in direction z;
/// the chart is [`square_to_sphere`](super::sphere::square_to_sphere): texels have equal areas but for what triangles cut off, most
/// at the poles, where four of them are a square in place of a disk.
pub fn sphere(centre: DVec3, radius: f64, segments: usize) -> Charted {
    octahedral(segments, |d| (centre + radius * d, d))
}

/// A dented sphere: in direction d from its centre the surface is at `radius` (1 + `amplitude` f(d)), with a smooth f from -1 to 1
/// that is always the same. The amplitude is below 1. The chart is that of [`sphere()`], so that texels have different areas:
/// from 0.65 to 1.32 of their mean for an amplitude of 0.15 ([`Charted::distortion`]).
pub fn distorted_sphere(centre: DVec3, radius: f64, amplitude: f64, segments: usize) -> Charted {
    octahedral(segments, |d| {
        let (dent, slope) = dents(d);
        let height = 1.0 + amplitude * dent;
        // The surface r(d) d has the normal r d - ∇r, ∇ along the unit sphere.
        let normal = height * d - amplitude * slope.reject_from_normalized(d);
        (centre + radius * height * d, normal.normalize())
    })
}

/// f of [`distorted_sphere`] and its gradient: waves along three directions.
fn dents(d: DVec3) -> (f64, DVec3) {
    const WAVES: [(f64, [f64; 3], f64); 3] =
        [(0.4, [3.1, 1.7, -0.6], 0.3), (0.35, [-1.2, 4.3, 2.2], 1.1), (0.25, [2.6, -0.9, 5.2], 2.0)];
    WAVES.iter().fold((0.0, DVec3::ZERO), |(dent, slope), &(weight, wave, phase)| {
        let wave = DVec3::from(wave);
        let (sine, cosine) = (wave.dot(d) + phase).sin_cos();
        (dent + weight * sine, slope + weight * cosine * wave)
    })
}

/// A torus around `axis`: a tube of radius `tube` whose middle is a circle of radius `ring`, greater than that of the tube. Along u it
/// runs around the axis, along v around the tube from the outer equator, with `segments` along both, each at least 3. Texels have
/// equal areas: with ψ the angle around the tube, v(ψ) = (R ψ + r sin ψ) / 2πR, the share of ∫ (R + r cos ψ) dψ.
pub fn torus(centre: DVec3, axis: DVec3, ring: f64, tube: f64, segments: [usize; 2]) -> Charted {
    let segments = segments.map(|n| n.max(3));
    let axis = axis.normalize();
    let side = axis.any_orthonormal_vector();
    let vertices = grid(segments).map(|[i, j]| {
        // Both ends of the square are one place, bit for bit.
        let share = |k: usize, n: usize| (k % n) as f64 / n as f64;
        let (sine, cosine) = (TAU * share(i, segments[0])).sin_cos();
        let outward = cosine * side + sine * axis.cross(side);
        let (sine, cosine) = around_tube(share(j, segments[1]), tube / ring).sin_cos();
        let normal = cosine * outward + sine * axis;
        (centre + ring * outward + tube * normal, normal)
    });
    charted(segments, vertices, |_| true, Border::Wrap)
}

/// The angle ψ in \[0, 2π) at which (ψ + e sin ψ) / 2π = v, with e the ratio of the radii.
fn around_tube(v: f64, e: f64) -> f64 {
    if v > 0.5 {
        return TAU - around_tube(1.0 - v, e);
    }
    // With E = π - ψ this is Kepler's equation E - e sin E = m, convex on [0, π]: Newton's method from π descends to the root.
    let m = PI - TAU * v;
    let mut angle = PI;
    for _ in 0..64 {
        let step = (angle - e * angle.sin() - m) / (1.0 - e * angle.cos());
        if step <= 0.0 {
            break;
        }
        angle -= step;
    }
    PI - angle
}

/// A surface that has a point and a normal for each direction. Faces end at the edges of the octahedron, where its map to the
/// sphere has a crease.
fn octahedral(segments: usize, point: impl Fn(DVec3) -> (DVec3, DVec3)) -> Charted {
    let n = segments.next_multiple_of(2).max(2);
    let vertices = grid([n; 2]).map(|place| {
        // Exactly odd about the middle, so that places that are one point have the same bits.
        let [x, y] = place.map(|i| (2.0 * i as f64 - n as f64) / n as f64);
        point(DVec3::from(unfolded(x, y)))
    });
    // The line between the middles of two edges of the square falls in half of its quadrants.
    let rising = |cell: [usize; 2]| (2 * cell[0] < n) != (2 * cell[1] < n);
    charted([n; 2], vertices, rising, Border::Octahedral)
}

/// Faces over a lattice of vertices, each cell cut by the diagonal that rises with u or by that which falls.
fn charted(
    [along, across]: [usize; 2],
    vertices: impl Iterator<Item = (DVec3, DVec3)>,
    rising: impl Fn([usize; 2]) -> bool,
    border: Border,
) -> Charted {
    let (positions, normals) = vertices.map(|(p, n)| (p.as_vec3(), n.as_vec3())).unzip();
    let vertex = |i: usize, j: usize| (j * (along + 1) + i) as u32;
    let mut faces = Vec::with_capacity(2 * along * across);
    for [i, j] in grid([along - 1, across - 1]) {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        faces.extend(if rising([i, j]) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
    }
    Charted { mesh: Mesh { positions, normals, faces }, uv: lattice([along, across]), border }
}

/// The vertices of a lattice over the square, row by row.
fn lattice(cells: [usize; 2]) -> Vec<Vec2> {
    grid(cells).map(|[i, j]| Vec2::new(i as f32 / cells[0] as f32, j as f32 / cells[1] as f32)).collect()
}

/// 0 to `along`, for each of 0 to `across`.
fn grid([along, across]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    (0..=across).flat_map(move |j| (0..=along).map(move |i| [i, j]))
}

#[cfg(test)]
mod tests;
