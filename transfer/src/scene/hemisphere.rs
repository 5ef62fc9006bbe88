//! Which of the [local directions](crate::hemisphere) is nearest to any direction.

use crate::error::{Error, Result};
use crate::hemisphere::{self, equal_area_hemisphere};
use glam::Vec3;
use std::f32::consts::SQRT_2;

/// `edge`² directions at the centres of equal-area cells, index `row * edge + column` of the concentric square.
pub struct LocalDirections {
    directions: Vec<Vec3>,
    /// For each bin of the Lambert disk, the range of `candidates` that can be nearest to a direction in it.
    bins: Vec<(u32, u32)>,
    candidates: Vec<u16>,
}

/// Bins along an edge of the square around the Lambert disk.
const BINS: usize = 128;

impl LocalDirections {
    /// Most cells along an edge.
    pub const MAX_EDGE: usize = hemisphere::MAX_EDGE;

    /// `edge`² cells, `edge` from 1 to [`LocalDirections::MAX_EDGE`].
    pub fn new(edge: usize) -> Result<LocalDirections> {
        if !(1..=Self::MAX_EDGE).contains(&edge) {
            return Err(Error::Parameter {
                method: "biscale".into(),
                name: "local directions along an edge".into(),
                value: edge.to_string(),
                expected: format!("from 1 to {}", Self::MAX_EDGE),
            });
        }
        let directions: Vec<Vec3> = hemisphere::local_directions(edge).into_iter().map(Vec3::from_array).collect();
        let (mut bins, mut candidates) = (Vec::with_capacity(BINS * BINS), Vec::new());
        for bin in 0..BINS * BINS {
            let first = candidates.len() as u32;
            candidates.extend(nearest_in_bin(&directions, bin % BINS, bin / BINS));
            bins.push((first, candidates.len() as u32));
        }
        Ok(LocalDirections { directions, bins, candidates })
    }

    /// The unit directions, z along the normal.
    pub fn directions(&self) -> &[Vec3] {
        &self.directions
    }

    /// The index of the direction nearest to the unit vector `local`; the lower index where two are equally near. One below
    /// the horizon is taken to the horizon first.
    #[inline]
    pub fn nearest(&self, local: Vec3) -> usize {
        let local = if local.z < 0.0 { Vec3::new(local.x, local.y, 0.0).normalize_or(Vec3::X) } else { local };
        // Inverse of `equal_area_hemisphere`: (x, y) / sqrt(1 + z).
        let scale = (1.0 + local.z).sqrt().recip();
        let bin = |c: f32| (((c * scale + 1.0) * (0.5 * BINS as f32)) as usize).min(BINS - 1);
        let (first, last) = self.bins[bin(local.y) * BINS + bin(local.x)];
        let candidates = &self.candidates[first as usize..last as usize];
        if let [only] = candidates {
            return usize::from(*only);
        }
        let mut best = (f32::NEG_INFINITY, 0);
        for &candidate in candidates {
            let cosine = self.directions[usize::from(candidate)].dot(local);
            if cosine > best.0 {
                best = (cosine, usize::from(candidate));
            }
        }
        best.1
    }
}

/// Every direction that may be the nearest to some direction of a bin, ascending.
fn nearest_in_bin(directions: &[Vec3], column: usize, row: usize) -> Vec<u16> {
    let centre = |i: usize| (2 * i + 1) as f32 / BINS as f32 - 1.0;
    let (mut x, mut y) = (centre(column), centre(row));
    // A bin outside the disk is asked for only by rounding at the horizon: its nearest point of the disk stands for it.
    let radius = x.hypot(y);
    let outside = (radius - 1.0).max(0.0);
    if radius > 1.0 {
        (x, y) = (x / radius, y / radius);
    }
    let centre = Vec3::from_array(equal_area_hemisphere(x, y));
    // The map stretches lengths by at most 2 towards the horizon (dθ/dr = 2/sqrt(2 - r²)), so that no direction of the bin is
    // further than this from its centre.
    let reach = 2.0 * (SQRT_2 / BINS as f32 + outside);
    let angle = |d: &Vec3| d.angle_between(centre);
    let nearest = directions.iter().map(angle).fold(f32::INFINITY, f32::min);
    let limit = nearest + 2.0 * reach + 1e-3;
    (0..directions.len() as u16).filter(|&j| angle(&directions[usize::from(j)]) <= limit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    /// Of each edge up to 16.
    static CELLS: LazyLock<Vec<LocalDirections>> =
        LazyLock::new(|| (1..=16).map(|edge| LocalDirections::new(edge).unwrap()).collect());

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(10_000))]

        #[test]
        fn nearest_is_the_nearest(edge in 1usize..=16, z in 0f32..1.0, phi in 0f32..std::f32::consts::TAU) {
            let local = Vec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z);
            let cells = &CELLS[edge - 1];
            let found = cells.directions()[cells.nearest(local)].dot(local);
            let best = cells.directions().iter().map(|d| d.dot(local)).fold(f32::NEG_INFINITY, f32::max);
            prop_assert_eq!(found, best);
        }
    }
}
