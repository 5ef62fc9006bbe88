//! Solids made of boxes: the surface of their union, without hidden faces and without T-junctions.

use super::flat::with_hard_edges;
use crate::mesh::Mesh;
use glam::DVec3;
use std::collections::HashMap;

/// An axis-aligned box, by its lowest and highest corner.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
}

/// The box over intervals of x, y and z.
pub(super) fn block(x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Block {
    Block { low: [x[0], y[0], z[0]], high: [x[1], y[1], z[1]] }
}

/// The planes of all boxes along one axis, and how each interval between two of them is subdivided.
struct Axis {
    planes: Vec<f64>,
    /// Where each plane is among the subdivided coordinates.
    starts: Vec<usize>,
    coordinates: Vec<f64>,
}

impl Axis {
    fn new(blocks: &[Block], axis: usize, step: f64) -> Axis {
        let mut planes: Vec<f64> = blocks.iter().flat_map(|b| [b.low[axis], b.high[axis]]).collect();
        planes.sort_by(f64::total_cmp);
        // Planes that are one but for rounding.
        planes.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let (mut starts, mut coordinates) = (vec![0], vec![planes[0]]);
        for ends in planes.windows(2) {
            let parts = ((ends[1] - ends[0]) / step).round().max(1.0) as usize;
            coordinates.extend((1..parts).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / parts as f64));
            coordinates.push(ends[1]);
            starts.push(coordinates.len() - 1);
        }
        Axis { planes, starts, coordinates }
    }

    fn centre(&self, interval: usize) -> f64 {
        self.planes[interval].midpoint(self.planes[interval + 1])
    }
}

/// The surface of the union of `blocks`, cut into quadrilaterals of about `step`, each point then moved by `warp` (which keeps
/// every face between two planes of the boxes flat). Cuts run through the whole solid, so that neighbours share vertices.
pub(super) fn solid(blocks: &[Block], step: f64, warp: impl Fn(DVec3) -> DVec3) -> Mesh {
    let axes: [Axis; 3] = std::array::from_fn(|axis| Axis::new(blocks, axis, step));
    let cells: [usize; 3] = std::array::from_fn(|axis| axes[axis].planes.len() - 1);
    let filled = |cell: [usize; 3]| {
        let centre: [f64; 3] = std::array::from_fn(|axis| axes[axis].centre(cell[axis]));
        blocks.iter().any(|b| (0..3).all(|i| b.low[i] < centre[i] && centre[i] < b.high[i]))
    };
    let mut surface = Surface { axes: &axes, numbers: HashMap::new(), positions: Vec::new(), faces: Vec::new() };
    for cell in (0..cells.iter().product()).map(|k| [k % cells[0], k / cells[0] % cells[1], k / cells[0] / cells[1]]) {
        if !filled(cell) {
            continue;
        }
        for axis in 0..3 {
            let open = |at_end: bool, neighbour: isize| {
                let mut other = cell;
                other[axis] = other[axis].wrapping_add_signed(neighbour);
                at_end || !filled(other)
            };
            if open(cell[axis] == 0, -1) {
                surface.add_side(cell, axis, false);
            }
            if open(cell[axis] + 1 == cells[axis], 1) {
                surface.add_side(cell, axis, true);
            }
        }
    }
    let positions: Vec<DVec3> = surface.positions.iter().map(|&p| warp(p)).collect();
    with_hard_edges(&positions, &surface.faces)
}

struct Surface<'a> {
    axes: &'a [Axis; 3],
    numbers: HashMap<[usize; 3], u32>,
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

impl Surface<'_> {
    /// Adds the side of a cell that looks along `axis`, upward or downward, subdivided.
    fn add_side(&mut self, cell: [usize; 3], axis: usize, upward: bool) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let height = self.axes[axis].starts[cell[axis] + usize::from(upward)];
        let range = |axis: usize| self.axes[axis].starts[cell[axis]]..self.axes[axis].starts[cell[axis] + 1];
        let (along, across) = (range(u), range(v));
        for i in along {
            for j in across.clone() {
                let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
                    let mut place = [height; 3];
                    (place[u], place[v]) = (i, j);
                    self.vertex(place)
                });
                let faces = if upward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                self.faces.extend(faces);
            }
        }
    }

    fn vertex(&mut self, place: [usize; 3]) -> u32 {
        *self.numbers.entry(place).or_insert_with(|| {
            self.positions.push(DVec3::from(std::array::from_fn(|axis| self.axes[axis].coordinates[place[axis]])));
            self.positions.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_union_of_two_boxes_has_the_area_and_volume_of_the_union() {
        let blocks = [block([0.0, 2.0], [0.0, 2.0], [0.0, 1.0]), block([1.0, 3.0], [0.0, 1.0], [0.5, 2.0])];
        for step in [0.9, 0.21] {
            let mesh = solid(&blocks, step, |p| p);
            assert!((mesh.volume() - (4.0 + 3.0 - 0.5)).abs() < 1e-5);
            // Two boxes of 16 and 13, less what of each lies inside the other, counted on both.
            let hidden = (1.0 + 0.5 + 0.5) + (0.5 + 0.5 + 1.0);
            assert!((mesh.area() - (16.0 + 13.0 - hidden)).abs() < 1e-5, "{}", mesh.area());
        }
    }

    #[test]
    fn a_cube_has_four_split_corners_a_side() {
        let mesh = solid(&[block([0.0, 1.0], [0.0, 1.0], [0.0, 1.0])], 1.0, |p| p);
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (24, 12));
    }
}
