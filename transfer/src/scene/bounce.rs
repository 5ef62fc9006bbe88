//! Interreflection: light that reaches a point by way of other points.
//!
//! `T = Σ_b G^b T_0`: the gathering operator G takes the exit radiance of all points to what each of them reflects of
//! it (Sloan et al. 2002, §5). A ray that is occluded meets the surface once more, now for the place of the hit, and
//! what leaves there in its direction is interpolated from the corners of the face. Energy falls by at least the albedo
//! with every bounce.

use crate::error::{Error, Result};
use crate::matrix::TransferMatrix;
use crate::mesh::Mesh;
use crate::progress::Progress;
use crate::responses::ResponseBasis;
use crate::scene::dense::{self, DenseSignal};
use crate::scene::signal::{Samples, Sampling, Surface, Traced};
use glam::Vec3;
use rayon::prelude::*;

/// A signal whose rows say what leaves a point towards any other.
pub trait Interreflecting: DenseSignal {
    /// What the rows stand for once they hold light that the surface reflected onto itself.
    fn bounced(&self) -> ResponseBasis {
        self.responses()
    }

    /// Adds to `out`, the rows of `point`, what it reflects of light that `arrivals` bring; `leaving` are the rows of
    /// every point, in order, of the bounce before.
    fn bounce_into(
        &self,
        surface: &Surface,
        point: usize,
        arrivals: &[Arrival],
        leaving: &[f32],
        out: &mut [f32],
    ) -> Result<()>;
}

/// A direction in which a point sees another part of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// From the point, unit.
    pub direction: Vec3,
    /// Solid angle in sr.
    pub solid_angle: f32,
    /// Corners of the face that is seen.
    pub corners: [u32; 3],
    /// Their shares of the place on it; they add up to 1.
    pub shares: [f32; 3],
}

/// What bounces did.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounced {
    /// Direct light and all bounces.
    pub matrix: TransferMatrix,
    /// Rays of direct light.
    pub traced: Traced,
    /// Σ T² of direct light, then of each bounce alone.
    pub energies: Vec<f64>,
}

/// What every point sees of the surface: from its vertex, in the order of `gather`'s lanes. The back of a face is
/// black.
struct Gathered(Vec<Vec<Arrival>>);

/// The matrix of `signal` with `bounces` of interreflection on `mesh`, whose vertices are the surface's points.
/// `gather` says how densely other parts of the surface are looked for.
///
/// # Errors
/// A surface whose points are not the mesh's vertices.
pub fn interreflect(
    signal: &dyn Interreflecting,
    surface: &Surface,
    mesh: &Mesh,
    gather: &Sampling,
    bounces: usize,
    progress: &dyn Progress,
) -> Result<Bounced> {
    Error::expect_size("surface points beside the mesh's vertices", mesh.positions.len(), surface.points.len())?;
    let shape = dense::shape(signal, surface.points.len())?;
    let (mut leaving, traced) = dense::rows(signal, surface, progress)?;
    let (mut total, mut energies) = (leaving.clone(), vec![energy(&leaving)]);
    let gathered =
        if bounces > 0 { Gathered::new(surface, mesh, &gather.samples()?, progress)? } else { Gathered(vec![]) };
    let rows = total.len() / surface.points.len().max(1);
    for bounce in 1..=bounces {
        progress.start(&format!("bounce {bounce}"), surface.points.len() as u64);
        let mut next = vec![0f32; total.len()];
        next.par_chunks_mut(rows.max(1)).zip(&gathered.0).enumerate().try_for_each(|(point, (out, arrivals))| {
            signal.bounce_into(surface, point, arrivals, &leaving, out)?;
            progress.advance(1)
        })?;
        total.par_iter_mut().zip(&next).for_each(|(total, next)| *total += next);
        energies.push(energy(&next));
        leaving = next;
    }
    let responses = if bounces > 0 { signal.bounced() } else { signal.responses() };
    Ok(Bounced { matrix: dense::assemble(total, shape, signal.basis(), responses)?, traced, energies })
}

/// Σ T², the same on any number of threads.
fn energy(values: &[f32]) -> f64 {
    let squares = |chunk: &[f32]| chunk.iter().map(|&v| f64::from(v) * f64::from(v)).sum::<f64>();
    values.par_chunks(1 << 14).map(squares).collect::<Vec<f64>>().into_iter().sum()
}

impl Gathered {
    fn new(surface: &Surface, mesh: &Mesh, samples: &Samples, progress: &dyn Progress) -> Result<Gathered> {
        progress.start("gather", surface.points.len() as u64);
        let normals: Vec<Vec3> = mesh.faces.iter().map(|&face| mesh.area_vector(face).as_vec3()).collect();
        let arrivals = (0..surface.points.len()).into_par_iter().map_init(
            || vec![0u64; samples.directions().tiles()],
            |masks, point| {
                let normal = surface.frames[point].normal;
                surface.occluders.visible(surface.points[point], normal, samples.directions(), masks);
                let origin = surface.points[point] + surface.occluders.offset() * normal;
                let occluded = samples.lanes().iter().enumerate().filter(|(lane, sample)| {
                    sample.solid_angle > 0.0
                        && sample.direction.dot(normal) > 0.0
                        && masks[lane / 64] >> (lane % 64) & 1 == 0
                });
                let arrival = |(_, sample): (usize, &crate::scene::signal::Sample)| {
                    let hit = surface.occluders.nearest(origin, sample.direction)?;
                    let front = sample.direction.dot(normals[hit.face as usize]) < 0.0;
                    front.then(|| Arrival {
                        direction: sample.direction,
                        solid_angle: sample.solid_angle as f32,
                        corners: mesh.faces[hit.face as usize],
                        shares: [1.0 - hit.u - hit.v, hit.u, hit.v],
                    })
                };
                progress.advance(1)?;
                Ok(occluded.filter_map(arrival).collect())
            },
        );
        Ok(Gathered(arrivals.collect::<Result<_>>()?))
    }
}
