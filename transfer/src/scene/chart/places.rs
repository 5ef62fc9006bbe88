//! Where the centres of texels lie on a surface.

use super::triangle::Triangle;
use super::{Charted, gutter};
use crate::chart::refused;
use crate::error::{Error, Result};
use crate::scene::repair::is_degenerate;
use crate::texels::{MAX_SIDE, Texels};
use glam::DVec2;

/// Where the centre of a texel lies on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Face of the mesh.
    pub face: u32,
    /// Weight of the face's second corner; the first has `1 - u - v`.
    pub u: f32,
    /// Weight of the face's third corner.
    pub v: f32,
}

/// The texels of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    /// The grid.
    pub texels: Texels,
    /// The place of texel `x + y · width`, row y = 0 at v = 0; `None` where no lookup of a point of the chart touches it.
    pub places: Vec<Option<Place>>,
    /// Texels outside of the chart that were given the nearest place on it, for lookups near its border.
    pub gutter: usize,
    /// Faces without area in the chart, which have no texels of their own.
    pub flat: usize,
}

/// How deep in two faces, in texels, the centre of a texel may be: charts in files meet up to the digits that were written.
const OVERLAP: f64 = 0.01;

impl Charted {
    /// Rasterises the chart: the place of the centre of each of `width` x `height` texels.
    ///
    /// A centre on an edge belongs to the first face there. Signs of edge functions are exact, so that faces that meet in the
    /// chart leave no texel out. Mirrored charts are charts.
    ///
    /// # Errors
    /// What [`Charted::check`] refuses, sides beyond [`MAX_SIDE`], charts that overlap at the centre of a texel, a face without
    /// area in space with a texel of its own, and a chart without any texel.
    pub fn places(&self, width: usize, height: usize) -> Result<Places> {
        self.check()?;
        if [width, height].iter().any(|side| !(1..=MAX_SIDE).contains(side)) {
            let expected = format!("from 1 to {MAX_SIDE} along each side");
            return Err(refused("texels of a chart".into(), &expected, format!("{width} x {height}")));
        }
        let texels = Texels { width, height, border: self.border };
        let faces = 0..self.mesh.faces.len() as u32;
        let triangles: Vec<Triangle> = faces.filter_map(|f| Triangle::new(self, f, [width, height])).collect();
        let flat = self.mesh.faces.len() - triangles.len();
        // A texel on an edge of a sound face is that face's.
        let thin = |t: &Triangle| is_degenerate(&self.mesh, self.mesh.faces[t.face as usize]);
        let (thin, sound): (Vec<_>, Vec<_>) = triangles.into_iter().partition(thin);
        let mut raster = Raster { charted: self, texels, places: vec![None; texels.count()] };
        sound.iter().try_for_each(|triangle| raster.add(triangle, |_| Ok(())))?;
        thin.iter().try_for_each(|triangle| raster.add(triangle, |texel| Err(without_area(triangle.face, texel))))?;
        let mut places = raster.places;
        if places.iter().all(Option::is_none) {
            let found = format!("none in {} faces, {flat} of them without area in the chart", self.mesh.faces.len());
            return Err(refused(
                format!("chart of {width} x {height} texels"),
                "the centre of a texel in a face",
                found,
            ));
        }
        let gutter = gutter::fill(&texels, &sound, &mut places);
        Ok(Places { texels, places, gutter, flat })
    }
}

struct Raster<'a> {
    charted: &'a Charted,
    texels: Texels,
    places: Vec<Option<Place>>,
}

impl Raster<'_> {
    /// Gives a face the texels in it that are no other's, each after `accept` has seen which it is.
    fn add(&mut self, triangle: &Triangle, accept: impl Fn(&str) -> Result<()>) -> Result<()> {
        let Texels { width, height, .. } = self.texels;
        for y in inside(triangle.rows(0.0), height) {
            for x in inside(triangle.columns(y as i64, 0.0), width) {
                let centre = DVec2::new(x as f64, y as f64) + 0.5;
                let weights = triangle.weights(centre);
                if weights.iter().any(|&w| w < 0.0) {
                    continue;
                }
                let texel = || format!("texel {x}, {y} of {width} x {height}");
                match &mut self.places[x + y * width] {
                    Some(first) => {
                        let first = first.face;
                        if self.overlap(first, triangle, centre) {
                            return Err(overlap(first, triangle.face, &texel()));
                        }
                    }
                    free => {
                        accept(&texel())?;
                        *free = Some(Place::new(triangle.face, weights));
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether a point is inside two faces by more than rounding.
    fn overlap(&self, first: u32, second: &Triangle, p: DVec2) -> bool {
        let first = Triangle::new(self.charted, first, [self.texels.width, self.texels.height]);
        second.depth(p) > OVERLAP && first.is_some_and(|first| first.depth(p) > OVERLAP)
    }
}

/// What of a range is in 0..side.
fn inside(range: std::ops::RangeInclusive<i64>, side: usize) -> std::ops::Range<usize> {
    let at = |i: i64| i.clamp(0, side as i64) as usize;
    at(*range.start())..at(*range.end() + 1)
}

fn overlap(first: u32, second: u32, texel: &str) -> Error {
    refused(format!("chart: {texel}"), "charts that do not overlap", format!("faces {first} and {second}"))
}

fn without_area(face: u32, texel: &str) -> Error {
    refused(format!("chart: face {face}, {texel}"), "triangles with an area", "none".into())
}

#[cfg(test)]
mod tests;
