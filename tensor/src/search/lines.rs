//! Where the search for clusters starts: lines through the origin.

use super::assign::{Stacked, assign};
use super::slabs::Slabs;
use ndarray::{Array2, Axis};
use prt_transfer::groups::Groups;
use prt_transfer::random::Random;
use prt_transfer::{Progress, Result};
use rayon::prelude::*;

/// Sweeps of lines at most.
const SWEEPS: usize = 10;
/// Samples that decide on the lines, all in all and for each cluster.
const DECIDING: usize = 4096;
const SAMPLES_OF_EACH: usize = 48;

/// Clusters around lines through the origin, the subspaces of one dimension that keep most: drawn with a probability that grows with what
/// those drawn before leave of a sample (k-means++), then alternated with their members.
///
/// Samples count as much as each other: every one by its direction.
pub(crate) fn lines(slabs: &Slabs, clusters: usize, seed: u64, progress: &dyn Progress) -> Result<Vec<u32>> {
    let some = slabs.some(DECIDING.max(SAMPLES_OF_EACH * clusters));
    let lines = alternated(&some, clusters, seed, progress)?;
    Ok(assign(slabs, &Stacked::of(&lines)).0.members)
}

fn alternated(slabs: &Slabs, clusters: usize, seed: u64, progress: &dyn Progress) -> Result<Vec<Array2<f32>>> {
    let squares = slabs.squares();
    let scale: Vec<f32> = squares.iter().map(|s| if *s > 0.0 { s.sqrt().recip() as f32 } else { 0.0 }).collect();
    let drawn = draw(slabs, &scale, clusters, seed)?;
    let mut lines: Vec<Array2<f32>> =
        drawn.iter().map(|&sample| direction(slabs, &scale, &[(sample as u32, 1.0)])).collect();
    let mut state = assign(slabs, &Stacked::of(&lines)).0;
    for _ in 0..SWEEPS {
        let groups = Groups::of(&state.members, lines.len());
        lines = (0..lines.len())
            .into_par_iter()
            .map(|cluster| moved(slabs, &scale, groups.of_cluster(cluster), &lines[cluster]))
            .collect();
        let next = assign(slabs, &Stacked::of(&lines)).0;
        progress.advance(1)?;
        let still = next.members == state.members;
        state = next;
        if still {
            break;
        }
    }
    Ok(lines)
}

/// Samples, no line twice: fewer than asked for where there are no more directions.
fn draw(slabs: &Slabs, scale: &[f32], clusters: usize, seed: u64) -> Result<Vec<usize>> {
    let hashes: Vec<u64> = (0..slabs.count).into_par_iter().map(|sample| hash(slabs.row(sample), seed)).collect();
    let mut left: Vec<f64> = scale.iter().map(|s| f64::from(u8::from(*s > 0.0))).collect();
    let mut drawn = Vec::new();
    while drawn.len() < clusters {
        let Some(sample) = pick(&hashes, &left, drawn.len()) else { break };
        drawn.push(sample);
        let line = direction(slabs, scale, &[(sample as u32, 1.0)]);
        let along = super::products::times_transposed(slabs.by_sample(), line.view());
        for ((left, along), scale) in left.iter_mut().zip(&along).zip(scale) {
            let outside = 1.0 - f64::from(along * scale).powi(2);
            *left = if outside < 1e-6 { 0.0 } else { left.min(outside) };
        }
        left[sample] = 0.0;
    }
    Ok(drawn)
}

/// A sample drawn with a probability proportional to its weight; `None` where all weights are 0. What is drawn depends on the samples and
/// not on their order: each brings its own random number (Efraimidis and Spirakis 2006).
pub(crate) fn pick(hashes: &[u64], weights: &[f64], draw: usize) -> Option<usize> {
    let key = |hash: u64, weight: f64| Random(hash ^ (draw as u64) << 32).uniform().max(1e-300).ln() / weight;
    let positive = weights.iter().zip(hashes).enumerate().filter(|(_, (weight, _))| **weight > 0.0);
    let keys = positive.map(|(sample, (weight, hash))| (key(*hash, *weight), sample));
    keys.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, sample)| sample)
}

/// A number of a sample, another one for each seed (FNV-1a by words). A power of two that the sample is multiplied by leaves it as it is.
pub(crate) fn hash(row: &[f32], seed: u64) -> u64 {
    let largest = row.iter().fold(0f32, |most, v| most.max(v.abs()));
    let unit = if largest > 0.0 { (-f64::from(largest).log2().floor()).exp2() } else { 1.0 };
    // In double precision nothing that is multiplied by it is lost.
    let bits = |v: &f32| u64::from(((f64::from(*v) * unit) as f32).to_bits());
    row.iter().fold(seed ^ 0xcbf2_9ce4_8422_2325, |hash, v| (hash ^ bits(v)).wrapping_mul(0x100_0000_01b3))
}

/// A unit row: the sum of samples as directions, each times a factor.
fn direction(slabs: &Slabs, scale: &[f32], terms: &[(u32, f32)]) -> Array2<f32> {
    let mut sum = vec![0f64; slabs.dimension()];
    for &(sample, factor) in terms {
        let factor = f64::from(factor * scale[sample as usize]);
        sum.iter_mut().zip(slabs.row(sample as usize)).for_each(|(sum, v)| *sum += factor * f64::from(*v));
    }
    let norm = sum.iter().map(|v| v * v).sum::<f64>().sqrt();
    let row = sum.iter().map(|v| if norm > 0.0 { (v / norm) as f32 } else { 0.0 });
    Array2::from_shape_vec((1, slabs.dimension()), row.collect()).expect("one row")
}

/// A step of power iteration on the members; the same line where there are none.
fn moved(slabs: &Slabs, scale: &[f32], group: &[u32], line: &Array2<f32>) -> Array2<f32> {
    if group.is_empty() {
        return line.clone();
    }
    let line = line.index_axis(Axis(0), 0);
    let line = line.as_slice().expect("one row");
    let along = |&sample: &u32| {
        let dot: f32 = slabs.row(sample as usize).iter().zip(line).map(|(a, b)| a * b).sum();
        (sample, dot * scale[sample as usize])
    };
    direction(slabs, scale, &group.iter().map(along).collect::<Vec<_>>())
}
