//! From a scene and a signal to a transfer matrix.

use crate::files;
use crate::registry::registry;
use crate::room;
use crate::scenes::{self, Up};
use crate::signal::{Signal, Spec};
use glam::DVec3;
use prt_transfer::footprint::by;
use prt_transfer::mesh::Mesh;
use prt_transfer::samples::square;
use prt_transfer::scene::biscale::biscale;
use prt_transfer::scene::bounce::{Bounced, Interreflecting, interreflect};
use prt_transfer::scene::brdf::Brdf;
use prt_transfer::scene::bvh::Occluders;
use prt_transfer::scene::dense::{self, DenseSignal, Transformed};
use prt_transfer::scene::diffuse::Diffuse;
use prt_transfer::scene::frames::{Frame, vertex_frames};
use prt_transfer::scene::glossy::{Glossy, GlossyParams};
use prt_transfer::scene::repair::Repairs;
use prt_transfer::scene::signal::{Sampling, Surface, Traced};
use prt_transfer::scene::terms::TermTransfer;
use prt_transfer::{
    Error, Label, LightBasis, LightTransform, Progress, ResponseBasis, Result, Shape, Stage, TransferMatrix,
};
use std::path::Path;
use std::time::Instant;

/// A matrix and what it took.
pub struct Precomputed {
    /// The transfer matrix.
    pub matrix: TransferMatrix,
    /// What was mended in the mesh.
    pub repairs: Repairs,
    /// Occlusion rays answered, and the time that took, summed over threads.
    pub traced: Traced,
    /// Σ T² of direct light, then of each bounce; empty without bounces.
    pub energies: Vec<f64>,
    /// Wall clock of everything, s.
    pub seconds: f64,
}

/// A scene ready to be computed on.
pub struct Computation<'a> {
    spec: &'a Spec,
    mesh: Mesh,
    repairs: Repairs,
    occluders: Occluders,
    frames: Vec<Frame>,
    began: Instant,
}

/// What is known of a matrix that was handed on row by row.
pub struct Streamed {
    /// What its columns stand for.
    pub basis: LightBasis,
    /// What the responses of a sample stand for.
    pub responses: ResponseBasis,
    /// Its shape.
    pub shape: Shape,
    /// Elements that are not 0.
    pub non_zeros: usize,
    /// See [`Precomputed`].
    pub repairs: Repairs,
    /// See [`Precomputed`].
    pub traced: Traced,
    /// See [`Precomputed`].
    pub seconds: f64,
}

/// The transfer matrix of a built-in scene with about `vertices` vertices, or of a mesh file, which has its own.
pub fn precompute(scene: &str, vertices: Option<usize>, spec: &Spec, progress: &dyn Progress) -> Result<Precomputed> {
    Computation::new(scene, vertices, Up::Z, spec)?.matrix(progress)
}

impl<'a> Computation<'a> {
    /// Loads a scene; see [`scenes::load`].
    pub fn new(scene: &str, vertices: Option<usize>, up: Up, spec: &'a Spec) -> Result<Computation<'a>> {
        let began = Instant::now();
        let (mesh, repairs) = scenes::load(scene, vertices, up)?;
        let (occluders, frames) = (Occluders::new(&mesh)?, vertex_frames(&mesh)?);
        Ok(Computation { spec, mesh, repairs, occluders, frames, began })
    }

    fn surface(&self) -> Surface<'_> {
        Surface { occluders: &self.occluders, points: &self.mesh.positions, frames: &self.frames }
    }

    /// How visibility is sampled: on the cubemap of the basis where it is one.
    fn sampling(&self) -> Sampling {
        let usual = Sampling { supersampling: self.spec.supersampling, ..Sampling::default() };
        match self.spec.basis {
            LightBasis::Cubemap { resolution } => Sampling { resolution, ..usual },
            _ => usual,
        }
    }

