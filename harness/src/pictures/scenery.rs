//! A mesh ready to be seen.

use glam::Vec3;
use ndarray::ArrayView2;
use prt_transfer::basis::Direction;
use prt_transfer::image::Image;
use prt_transfer::mesh::Mesh;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::camera::Camera;
use prt_transfer::scene::frames::{Frame, vertex_frames};
use prt_transfer::scene::shading::Shading;
use prt_transfer::scene::signal::Surface;
use prt_transfer::scene::view::View;
use prt_transfer::{Progress, Result};

/// A mesh with what rays are traced in and the frames in which its vertices reflect.
pub struct Scenery {
    mesh: Mesh,
    occluders: Occluders,
    frames: Vec<Frame>,
}

impl Scenery {
    /// Of a repaired mesh.
    pub fn new(mesh: Mesh) -> Result<Scenery> {
        let (occluders, frames) = (Occluders::new(&mesh)?, vertex_frames(&mesh)?);
        Ok(Scenery { mesh, occluders, frames })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Its vertices.
    pub fn surface(&self) -> Surface<'_> {
        Surface { occluders: &self.occluders, points: &self.mesh.positions, frames: &self.frames }
    }

    /// What a camera sees, `samples` x `samples` rays a pixel.
    pub fn view(&self, camera: Camera, samples: usize, progress: &dyn Progress) -> Result<View> {
        View::cast(&self.mesh, &self.occluders, camera, samples, progress)
    }

    /// The image of relit output, rows x 3, in a view of this mesh before `background`, linear RGB by unit direction.
    pub fn image(
        &self,
        view: &View,
        shading: &Shading,
        output: ArrayView2<f32>,
        background: impl Fn(Direction) -> [f32; 3] + Sync,
    ) -> Result<Image> {
        let (eye, points): (Vec3, &[Vec3]) = (view.camera().eye(), &self.mesh.positions);
        view.interpolate(&shading.colours(points, &self.frames, eye, output)?, background)
    }
}

/// Adds a colour, linear RGB, to what the surface leaves open of each pixel.
pub fn fill_behind(image: &mut Image, coverage: &[f32], colour: [f32; 3]) {
    for (pixel, covered) in image.pixels.iter_mut().zip(coverage) {
        pixel.iter_mut().zip(colour).for_each(|(pixel, colour)| *pixel += (1.0 - covered) * colour);
    }
}
