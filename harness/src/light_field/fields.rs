//! A folder of fields, and pictures of them.

use super::compression::as_slf;
use crate::files;
use crate::operator::Operator;
use crate::registry::registry;
use anyhow::{Context, bail, ensure};
use glam::Vec3;
use ndarray::{Array2, Axis};
use prt_slf::{EncodedSlf, Interpolation, Rows, Sphere, SurfaceLightField};
use prt_transfer::image::Image;
use prt_transfer::responses::Directions;
use prt_transfer::scene::light_field::mirrored;
use prt_transfer::scene::path::{PathTracer, Tally};
use prt_transfer::scene::picture::{Shot, picture};
use prt_transfer::scene::world::{SurfacePoint, World};
use prt_transfer::texels::Texels;
use prt_transfer::{LightBasis, Progress, ResponseBasis, Result};
use rayon::prelude::*;
use std::path::Path;

/// Rows that one task decodes at once.
const AT_ONCE: usize = 32;

/// The fields of a world's shapes.
pub struct Fields {
    /// By object; `None` where the folder has none.
    of: Vec<Option<Field>>,
}

/// The field of one shape.
pub struct Field {
    of: Lookup,
    directions: Directions,
}

enum Lookup {
    Slf(Box<SurfaceLightField<EncodedSlf>>),
    Rows(SurfaceLightField<Rows>),
}

impl Field {
    /// Of any method: what is not `slf` is decoded, for looking up needs single elements.
    fn read(path: &Path, interpolation: Interpolation) -> anyhow::Result<Field> {
        let compressed = files::read_prt(path, &registry())?;
        let named = || format!("{} is no light field", path.display());
        let Some(slf) = as_slf(&compressed)? else {
            return Field::decoded(&compressed, interpolation).with_context(named);
        };
        let (texels, sphere, directions) = parts(&compressed).with_context(named)?;
        let field = SurfaceLightField::new(texels, sphere, slf, interpolation).with_context(named)?;
        Ok(Field { of: Lookup::Slf(Box::new(field)), directions })
    }

    /// Every element of a matrix, exact or compressed.
    ///
    /// # Errors
    /// Rows that are not radiance of texels, columns that are not a lat-long grid.
    pub fn decoded(matrix: &dyn Operator, interpolation: Interpolation) -> anyhow::Result<Field> {
        let (texels, sphere, directions) = parts(matrix)?;
        let shape = matrix.shape();
        let mut values = Array2::zeros((shape.rows(), shape.lights));
        let blocks = values.axis_chunks_iter_mut(Axis(0), AT_ONCE).into_par_iter().enumerate();
        blocks.for_each(|(block, out)| matrix.rows_into(block * AT_ONCE, out));
        let rows = Rows::new(values.into_raw_vec_and_offset().0, shape)?;
        Ok(Field { of: Lookup::Rows(SurfaceLightField::new(texels, sphere, rows, interpolation)?), directions })
    }

    /// Linear RGB that leaves a point towards a unit direction.
    pub fn radiance(&self, point: &SurfacePoint, view: Vec3) -> [f32; 3] {
        let direction = match self.directions {
            Directions::World => view,
            Directions::Reflected => mirrored(view, point.normal),
        };
        let (uv, direction) = (point.uv.to_array(), direction.to_array());
        match &self.of {
            Lookup::Slf(field) => field.radiance(uv, direction),
            Lookup::Rows(field) => field.radiance(uv, direction),
        }
    }
}

/// What a field's rows and columns stand for.
fn parts(matrix: &dyn Operator) -> anyhow::Result<(Texels, Sphere, Directions)> {
    let ResponseBasis::Radiance { texels, directions } = *matrix.responses() else {
        bail!("it holds {}, not radiance of texels", matrix.responses());
    };
    let LightBasis::LatLong { width, height } = *matrix.basis() else {
        bail!("it holds radiance by {}, not by a lat-long grid of directions", matrix.basis());
    };
    Ok((texels, Sphere { z: width, w: height }, directions))
}

impl Fields {
    /// Reads SHAPE.prt of every object that has one.
    pub fn read(folder: &Path, world: &World, interpolation: Interpolation) -> anyhow::Result<Fields> {
        let of = |name: &str| {
            let path = folder.join(format!("{name}.prt"));
            path.exists().then(|| Field::read(&path, interpolation)).transpose()
        };
        let of = world.objects().iter().map(|o| of(&o.name)).collect::<anyhow::Result<Vec<_>>>()?;
        let names: Vec<&str> = world.objects().iter().map(|o| o.name.as_str()).collect();
        ensure!(
            of.iter().any(Option::is_some),
            "{} holds no field of a shape ({}.prt): prt slf makes them",
            folder.display(),
            names.join(".prt, ")
        );
        Ok(Fields { of })
    }

    /// Objects without a field.
    pub fn without<'a>(&self, world: &'a World) -> Vec<&'a str> {
        world.objects().iter().zip(&self.of).filter(|(_, f)| f.is_none()).map(|(o, _)| o.name.as_str()).collect()
    }

    /// The picture, and for every pixel the share of its samples that meet a surface. Objects without a field are traced, a path a sample.
    pub fn picture(&self, tracer: &PathTracer, shot: &Shot, progress: &dyn Progress) -> Result<(Image, Vec<f32>)> {
        let radiance = |point: &SurfacePoint, view: Vec3| match &self.of[point.object as usize] {
            Some(field) => field.radiance(point, view),
            None => traced(tracer, point, view),
        };
        picture(tracer.world(), shot, radiance, progress)
    }
}

/// Radiance of a shape without a field: one path.
fn traced(tracer: &PathTracer, point: &SurfacePoint, view: Vec3) -> [f32; 3] {
    // A sequence of its own for every point that is seen.
    let bits = point.position.to_array().map(f32::to_bits);
    let key = bits.into_iter().fold(0u64, |key, bits| key.rotate_left(21) ^ u64::from(bits));
    let mut tally = Tally::default();
    let material = &tracer.world().objects()[point.object as usize].material;
    let reflected = tracer.diffuse(point, key, 0, &mut tally) + tracer.lobe(point, view, key, 0, &mut tally);
    (material.emission + reflected).to_array()
}
