//! Curved shapes: a point at a distance r(d) along every direction d from the centre.

use crate::mesh::Mesh;
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// The unit sphere as a subdivided icosahedron: `10 frequency² + 2` vertices; frequency 0 counts as 1.
pub fn sphere(frequency: usize) -> Mesh {
    radial(frequency.max(1), 0, |_| 1.0)
}

/// A sphere with rounded bumps, about 8 around the equator.
pub(super) fn bumpy_sphere(steps: usize) -> Mesh {
    radial(steps, 0, |d| {
        let [x, y, z] = (7.0 * d).to_array().map(f64::sin);
        1.0 + 0.09 * (x * y + y * z + z * x)
    })
}

/// A body, a head and two long ears: ellipsoids around a common point, joined smoothly.
pub(super) fn blob(steps: usize) -> Mesh {
    let parts = ears_and_body();
    // ‖r‖_p of the parts' radii is a smooth maximum.
    let power = 4.0;
    // Below a frequency of 5 the ears are lost between the vertices.
    radial(steps + 4, 20, move |d| parts.iter().map(|e| e.radius(d).powf(power)).sum::<f64>().powf(1.0 / power))
}

/// An ellipsoid that contains the origin.
struct Ellipsoid {
    centre: DVec3,
    /// Takes world coordinates to those in which the ellipsoid is the unit sphere.
    to_unit: DMat3,
}

impl Ellipsoid {
    /// Half axes along `x`, its perpendicular in the horizontal, and the third direction.
    fn new(centre: [f64; 3], axis: [f64; 3], [long, wide, thick]: [f64; 3]) -> Ellipsoid {
        let along = DVec3::from(axis).normalize();
        let across = DVec3::Z.cross(along).try_normalize().unwrap_or(DVec3::Y);
        let rows = DMat3::from_cols(along / long, across / wide, along.cross(across) / thick);
        Ellipsoid { centre: centre.into(), to_unit: rows.transpose() }
    }

    /// Where the ray from the origin along `d` leaves it.
    fn radius(&self, d: DVec3) -> f64 {
        // |t a − b|² = 1 with a, b in unit-sphere coordinates.
        let (a, b) = (self.to_unit * d, self.to_unit * self.centre);
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        (ab + (ab * ab - aa * (bb - 1.0)).sqrt()) / aa
    }
}

fn ears_and_body() -> [Ellipsoid; 6] {
    [
        // Body, chest and head (towards +x), tail, ears up and slightly back.
        Ellipsoid::new([-0.30, 0.0, -0.35], [1.0, 0.0, 0.2], [0.95, 0.68, 0.66]),
        Ellipsoid::new([0.10, 0.0, -0.45], [0.0, 0.0, 1.0], [0.62, 0.50, 0.50]),
        Ellipsoid::new([0.38, 0.0, 0.24], [1.0, 0.0, -0.3], [0.58, 0.40, 0.44]),
        Ellipsoid::new([-0.68, 0.0, -0.25], [0.68, 0.0, 0.25], [0.76, 0.17, 0.17]),
        Ellipsoid::new([0.08, 0.34, 0.74], [0.08, 0.34, 0.74], [0.86, 0.17, 0.12]),
        Ellipsoid::new([0.08, -0.34, 0.74], [0.08, -0.34, 0.74], [0.86, 0.17, 0.12]),
    ]
}

/// The surface r(d) over the vertices of an icosahedron subdivided `frequency` times along each edge. Each of `relaxations`
/// sweeps moves vertices towards the centre of their neighbours, along the surface: where r(d) rises steeply, the vertices
/// of a regular sphere are far apart.
fn radial(frequency: usize, relaxations: usize, radius: impl Fn(DVec3) -> f64) -> Mesh {
    let (mut directions, faces) = icosphere(frequency);
    for _ in 0..relaxations {
        let points: Vec<DVec3> = directions.iter().map(|&d| radius(d) * d).collect();
        let mut sums = vec![(DVec3::ZERO, 0.0); points.len()];
        for &face in &faces {
            let [a, b, c] = face.map(|v| points[v as usize]);
            let area = (b - a).cross(c - a).length();
            for v in face {
                sums[v as usize].0 += area * (a + b + c) / 3.0;
                sums[v as usize].1 += area;
            }
        }
        directions = sums.iter().map(|(sum, area)| (*sum / *area).normalize()).collect();
    }
    Mesh {
        positions: directions.iter().map(|&d| (radius(d) * d).as_vec3()).collect(),
        normals: directions.iter().map(|&d| normal(d, &radius).as_vec3()).collect(),
        faces,
    }
}

