//! The cubemap around a sample: texels in the order of a scan, and how much of each is above a horizon.

use super::frame::{Vector, dot};
use crate::basis::FACES;

/// A cubemap whose texels are sampled `edge` x `edge` times.
pub(super) struct Sky {
    resolution: usize,
    edge: usize,
    /// Half the edge of a texel, in face coordinates.
    half: f64,
}

/// A texel of the cubemap.
pub(super) struct Texel {
    /// Its column.
    pub(super) column: usize,
    face: usize,
    /// The direction of its centre, not of unit length: on the cube of half edge 1.
    pub(super) centre: Vector,
}

impl Sky {
    /// Most samples along an edge of a texel.
    pub(super) const MAX_EDGE: usize = 16;

    /// A cubemap of 6 x `resolution`² texels.
    pub(super) fn new(resolution: usize, edge: usize) -> Sky {
        Sky { resolution, edge, half: 1.0 / resolution as f64 }
    }

    /// The cubemap with so many texels.
    pub(super) fn with_texels(texels: usize, edge: usize) -> Option<Sky> {
        let resolution = (texels / 6).isqrt();
        (6 * resolution * resolution == texels).then(|| Sky::new(resolution, edge))
    }

    /// Samples along an edge of a texel.
    pub(super) fn edge(&self) -> usize {
        self.edge
    }

    /// Every texel in the order of the scan: along the rows of each face, there and back.
    pub(super) fn scan(&self) -> impl Iterator<Item = Texel> {
        let (r, half) = (self.resolution, self.half);
        let coordinate = move |i: usize| (2 * i + 1) as f64 * half - 1.0;
        (0..6).flat_map(move |face| {
            let [forward, right, down] = FACES[face];
            (0..r).flat_map(move |row| {
                let left = sum(forward, coordinate(row), down);
                let along = move |i: usize| if row % 2 == 0 { i } else { r - 1 - i };
                (0..r).map(along).map(move |i| Texel {
                    column: (face * r + row) * r + i,
                    face,
                    centre: sum(left, coordinate(i), right),
                })
            })
        })
    }

    /// How many of a texel's samples are above the plane through the origin with this unit normal.
    #[inline]
    pub(super) fn above(&self, texel: &Texel, normal: Vector) -> usize {
        let height = dot(texel.centre, normal);
        // A texel reaches √2 of its half edge from its centre.
        match height.abs() > 1.5 * self.half {
            true if height > 0.0 => self.edge * self.edge,
            true => 0,
            false => self.above_near(texel.face, height, normal),
        }
    }

    /// [`Sky::above`] for a texel whose centre is at this height.
    fn above_near(&self, face: usize, height: f64, normal: Vector) -> usize {
        let [_, right, down] = FACES[face];
        let (right, down) = (dot(right, normal) * self.half, dot(down, normal) * self.half);
        let offset = |i: usize| (2 * i + 1) as f64 / self.edge as f64 - 1.0;
        let above = |s: &usize| height + offset(s % self.edge) * right + offset(s / self.edge) * down > 0.0;
        (0..self.edge * self.edge).filter(above).count()
    }

    /// The level that stands for each number of samples above the horizon: their part of all, or the next there is.
    pub(super) fn predictions(&self, levels: &[f32]) -> Vec<Option<usize>> {
        let samples = self.edge * self.edge;
        let level = |count: usize| {
            let part = count as f32 / samples as f32;
            levels.partition_point(|&level| level < part).min(levels.len().saturating_sub(1))
        };
        (0..=samples).map(|count| (count > 0 && !levels.is_empty()).then(|| level(count))).collect()
    }
}

/// a + factor · b
fn sum(a: Vector, factor: f64, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + factor * b[i])
}
