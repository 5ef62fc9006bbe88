//! Directions of a latitude-longitude grid, and what lies between them.

use std::f32::consts::PI;
use std::ops::Deref;

/// The grid of [`prt_transfer::LightBasis::LatLong`]: Z columns around the equator, W rows from pole to pole, z up.
///
/// It is the paper's (Eq. 1 and 2) with other axes: ξ_1 is azimuth over a whole turn, ξ_2 the angle from the pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sphere {
    /// Z: columns, azimuth.
    pub z: usize,
    /// W: rows, from +z to -z.
    pub w: usize,
}

/// Directions of a grid with weights from 0 to 1 that add up to 1; one direction may be there twice.
#[derive(Clone, Copy, Debug)]
pub struct Taps {
    taps: [(u32, f32); 6],
    count: usize,
}

impl Deref for Taps {
    type Target = [(u32, f32)];
    fn deref(&self) -> &[(u32, f32)] {
        &self.taps[..self.count]
    }
}

/// Columns whose mean is the value at a pole.
const AT_POLE: usize = 4;

impl Sphere {
    /// How many directions.
    pub fn count(&self) -> usize {
        self.z * self.w
    }

    /// The middle of each direction's texel.
    pub fn centres(&self) -> Vec<[f32; 3]> {
        let middle = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        let centre = |at: usize| {
            let direction =
                prt_transfer::basis::latlong_direction(middle(at % self.z, self.z), middle(at / self.z, self.w));
            direction.map(|c| c as f32)
        };
        (0..self.count()).map(centre).collect()
    }

    /// Directions around `direction`, of any length, and their bilinear weights in azimuth and polar angle: continuous everywhere, and exact to
    /// the second order. Azimuth wraps. Between a pole and the row of texels next to it radiance goes over to one value at the pole, the mean
    /// of four directions of that row around it; with the opposite azimuth in its place, a pole would have another value for each azimuth that
    /// it is reached from.
    ///
    /// # Panics
    /// A grid without directions.
    pub fn taps(&self, direction: [f32; 3]) -> Taps {
        let Cell { columns: [left, right], rows: [top, bottom], across, down } = self.cell(direction);
        let column = |side: usize, row: usize| (row * self.z + side) as u32;
        let mut taps = [(0, 0.0); 6];
        let (row, pole) = match (top, bottom) {
            (Some(top), Some(bottom)) => {
                taps[..2].copy_from_slice(&[
                    (column(left, top), (1.0 - across) * (1.0 - down)),
                    (column(right, top), across * (1.0 - down)),
                ]);
                taps[2..4].copy_from_slice(&[
                    (column(left, bottom), (1.0 - across) * down),
                    (column(right, bottom), across * down),
                ]);
                return Taps { taps, count: 4 };
            }
            // From the middle of the row to the pole is half a row.
            (None, _) => (0, 2.0 * (1.0 - down)),
            (_, None) => (self.w - 1, 2.0 * down),
        };
        taps[0] = (column(left, row), (1.0 - across) * (1.0 - pole));
        taps[1] = (column(right, row), across * (1.0 - pole));
        for (i, tap) in taps[2..].iter_mut().enumerate() {
            *tap = (column(i * self.z / AT_POLE, row), pole / AT_POLE as f32);
        }
        Taps { taps, count: 2 + AT_POLE }
    }

    /// The four texels that a direction lies between, as the paper takes them: across a pole the rows go on at the opposite azimuth.
    pub(super) fn nearest(&self, direction: [f32; 3]) -> [u32; 4] {
        let Cell { columns: [left, right], rows: [top, bottom], .. } = self.cell(direction);
        let texel = |column: usize, row: Option<usize>, beyond: usize| match row {
            Some(row) => (row * self.z + column) as u32,
            None => (beyond * self.z + (column + self.z / 2) % self.z) as u32,
        };
        [texel(left, top, 0), texel(right, top, 0), texel(left, bottom, self.w - 1), texel(right, bottom, self.w - 1)]
    }

    /// Where a direction lies among the middles of texels.
    fn cell(&self, [x, y, z]: [f32; 3]) -> Cell {
        assert!(self.count() > 0, "a sphere of {} x {} directions", self.z, self.w);
        // The inverse of `latlong_direction`.
        let (s, t) = ((PI - y.atan2(x)) / (2.0 * PI), (x * x + y * y).sqrt().atan2(z) / PI);
        let (s, t) = (s * self.z as f32 - 0.5, t * self.w as f32 - 0.5);
        // From -1 to Z.
        let wrapped = |column: i64| match column {
            column if column < 0 => self.z - 1,
            column if column >= self.z as i64 => 0,
            column => column as usize,
        };
        // Both are above -1; `floor` is a call on many processors.
        let floor = |x: f32| x as i64 - i64::from(x < 0.0);
        let (left, top) = (floor(s), floor(t));
        let row = |row: i64| usize::try_from(row).ok().filter(|row| *row < self.w);
        Cell {
            columns: [wrapped(left), wrapped(left + 1)],
            rows: [row(top), row(top + 1)],
            across: s - left as f32,
            down: t - top as f32,
        }
    }
}

/// Four texels around a direction.
struct Cell {
    /// To the left and right.
    columns: [usize; 2],
    /// Above and below; `None` beyond a pole.
    rows: [Option<usize>; 2],
    /// From the first column and row, in texels.
    across: f32,
    down: f32,
}