/// Normal of the surface r(d): r d − ∇r with the gradient along the unit sphere, by central differences.
fn normal(d: DVec3, radius: impl Fn(DVec3) -> f64) -> DVec3 {
    let h = 1e-5;
    let slope = |t: DVec3| (radius((d + h * t).normalize()) - radius((d - h * t).normalize())) / (2.0 * h) * t;
    let (a, b) = d.any_orthonormal_pair();
    (radius(d) * d - slope(a) - slope(b)).normalize()
}

/// Unit directions and faces of the icosahedron whose edges are cut into `frequency` parts.
fn icosphere(frequency: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let corners: [DVec3; 12] = std::array::from_fn(|i| {
        // Cyclic permutations of (0, ±1, ±φ).
        let signs = |bit: usize| if i & bit == 0 { 1.0 } else { -1.0 };
        let mut p = [0.0, signs(1), golden * signs(2)];
        p.rotate_right(i / 4);
        DVec3::from(p)
    });
    let (mut directions, mut faces, mut numbers) = (Vec::new(), Vec::new(), HashMap::new());
    for [a, b, c] in icosahedron_faces(&corners) {
        let mut vertex = |i: usize, j: usize| {
            // Weights of the corners that count, in order: what the faces at an edge have in common.
            let mut key = [(a, frequency - i - j), (b, i), (c, j)].map(|(k, w)| if w == 0 { (12, 0) } else { (k, w) });
            key.sort_unstable();
            *numbers.entry(key).or_insert_with(|| {
                let sum: DVec3 = key.iter().filter(|(_, w)| *w > 0).map(|&(k, w)| w as f64 * corners[k]).sum();
                directions.push(sum.normalize());
                directions.len() as u32 - 1
            })
        };
        for i in 0..frequency {
            for j in 0..frequency - i {
                faces.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 1 < frequency {
                    faces.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
    }
    (directions, faces)
}

/// The 20 triples of corners at the least distance of each other (2, for the corners used), facing outward.
fn icosahedron_faces(corners: &[DVec3; 12]) -> Vec<[usize; 3]> {
    let near = |a: usize, b: usize| (corners[a].distance(corners[b]) - 2.0).abs() < 1e-9;
    let triples = (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| [a, b, c])));
    triples
        .filter(|&[a, b, c]| near(a, b) && near(b, c) && near(c, a))
        .map(|[a, b, c]| {
            let outward = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
            if outward { [a, b, c] } else { [a, c, b] }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn area_and_volume_of_the_sphere_converge_with_the_square_of_the_frequency() {
        let error = |n: usize| {
            let mesh = sphere(n);
            assert_eq!(mesh.positions.len(), 10 * n * n + 2);
            [1.0 - mesh.area() / (4.0 * PI), 1.0 - mesh.volume() / (4.0 * PI / 3.0)]
        };
        let ([area, volume], [finer_area, finer_volume]) = (error(12), error(24));
        assert!(area > 0.0 && volume > 0.0 && finer_area < 2e-3 && finer_volume < 4e-3);
        assert!((area / finer_area - 4.0).abs() < 0.1 && (volume / finer_volume - 4.0).abs() < 0.1);
    }

    #[test]
    fn an_ellipsoid_off_centre_is_left_where_its_equation_says() {
        let e = Ellipsoid::new([0.2, -0.1, 0.3], [1.0, 2.0, 0.5], [1.5, 0.8, 0.6]);
        for d in [DVec3::X, DVec3::NEG_Y, DVec3::new(1.0, -2.0, 3.0).normalize()] {
            assert!(((e.to_unit * (e.radius(d) * d - e.centre)).length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_parts_of_the_blob_contain_its_centre() {
        // Else a ray from there would miss them, and the radius would not be a number.
        for part in ears_and_body() {
            assert!((part.to_unit * part.centre).length() < 1.0);
        }
    }

    #[test]
    fn normals_of_an_ellipsoid_are_its_gradient() {
        let e = Ellipsoid::new([0.1, 0.0, 0.2], [1.0, 0.0, 0.0], [1.5, 0.8, 0.6]);
        for d in [DVec3::X, DVec3::new(0.3, -0.5, 0.8).normalize()] {
            let gradient = e.to_unit.transpose() * (e.to_unit * (e.radius(d) * d - e.centre));
            assert!(normal(d, |d| e.radius(d)).dot(gradient.normalize()) > 1.0 - 1e-9);
        }
    }
}