    /// Refuses a matrix that does not fit into memory, with what writing it takes: into a `.npz` where `archived`.
    pub fn check_room(&self, archived: bool) -> anyhow::Result<()> {
        let (samples, texels) = (self.points() as u64, 6 * (self.sampling().resolution as u64).pow(2));
        let needed = match self.dense()? {
            Some(signal) => {
                let shape = dense::shape(&*signal, self.points())?;
                let cells = (shape.rows() as u64).saturating_mul(shape.lights as u64);
                // What is archived is its non-zeros, in order, packed and put together: of texels about half.
                let full = !matches!(signal.basis(), LightBasis::Cubemap { .. }) || self.spec.bounces > 0;
                let written = if archived { by(if full { 20.0 } else { 10.0 }, cells) } else { 0 };
                // Each bounce is a matrix made of another, and where every texel's ray of a sample ends.
                let bounced = if self.spec.bounces > 0 { by(8.0, cells) + by(24.0, samples * texels) } else { 0 };
                by(4.0, cells) + written.max(bounced)
            }
            // A sample sees about half of the texels.
            None => by(7.0, samples * texels) + by(16.0, samples * (self.spec.local_directions as u64).pow(2)),
        };
        room::check(&format!("the matrix of {samples} points"), needed, room::SMALLER_MATRIX)
    }

    /// The matrix as a whole.
    pub fn matrix(&self, progress: &dyn Progress) -> Result<Precomputed> {
        let (spec, surface) = (self.spec, self.surface());
        if spec.bounces > 0 {
            // Other parts of the surface fill their texels: one ray each is enough where a light needs four.
            let gather = Sampling { supersampling: 0, ..self.sampling() };
            let signal = self.interreflecting()?;
            let bounced = interreflect(&*signal, &surface, &self.mesh, &gather, spec.bounces, progress)?;
            let Bounced { matrix, traced, energies } = bounced;
            return Ok(self.finished(matrix, traced, energies));
        }
        let (matrix, traced) = match self.dense()? {
            Some(signal) => dense::matrix(&*signal, &surface, progress)?,
            None => biscale(&surface, &self.sampling(), spec.local_directions, progress)?,
        };
        Ok(self.finished(matrix, traced, Vec::new()))
    }

    fn finished(&self, matrix: TransferMatrix, traced: Traced, energies: Vec<f64>) -> Precomputed {
        Precomputed { matrix, repairs: self.repairs, traced, energies, seconds: self.began.elapsed().as_secs_f64() }
    }

    /// Computes a dense signal without bounces into a `.npy` as it goes, so that it never has to be in memory; `None`,
    /// and no file, for any other.
    pub fn write_npy(&self, path: &Path, progress: &dyn Progress) -> Result<Option<Streamed>> {
        let Some(signal) = self.unbounced()? else { return Ok(None) };
        let mut file = files::dense_writer(path, dense::shape(&*signal, self.points())?)?;
        let streamed = self.stream(&*signal, progress, |rows| file.push_rows(rows))?;
        file.finish()?;
        Ok(Some(streamed))
    }

    /// As [`Computation::write_npy`], the rows as `transform` makes them of the signal's; and the part of their square over the sphere that
    /// is not in what was written, where the columns of that are orthonormal.
    pub fn write_transformed(
        &self,
        path: &Path,
        transform: &Stage,
        progress: &dyn Progress,
    ) -> Result<(Streamed, Option<f64>)> {
        let (signal, bound) = self.transformed(transform)?;
        let transformed = Transformed::new(&*signal, &*bound, self.points());
        let mut file = files::dense_writer(path, dense::shape(&transformed, self.points())?)?;
        let mut kept = 0.0;
        let streamed = self.stream(&transformed, progress, |rows| {
            kept += square(rows);
            file.push_rows(rows)
        })?;
        file.finish()?;
        let orthonormal = matches!(bound.output(), LightBasis::Lobes { orthonormal: true, .. });
        Ok((streamed, transformed.square().filter(|_| orthonormal).map(|all| (1.0 - kept / all).max(0.0))))
    }

