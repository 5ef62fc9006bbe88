//! A mesh seen by a camera: rays are cast once, and what they met is shaded as often as there are methods and lights.

use super::bvh::Occluders;
use super::camera::Camera;
use crate::basis::Direction;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::mesh::Mesh;
use crate::progress::Progress;
use glam::Vec3;
use rayon::prelude::*;

/// Samples of a picture at most: 5 GB of places that are seen.
const MAX_SEEN: usize = 1 << 28;

/// Most samples along an edge of a pixel.
pub const MAX_SAMPLES: usize = 16;

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Face of the mesh.
    pub face: u32,
    /// Barycentric weights of the face's corners; they add up to 1.
    pub weights: [f32; 3],
}

impl Seen {
    /// Σ weights · values.
    pub fn mix(&self, values: [Vec3; 3]) -> Vec3 {
        self.weights[0] * values[0] + self.weights[1] * values[1] + self.weights[2] * values[2]
    }
}

/// What the samples of every pixel see of a mesh: the nearest point, from either side. A pixel is the mean of its
/// samples, which lie on a regular grid (a box filter); where one meets nothing, it sees the background.
pub struct View {
    /// Those of the mesh, and how many vertices they are made of.
    faces: Vec<[u32; 3]>,
    vertices: usize,
    camera: Camera,
    /// Samples along an edge of a pixel.
    samples: usize,
    /// Pixel by pixel, in rows from the top; inside a pixel too.
    seen: Vec<Option<Seen>>,
}

impl View {
    /// Casts `samples` x `samples` rays through every pixel, from 1 to [`MAX_SAMPLES`]; `occluders` are those of the
    /// mesh. The result is the same on any number of threads.
    ///
    /// # Errors
    /// A number of samples out of range, a mesh that fails [`Mesh::check`], and occluders of another mesh where that
    /// shows.
    pub fn cast(
        mesh: &Mesh,
        occluders: &Occluders,
        camera: Camera,
        samples: usize,
        progress: &dyn Progress,
    ) -> Result<View> {
        mesh.check()?;
        if !(1..=MAX_SAMPLES).contains(&samples) {
            return Err(Error::Parameter {
                method: "view".into(),
                name: "samples".into(),
                value: samples.to_string(),
                expected: format!("from 1 to {MAX_SAMPLES} along an edge of a pixel"),
            });
        }
        let row = camera.width() * samples * samples;
        let (limit, found) = (MAX_SEEN as u64, (camera.height() as u64).saturating_mul(row as u64));
        if found > limit {
            return Err(Error::TooLarge { what: "samples of a picture (width x height x n x n)".into(), limit, found });
        }
        let (faces, vertices) = (mesh.faces.clone(), mesh.positions.len());
        let mut view = View { faces, vertices, camera, samples, seen: Vec::new() };
        let mut seen = vec![None; view.camera.height() * row];
        progress.start("view", seen.len() as u64);
        seen.par_chunks_mut(row).enumerate().try_for_each(|(y, row)| {
            for (i, seen) in row.iter_mut().enumerate() {
                *seen = view.nearest(occluders, view.direction(y * view.camera.width() * samples * samples + i))?;
            }
            progress.advance(row.len() as u64)
        })?;
        view.seen = seen;
        Ok(view)
    }

    /// The nearest point along a direction from the eye.
    fn nearest(&self, occluders: &Occluders, direction: Direction) -> Result<Option<Seen>> {
        let direction = Vec3::from_array(direction.map(|c| c as f32));
        let Some(hit) = occluders.nearest(self.camera.eye(), direction) else { return Ok(None) };
        if hit.face as usize >= self.faces.len() {
            return Err(Error::Unsupported {
                what: "view: occluders".into(),
                expected: format!("those of the mesh, of {} faces", self.faces.len()),
                found: format!("a hit of face {}", hit.face),
            });
        }
        Ok(Some(Seen { face: hit.face, weights: [1.0 - hit.u - hit.v, hit.u, hit.v] }))
    }

    /// The direction of a sample, by its place in `seen`.
    fn direction(&self, sample: usize) -> Direction {
        let (n, width) = (self.samples, self.camera.width());
        let (pixel, within) = (sample / (n * n), sample % (n * n));
        let place = |pixel: usize, within: usize| pixel as f64 + (within as f64 + 0.5) / n as f64;
        self.camera.ray(place(pixel % width, within % n), place(pixel / width, within / n)).to_array()
    }

    /// Vertices of the mesh that is seen.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Who sees it.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// For every pixel the share of its samples that meet the mesh, from 0 to 1.
    pub fn coverage(&self) -> Vec<f32> {
        let pixels = self.seen.chunks(self.samples * self.samples);
        pixels.map(|seen| seen.iter().flatten().count() as f32 / seen.len() as f32).collect()
    }

    /// The values of a point's three corners, out of one for each vertex.
    pub fn corners<T: Copy>(&self, seen: &Seen, of_vertices: &[T]) -> [T; 3] {
        self.faces[seen.face as usize].map(|vertex| of_vertices[vertex as usize])
    }

    /// The image of linear RGB radiance at the vertices, interpolated over the faces (Gouraud), before `background`,
    /// linear RGB by unit direction. A face seen from behind shows what its front has.
    ///
    /// # Errors
    /// Colours that are not one a vertex or not finite (row = vertex), and a background that is not finite, with its
    /// pixel.
    pub fn interpolate(
        &self,
        colours: &[[f32; 3]],
        background: impl Fn(Direction) -> [f32; 3] + Sync,
    ) -> Result<Image> {
        Error::expect_size("colours, one for each vertex", self.vertices, colours.len())?;
        for (row, colour) in colours.iter().enumerate() {
            if let Some(col) = colour.iter().position(|c| !c.is_finite()) {
                return Err(Error::NotFinite { row, col, value: f64::from(colour[col]) });
            }
        }
        let surface = |seen: &Seen| Ok(seen.mix(self.corners(seen, colours).map(Vec3::from_array)).to_array());
        self.shade(surface, background, |_| Ok(()))
    }

    /// The image whose samples are what `surface` gives for a point and `background` for a direction; after each row,
    /// `finished` is told its number of pixels.
    pub(super) fn shade(
        &self,
        surface: impl Fn(&Seen) -> Result<[f32; 3]> + Sync,
        background: impl Fn(Direction) -> [f32; 3] + Sync,
        finished: impl Fn(u64) -> Result<()> + Sync,
    ) -> Result<Image> {
        let (width, height, samples) = (self.camera.width(), self.camera.height(), self.samples * self.samples);
        let mut pixels = vec![[0.0; 3]; width * height];
        pixels.par_chunks_mut(width).enumerate().try_for_each(|(row, pixels)| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let first = (row * width + column) * samples;
                let mut sum = [0f64; 3];
                for sample in first..first + samples {
                    let colour = match &self.seen[sample] {
                        Some(seen) => surface(seen)?,
                        None => background(self.direction(sample)),
                    };
                    sum.iter_mut().zip(colour).for_each(|(sum, c)| *sum += f64::from(c));
                }
                *pixel = sum.map(|sum| (sum / samples as f64) as f32);
            }
            finished(width as u64)
        })?;
        let image = Image { width, height, pixels };
        image.check()?;
        Ok(image)
    }
}
