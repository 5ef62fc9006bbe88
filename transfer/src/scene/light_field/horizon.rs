//! What a field holds where nothing is to be seen.

use super::directions::Grid;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Cells below the horizon over which radiance goes over into the mean.
const REACH: f32 = 2.0;

/// Fills the directions without radiance, all of them below the horizon of a surface with this normal: at the horizon with the radiance of
/// the nearest direction above it, from [`REACH`] cells on with the mean over all directions above. Both leave no edge for interpolation or
/// compression to trip over.
pub(super) fn continue_below(grid: &Grid, normal: Vec3, radiance: &mut [Option<Vec3>]) {
    if radiance.iter().all(Option::is_some) {
        return;
    }
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for (radiance, &angle) in radiance.iter().zip(&grid.solid_angles) {
        if let Some(radiance) = radiance {
            sum += angle * radiance.as_dvec3();
            weights += angle;
        }
    }
    let mean = if weights > 0.0 { (sum / weights).as_vec3() } else { Vec3::ZERO };
    let above: Vec<Option<Vec3>> = radiance.to_vec();
    let step = PI / grid.down as f32;
    for (radiance, &direction) in radiance.iter_mut().zip(&grid.directions).filter(|(r, _)| r.is_none()) {
        let depth = (-direction.dot(normal)).clamp(0.0, 1.0).asin() / (REACH * step);
        let share = smooth(depth.min(1.0));
        let nearest = if share < 1.0 { nearest_above(grid, &above, normal, direction, step) } else { None };
        *radiance = Some(nearest.unwrap_or(mean).lerp(mean, share));
    }
}

/// Radiance where the meridian of a direction, seen from the normal, first meets a cell that has any.
fn nearest_above(grid: &Grid, above: &[Option<Vec3>], normal: Vec3, direction: Vec3, step: f32) -> Option<Vec3> {
    let level = direction.reject_from_normalized(normal).try_normalize()?;
    // Half a cell at a time; two cells are enough, since a cell's middle is less than one from its rim.
    (0..=4).find_map(|i| {
        let (sine, cosine) = (0.5 * step * i as f32).sin_cos();
        above[grid.cell(cosine * level + sine * normal)]
    })
}

/// 3t² − 2t³.
fn smooth(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}
