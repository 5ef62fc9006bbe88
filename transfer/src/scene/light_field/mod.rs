//! Surface light fields: the radiance that leaves the texels of a surface in all directions (Miandji, Kronander and Unger 2011, §3.1).
//!
//! A texel is a point of the surface ([`crate::scene::chart`]), a direction a cell of a Z x W lat-long grid ([`LightBasis::LatLong`],
//! z up, where the paper's Eq. 1 has y). What a point's diffuse part reflects leaves it alike in every direction: it is estimated once
//! for a texel, with as many paths as its directions together would have taken. A lobe is traced for each direction by itself.
//!
//! The grid covers the sphere, as in the paper, so that no lookup has to turn into a point's frame. Nothing leaves an opaque surface
//! below its horizon, and what a field holds there is free: see [`Horizon`].

mod directions;
mod horizon;
#[cfg(test)]
mod tests;

use crate::basis::LightBasis;
use crate::error::{Error, Result};
use crate::matrix::TransferMatrix;
use crate::progress::Progress;
use crate::responses::{Directions, ResponseBasis};
use crate::scene::chart::{Charted, Place, Places};
use crate::scene::path::{PathTracer, Tally};
use crate::scene::world::{Object, SurfacePoint};
use directions::Grid;
use glam::Vec3;
use rayon::prelude::*;

crate::choices! {
    /// What a field holds for directions below a point's horizon.
    pub enum Horizon {
        /// The radiance at the horizon goes over into the mean of all directions: interpolation at a silhouette finds no darkness, and a matte
        /// surface is one number a texel.
        Continued = "continued",
        /// Nothing.
        Dark = "dark",
    }
}

crate::params! {
    /// How a surface light field is sampled.
    pub struct FieldParams: "light-field" {
        /// X, texels in a row, 1 to 4096.
        width: usize = 256,
        /// Y, rows of texels, 1 to 4096.
        height: usize = 256,
        /// Z, directions around, 4 to 1024.
        around: usize = 32,
        /// W, directions from pole to pole, 2 to 512.
        down: usize = 16,
        /// Each direction is the mean over a finer grid of s x s directions in its cell, a path each; s from 1 to 16.
        supersampling: usize = 2,
        /// Width of the box filter in finer directions, 1 to 64, odd or even as s is; none = s, a cell. The paper has 5.
        filter: Option<usize> = None,
        /// Paths of a texel for what its diffuse part reflects, 0 to 65536.
        diffuse: usize = 256,
        /// Below the horizon: continued or dark.
        horizon: Horizon = Horizon::Continued,
        /// What directions are: world or reflected, about the point's normal.
        frame: Directions = Directions::World,
    }
}

/// A sampled field and what it took.
#[derive(Clone, Debug)]
pub struct LightField {
    /// (X·Y texels, three channels) x (Z·W directions), W/m²/sr.
    pub matrix: TransferMatrix,
    /// Paths and rays.
    pub tally: Tally,
    /// Texels beside the chart that hold what is at its rim, and texels that nothing will look up.
    pub gutter: usize,
    /// See `gutter`.
    pub unused: usize,
}

impl FieldParams {
    /// Refuses what is out of range.
    ///
    /// # Errors
    /// The parameter, and its range.
    pub fn check(&self) -> Result<()> {
        let whole = [
            ("width", self.width, 1, 4096),
            ("height", self.height, 1, 4096),
            ("around", self.around, 4, 1024),
            ("down", self.down, 2, 512),
            ("supersampling", self.supersampling, 1, 16),
            ("filter", self.filter_width(), 1, 64),
            ("diffuse", self.diffuse, 0, 1 << 16),
        ];
        for (name, value, least, most) in whole {
            if !(least..=most).contains(&value) {
                return Err(refuse(name, value, format!("from {least} to {most}")));
            }
        }
        // The finer directions of a filter lie evenly about the middle of a cell.
        if self.filter_width() % 2 != self.supersampling % 2 {
            let expected = format!("odd or even as supersampling={} is", self.supersampling);
            return Err(refuse("filter", self.filter_width(), expected));
        }
        Ok(())
    }

    /// Finer directions across a box.
    pub fn filter_width(&self) -> usize {
        self.filter.unwrap_or(self.supersampling)
    }

    /// Directions of the field.
    pub fn basis(&self) -> LightBasis {
        LightBasis::LatLong { width: self.around, height: self.down }
    }
}

fn refuse(name: &str, value: impl ToString, expected: String) -> Error {
    use crate::params::Params;
    FieldParams::refuse(name, value.to_string(), expected)
}

