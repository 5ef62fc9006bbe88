//! Where figures are measured: meshes, their signals, and the settings on them.

use super::outcome::Outcome;
use super::setting::Curve;
use crate::cache::About;
use crate::compare::compare;
use crate::compute::Computation;
use crate::interrupt::Unseen;
use crate::machine::Machine;
use crate::measure::{Bench, Reference};
use crate::progress::Steps;
use crate::row::Row;
use crate::scenes::Up;
use crate::signal::Spec;
use prt_transfer::TransferMatrix;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Where meshes come from.
pub enum Meshes {
    /// A folder of meshes about as large as the papers'.
    Files(PathBuf),
    /// Built-in scenes of about so many vertices.
    BuiltIn(usize),
    /// Built-in scenes and worlds of the papers' sizes.
    PaperSized,
}

/// A paper's model and what stands in for it.
#[derive(Clone, Copy, Debug)]
pub struct Mesh {
    /// A file among the user's assets, y upwards; none where the built-in scene is the model itself.
    pub file: Option<&'static str>,
    /// The built-in scene where there are no assets.
    pub built_in: &'static str,
    /// The paper's vertices, m_p.
    pub vertices: usize,
}

/// A signal of a mesh, ready to be compressed.
pub struct Subject {
    row: Row,
    spec: Spec,
    reference: Reference,
}

/// What the user chose, of papers that let scenes and methods be chosen.
#[derive(Clone, Debug, Default)]
pub struct Chosen {
    /// Scenes by the paper's names; all where none is.
    pub scenes: Vec<String>,
    /// Labels; the usual ones where none is.
    pub methods: Vec<String>,
}

/// Everything that is needed to measure a figure.
pub struct Stage<'a> {
    /// What measures.
    pub bench: Bench<'a>,
    /// On which machine.
    pub machine: Machine,
    /// Where progress is shown.
    pub steps: Steps,
    /// Of scenes and methods.
    pub chosen: Chosen,
    meshes: Meshes,
    known: RefCell<Vec<Rc<Subject>>>,
}

impl<'a> Stage<'a> {
    /// With nothing computed yet.
    pub fn new(bench: Bench<'a>, machine: Machine, meshes: Meshes) -> Stage<'a> {
        Stage { bench, machine, steps: Steps::new(0), chosen: Chosen::default(), meshes, known: RefCell::default() }
    }

    /// Whether meshes are about as large as the papers', so that their settings can be taken as they are.
    pub fn is_paper_sized(&self) -> bool {
        !matches!(self.meshes, Meshes::BuiltIn(_))
    }

    /// The user's assets, if any.
    pub fn folder(&self) -> Option<&Path> {
        match &self.meshes {
            Meshes::Files(folder) => Some(folder),
            Meshes::BuiltIn(_) | Meshes::PaperSized => None,
        }
    }

    /// A signal of a mesh; computed once.
    pub fn subject(&self, mesh: &Mesh, spec: &Spec) -> anyhow::Result<Rc<Subject>> {
        let (scene, vertices, up) = self.place(mesh);
        let same = |known: &&Rc<Subject>| known.row.scene == scene && known.spec == *spec;
        if let Some(known) = self.known.borrow().iter().find(same) {
            return Ok(Rc::clone(known));
        }
        let subject = Rc::new(self.computed((scene, vertices, up), spec)?);
        self.known.borrow_mut().push(Rc::clone(&subject));
        Ok(subject)
    }

    /// A signal of a scene as [`Computation::new`] takes it; forgotten with the subject.
    pub fn computed(&self, (scene, vertices, up): (String, Option<usize>, Up), spec: &Spec) -> anyhow::Result<Subject> {
        self.steps.show(&scene);
        let made = Computation::new(&scene, vertices, up, spec)?.matrix(&Unseen)?;
        self.given(&scene, spec, made.matrix)
    }

    /// A matrix of a scene's signal.
    pub fn given(&self, scene: &str, spec: &Spec, matrix: TransferMatrix) -> anyhow::Result<Subject> {
        let row = Row { scene: scene.into(), signal: spec.signal.to_string(), ..Row::default() };
        let row = About::of(&matrix, 0, 0.0).describe(row);
        let reference = self.bench.pools.everywhere(|| Reference::new(matrix))?;
        Ok(Subject { row, spec: spec.clone(), reference })
    }

    /// As [`Computation::new`] takes it.
    pub fn place(&self, mesh: &Mesh) -> (String, Option<usize>, Up) {
        match (&self.meshes, mesh.file) {
            (Meshes::Files(folder), Some(file)) => (folder.join(file).display().to_string(), None, Up::Y),
            (Meshes::Files(_), None) | (Meshes::PaperSized, _) => (mesh.built_in.into(), Some(mesh.vertices), Up::Z),
            (&Meshes::BuiltIn(vertices), _) => (mesh.built_in.into(), Some(vertices), Up::Z),
        }
    }

    /// The paper's number of clusters; on a smaller scene a power of two, so that a cluster has about as many samples as the paper's.
    pub fn clusters(&self, papers: usize, mesh: &Mesh, samples: usize) -> usize {
        if self.is_paper_sized() {
            return papers;
        }
        let share = papers as f64 * samples as f64 / mesh.vertices as f64;
        (share.log2().round().max(0.0).exp2() as usize).min(papers)
    }

    /// Every setting of every curve. What fails is an outcome with its reason.
    pub fn measure(&self, subject: &Subject, curves: &[Curve]) -> anyhow::Result<Vec<Outcome>> {
        let settings = || curves.iter().enumerate().flat_map(|(i, curve)| curve.settings.iter().map(move |s| (i, s)));
        let methods: Vec<String> = settings().map(|(_, setting)| setting.method.clone()).collect();
        let rows = self.rows(subject, &methods)?;
        let square = subject.reference.square();
        let outcomes = settings().zip(rows).map(|((curve, setting), row)| Outcome {
            curve,
            setting: setting.clone(),
            row,
            square,
        });
        Ok(outcomes.collect())
    }

    /// Every method. What fails is a row with its reason.
    pub fn rows(&self, subject: &Subject, methods: &[String]) -> anyhow::Result<Vec<Row>> {
        self.steps.more(methods.len());
        compare(&self.bench, &subject.row, &subject.reference, methods, &self.steps)
    }
}

impl Subject {
    /// The matrix.
    pub fn matrix(&self) -> &TransferMatrix {
        self.reference.matrix()
    }

    /// Surface points, m_p.
    pub fn samples(&self) -> usize {
        self.row.samples
    }

    /// Numbers of a sample, n.
    pub fn dimension(&self) -> usize {
        self.row.responses * self.row.lights
    }

    /// Scene, signal, basis and shape.
    pub fn title(&self) -> String {
        let Row { scene, signal, basis, samples, responses, lights, .. } = &self.row;
        format!("{} · {signal} · {basis} · {samples} x {responses} x {lights}", title(scene))
    }

    /// The scene's name for people.
    pub fn name(&self) -> String {
        title(&self.row.scene)
    }
}

/// A scene's name for people: of a file its stem.
pub fn title(scene: &str) -> String {
    Path::new(scene).file_stem().map_or_else(|| scene.into(), |stem| stem.display().to_string())
}
