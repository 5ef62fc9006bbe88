//! Fixed batches of directions, grouped so that rays from one origin can be answered together.
//!
//! Directions lie on the faces of a cube around the origin. There an edge of a triangle, seen from the origin, is a straight
//! line, and a box a rectangle. A *window* is a piece of a face with coordinates (column, row) in which both are tested: either
//! a grid of up to 64 x 64 directions, one tile of ≤ 64 directions per row, or one tile of ≤ 64 scattered directions.

use crate::basis::{FACES, cubemap_direction};
use crate::error::{Error, Result};
use crate::matrix::MAX_LIGHTS;
use glam::{DVec3, Vec3};

/// Directions of a tile at most: the bits of its mask.
pub const TILE: usize = 64;

/// A lane without a direction.
const NONE: u32 = u32::MAX;

/// A batch of unit directions in tiles of at most 64; a set of them is one `u64` per tile.
#[derive(Clone, Debug)]
pub struct Directions {
    /// One per lane: `TILE` of them per tile, zero where there is no direction.
    lanes: Vec<Vec3>,
    /// Per lane the texel or the place in the given list.
    index: Vec<u32>,
    /// Per tile the lanes in use.
    filled: Vec<u64>,
    pub(crate) windows: Vec<Window>,
}

/// A piece of a cube face with its own coordinates: face coordinate `u = u0 + column / scale`, `v = v0 + row / scale`.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    pub(crate) face: usize,
    /// Face coordinates of column 0 and row 0.
    pub(crate) corner: [f32; 2],
    pub(crate) scale: f32,
    /// Columns and rows, at most 64 each.
    pub(crate) size: [usize; 2],
    pub(crate) first_tile: usize,
    /// `None` for a grid, whose directions lie at whole columns and rows, one tile per row; else where each lies.
    pub(crate) places: Option<Box<[[f32; TILE]; 2]>>,
}

impl Directions {
    /// The texel centres of `LightBasis::Cubemap { resolution }`, or with `supersampling` = s the centres of s x s equal parts
    /// (in face coordinates) of each texel. [`Directions::index`] is the texel, that is the column of the transfer matrix.
    /// One tile holds (up to 64 neighbours of) one row of the finer grid.
    ///
    /// Errors: [`Error::Parameter`] where either is 0, [`Error::TooLarge`] above 2²⁵ directions.
    pub fn cubemap(resolution: usize, supersampling: usize) -> Result<Directions> {
        for (name, value) in [("resolution", resolution), ("supersampling", supersampling)] {
            if value == 0 {
                let (name, value) = (name.to_string(), value.to_string());
                return Err(Error::Parameter { method: "cubemap".into(), name, value, expected: "at least 1".into() });
            }
        }
        let side = resolution.saturating_mul(supersampling);
        let found = 6u64.saturating_mul((side as u64).saturating_mul(side as u64));
        if found > MAX_LIGHTS as u64 {
            return Err(Error::TooLarge { what: "directions".into(), limit: MAX_LIGHTS as u64, found });
        }
        let mut directions = Directions { lanes: vec![], index: vec![], filled: vec![], windows: vec![] };
        let blocks = || (0..side).step_by(TILE);
        for (face, top, left) in (0..6).flat_map(|f| blocks().flat_map(move |t| blocks().map(move |l| (f, t, l)))) {
            directions.push_grid(face, [left, top], side, supersampling);
        }
        Ok(directions)
    }

    fn push_grid(&mut self, face: usize, start: [usize; 2], side: usize, supersampling: usize) {
        let centre = |i: usize| (2 * i + 1) as f64 / side as f64 - 1.0;
        let size = start.map(|i| (side - i).min(TILE));
        self.windows.push(Window {
            face,
            corner: start.map(|i| centre(i) as f32),
            scale: side as f32 / 2.0,
            size,
            first_tile: self.filled.len(),
            places: None,
        });
        let resolution = side / supersampling;
        let texel = |column: usize, row: usize| {
            ((face * resolution + row / supersampling) * resolution + column / supersampling) as u32
        };
        for row in start[1]..start[1] + size[1] {
            self.push_tile((start[0]..start[0] + size[0]).map(|column| {
                let direction = cubemap_direction(face, centre(column), centre(row));
                (DVec3::from_array(direction).as_vec3(), texel(column, row))
            }));
        }
    }

