//! Lobes seen from the target's directions: the matrix of the linear least squares, by tiles.

use super::target::{Target, Tile};
use crate::kernel::Kernel;
use crate::lobe::Lobe;
use ndarray::{Array2, ArrayView2};
use prt_transfer::linalg;
use rayon::prelude::*;

/// A lobe whose values on a tile are all below this share of its peak is left out there.
const NEGLIGIBLE: f64 = 1e-12;

/// Runs of tiles that are worked on side by side, each with sums of its own: a fixed number, so that results do not depend on threads.
const RUNS: usize = 8;

/// Normalised lobes Ĝ = G/‖G‖ on a target.
pub(super) struct Design<'a> {
    pub(super) target: &'a Target,
    pub(super) kernel: Kernel,
    pub(super) lobes: &'a [Lobe],
    /// ‖G‖ of each.
    pub(super) norms: Vec<f64>,
    pub(super) tiles: Vec<TileDesign>,
}

/// The lobes that matter on a tile.
pub(super) struct TileDesign {
    /// Ascending.
    pub(super) active: Vec<usize>,
    /// Ĝ times the roots of the tile: active lobes x directions.
    pub(super) values: Vec<f64>,
}

/// AᵀA (lobes x lobes) and AᵀY (lobes x channels).
pub(super) struct Normal {
    pub(super) gram: Array2<f64>,
    pub(super) right: Array2<f64>,
}

/// Work on runs of tiles, in order.
pub(super) fn in_runs<T: Send>(tiles: usize, runs: usize, work: impl Fn(std::ops::Range<usize>) -> T + Sync) -> Vec<T> {
    let runs = runs.min(tiles.max(1));
    (0..runs).into_par_iter().map(|run| work(run * tiles / runs..(run + 1) * tiles / runs)).collect()
}

impl<'a> Design<'a> {
    pub(super) fn new(target: &'a Target, kernel: Kernel, lobes: &'a [Lobe]) -> Design<'a> {
        let norms: Vec<f64> = lobes.iter().map(|lobe| kernel.norm(lobe.bandwidth)).collect();
        let of = |tile: &Tile| TileDesign::new(tile, kernel, lobes, &norms);
        let tiles = target.tiles.par_iter().map(of).collect();
        Design { target, kernel, lobes, norms, tiles }
    }

    pub(super) fn normal(&self) -> Normal {
        let (n, channels) = (self.lobes.len(), self.target.channels);
        let zero = || Normal { gram: Array2::zeros((n, n)), right: Array2::zeros((n, channels)) };
        let parts = in_runs(self.tiles.len(), RUNS, |run| {
            let mut sums = zero();
            self.pairs(run).for_each(|(tile, design)| design.add_normal(tile, &mut sums));
            sums
        });
        parts.into_iter().fold(zero(), |mut all, part| {
            all.gram += &part.gram;
            all.right += &part.right;
            all
        })
    }

    /// Tiles of a run with their designs.
    pub(super) fn pairs(&self, run: std::ops::Range<usize>) -> impl Iterator<Item = (&Tile, &TileDesign)> {
        self.target.tiles[run.clone()].iter().zip(&self.tiles[run])
    }

    /// Y - A·C of every tile: channels x directions, weighted.
    pub(super) fn residuals(&self, coefficients: &Array2<f64>) -> Vec<Vec<f64>> {
        let pairs = self.target.tiles.par_iter().zip(&self.tiles);
        pairs.map(|(tile, design)| design.residual(tile, coefficients)).collect()
    }
}

/// Σ of squares.
pub(super) fn square(residuals: &[Vec<f64>]) -> f64 {
    residuals.iter().map(|r| r.iter().map(|v| v * v).sum::<f64>()).sum()
}

impl TileDesign {
    fn new(tile: &Tile, kernel: Kernel, lobes: &[Lobe], norms: &[f64]) -> TileDesign {
        let (mut active, mut values) = (Vec::new(), Vec::with_capacity(lobes.len() * tile.len() / 2));
        for (j, lobe) in lobes.iter().enumerate() {
            let nearest = kernel.value(tile.nearest_cosine(lobe.centre), lobe.bandwidth);
            if nearest > NEGLIGIBLE * kernel.value(1.0, lobe.bandwidth) {
                active.push(j);
                add_row(tile, kernel, lobe, 1.0 / norms[j], &mut values);
            }
        }
        TileDesign { active, values }
    }

    fn add_normal(&self, tile: &Tile, sums: &mut Normal) {
        let rows = ArrayView2::from_shape((self.active.len(), tile.len()), &self.values[..]).expect("rows of a tile");
        let mut gram = Array2::zeros((self.active.len(), self.active.len()));
        linalg::times_transposed_f64(rows, rows, gram.view_mut());
        for (row, &i) in gram.outer_iter().zip(&self.active) {
            let mut sums = sums.gram.row_mut(i);
            row.iter().zip(&self.active).for_each(|(v, &j)| sums[j] += v);
        }
        for (row, &i) in rows.outer_iter().zip(&self.active) {
            let row = row.to_slice().expect("contiguous");
            for (sum, values) in sums.right.row_mut(i).iter_mut().zip(tile.values.chunks(tile.len())) {
                *sum += product(row, values);
            }
        }
    }

    fn residual(&self, tile: &Tile, coefficients: &Array2<f64>) -> Vec<f64> {
        let mut residual = tile.values.clone();
        for (row, &j) in self.values.chunks(tile.len()).zip(&self.active) {
            for (residual, c) in residual.chunks_mut(tile.len()).zip(coefficients.row(j)) {
                residual.iter_mut().zip(row).for_each(|(r, v)| *r -= c * v);
            }
        }
        residual
    }
}

/// Appends `scale`·G times the tile's roots.
fn add_row(tile: &Tile, kernel: Kernel, lobe: &Lobe, scale: f64, values: &mut Vec<f64>) {
    let [x, y, z] = &tile.directions;
    let [a, b, c] = lobe.centre;
    let start = values.len();
    values.extend(x.iter().zip(y).zip(z).map(|((x, y), z)| a * x + b * y + c * z));
    let row = &mut values[start..];
    kernel.values(row, lobe.bandwidth);
    row.iter_mut().zip(&tile.roots).for_each(|(v, root)| *v *= scale * root);
}

pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    // Four sums, so that the additions do not wait for each other.
    let mut sums = [0.0; 4];
    let (fours, rest) = (a.len() / 4 * 4, a.len() % 4);
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        (0..4).for_each(|i| sums[i] += a[i] * b[i]);
    }
    (0..rest).for_each(|i| sums[i] += a[fours + i] * b[fours + i]);
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
