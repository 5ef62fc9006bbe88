//! What the surface sends to the eye: from a matrix's responses, or by a BRDF.

use glam::Vec3;
use ndarray::ArrayView2;
use prt_transfer::scene::frames::Frame;
use prt_transfer::scene::reference::Reflectance;
use prt_transfer::{Error, Result};
use std::f32::consts::PI;

/// Reflectance of a Lambertian surface.
const ALBEDO: f32 = 0.8;

/// Linear RGB radiance of every vertex towards `eye`, from `responses` (rows x 3): here irradiance, a row a vertex, on a
/// Lambertian surface, which sends the same to every eye.
///
/// # Errors
/// Rows that are not one for each vertex.
pub(super) fn vertex_colours(_eye: Vec3, frames: &[Frame], responses: ArrayView2<f32>) -> Result<Vec<[f32; 3]>> {
    Error::expect_size("responses of the matrix, one for each vertex (diffuse)", frames.len(), responses.nrows())?;
    let radiance = |irradiance: f32| ALBEDO / PI * irradiance;
    Ok(responses.outer_iter().map(|y| [y[0], y[1], y[2]].map(radiance)).collect())
}

/// The BRDF of this name.
///
/// # Errors
/// A name that is not known.
pub(super) fn brdf(text: &str) -> Result<Box<Reflectance<'static>>> {
    match text {
        "lambert" => Ok(Box::new(|_, _| ALBEDO / PI)),
        _ => Err(Error::Unknown { what: "BRDF", name: text.into(), known: "lambert".into() }),
    }
}
