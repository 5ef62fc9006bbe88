//! The enhanced LBG algorithm (Patanè and Russo 2001): means that move from where they are of little use to where they are missed.

use super::lines::{hash, pick};
use super::products;
use super::slabs::Slabs;
use ndarray::Array2;
use prt_transfer::groups::Groups;
use prt_transfer::samples::square;
use prt_transfer::{Progress, Result};
use rayon::prelude::*;

/// Sweeps of LBG at most.
const SWEEPS: usize = 12;
/// It ends where a sweep lowers the squared error by less than this part.
const LITTLE: f64 = 1e-3;
/// Rounds of LBG between the two halves of a cell.
const ROUNDS: usize = 3;

/// Cells around means.
struct Cells<'a> {
    slabs: &'a Slabs<'a>,
    squares: Vec<f64>,
    /// A row each.
    means: Array2<f32>,
    members: Vec<u32>,
    /// Squared distances to the own mean.
    distances: Vec<f64>,
    /// Of each cell, and how often was drawn: cells are in the order in which their samples were drawn, not in that of the samples.
    random: Vec<u64>,
    drawn: usize,
}

/// The cluster of each sample around means of samples drawn at random.
pub(crate) fn elbg(slabs: &Slabs, clusters: usize, seed: u64, progress: &dyn Progress) -> Result<Vec<u32>> {
    let mut cells = Cells::new(slabs, clusters, seed);
    let mut before = cells.assign();
    for _ in 0..SWEEPS {
        cells.shift();
        cells.centre();
        let now = cells.assign();
        progress.advance(1)?;
        if before - now <= LITTLE * before {
            break;
        }
        before = now;
    }
    Ok(cells.members)
}

impl<'a> Cells<'a> {
    fn new(slabs: &'a Slabs<'a>, clusters: usize, seed: u64) -> Cells<'a> {
        let hashes: Vec<u64> = (0..slabs.count).into_par_iter().map(|i| hash(slabs.row(i), seed)).collect();
        let (mut weights, mut drawn) = (vec![1f64; slabs.count], Vec::new());
        while let Some(sample) = pick(&hashes, &weights, drawn.len()).filter(|_| drawn.len() < clusters) {
            weights[sample] = 0.0;
            drawn.push(sample as u32);
        }
        let random = drawn.iter().map(|&sample| hashes[sample as usize]).collect();
        let means = slabs.gathered(&drawn).by_sample().to_owned();
        let (members, distances) = (vec![0; slabs.count], vec![0.0; slabs.count]);
        Cells { slabs, squares: slabs.squares(), means, members, distances, random, drawn: drawn.len() }
    }

    /// Every sample to the nearest mean; the sum of squared distances.
    fn assign(&mut self) -> f64 {
        let of_means: Vec<f64> = self.means.outer_iter().map(|m| square(m.to_slice().expect("contiguous"))).collect();
        let products = products::times_transposed(self.slabs.by_sample(), self.means.view());
        for (sample, row) in products.outer_iter().enumerate() {
            let distance = |k: usize| self.squares[sample] - 2.0 * f64::from(row[k]) + of_means[k];
            let nearest = (0..of_means.len()).fold((0, f64::INFINITY), |best, k| match distance(k) {
                d if d < best.1 => (k as u32, d),
                _ => best,
            });
            (self.members[sample], self.distances[sample]) = (nearest.0, nearest.1.max(0.0));
        }
        self.distances.iter().sum()
    }

    /// Means of the members; a mean without any stays.
    fn centre(&mut self) {
        let groups = Groups::of(&self.members, self.means.nrows());
        for (cluster, mut mean) in self.means.outer_iter_mut().enumerate() {
            if !groups.of_cluster(cluster).is_empty() {
                mean.assign(&ndarray::ArrayView1::from(&mean_of(self.slabs, groups.of_cluster(cluster))));
            }
        }
    }

    /// Attempts to shift each cell of less than mean distortion into one of more, where that lowers the error: the cell's members go to its
    /// neighbour, the other cell is split.
    fn shift(&mut self) {
        let cells = self.means.nrows();
        let mut distortion = vec![0f64; cells];
        self.members.iter().zip(&self.distances).for_each(|(&k, d)| distortion[k as usize] += d);
        let mean = distortion.iter().sum::<f64>() / cells.max(1) as f64;
        let mut low: Vec<usize> = (0..cells).filter(|&k| distortion[k] < mean).collect();
        low.sort_by(|a, b| distortion[*a].total_cmp(&distortion[*b]));
        let mut touched = vec![false; cells];
        for cell in low {
            let high: Vec<f64> =
                (0..cells).map(|k| if distortion[k] > mean && !touched[k] { distortion[k] } else { 0.0 }).collect();
            self.drawn += 1;
            let Some(split) = pick(&self.random, &high, self.drawn) else { return };
            let Some(neighbour) = self.neighbour(cell).filter(|&n| !touched[n] && !touched[cell] && n != split) else {
                continue;
            };
            if self.attempt([cell, neighbour, split], &distortion) {
                [cell, neighbour, split].iter().for_each(|&k| touched[k] = true);
            }
        }
    }

    fn neighbour(&self, cell: usize) -> Option<usize> {
        let distance = |k: usize| -> f64 {
            let pairs = self.means.row(k).into_iter().zip(self.means.row(cell)).map(|(a, b)| f64::from(a - b).powi(2));
            pairs.sum()
        };
        (0..self.means.nrows()).filter(|&k| k != cell).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }

    /// Whether the shift lowers the error; then it is done.
    fn attempt(&mut self, [cell, neighbour, split]: [usize; 3], distortion: &[f64]) -> bool {
        let of = |k: usize| -> Vec<u32> {
            self.members.iter().enumerate().filter(|(_, m)| **m as usize == k).map(|(i, _)| i as u32).collect()
        };
        let merged = [of(cell), of(neighbour)].concat();
        let Some(halves) = halves(self.slabs, &of(split)) else { return false };
        let groups = [halves[0].clone(), halves[1].clone(), merged];
        let now: f64 = groups.iter().map(|group| spread(self.slabs, group)).sum();
        if now >= distortion[cell] + distortion[neighbour] + distortion[split] {
            return false;
        }
        for (k, group) in [cell, split, neighbour].into_iter().zip(groups) {
            group.iter().for_each(|&sample| self.members[sample as usize] = k as u32);
        }
        true
    }
}

