//! The paper's first guess (Tsai and Shih 2006, section 5.3).

use super::target::Target;
use crate::kernel::Kernel;
use crate::lobe::{Lobe, dot};
use prt_transfer::basis::Direction;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Steps of angle in which a coverage is measured.
const RINGS: usize = 128;

/// A direction belongs to another one's coverage where their squared difference is at most this share of the squared radiance there.
const DIFFERENCE: f64 = 0.25;

/// A coverage ends where more than this share of the directions in it differ.
const SHARE: f64 = 0.1;

/// Where all directions are marked before there are enough lobes, coverages shrink by this.
const SHRINK: f64 = 0.7;

/// Lobes in the order of radiance times coverage, none within the coverage of one before it; the coverage is their spread.
pub(super) fn lobes(target: &Target, kernel: Kernel, bandwidths: [f64; 2], count: usize) -> Vec<Lobe> {
    let (directions, radiance) = directions_and_radiance(target);
    let mut covers: Vec<f64> =
        (0..directions.len()).into_par_iter().map(|i| coverage(i, &directions, &radiance)).collect();
    let norm = |i: usize| radiance[i].iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut order: Vec<usize> = (0..directions.len()).collect();
    order.sort_by(|&i, &j| (norm(j) * covers[j]).total_cmp(&(norm(i) * covers[i])));
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count.min(directions.len()) {
        for &i in &order {
            let marked = |&j: &usize| i == j || dot(directions[i], directions[j]) > covers[j].cos();
            if chosen.len() < count && !chosen.iter().any(marked) {
                chosen.push(i);
            }
        }
        covers.iter_mut().for_each(|c| *c *= SHRINK);
    }
    // More lobes than directions start on each other's place; descent parts them as far as that pays.
    let repeated = chosen.iter().cycle().take(count);
    let lobe = |&i: &usize| {
        let bandwidth = kernel.bandwidth_of_spread(covers[i] / SHRINK).clamp(bandwidths[0], bandwidths[1]);
        Lobe { centre: directions[i], bandwidth }
    };
    repeated.map(lobe).collect()
}

/// Every direction and its radiance in all channels.
fn directions_and_radiance(target: &Target) -> (Vec<Direction>, Vec<Vec<f64>>) {
    let all = target.tiles.iter().flat_map(|tile| (0..tile.len()).map(move |i| (tile, i)));
    all.map(|(tile, i)| {
        let values = tile.values.chunks(tile.len()).map(|channel| channel[i] / tile.roots[i]);
        (tile.direction(i), values.collect())
    })
    .unzip()
}

/// The angle up to which at most a share of the directions differ from direction `i`.
fn coverage(i: usize, directions: &[Direction], radiance: &[Vec<f64>]) -> f64 {
    let own: f64 = radiance[i].iter().map(|c| c * c).sum();
    let mut rings = [[0usize; 2]; RINGS];
    for (direction, other) in directions.iter().zip(radiance) {
        let angle = dot(directions[i], *direction).clamp(-1.0, 1.0).acos();
        let difference: f64 = radiance[i].iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum();
        let ring = &mut rings[((angle / PI * RINGS as f64) as usize).min(RINGS - 1)];
        ring[0] += 1;
        ring[1] += usize::from(difference > DIFFERENCE * own);
    }
    let (mut all, mut differing) = (0, 0);
    for (k, [ring, other]) in rings.into_iter().enumerate() {
        (all, differing) = (all + ring, differing + other);
        if differing as f64 > SHARE * all as f64 {
            return (k.max(1) as f64) / RINGS as f64 * PI;
        }
    }
    PI
}
