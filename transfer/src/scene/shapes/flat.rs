//! Flat faces, subdivided, with hard edges.

use crate::mesh::Mesh;
use glam::DVec3;

/// Adds the bilinear patch of four corners, counter-clockwise seen from outside, as `along` x `across` quadrilaterals: `along`
/// between the first two corners, `across` between the second and the third. Normals are the patch's own; the vertices are
/// its alone, so that its borders are hard edges.
pub(in crate::scene) fn add_patch(mesh: &mut Mesh, corners: [DVec3; 4], along: usize, across: usize) {
    let [a, b, c, d] = corners;
    let first = mesh.positions.len() as u32;
    for (i, j) in (0..(along + 1) * (across + 1)).map(|k| (k % (along + 1), k / (along + 1))) {
        let (s, t) = (i as f64 / along as f64, j as f64 / across as f64);
        let (near, far) = (a.lerp(b, s), d.lerp(c, s));
        let normal = (b - a).lerp(c - d, t).cross(far - near).normalize();
        mesh.positions.push(near.lerp(far, t).as_vec3());
        mesh.normals.push(normal.as_vec3());
    }
    let vertex = |i: usize, j: usize| first + (j * (along + 1) + i) as u32;
    for (i, j) in (0..along * across).map(|k| (k % along, k / along)) {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        mesh.faces.extend([[a, b, c], [a, c, d]]);
    }
}

/// Segments for a side of this length where the `longest` side has `steps`: at least one.
pub(super) fn segments(length: f64, longest: f64, steps: usize) -> usize {
    ((length / longest * steps as f64).round() as usize).max(1)
}

/// A mesh of flat faces: each vertex is split into one for each direction that the faces around it have.
pub(super) fn with_hard_edges(positions: &[DVec3], faces: &[[u32; 3]]) -> Mesh {
    let mut mesh = Mesh { positions: positions.iter().map(|p| p.as_vec3()).collect(), ..Mesh::default() };
    // The normals at each position, and the vertex that each became.
    let mut sides: Vec<Vec<(DVec3, u32)>> = vec![Vec::new(); positions.len()];
    let (mut split, mut normals) = (Vec::new(), Vec::new());
    for face in faces {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize();
        mesh.faces.push(face.map(|v| {
            let here = &mut sides[v as usize];
            if let Some((_, vertex)) = here.iter().find(|(n, _)| n.dot(normal) > 1.0 - 1e-9) {
                return *vertex;
            }
            split.push(mesh.positions[v as usize]);
            normals.push(clean(normal).as_vec3());
            here.push((normal, split.len() as u32 - 1));
            split.len() as u32 - 1
        }));
    }
    mesh.positions = split;
    mesh.normals = normals;
    mesh
}

/// Rounding noise of a flat face's normal removed, so that a wall has one normal, bit for bit.
fn clean(normal: DVec3) -> DVec3 {
    ((normal * 1e9).round() / 1e9 + DVec3::ZERO).normalize()
}