fn mean_of(slabs: &Slabs, group: &[u32]) -> Vec<f32> {
    let mut sum = vec![0f64; slabs.dimension()];
    for &sample in group {
        sum.iter_mut().zip(slabs.row(sample as usize)).for_each(|(s, v)| *s += f64::from(*v));
    }
    sum.iter().map(|s| (s / group.len().max(1) as f64) as f32).collect()
}

fn distance(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}

/// Squared distances from the mean.
fn spread(slabs: &Slabs, group: &[u32]) -> f64 {
    let mean = mean_of(slabs, group);
    group.iter().map(|&sample| distance(slabs.row(sample as usize), &mean)).sum()
}

/// Members of a cell nearer to either of two means; `None` where they do not differ.
fn halves(slabs: &Slabs, group: &[u32]) -> Option<[Vec<u32>; 2]> {
    let row = |sample: u32| slabs.row(sample as usize);
    let farthest =
        |from: &[f32]| group.iter().copied().max_by(|&a, &b| distance(row(a), from).total_cmp(&distance(row(b), from)));
    let first = farthest(&mean_of(slabs, group))?;
    let mut means = [row(first).to_vec(), row(farthest(row(first))?).to_vec()];
    let mut halves = None;
    for _ in 0..ROUNDS {
        let (left, right): (Vec<u32>, Vec<u32>) =
            group.iter().partition(|&&sample| distance(row(sample), &means[0]) <= distance(row(sample), &means[1]));
        if left.is_empty() || right.is_empty() {
            break;
        }
        means = [mean_of(slabs, &left), mean_of(slabs, &right)];
        halves = Some([left, right]);
    }
    halves
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::Quiet;

    #[test]
    fn every_clump_gets_a_mean_whatever_is_drawn() {
        // Six clumps of 20 samples far apart: of six samples drawn at random some share a clump nearly always.
        let value = |i: usize| [(i / 20 % 3) as f32 * 100.0, (i / 60) as f32 * 100.0].map(|v| v + (i * 37 % 11) as f32);
        let values: Vec<f32> = (0..120).flat_map(value).collect();
        let slabs = Slabs::lent(&values, [120, 1, 2]);
        for seed in 0..20 {
            let members = elbg(&slabs, 6, seed, &Quiet).unwrap();
            let alike = (0..120).all(|i| members[i] == members[i / 20 * 20]);
            let means: std::collections::BTreeSet<u32> = members.iter().copied().collect();
            assert!(alike && means.len() == 6, "seed {seed}: {members:?}");
        }
    }

    #[test]
    fn there_are_no_more_cells_than_samples_and_equal_samples_share_one() {
        let values = [1.0, 2.0, 1.0, 2.0, 5.0, 5.0];
        assert!(elbg(&Slabs::lent(&values, [3, 1, 2]), 9, 0, &Quiet).unwrap().iter().all(|k| *k < 3));
        let members = elbg(&Slabs::lent(&[3.0; 8], [4, 1, 2]), 3, 0, &Quiet).unwrap();
        assert!(members.iter().all(|k| *k == members[0]), "{members:?}");
    }
}
