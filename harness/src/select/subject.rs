//! The matrix that a model is wanted of: read from a file, or computed of a scene.

use super::Select;
use crate::cache;
use crate::files::{self, Description};
use crate::registry::registry;
use crate::suite::{Origin, Size, Suite, Wishes};
use anyhow::{Context, Result, bail};
use prt_transfer::{Progress, TransferMatrix};
use std::path::Path;

/// What it is, in a line, and the matrix.
pub(super) fn read(arguments: &Select, progress: &dyn Progress) -> Result<(String, TransferMatrix)> {
    let origin = origin(arguments)?;
    let matrix = match &origin {
        Origin::Matrix(path) => {
            let description = Description { responses: arguments.responses.clone(), basis: arguments.basis.clone() };
            files::read_matrix(path, &description)?
        }
        // Nothing is kept: a matrix that is wanted twice is a file.
        _ => cache::computed(&origin, progress)?.0,
    };
    let (subject, shape) = (cache::subject(&origin), matrix.shape());
    let signal = if subject.signal == "file" { String::new() } else { format!(" · {}", subject.signal) };
    let size = format!("{} x {} x {}", shape.samples, shape.responses, shape.lights);
    Ok((format!("{}{signal} · {} · {size}", subject.scene, matrix.basis()), matrix))
}

/// Where the matrix comes from; options of other origins are refused.
fn origin(arguments: &Select) -> Result<Origin> {
    let Select { subject, signal, vertices, up, basis, responses, .. } = arguments;
    let file = Path::new(subject).extension().is_some();
    let wishes = Wishes {
        scenes: vec![subject.clone()],
        signals: signal.iter().copied().collect(),
        methods: vec!["csr".into()],
        up: up.unwrap_or_default(),
    };
    let suite = Suite::new(Size::Standard, &wishes, &registry());
    let mut origin = suite.subjects.into_iter().next().context("one scene has one matrix")?.origin;
    let of_scenes = [("--signal", signal.is_some()), ("--vertices", vertices.is_some()), ("--up", up.is_some())];
    let of_files = [("--responses", responses.is_some())];
    let foreign = |options: &[(&str, bool)], of: &str| match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => bail!("{option} belongs to a {of}, which {subject} is not"),
        None => Ok(()),
    };
    match &mut origin {
        Origin::Matrix(_) => foreign(&of_scenes, "scene or mesh")?,
        Origin::Field { .. } => {
            foreign(&of_scenes, "scene or mesh")?;
            foreign(&of_files, "matrix file")?;
            foreign(&[("--basis", basis.is_some())], "matrix file, scene or mesh")?;
        }
        Origin::Scene { vertices: of_scene, spec, .. } => {
            foreign(&of_files, "matrix file")?;
            match file {
                true => foreign(&[("--vertices", vertices.is_some())], "built-in scene")?,
                false => foreign(&[("--up", up.is_some())], "mesh file")?,
            }
            if signal.is_none() {
                bail!("--signal says what is precomputed of {subject}: biscale, diffuse, glossy or terms");
            }
            *of_scene = vertices.or(*of_scene);
            spec.basis = basis.clone().unwrap_or_else(|| spec.basis.clone());
        }
    }
    Ok(origin)
}
