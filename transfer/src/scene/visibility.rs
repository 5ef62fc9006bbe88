//! Which of a fixed batch of directions a point sees.
//!
//! What counts as hidden is decided exactly: corners relative to the lifted origin are rounded to `f32` once, and then a
//! direction is hidden if and only if it lies, as real numbers have it, inside or on the border of the image of a triangle.
//! Hence the masks depend neither on the tree, nor on the tiles, nor on the instruction set, and single rays
//! ([`Occluders::occluded`]) agree with them bit by bit.

use super::bvh::Occluders;
use super::directions::Directions;
use super::sweep::Sweep;
use super::visibility_kernel::dispatch;
use crate::error::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;

/// Distance by which origins are lifted off the surface, over the diagonal of the bounding box: some thousand times the
/// rounding of a coordinate, and still a fiftieth of the edges of a closed mesh of 70,000 faces.
pub const OFFSET: f32 = 1e-4;

impl Occluders {
    /// The distance by which [`Occluders::visible`] moves an origin along its normal, in the units of the mesh.
    pub fn offset(&self) -> f32 {
        OFFSET * self.diagonal()
    }

    /// Sets in `out`, one mask per tile, the directions `d` above the horizon (`d.dot(normal) > 0`) whose ray from
    /// `origin + offset·normal` meets no triangle, from either side and at any distance. Returns how many directions are above
    /// the horizon, which is the number of rays answered. `normal` is a unit vector; both are finite.
    ///
    /// # Panics
    /// Where `out.len()` is not [`Directions::tiles`].
    pub fn visible(&self, origin: Vec3, normal: Vec3, directions: &Directions, out: &mut [u64]) -> u64 {
        assert_eq!(out.len(), directions.tiles(), "one mask per tile of directions");
        let origin = (origin + self.offset() * normal) * self.scale;
        dispatch(Sweep { occluders: self, directions, origin, normal, out })
    }

    /// [`Occluders::visible`] from every (origin, normal), spread over rayon's current pool; `each(k, masks)` is told the masks
    /// of point k, in no particular order. Returns the number of rays answered.
    ///
    /// Errors: [`Error::NotFinite`] (row = point; columns 0 to 2 are the origin, 3 to 5 the normal).
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
