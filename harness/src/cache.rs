//! Precomputed matrices of a bench, kept beside its results so that resuming need not compute them again.

use crate::compute::Computation;
use crate::files::{self, Description};
use crate::fingerprint;
use crate::row::Row;
use crate::signal::Signal;
use crate::suite::Origin;
use crate::worlds::{self, Look, Needs};
use anyhow::{Context, bail};
use prt_transfer::scene::light_field::light_field;
use prt_transfer::scene::path::{PathParams, PathTracer};
use prt_transfer::{Progress, TransferMatrix};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A matrix of the bench: what it is, and where it lies until it is needed.
pub struct Prepared {
    about: About,
    path: PathBuf,
    matrix: Option<TransferMatrix>,
}

/// What is known of a matrix without reading it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The program that computed it: another one might compute another matrix.
    program: String,
    /// CRC-32 of the matrix.
    fingerprint: String,
    /// What the columns stand for.
    basis: String,
    /// What the responses of a sample stand for.
    response_basis: String,
    samples: usize,
    responses: usize,
    lights: usize,
    non_zeros: usize,
    /// Rays cast for it.
    pub rays: u64,
    /// What its precomputation took, s.
    pub seconds: f64,
}

/// The matrix of a scene or a field, and the rays and seconds that it took; nothing is kept.
pub fn computed(origin: &Origin, progress: &dyn Progress) -> anyhow::Result<(TransferMatrix, u64, f64)> {
    match origin {
        Origin::Matrix(path) => bail!("{} is not computed", path.display()),
        Origin::Scene { scene, vertices, up, spec } => {
            let computation = Computation::new(scene, *vertices, *up, spec)?;
            computation.check_room(extension(origin) == "npz")?;
            let made = computation.matrix(progress)?;
            Ok((made.matrix, made.traced.rays, made.seconds))
        }
        Origin::Field { world, shape, params } => {
            let began = Instant::now();
            let world = worlds::load(world, Look::default(), Needs::Charts)?;
            let Some(object) = world.objects().iter().position(|o| o.name == *shape) else {
                let names: Vec<&str> = world.objects().iter().map(|o| o.name.as_str()).collect();
                bail!("there is no shape {shape}: there are {}", names.join(", "));
            };
            let field = light_field(&PathTracer::new(&world, PathParams::default())?, object, params, progress)?;
            Ok((field.matrix, field.tally.rays, began.elapsed().as_secs_f64()))
        }
    }
}

/// Of the file in which a matrix is kept: a dense one keeps its form only in .npy, which does not carry the basis.
fn extension(origin: &Origin) -> &'static str {
    match origin {
        Origin::Scene { spec, .. } if spec.signal == Signal::Biscale => "npz",
        _ => "npy",
    }
}

/// Finds the matrix of `origin` in `folder`, or computes and keeps it. Only scenes are kept; files are where they are.
pub fn prepare(folder: &Path, origin: &Origin, progress: &dyn Progress) -> anyhow::Result<Prepared> {
    match origin {
        Origin::Matrix(path) => {
            let matrix = files::read_matrix(path, &Description::default())?;
            Ok(Prepared { about: About::of(&matrix, 0, 0.0), path: path.clone(), matrix: Some(matrix) })
        }
        // A mesh may change under its name; a built-in scene changes with the program.
        Origin::Scene { vertices, .. } => kept(folder, origin, vertices.is_some(), progress),
        Origin::Field { .. } => kept(folder, origin, true, progress),
    }
}

/// The matrix of `origin` in `folder`; computed, with the rays and seconds that took, and kept there where it is not.
fn kept(folder: &Path, origin: &Origin, trusted: bool, progress: &dyn Progress) -> anyhow::Result<Prepared> {
    let path = folder.join(format!("{}.{}", file_name(origin), extension(origin)));
    let known = if trusted { About::read(&path) } else { None };
    if let Some(about) = known.filter(|_| path.exists()) {
        return Ok(Prepared { about, path, matrix: None });
    }
    let (matrix, rays, seconds) = computed(origin, progress)?;
    let about = About::of(&matrix, rays, seconds);
    files::write_matrix(&path, &matrix)?;
    // Last, since it vouches for the matrix.
    files::write_beside(&description_of(&path), &serde_json::to_vec_pretty(&about)?)?;
    Ok(Prepared { about, path, matrix: Some(matrix) })
}

/// Scene and signal of an origin, as its rows and its charts name them.
pub fn subject(origin: &Origin) -> Row {
    let (scene, signal, basis) = match origin {
        Origin::Scene { scene, spec, .. } => (scene.clone(), spec.signal.to_string(), spec.basis.to_string()),
        Origin::Field { world, shape, params } => {
            (format!("{world}/{shape}"), "slf".into(), params.basis().to_string())
        }
        Origin::Matrix(path) => (path.display().to_string(), "file".into(), String::new()),
    };
    Row { scene, signal, basis, threads: 0, ..Row::default() }
}

