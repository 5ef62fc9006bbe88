//! The grid of directions, the finer one that is traced, and the box filter between them.

use super::FieldParams;
use crate::basis::LightBasis;
use crate::scene::resample::texel_of;
use glam::Vec3;

/// Z x W directions and the (sZ) x (sW) finer ones.
pub(super) struct Grid {
    /// Z.
    pub(super) around: usize,
    /// W.
    pub(super) down: usize,
    /// The middle of each cell.
    pub(super) directions: Vec<Vec3>,
    /// Of each cell, sr.
    pub(super) solid_angles: Vec<f64>,
    /// The middle of each finer cell.
    pub(super) fine: Vec<Vec3>,
    /// Solid angle of the finer cells of each row, sr.
    fine_angles: Vec<f64>,
    /// s.
    supersampling: usize,
    /// Finer cells across the box.
    filter: usize,
    basis: LightBasis,
}

impl Grid {
    pub(super) fn new(params: &FieldParams) -> Grid {
        let (around, down, s) = (params.around, params.down, params.supersampling);
        let (coarse, fine) = (params.basis(), LightBasis::LatLong { width: s * around, height: s * down });
        let fine_angles = fine.solid_angles().unwrap_or_default().into_iter().step_by(s * around).collect();
        Grid {
            around,
            down,
            directions: vectors(&coarse),
            solid_angles: coarse.solid_angles().unwrap_or_default(),
            fine: vectors(&fine),
            fine_angles,
            supersampling: s,
            filter: params.filter_width(),
            basis: coarse,
        }
    }

    /// The cell in which a finer one lies, and its number there.
    pub(super) fn cell_of(&self, fine: usize) -> (usize, usize) {
        let s = self.supersampling;
        let (x, y) = (fine % (s * self.around), fine / (s * self.around));
        (y / s * self.around + x / s, y % s * s + x % s)
    }

    /// The cell in which a direction lies.
    pub(super) fn cell(&self, direction: Vec3) -> usize {
        texel_of(&self.basis, direction.as_dvec3().to_array()).unwrap_or_default()
    }

    /// The mean of the finer directions in the box around each cell's middle, by solid angle, over those that there are; `None` without any.
    pub(super) fn filter(&self, fine: &[Option<Vec3>], out: &mut [Option<Vec3>]) {
        let (s, w) = (self.supersampling as i64, self.filter as i64);
        let (width, height) = (s * self.around as i64, s * self.down as i64);
        for (cell, out) in out.iter_mut().enumerate() {
            let (x, y) = ((cell % self.around) as i64, (cell / self.around) as i64);
            // Evenly about the middle: w and s are both odd or both even.
            let (left, top) = (s * x + (s - w) / 2, s * y + (s - w) / 2);
            let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
            for row in top.max(0)..(top + w).min(height) {
                let angle = self.fine_angles[row as usize] as f32;
                for column in left..left + w {
                    if let Some(radiance) = fine[(row * width + column.rem_euclid(width)) as usize] {
                        sum += angle * radiance;
                        weights += angle;
                    }
                }
            }
            *out = (weights > 0.0).then(|| sum / weights);
        }
    }
}

fn vectors(basis: &LightBasis) -> Vec<Vec3> {
    let directions = basis.directions().unwrap_or_default();
    directions.into_iter().map(|d| Vec3::from_array(d.map(|c| c as f32))).collect()
}
