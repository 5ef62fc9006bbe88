//! Which of a fixed batch of directions a point sees.

use super::bvh::Occluders;
use super::directions::Directions;
use super::sweep::Sweep;
use super::visibility_kernel::dispatch;
use crate::error::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;

/// Distance by which origins are lifted off the surface, over the diagonal of the bounding box.
pub const OFFSET: f32 = 1e-4;

impl Occluders {
    /// The distance by which [`Occluders::visible`] moves an origin along its normal, in the units of the mesh.
    pub fn offset(&self) -> f32 {
        OFFSET * self.diagonal()
    }

    /// Sets in `out`, one mask per tile, the directions `d` above the horizon (`d.dot(normal) > 0`) whose ray from
    /// `origin + offset·normal` meets no triangle, from either side; returns how many are above the horizon, which is the
    /// number of rays answered.
    pub fn visible(&self, origin: Vec3, normal: Vec3, directions: &Directions, out: &mut [u64]) -> u64 {
        assert_eq!(out.len(), directions.tiles(), "one mask per tile of directions");
        let origin = (origin + self.offset() * normal) * self.scale;
        dispatch(Sweep { occluders: self, directions, origin, normal, out })
    }

    /// Every point.
    pub fn visible_from(
        &self,
        points: &[(Vec3, Vec3)],
        directions: &Directions,
        each: impl Fn(usize, &[u64]) + Sync,
    ) -> Result<u64> {
        for (row, (origin, normal)) in points.iter().enumerate() {
            let coordinates = origin.to_array().into_iter().chain(normal.to_array());
            if let Some((col, value)) = coordinates.enumerate().find(|(_, x)| !x.is_finite()) {
                return Err(Error::NotFinite { row, col, value: f64::from(value) });
            }
        }
        let masks = || vec![0; directions.tiles()];
        let rays = points.par_iter().enumerate().map_init(masks, |masks, (k, &(origin, normal))| {
            let rays = self.visible(origin, normal, directions, masks);
            each(k, masks);
            rays
        });
        Ok(rays.sum())
    }
}
