//! What every signal shares: surface points with frames, the batch of directions, and what precomputation reports.

use crate::basis::cubemap_solid_angle;
use crate::error::{Error, Result};
use crate::params::Params;
use crate::progress::Progress;
use crate::scene::bvh::Occluders;
use crate::scene::directions::Directions;
use crate::scene::frames::Frame;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Instant;

crate::params! {
    /// How visibility is sampled.
    pub struct Sampling: "sampling" {
        /// Texels along an edge of a cubemap face, 1 to 512.
        resolution: usize = 32,
        /// Each texel is sampled 2^m x 2^m times; m from 0 to 4.
        supersampling: u32 = 1,
    }
}

/// Surface points that transfer is computed at: vertices of a mesh.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// What casts shadows.
    pub occluders: &'a Occluders,
    /// Positions.
    pub points: &'a [Vec3],
    /// Local frames; the third axis is the normal.
    pub frames: &'a [Frame],
}

/// What precomputation did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traced {
    /// Occlusion rays answered: directions above a point's horizon.
    pub rays: u64,
    /// Time spent answering them, summed over threads, in seconds.
    pub seconds: f64,
}

/// One direction of the batch and the part of the sphere that it stands for.
pub struct Sample {
    /// Unit direction.
    pub direction: Vec3,
    /// The texel that it lies in: a column of a cubemap basis.
    pub texel: u32,
    /// Solid angle in sr; those of all samples add up to 4π.
    pub solid_angle: f64,
}

/// All samples of a [`Sampling`], beside the tiles that visibility is answered in.
pub struct Samples {
    directions: Directions,
    /// 64 a tile, in the order of its bits.
    lanes: Vec<Sample>,
}

impl Sampling {
    /// Samples of a texel: 4^m.
    pub fn samples_per_texel(&self) -> usize {
        1 << (2 * self.supersampling)
    }

    /// The samples, after checking the ranges.
    pub fn samples(&self) -> Result<Samples> {
        if !(1..=512).contains(&self.resolution) {
            return Err(Self::refuse("resolution", self.resolution, "from 1 to 512"));
        }
        if self.supersampling > 4 {
            return Err(Self::refuse("supersampling", self.supersampling, "from 0 to 4"));
        }
        let edge = 1 << self.supersampling;
        let directions = Directions::cubemap(self.resolution, edge)?;
        let half = 1.0 / (self.resolution * edge) as f64;
        let lanes = (0..64 * directions.tiles())
            .map(|lane| (lane / 64, lane % 64))
            .map(|(tile, bit)| {
                let direction = directions.direction(tile, bit);
                if directions.filled(tile) >> bit & 1 == 0 {
                    return Sample { direction, texel: u32::MAX, solid_angle: 0.0 };
                }
                Sample {
                    direction,
                    texel: directions.index(tile, bit) as u32,
                    solid_angle: solid_angle(direction, half),
                }
            })
            .collect();
        Ok(Samples { directions, lanes })
    }
}

/// Solid angle in sr of the square part of a cube face around `direction`, `2 * half` wide in face coordinates.
fn solid_angle(direction: Vec3, half: f64) -> f64 {
    // Divided by the largest component the other two are the face coordinates; their order and signs do not matter.
    let mut d = direction.to_array().map(|c| f64::from(c.abs()));
    d.sort_by(f64::total_cmp);
    let (u, v) = (d[0] / d[2], d[1] / d[2]);
    cubemap_solid_angle(u - half, v - half, u + half, v + half)
}

/// The samples above a point's horizon that nothing occludes.
pub struct Visible<'a> {
    pub(crate) masks: &'a [u64],
}

impl Visible<'_> {
    /// A bit for each lane, a word for each tile of 64.
    pub fn masks(&self) -> &[u64] {
        self.masks
    }

    /// The lanes, ascending.
    pub fn lanes(&self) -> impl Iterator<Item = usize> + use<'_> {
        self.masks.iter().enumerate().flat_map(|(tile, &mask)| {
            let next = |mask: &u64| Some(mask & (mask - 1)).filter(|rest| *rest != 0);
            std::iter::successors(Some(mask).filter(|m| *m != 0), next)
                .map(move |mask| 64 * tile + mask.trailing_zeros() as usize)
        })
    }
}

impl Samples {
    /// The same directions, as rays are answered.
    pub(crate) fn directions(&self) -> &Directions {
        &self.directions
    }

    /// The sample of each lane; a lane without one has a texel that does not exist.
    pub fn lanes(&self) -> &[Sample] {
        &self.lanes
    }
}

/// Points of one batch for each thread at most: what is computed before anything is handed on.
const BATCH: usize = 32;

/// Bytes of a batch at most, where more than one point for each thread has them.
const BATCH_BYTES: usize = 64 << 20;

/// Runs `signal(point, visible)` for every surface point on all cores and hands the results to `take` in the order of
/// the points, batch by batch, so that they need not all be in memory; `bytes` are those of one result, about.
pub(crate) fn for_each_point<T: Send>(
    surface: &Surface,
    samples: &Samples,
    bytes: usize,
    progress: &dyn Progress,
    signal: impl Fn(usize, &Visible) -> Result<T> + Sync,
    mut take: impl FnMut(T) -> Result<()> + Send,
) -> Result<Traced> {
    Error::expect_size("frames beside surface points", surface.points.len(), surface.frames.len())?;
    progress.start("precompute", surface.points.len() as u64);
    let (rays, nanoseconds) = (AtomicU64::new(0), AtomicU64::new(0));
    let at = |masks: &mut Vec<u64>, point: usize| {
        let (start, normal) = (Instant::now(), surface.frames[point].normal);
        let answered = surface.occluders.visible(surface.points[point], normal, &samples.directions, masks);
        nanoseconds.fetch_add(start.elapsed().as_nanos() as u64, Relaxed);
        rays.fetch_add(answered, Relaxed);
        progress.advance(1)?;
        signal(point, &Visible { masks })
    };
    let threads = rayon::current_num_threads();
    let batch = (BATCH_BYTES / bytes.max(1)).clamp(threads, BATCH * threads);
    let mut ready: Vec<T> = Vec::new();
    for first in (0..surface.points.len()).step_by(batch) {
        let points = first..surface.points.len().min(first + batch);
        let masks = || vec![0u64; samples.directions.tiles()];
        // One thread hands on what is ready while the others compute.
        let (taken, next) = rayon::join(
            || ready.into_iter().try_for_each(&mut take),
            || points.into_par_iter().map_init(masks, at).collect::<Result<Vec<T>>>(),
        );
        taken?;
        ready = next?;
    }
    ready.into_iter().try_for_each(take)?;
    Ok(Traced { rays: rays.into_inner(), seconds: nanoseconds.into_inner() as f64 * 1e-9 })
}