    /// Any list of directions; [`Directions::index`] is the place in it. They need not be unit vectors, but finite and not
    /// zero; [`Directions::direction`] is the normalised one (what is a unit vector to `f32` precision stays as it is).
    /// Neighbours on the sphere are brought together into tiles.
    ///
    /// Errors: [`Error::NotFinite`] (row = place), [`Error::Parameter`] for a zero vector, [`Error::TooLarge`] above 2²⁵.
    pub fn new(list: &[Vec3]) -> Result<Directions> {
        if list.len() > MAX_LIGHTS {
            let (limit, found) = (MAX_LIGHTS as u64, list.len() as u64);
            return Err(Error::TooLarge { what: "directions".into(), limit, found });
        }
        let mut faces: [Vec<Placed>; 6] = Default::default();
        for (row, d) in list.iter().enumerate() {
            if let Some(col) = d.to_array().iter().position(|x| !x.is_finite()) {
                return Err(Error::NotFinite { row, col, value: f64::from(d[col]) });
            }
            let unit = d.as_dvec3().try_normalize().ok_or_else(|| Error::Parameter {
                method: "directions".into(),
                name: format!("direction {row}"),
                value: "0 0 0".into(),
                expected: "a vector that is not zero".into(),
            })?;
            let (face, at) = face_coordinates(unit);
            let kept = (d.as_dvec3().length_squared() - 1.0).abs() < 4.0 * f64::from(f32::EPSILON);
            faces[face].push(Placed { at, unit: if kept { *d } else { unit.as_vec3() }, index: row as u32 });
        }
        let mut directions = Directions { lanes: vec![], index: vec![], filled: vec![], windows: vec![] };
        for (face, placed) in faces.iter_mut().enumerate() {
            directions.push_scattered(face, placed);
        }
        Ok(directions)
    }

    /// Halves the longer side until a tile holds the rest.
    fn push_scattered(&mut self, face: usize, placed: &mut [Placed]) {
        if placed.is_empty() {
            return;
        }
        let [u, v] = [0, 1].map(|axis| {
            let coordinates = placed.iter().map(|p| p.at[axis]);
            coordinates.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        });
        let spread = (u.1 - u.0).max(v.1 - v.0);
        if placed.len() > TILE {
            let axis = usize::from(v.1 - v.0 > u.1 - u.0);
            let half = (placed.len() / 2).next_multiple_of(TILE);
            placed.select_nth_unstable_by(half, |a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.index.cmp(&b.index)));
            let (low, high) = placed.split_at_mut(half);
            self.push_scattered(face, low);
            return self.push_scattered(face, high);
        }
        placed.sort_unstable_by_key(|p| p.index);
        // A single direction, or many equal ones, still get a rectangle that f32 can tell from a point.
        let scale = (TILE - 1) as f64 / spread.max(1e-3);
        let mut places = Box::new([[0.0; TILE]; 2]);
        for (lane, p) in placed.iter().enumerate() {
            places[0][lane] = ((p.at[0] - u.0) * scale) as f32;
            places[1][lane] = ((p.at[1] - v.0) * scale) as f32;
        }
        self.windows.push(Window {
            face,
            corner: [u.0 as f32, v.0 as f32],
            scale: scale as f32,
            size: [TILE; 2],
            first_tile: self.filled.len(),
            places: Some(places),
        });
        self.push_tile(placed.iter().map(|p| (p.unit, p.index)));
    }

    fn push_tile(&mut self, directions: impl Iterator<Item = (Vec3, u32)>) {
        let start = self.lanes.len();
        let (lanes, index): (Vec<_>, Vec<_>) = directions.unzip();
        self.filled.push(!0 >> (TILE - lanes.len()));
        self.lanes.extend(lanes);
        self.index.extend(index);
        self.lanes.resize(start + TILE, Vec3::ZERO);
        self.index.resize(start + TILE, NONE);
    }

    /// Tiles, which is the number of masks.
    pub fn tiles(&self) -> usize {
        self.filled.len()
    }

    /// Directions in all tiles.
    pub fn count(&self) -> usize {
        self.filled.iter().map(|f| f.count_ones() as usize).sum()
    }

    /// The bits of a tile that stand for a direction.
    pub fn filled(&self, tile: usize) -> u64 {
        self.filled[tile]
    }

    /// The unit direction of a bit; zero where the bit stands for none.
    pub fn direction(&self, tile: usize, bit: usize) -> Vec3 {
        self.lanes[tile * TILE + bit]
    }

    /// The texel, or the place in the given list, of a bit that stands for a direction.
    pub fn index(&self, tile: usize, bit: usize) -> usize {
        self.index[tile * TILE + bit] as usize
    }

    /// For each direction that is set in `masks` (one per tile), its [`Directions::index`].
    pub fn indices<'a>(&'a self, masks: &'a [u64]) -> impl Iterator<Item = usize> + 'a {
        masks.iter().zip(&self.filled).enumerate().flat_map(move |(tile, (mask, filled))| {
            let mut rest = mask & filled;
            std::iter::from_fn(move || {
                let bit = rest.trailing_zeros() as usize;
                rest &= rest.checked_sub(1)?;
                Some(self.index(tile, bit))
            })
        })
    }
}

