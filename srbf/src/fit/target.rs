//! The light to be approximated: directions in tiles of neighbours, so that lobes far from a tile cost nothing there.

use crate::lobe::{dot, normalised};
use prt_transfer::basis::Direction;
use prt_transfer::{Error, Result};

/// Directions in a tile, at most.
const TILE: usize = 64;

/// Radiance in directions that share out the sphere.
pub(super) struct Target {
    pub(super) tiles: Vec<Tile>,
    pub(super) channels: usize,
    pub(super) texels: usize,
}

/// Neighbouring directions and a cap that holds them.
pub(super) struct Tile {
    pub(super) directions: [Vec<f64>; 3],
    /// √ of each solid angle.
    pub(super) roots: Vec<f64>,
    /// channels x directions: radiance times `roots`, over the norm (Σ L² dω)^½ of the light: squared errors are relative.
    pub(super) values: Vec<f64>,
    middle: Direction,
    /// Cosine and sine of the angle between the middle and the farthest direction.
    radius: [f64; 2],
}

impl Tile {
    pub(super) fn len(&self) -> usize {
        self.roots.len()
    }

    pub(super) fn direction(&self, i: usize) -> Direction {
        [0, 1, 2].map(|axis| self.directions[axis][i])
    }

    /// The largest cosine between a direction of the tile's cap and `centre`.
    pub(super) fn nearest_cosine(&self, centre: Direction) -> f64 {
        let cosine = dot(self.middle, centre);
        // cos (a - b), without angles.
        let beyond = cosine * self.radius[0] + (1.0 - cosine * cosine).max(0.0).sqrt() * self.radius[1];
        if cosine > self.radius[0] { 1.0 } else { beyond }
    }
}

impl Target {
    /// Radiance in directions x channels, row by row, each direction with its solid angle.
    pub(super) fn new(directions: &[Direction], angles: &[f64], values: &[f32], channels: usize) -> Result<Target> {
        let texels = directions.len();
        Error::expect_size("solid angles of the light", texels, angles.len())?;
        Error::expect_size("radiance of the light, directions x channels", texels * channels, values.len())?;
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite { row: i / channels, col: i % channels, value: values[i].into() });
        }
        let energy: f64 = (0..texels * channels).map(|i| angles[i / channels] * f64::from(values[i]).powi(2)).sum();
        let scale = if energy > 0.0 { 1.0 / energy.sqrt() } else { 0.0 };
        let mut order: Vec<usize> = (0..texels).collect();
        let mut tiles = Vec::new();
        split(directions, &mut order, &mut |members| {
            let roots: Vec<f64> = members.iter().map(|&i| angles[i].sqrt()).collect();
            let of = |c: usize| {
                members.iter().zip(&roots).map(move |(&i, root)| root * scale * f64::from(values[i * channels + c]))
            };
            let middle =
                normalised(members.iter().fold([0.0; 3], |sum, &i| [0, 1, 2].map(|a| sum[a] + directions[i][a])));
            let cosine = members.iter().map(|&i| dot(middle, directions[i])).fold(1.0, f64::min);
            tiles.push(Tile {
                directions: [0, 1, 2].map(|axis| members.iter().map(|&i| directions[i][axis]).collect()),
                values: (0..channels).flat_map(of).collect(),
                middle,
                // Rounding of the cosine must not leave the farthest direction out.
                radius: {
                    let cosine = (cosine - 1e-12).max(-1.0);
                    [cosine, (1.0 - cosine * cosine).max(0.0).sqrt()]
                },
                roots,
            });
        });
        Ok(Target { tiles, channels, texels })
    }

    /// Whether there is no light at all.
    pub(super) fn is_black(&self) -> bool {
        self.tiles.iter().all(|tile| tile.values.iter().all(|v| *v == 0.0))
    }
}

/// Halves the directions across their longest extent until they fit a tile.
fn split(directions: &[Direction], members: &mut [usize], tile: &mut impl FnMut(&[usize])) {
    if members.len() <= TILE {
        if !members.is_empty() {
            tile(members);
        }
        return;
    }
    let extent = |axis: usize| {
        let ends = members.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &i| {
            [low.min(directions[i][axis]), high.max(directions[i][axis])]
        });
        ends[1] - ends[0]
    };
    let extents = [0, 1, 2].map(extent);
    let axis = (0..3).fold(0, |best, axis| if extents[axis] > extents[best] { axis } else { best });
    let middle = members.len() / 2;
    members
        .select_nth_unstable_by(middle, |&i, &j| directions[i][axis].total_cmp(&directions[j][axis]).then(i.cmp(&j)));
    let (low, high) = members.split_at_mut(middle);
    split(directions, low, tile);
    split(directions, high, tile);
}
