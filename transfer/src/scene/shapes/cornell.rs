//! Cornell box, from the measurements that Cornell's Program of Computer Graphics published with it (in millimetres).
//!
//! There y is up and the opening lies at z = 0; here z is up and the box opens towards -y. The lamp is left out: it lies in
//! the ceiling's plane, and scenes here are lit from afar, through the opening. The floor runs on
//! under the blocks, as published: the few samples there see nothing.

use super::flat::{add_patch, segments};
use crate::mesh::Mesh;
use glam::DVec3;

/// Corners of floor and ceiling as published, in the order front right, front left, back left, back right.
const FLOOR: [[f64; 3]; 4] = [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]];
const CEILING: [[f64; 3]; 4] = [[556.0, 548.8, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]];

/// A block on the floor: corners of its top (x and z), and its height.
struct Stand {
    top: [[f64; 2]; 4],
    height: f64,
}

const SHORT: Stand = Stand { top: [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]], height: 165.0 };
const TALL: Stand = Stand { top: [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]], height: 330.0 };

/// Lengths by which sides are subdivided: nominal, so that sides that meet are cut alike.
const ROOM: f64 = 556.0;
const STAND: f64 = 165.0;

/// x to the right seen through the opening, y inward, z up. Published x runs to the left.
fn place([x, y, z]: [f64; 3]) -> DVec3 {
    DVec3::new(ROOM - x, z, y)
}

pub(super) fn tessellate(steps: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let ([a, b, c, d], [e, f, g, h]) = (FLOOR.map(place), CEILING.map(place));
    // Floor, ceiling, back, left (red) and right (green) wall, each counter-clockwise seen from inside.
    for wall in [[a, b, c, d], [e, h, g, f], [d, c, g, h], [a, d, h, e], [c, b, f, g]] {
        add_patch(&mut mesh, wall, steps, steps);
    }
    for stand in [SHORT, TALL] {
        add_stand(&mut mesh, &stand, steps);
    }
    mesh
}

/// Five sides; the sixth stands on the floor.
fn add_stand(mesh: &mut Mesh, stand: &Stand, steps: usize) {
    let (width, height) = (segments(STAND, ROOM, steps), segments(stand.height, ROOM, steps));
    let at = |height: f64| stand.top.map(|[x, z]| place([x, height, z]));
    let (bottom, top) = (at(0.0), at(stand.height));
    add_patch(mesh, top, width, width);
    for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
        add_patch(mesh, [bottom[i], bottom[j], top[j], top[i]], width, height);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of a polygon in the plane, positive if counter-clockwise (shoelace formula).
    fn shoelace(corners: &[[f64; 2]]) -> f64 {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - b[0] * a[1])).sum()
    }

    #[test]
    fn blocks_have_the_volume_of_their_base_times_height() {
        for stand in [SHORT, TALL] {
            let mut mesh = Mesh::default();
            add_stand(&mut mesh, &stand, 9);
            // The missing bottom lies at z = 0, where it adds nothing to ∮ z n_z dA.
            let flux = |f: &[u32; 3]| mesh.corners(*f).iter().map(|c| c.z / 3.0).sum::<f64>() * mesh.area_vector(*f).z;
            let volume: f64 = mesh.faces.iter().map(flux).sum();
            let expected = shoelace(&stand.top).abs() * stand.height;
            assert!((volume / expected - 1.0).abs() < 1e-5, "{volume} {expected}");
        }
    }

    #[test]
    fn walls_face_into_the_room() {
        let mesh = tessellate(3);
        let (walls, centre) = (5 * 16, DVec3::new(278.0, 279.6, 274.4));
        for v in 0..walls {
            assert!((centre - mesh.positions[v].as_dvec3()).dot(mesh.normals[v].as_dvec3()) > 100.0);
        }
    }

    #[test]
    fn the_room_has_the_published_floor_and_ceiling() {
        let mesh = tessellate(4);
        let area = |wall: usize| {
            mesh.faces[32 * wall..32 * (wall + 1)].iter().map(|&f| mesh.area_vector(f).length()).sum::<f64>()
        };
        assert!((area(0) / (0.5 * (552.8 + 549.6) * 559.2) - 1.0).abs() < 1e-5);
        assert!((area(1) / (556.0 * 559.2) - 1.0).abs() < 1e-5);
    }
}
