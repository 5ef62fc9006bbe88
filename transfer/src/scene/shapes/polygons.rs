//! Two polygons: the smaller floats above the larger and shadows it.

use super::flat::{add_patch, segments};
use crate::mesh::Mesh;
use glam::DVec3;

/// Half the edge of the polygons and their heights: ground and blocker, parallel, facing up.
const POLYGONS: [(f64, f64); 2] = [(1.0, 0.0), (0.4, 0.5)];

pub(super) fn tessellate(steps: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for (half, height) in POLYGONS {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let n = segments(half, POLYGONS[0].0, steps);
        add_patch(&mut mesh, corners.map(|(x, y)| DVec3::new(x * half, y * half, height)), n, n);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_polygons_keep_their_area_at_any_density() {
        for steps in [1, 7, 40] {
            assert!((tessellate(steps).area() - (4.0 + 0.64)).abs() < 1e-5);
        }
    }
}
