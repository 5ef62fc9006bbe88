//! Chair of flat boards.

use super::lattice::{Block, block, solid};
use crate::mesh::Mesh;

/// Half the seat's width and depth (x, y), its underside and its top.
const SEAT: [f64; 2] = [0.24, 0.23];
const SEAT_HEIGHT: [f64; 2] = [0.42, 0.46];
/// Legs are square, of this width, at the seat's corners; the two at the back rise to the top.
const LEG: f64 = 0.05;
const TOP: f64 = 0.96;
/// Boards of the back, by height.
const BACK: [[f64; 2]; 3] = [[0.54, 0.62], [0.68, 0.76], [0.82, 0.94]];
/// Rails between the legs, by height.
const RAIL: [f64; 2] = [0.18, 0.22];
/// The back leans by this much for each unit of height above the seat.
const LEAN: f64 = 0.18;
/// How thick boards and rails are, set into the middle of the legs.
const BOARD: f64 = 0.02;

pub(super) fn tessellate(steps: usize) -> Mesh {
    let [x, y] = SEAT;
    let mut blocks = vec![block([-x, x], [-y, y], SEAT_HEIGHT)];
    for x in [[-x, LEG - x], [x - LEG, x]] {
        blocks.push(block(x, [-y, LEG - y], [0.0, SEAT_HEIGHT[0]]));
        blocks.push(block(x, [y - LEG, y], [0.0, TOP]));
    }
    blocks.extend(rails());
    blocks.extend(BACK.map(|z| block([LEG - x, x - LEG], middle(y), z)));
    solid(&blocks, TOP / steps as f64, |p| p.with_y(p.y + LEAN * (p.z - SEAT_HEIGHT[1]).max(0.0)))
}

/// Where a board lies in a leg whose outer side is at `outer`.
fn middle(outer: f64) -> [f64; 2] {
    let centre = outer - 0.5 * LEG;
    [centre - 0.5 * BOARD, centre + 0.5 * BOARD]
}

/// One on each side, one at the back.
fn rails() -> Vec<Block> {
    let ([x, y], [low, high]) = (SEAT, middle(SEAT[0]));
    let along = [LEG - y, y - LEG];
    vec![block([-high, -low], along, RAIL), block([low, high], along, RAIL), block([LEG - x, x - LEG], middle(y), RAIL)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaning_keeps_the_volume_of_the_boards() {
        let ([x, y], seat) = (SEAT, SEAT_HEIGHT[1] - SEAT_HEIGHT[0]);
        let legs = LEG * LEG * (4.0 * SEAT_HEIGHT[0] + 2.0 * (TOP - SEAT_HEIGHT[1]));
        let back: f64 = BACK.iter().map(|[low, high]| 2.0 * (x - LEG) * BOARD * (high - low)).sum();
        let rails = BOARD * (RAIL[1] - RAIL[0]) * (4.0 * (y - LEG) + 2.0 * (x - LEG));
        let expected = 4.0 * x * y * seat + legs + back + rails;
        for n in [10, 33] {
            assert!((tessellate(n).volume() / expected - 1.0).abs() < 1e-5);
        }
    }
}