/// The light field of one object of the tracer's world.
///
/// The same parameters and seed give the same field on any number of threads.
///
/// # Errors
/// Parameters out of range, an object without a chart, and a chart that has no place for its texels.
pub fn light_field(
    tracer: &PathTracer,
    object: usize,
    params: &FieldParams,
    progress: &dyn Progress,
) -> Result<LightField> {
    let of = &tracer.world().objects()[object];
    let Places { texels, places, gutter, .. } = places(of, params)?;
    let grid = Grid::new(params);
    let sampler = Sampler { tracer, object, params, grid: &grid, lobe: of.material.has_lobe() };
    let row = 3 * grid.directions.len();
    let mut values = vec![0f32; texels.count() * row];
    progress.start(&format!("light field of {}", of.name), texels.count() as u64);
    let tally = values
        .par_chunks_mut(row)
        .zip(&places)
        .enumerate()
        .map(|(texel, (out, place))| {
            let mut tally = Tally::default();
            if let Some(place) = place {
                sampler.texel(texel, place, out, &mut tally);
            }
            progress.advance(1)?;
            Ok(tally)
        })
        .try_reduce(Tally::default, |mut sum, texel| {
            sum += texel;
            Ok(sum)
        })?;
    let unused = places.iter().filter(|place| place.is_none()).count();
    let matrix = TransferMatrix::from_dense(values, texels.count() * 3, 3, params.basis())?;
    let responses = ResponseBasis::Radiance { texels, directions: params.frame };
    Ok(LightField { matrix: matrix.with_responses(responses)?, tally, gutter, unused })
}

/// Where the texels of an object lie; all that can be wrong with a field before anything is traced.
///
/// # Errors
/// As [`light_field`].
pub fn places(object: &Object, params: &FieldParams) -> Result<Places> {
    params.check()?;
    object.charted().and_then(|chart| chart.places(params.width, params.height)).map_err(|e| e.in_file(&object.name))
}

struct Sampler<'a> {
    tracer: &'a PathTracer<'a>,
    object: usize,
    params: &'a FieldParams,
    grid: &'a Grid,
    /// Whether radiance depends on direction at all.
    lobe: bool,
}

impl Sampler<'_> {
    /// Radiance of a texel, channel after channel.
    fn texel(&self, texel: usize, place: &Place, out: &mut [f32], tally: &mut Tally) {
        let point = self.tracer.world().point(self.object, place.face, place.u, place.v);
        let even = self.even(texel, &point, tally);
        let mut radiance = vec![Some(even); self.grid.directions.len()];
        let towards = |direction: Vec3| view(self.params.frame, direction, &point);
        let above = |direction: Vec3| {
            let view = towards(direction);
            view.dot(point.normal).min(view.dot(point.geometric)) > GRAZING
        };
        if self.lobe {
            let fine = self.lobe(texel, &point, above, tally);
            self.grid.filter(&fine, &mut radiance);
            radiance.iter_mut().flatten().for_each(|radiance| *radiance += even);
        } else if self.params.horizon == Horizon::Dark {
            let dark = self.grid.directions.iter().map(|&d| above(d).then_some(even));
            radiance = dark.collect();
        }
        match self.params.horizon {
            Horizon::Continued => horizon::continue_below(self.grid, point.normal, &mut radiance),
            Horizon::Dark => {}
        }
        let n = radiance.len();
        for (direction, radiance) in radiance.into_iter().enumerate() {
            let radiance = radiance.unwrap_or(Vec3::ZERO);
            (0..3).for_each(|channel| out[channel * n + direction] = radiance[channel]);
        }
    }

    /// What leaves the point alike in all directions.
    fn even(&self, texel: usize, point: &SurfacePoint, tally: &mut Tally) -> Vec3 {
        let material = &self.tracer.world().objects()[self.object].material;
        let paths = if material.has_diffuse() { self.params.diffuse } else { 0 };
        let key = key(self.object, texel, 0);
        let sum: glam::DVec3 = (0..paths).map(|i| self.tracer.diffuse(point, key, i as u32, tally).as_dvec3()).sum();
        material.emission + (sum / paths.max(1) as f64).as_vec3()
    }

    /// What the lobe reflects in each of the finer directions, a path each; `None` below the horizon.
    fn lobe(
        &self,
        texel: usize,
        point: &SurfacePoint,
        above: impl Fn(Vec3) -> bool,
        tally: &mut Tally,
    ) -> Vec<Option<Vec3>> {
        let trace = |(fine, &direction): (usize, &Vec3)| {
            // Paths of one cell are a low-discrepancy sequence together; those of others are another one.
            let (cell, index) = self.grid.cell_of(fine);
            let key = key(self.object, texel, 1 + cell as u64);
            let view = view(self.params.frame, direction, point);
            above(direction).then(|| self.tracer.lobe(point, view, key, index as u32, tally))
        };
        self.grid.fine.iter().enumerate().map(trace).collect()
    }
}

/// Where radiance goes that a column's direction names. The way back is the same: a mirror image's mirror image.
fn view(directions: Directions, direction: Vec3, point: &SurfacePoint) -> Vec3 {
    match directions {
        Directions::World => direction,
        Directions::Reflected => mirrored(direction, point.normal),
    }
}

/// The direction that a mirror of this unit normal takes to `direction`; both point away from it.
pub fn mirrored(direction: Vec3, normal: Vec3) -> Vec3 {
    2.0 * normal.dot(direction) * normal - direction
}

/// Sine of the elevation up to which a direction counts as below the horizon.
const GRAZING: f32 = 1e-3;

/// Names a sequence of samples.
fn key(object: usize, texel: usize, cell: u64) -> u64 {
    (object as u64) << 48 ^ (texel as u64) << 22 ^ cell
}

impl Object {
    /// The object's surface laid out in a square.
    fn charted(&self) -> Result<Charted> {
        Charted::new(self.mesh.clone(), self.uv.clone(), self.border)
    }
}