/// A name for the files of an origin: letters, digits, dashes, dots and underscores.
pub fn file_name(origin: &Origin) -> String {
    let name = match origin {
        Origin::Scene { scene, vertices, spec, .. } => {
            let vertices = vertices.map_or(String::new(), |n| format!("-{n}"));
            format!("{scene}{vertices}-{}", spec.file_name())
        }
        Origin::Field { world, shape, params } => {
            let [texels, directions] = [(params.width, params.height), (params.around, params.down)];
            format!("{world}-{shape}-{}x{}-{}x{}", texels.0, texels.1, directions.0, directions.1)
        }
        Origin::Matrix(path) => path.display().to_string(),
    };
    safe(&name)
}

/// `text` with anything that a file system might mind replaced.
pub fn safe(text: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    text.trim_start_matches(['.', '/']).chars().map(keep).collect()
}

impl Prepared {
    /// What is known without reading the matrix.
    pub fn about(&self) -> &About {
        &self.about
    }
    /// The matrix, read where it is not at hand.
    pub fn into_matrix(self) -> anyhow::Result<TransferMatrix> {
        match self.matrix {
            Some(matrix) => Ok(matrix),
            None => {
                let About { response_basis, basis, .. } = &self.about;
                let description = Description { responses: Some(response_basis.parse()?), basis: Some(basis.parse()?) };
                let path = self.path.display();
                let matrix = files::read_matrix(&self.path, &description)
                    .with_context(|| format!("the matrix of an earlier run; delete {path} to compute it again"))?;
                let (found, expected) = (fingerprint::matrix(&matrix), &self.about.fingerprint);
                anyhow::ensure!(
                    found == *expected,
                    "{path} is not the matrix that was written there (CRC-32 {found}, expected {expected}); delete it to compute it again",
                );
                Ok(matrix)
            }
        }
    }
}

impl About {
    /// What can be said of a matrix, with the rays that were cast for it and the seconds that took.
    pub fn of(matrix: &TransferMatrix, rays: u64, seconds: f64) -> About {
        let shape = matrix.shape();
        About {
            program: fingerprint::program().into(),
            fingerprint: fingerprint::matrix(matrix),
            basis: matrix.basis().to_string(),
            response_basis: matrix.responses().to_string(),
            samples: shape.samples,
            responses: shape.responses,
            lights: shape.lights,
            non_zeros: matrix.non_zeros(),
            rays,
            seconds,
        }
    }

    /// What this program wrote beside a matrix; nothing where there is none or another program wrote it.
    fn read(path: &Path) -> Option<About> {
        let bytes = std::fs::read(description_of(path)).ok()?;
        let about: About = serde_json::from_slice(&bytes).ok()?;
        (about.program == fingerprint::program()).then_some(about)
    }

    /// `row` with everything that is known of the matrix.
    pub fn describe(&self, row: Row) -> Row {
        Row {
            basis: self.basis.clone(),
            samples: self.samples,
            responses: self.responses,
            lights: self.lights,
            non_zeros: self.non_zeros,
            fingerprint: self.fingerprint.clone(),
            ..row
        }
    }
}

fn description_of(path: &Path) -> PathBuf {
    path.with_extension("json")
}

/// The compressed file of a method on the matrix of this [`file_name`], inside a bench's folder.
pub fn encoded(out: &Path, file_name: &str, method: &str) -> PathBuf {
    out.join("encoded").join(format!("{file_name}-{}.prt", safe(method)))
}

/// The folder of matrices inside a bench's folder.
pub fn folder(out: &Path) -> anyhow::Result<PathBuf> {
    make(out.join("matrices"))
}

/// Makes a folder and those above it.
pub fn make(path: PathBuf) -> anyhow::Result<PathBuf> {
    std::fs::create_dir_all(&path).with_context(|| format!("cannot create {}", path.display()))?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{self, Up};
    use crate::signal::Spec;
    use prt_transfer::{LightBasis, Quiet};

    #[test]
    fn a_matrix_is_computed_once_and_read_back_the_same() {
        let folder = tempfile::tempdir().unwrap();
        for signal in [Signal::Diffuse, Signal::Biscale] {
            let spec = Spec::new(signal, LightBasis::Cubemap { resolution: 4 });
            let scene = scenes::scenes()[0].name.to_string();
            let origin = Origin::Scene { scene, vertices: Some(60), up: Up::Z, spec };
            let first = prepare(folder.path(), &origin, &Quiet).unwrap();
            let second = prepare(folder.path(), &origin, &Quiet).unwrap();
            assert!(first.matrix.is_some() && second.matrix.is_none());
            assert_eq!(first.about, second.about);
            assert_eq!(first.into_matrix().unwrap(), second.into_matrix().unwrap());
        }
    }

    #[test]
    fn file_names_hold_nothing_that_a_path_could_mean() {
        assert_eq!(safe("../a b/c:d=e+f.prt"), "a_b_c_d_e_f.prt");
    }
}
