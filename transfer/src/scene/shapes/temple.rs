//! Greek temple with a row of columns all around (peripteral), four by seven.

use super::lattice::{Block, block, solid};
use crate::mesh::Mesh;
use glam::DVec3;

/// Half the lengths of the three steps, from the lowest: x, y. Each is [`STEP`] high.
const STEPS: [[f64; 2]; 3] = [[9.2, 5.45], [8.8, 5.05], [8.4, 4.65]];
const STEP: f64 = 0.4;
/// Half a column's width; its axes stand at multiples of the pitch.
const COLUMN: f64 = 0.45;
const PITCH: f64 = 2.5;
/// Outermost column axes: x, y.
const OUTER: [f64; 2] = [7.5, 3.75];
/// Heights: floor, underside of the architrave, underside of the roof, eaves, ridge.
const FLOOR: f64 = 3.0 * STEP;
const ARCHITRAVE: f64 = 6.2;
const CEILING: f64 = 7.2;
const EAVES: f64 = 7.5;
const RIDGE: f64 = 9.4;
/// The closed room: half its lengths, its walls' thickness, its door's half width and its height.
const CELLA: [f64; 2] = [5.0, 2.2];
const WALL: f64 = 0.4;
const DOOR: [f64; 2] = [0.8, 5.0];

pub(super) fn tessellate(steps: usize) -> Mesh {
    let blocks: Vec<Block> = [base(), columns(), architrave(), cella(), roof()].concat();
    solid(&blocks, 2.0 * STEPS[0][0] / steps as f64, gable)
}

fn base() -> Vec<Block> {
    let step = |(i, [x, y]): (usize, &[f64; 2])| block([-x, *x], [-y, *y], [STEP * i as f64, STEP * (i + 1) as f64]);
    STEPS.iter().enumerate().map(step).collect()
}

fn columns() -> Vec<Block> {
    let axes = |outer: f64| (0..=(2.0 * outer / PITCH).round() as usize).map(move |i| PITCH * i as f64 - outer);
    axes(OUTER[0])
        .flat_map(|x| axes(OUTER[1]).map(move |y| (x, y)))
        .filter(|(x, y)| x.abs() == OUTER[0] || y.abs() == OUTER[1])
        .map(|(x, y)| block([x - COLUMN, x + COLUMN], [y - COLUMN, y + COLUMN], [FLOOR, ARCHITRAVE]))
        .collect()
}

/// The beam around, as wide as the columns.
fn architrave() -> Vec<Block> {
    ring([OUTER[0] + COLUMN, OUTER[1] + COLUMN], 2.0 * COLUMN, [ARCHITRAVE, CEILING])
}

/// Four walls with these outer half lengths.
fn ring([x, y]: [f64; 2], thickness: f64, z: [f64; 2]) -> Vec<Block> {
    let (inner_x, inner_y) = (x - thickness, y - thickness);
    vec![
        block([-x, x], [-y, -inner_y], z),
        block([-x, x], [inner_y, y], z),
        block([-x, -inner_x], [-inner_y, inner_y], z),
        block([inner_x, x], [-inner_y, inner_y], z),
    ]
}

/// The room inside, its door towards +x.
fn cella() -> Vec<Block> {
    let mut walls = ring(CELLA, WALL, [FLOOR, CEILING]);
    walls.pop();
    let (x, y) = ([CELLA[0] - WALL, CELLA[0]], CELLA[1] - WALL);
    walls.extend([
        block(x, [-y, -DOOR[0]], [FLOOR, CEILING]),
        block(x, [DOOR[0], y], [FLOOR, CEILING]),
        block(x, [-DOOR[0], DOOR[0]], [DOOR[1], CEILING]),
    ]);
    walls
}

/// As wide as the middle step; parted at the ridge, where [`gable`] bends it.
fn roof() -> Vec<Block> {
    let [x, y] = STEPS[1];
    [[-y, 0.0], [0.0, y]].map(|y| block([-x, x], y, [CEILING, RIDGE])).into()
}

/// Slopes the roof from the ridge down to the eaves.
fn gable(p: DVec3) -> DVec3 {
    if p.z <= CEILING {
        return p;
    }
    let top = EAVES + (RIDGE - EAVES) * (1.0 - p.y.abs() / STEPS[1][1]);
    p.with_z(CEILING + (p.z - CEILING) * (top - CEILING) / (RIDGE - CEILING))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_volume_is_the_sum_of_its_parts() {
        let steps: f64 = STEPS.iter().map(|[x, y]| 4.0 * x * y * STEP).sum();
        let columns = 18.0 * (2.0 * COLUMN).powi(2) * (ARCHITRAVE - FLOOR);
        let ring = |[x, y]: [f64; 2], t: f64| 4.0 * (x * y - (x - t) * (y - t));
        let beam = ring([OUTER[0] + COLUMN, OUTER[1] + COLUMN], 2.0 * COLUMN) * (CEILING - ARCHITRAVE);
        let door = 2.0 * DOOR[0] * WALL * (DOOR[1] - FLOOR);
        let cella = ring(CELLA, WALL) * (CEILING - FLOOR) - door;
        let [x, y] = STEPS[1];
        let roof = 4.0 * x * y * ((EAVES - CEILING) + 0.5 * (RIDGE - EAVES));
        let expected = steps + columns + beam + cella + roof;
        for n in [20, 61] {
            assert!((tessellate(n).volume() / expected - 1.0).abs() < 1e-5);
        }
    }
}
