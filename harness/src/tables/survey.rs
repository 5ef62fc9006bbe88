//! Measures every method on the scenes of a paper, each scene once however many tables it is in.

use super::paper::{PaperScene, SceneOrigin};
use crate::cache::About;
use crate::compare::compare;
use crate::compute;
use crate::measure::{Bench, Reference};
use crate::progress::Steps;
use crate::row::Row;
use crate::signal::Spec;
use prt_transfer::Quiet;
use std::path::{Path, PathBuf};

/// Where meshes come from.
pub enum Meshes {
    /// A folder.
    Files(PathBuf),
    /// The built-in scenes: as large as the paper's, or so that the first of a table has about so many vertices.
    BuiltIn(Option<usize>),
}

/// What was measured of a scene.
#[derive(Clone)]
pub struct Survey {
    /// The scene.
    pub scene: &'static PaperScene,
    /// What was measured in its place; none where there is nothing.
    pub subject: Option<String>,
    /// A row for each method, failed ones with their reason; without a method where there is no subject.
    pub rows: Vec<Row>,
}

/// Measures scenes and remembers them.
pub struct Surveyor<'a> {
    bench: &'a Bench<'a>,
    spec: Spec,
    methods: &'a [String],
    meshes: &'a Meshes,
    steps: &'a Steps,
    known: Vec<Survey>,
}

/// A mesh file or a built-in scene.
struct Subject {
    /// As a person reads it.
    name: String,
    /// As [`crate::compute::precompute`] takes it.
    scene: String,
    vertices: Option<usize>,
}

impl<'a> Surveyor<'a> {
    /// With nothing measured yet.
    pub fn new(
        bench: &'a Bench<'a>,
        spec: Spec,
        methods: &'a [String],
        meshes: &'a Meshes,
        steps: &'a Steps,
    ) -> Surveyor<'a> {
        Surveyor { bench, spec, methods, meshes, steps, known: Vec::new() }
    }

    /// Every method on a scene of a table whose first scene has `first` vertices. What fails is a row with its reason.
    pub fn survey(&mut self, scene: &'static PaperScene, first: Option<usize>) -> anyhow::Result<Survey> {
        let subject = match &scene.origin {
            SceneOrigin::Unavailable(reason) => {
                self.steps.done(self.methods.len());
                let row = Row { scene: scene.name.into(), ..Row::default() }.failed(*reason);
                return Ok(Survey { scene, subject: None, rows: vec![row] });
            }
            &SceneOrigin::Mesh { file, built_in, vertices } => self.meshes.subject(file, built_in, vertices, first),
        };
        let same = |known: &&Survey| known.subject.as_deref() == Some(&subject.name);
        if let Some(known) = self.known.iter().find(same) {
            self.steps.done(self.methods.len());
            return Ok(Survey { scene, ..known.clone() });
        }
        let rows = self.rows(&subject)?;
        let survey = Survey { scene, subject: Some(subject.name), rows };
        self.known.push(survey.clone());
        Ok(survey)
    }

    fn rows(&self, subject: &Subject) -> anyhow::Result<Vec<Row>> {
        let row = Row {
            scene: subject.scene.clone(),
            signal: self.spec.signal.to_string(),
            basis: self.spec.basis.to_string(),
            ..Row::default()
        };
        self.steps.show(&subject.name);
        match self.reference(subject) {
            Ok((reference, about)) => compare(self.bench, &about.describe(row), &reference, self.methods, self.steps),
            Err(error) => {
                self.steps.done(self.methods.len());
                Ok(self.methods.iter().map(|m| self.bench.planned(&row, m).failed(format!("{error:#}"))).collect())
            }
        }
    }

    fn reference(&self, subject: &Subject) -> anyhow::Result<(Reference, About)> {
        let path = Path::new(&subject.scene);
        anyhow::ensure!(path.extension().is_none() || path.exists(), "there is no file {}", path.display());
        let made = compute::precompute(&subject.scene, subject.vertices, &self.spec, &Quiet)?;
        let about = About::of(&made.matrix, made.traced.rays, made.seconds);
        Ok((self.bench.pools.everywhere(|| Reference::new(made.matrix))?, about))
    }
}

impl Meshes {
    fn subject(&self, file: &str, built_in: &str, vertices: usize, first: Option<usize>) -> Subject {
        match self {
            Meshes::Files(folder) => {
                let name = file.strip_suffix(".ply").unwrap_or(file).into();
                Subject { name, scene: folder.join(file).display().to_string(), vertices: None }
            }
            Meshes::BuiltIn(wanted) => {
                let scale = wanted.map_or(1.0, |n| n as f64 / first.unwrap_or(vertices).max(1) as f64);
                let vertices = (scale * vertices as f64).round().max(1.0) as usize;
                Subject { name: format!("{built_in}-{vertices}"), scene: built_in.into(), vertices: Some(vertices) }
            }
        }
    }
}