/// A direction on its way into a tile.
struct Placed {
    at: [f64; 2],
    unit: Vec3,
    index: u32,
}

/// The face that a direction passes through, and where.
fn face_coordinates(d: DVec3) -> (usize, [f64; 2]) {
    let axis = d.abs().max_position();
    let face = 2 * axis + usize::from(d[axis] < 0.0);
    let [forward, right, down] = FACES[face].map(DVec3::from_array);
    let depth = d.dot(forward);
    (face, [d.dot(right) / depth, d.dot(down) / depth])
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::basis::LightBasis;
    use proptest::prelude::*;

    /// Tile, bit and direction of each direction.
    pub(crate) fn each(directions: &Directions) -> impl Iterator<Item = (usize, usize, Vec3)> {
        (0..directions.tiles())
            .flat_map(|tile| (0..TILE).map(move |bit| (tile, bit)))
            .filter(|&(tile, bit)| directions.filled(tile) >> bit & 1 == 1)
            .map(|(tile, bit)| (tile, bit, directions.direction(tile, bit)))
    }

    proptest! {
    #[test]
    fn lists_of_directions_keep_each_of_them_once(
        list in prop::collection::vec(prop::array::uniform3(-2f32..2.0), 0..500), copies in 1usize..4,
    ) {
        let list: Vec<Vec3> = list.into_iter().map(Vec3::from_array).filter(|d| d.length() > 1e-3).collect();
        let list = list.repeat(copies);
        let directions = Directions::new(&list).unwrap();
        let mut found: Vec<_> = each(&directions).map(|(tile, bit, d)| (directions.index(tile, bit), d)).collect();
        found.sort_by_key(|&(index, _)| index);
        prop_assert_eq!(found.len(), list.len());
        prop_assert_eq!(directions.count(), list.len());
        for (k, (index, d)) in found.into_iter().enumerate() {
            prop_assert_eq!(index, k);
            prop_assert!((d - list[k].normalize()).length() < 1e-6);
        }
        let all: Vec<u64> = (0..directions.tiles()).map(|_| !0).collect();
        prop_assert_eq!(directions.indices(&all).count(), list.len());
    }
    }

    #[test]
    fn cubemap_directions_lie_in_their_texels() {
        for (resolution, supersampling) in [(1, 1), (7, 3), (32, 2), (33, 4)] {
            let directions = Directions::cubemap(resolution, supersampling).unwrap();
            let mut samples = vec![0; 6 * resolution * resolution];
            for (tile, bit, d) in each(&directions) {
                let texel = directions.index(tile, bit);
                let (face, row, column) =
                    (texel / resolution / resolution, texel / resolution % resolution, texel % resolution);
                let edge = |i: usize, by: f64| 2.0 * (i as f64 + 0.5 + by) / resolution as f64 - 1.0;
                let reach = (1.0 - 1.0 / supersampling as f64) / 2.0 + 1e-4;
                let corner = |x: f64, y: f64| DVec3::from_array(cubemap_direction(face, edge(column, x), edge(row, y)));
                let corners =
                    [corner(-reach, -reach), corner(reach, -reach), corner(reach, reach), corner(-reach, reach)];
                let inside = (0..4).map(|k| corners[k].cross(corners[(k + 1) % 4]).dot(d.as_dvec3()) > 0.0);
                let inside = inside.fold(0, |sum, s| sum + i32::from(s));
                assert!(inside == 0 || inside == 4, "texel {texel}: {d}");
                assert!((d.length() - 1.0).abs() < 1e-6);
                samples[texel] += 1;
            }
            assert!(samples.iter().all(|&n| n == supersampling * supersampling));
        }
        let centres = LightBasis::Cubemap { resolution: 6 }.directions().unwrap();
        let directions = Directions::cubemap(6, 1).unwrap();
        for (tile, bit, d) in each(&directions) {
            assert_eq!(d, DVec3::from_array(centres[directions.index(tile, bit)]).as_vec3());
        }
    }
}