    /// A signal without bounces and a light transform on its basis.
    pub fn transformed(&self, transform: &Stage) -> Result<(Box<dyn DenseSignal>, Box<dyn LightTransform>)> {
        let signal = self.unbounced()?.ok_or_else(|| Error::Unsupported {
            what: "signal whose rows are transformed as they are computed".into(),
            expected: "diffuse, glossy or terms without bounces".into(),
            found: format!("{} with {} bounces", self.spec.signal, self.spec.bounces),
        })?;
        let method = registry().method(&Label { transform: transform.clone(), codec: Stage::named("dense") })?;
        let bound = method.bind(&signal.basis())?;
        Ok((signal, bound))
    }

    /// How many points there are.
    pub fn points(&self) -> usize {
        self.mesh.positions.len()
    }

    fn unbounced(&self) -> Result<Option<Box<dyn DenseSignal>>> {
        if self.spec.bounces == 0 { self.dense() } else { Ok(None) }
    }

    /// Hands on the rows of every point, and tells what they were.
    pub fn stream(
        &self,
        signal: &dyn DenseSignal,
        progress: &dyn Progress,
        mut take: impl FnMut(&[f32]) -> Result<()> + Send,
    ) -> Result<Streamed> {
        let mut non_zeros = 0;
        let traced = dense::stream(signal, &self.surface(), progress, |rows| {
            non_zeros += rows.iter().filter(|v| **v != 0.0).count();
            take(rows)
        })?;
        let (shape, basis, responses) = (dense::shape(signal, self.points())?, signal.basis(), signal.responses());
        let seconds = self.began.elapsed().as_secs_f64();
        Ok(Streamed { basis, responses, shape, non_zeros, repairs: self.repairs, traced, seconds })
    }

    /// The signal where its rows are dense.
    fn dense(&self) -> Result<Option<Box<dyn DenseSignal>>> {
        let (spec, sampling) = (self.spec, self.sampling());
        let cubemap = LightBasis::Cubemap { resolution: sampling.resolution };
        let expect = |expected: &str, holds: bool| match holds {
            true => Ok(()),
            false => Err(Error::Unsupported {
                what: format!("light basis of a {} signal", spec.signal),
                expected: expected.into(),
                found: spec.basis.to_string(),
            }),
        };
        Ok(match spec.signal {
            Signal::Biscale => {
                expect("cubemap:EDGE", spec.basis == cubemap)?;
                None
            }
            Signal::Terms => {
                expect("cubemap:EDGE", spec.basis == cubemap)?;
                Some(Box::new(TermTransfer::new(&spec.brdf, spec.terms, &sampling)?))
            }
            Signal::Diffuse => Some(Box::new(self.diffuse()?)),
            Signal::Glossy => Some(Box::new(self.glossy()?)),
        })
    }

    fn interreflecting(&self) -> Result<Box<dyn Interreflecting>> {
        match self.spec.signal {
            Signal::Diffuse => Ok(Box::new(self.diffuse()?)),
            Signal::Glossy => Ok(Box::new(self.glossy()?)),
            signal => Err(Error::Unsupported {
                what: "signal with bounces".into(),
                expected: "diffuse or glossy, which say what leaves a point".into(),
                found: signal.to_string(),
            }),
        }
    }

    fn diffuse(&self) -> Result<Diffuse> {
        let Brdf::Lambert(_) = self.spec.brdf else {
            let (what, found) = ("BRDF of a diffuse signal".into(), self.spec.brdf.to_string());
            return Err(Error::Unsupported { what, expected: "lambert".into(), found });
        };
        Diffuse::new(&self.sampling(), &self.spec.basis)?.with_albedo(self.spec.brdf.albedo(DVec3::Z))
    }

    fn glossy(&self) -> Result<Glossy> {
        let LightBasis::SphericalHarmonics { order: light } = self.spec.basis else {
            let (what, found) = ("light basis of a glossy signal".into(), self.spec.basis.to_string());
            return Err(Error::Unsupported { what, expected: "sh:ORDER".into(), found });
        };
        let Spec { coefficients, incident, coordinates, brdf, .. } = self.spec;
        let params = GlossyParams { coefficients: *coefficients, incident: *incident, light };
        Glossy::new(params, *coordinates, brdf, &self.sampling())
    }
}
