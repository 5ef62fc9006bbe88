//! Table 1: encoding time and error of static and iterative components, for each of the paper's models.

use super::table1_layout::beside;
use super::{ANISOTROPIC, BIRD, BUDDHA, ISOTROPIC, cpca, diffuse, glossy};
use crate::figures::outcome::Outcome;
use crate::figures::setting::Curve;
use crate::figures::stage::{Mesh, Stage};
use crate::figures::{Drawing, Figure};
use crate::signal::Spec;
use prt_cpca::Mode;

pub(super) const FIGURE: Figure =
    Figure { name: "table1", table: Some("Table 1: time and error of static and iterative encoding"), draw };

/// A line of the paper's table.
pub(super) struct Line {
    /// Its model and BRDF.
    pub(super) model: &'static str,
    pub(super) brdf: &'static str,
    /// N_r x N_i.
    pub(super) matrix: &'static str,
    pub(super) clusters: usize,
    pub(super) components: usize,
    /// Static, then iterative.
    pub(super) printed: [Printed; 2],
    /// Where ours comes from.
    pub(super) mesh: Mesh,
    spec: fn() -> Spec,
}

/// What is printed for one way of encoding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Printed {
    pub(super) seconds: f64,
    pub(super) error: f64,
}

/// A line with what was measured for it.
pub(super) struct Measured {
    pub(super) line: &'static Line,
    /// Scene, signal and shape; the reason where there is none.
    pub(super) subject: Result<String, String>,
    pub(super) clusters: usize,
    /// Static, then iterative; nothing without a subject.
    pub(super) outcomes: Vec<Outcome>,
}

const HEAD: Mesh = Mesh { file: Some("bust_19k.ply"), built_in: "teapot", vertices: 50_060 };
const POLYGONS: Mesh = Mesh { file: None, built_in: "two-polygons", vertices: 58_624 };

/// Subsurface scattering is not computed here, so that its line is one of reflection alone.
#[expect(clippy::approx_constant, reason = "the paper prints an error of 3.14")]
pub(super) static LINES: [Line; 7] = [
    Line {
        model: "Buddha",
        brdf: "gloss-iso",
        matrix: "16x25",
        clusters: 256,
        components: 6,
        printed: [at(3, 30, 563.0), at(60 + 51, 0, 451.0)],
        mesh: BUDDHA,
        spec: || glossy(ISOTROPIC, 16),
    },
    Line {
        model: "Buddha",
        brdf: "gloss-anis",
        matrix: "24x25",
        clusters: 256,
        components: 8,
        printed: [at(6, 7, 10_996.0), at(4 * 60 + 34, 0, 8524.0)],
        mesh: BUDDHA,
        spec: || glossy(ANISOTROPIC, 24),
    },
    Line {
        model: "Buddha",
        brdf: "subsurf+gloss-iso",
        matrix: "25x25",
        clusters: 256,
        components: 8,
        printed: [at(6, 21, 1992.0), at(4 * 60 + 32, 0, 1439.0)],
        mesh: BUDDHA,
        spec: || glossy(ISOTROPIC, 25),
    },
    Line {
        model: "bird",
        brdf: "gloss-anis",
        matrix: "24x25",
        clusters: 256,
        components: 8,
        printed: [at(6, 34, 898.0), at(3 * 60 + 43, 0, 294.0)],
        mesh: BIRD,
        spec: || glossy(ANISOTROPIC, 24),
    },
    Line {
        model: "bird",
        brdf: "diffuse",
        matrix: "1x100",
        clusters: 256,
        components: 8,
        printed: [at(0, 43, 3.14), at(3, 26, 0.668)],
        mesh: BIRD,
        spec: || diffuse(10),
    },
    Line {
        model: "head",
        brdf: "gloss-iso",
        matrix: "16x25",
        clusters: 256,
        components: 6,
        printed: [at(4, 20, 78.8), at(2 * 60 + 12, 0, 43.7)],
        mesh: HEAD,
        spec: || glossy(ISOTROPIC, 16),
    },
    Line {
        model: "polys",
        brdf: "diffuse",
        matrix: "1x100",
        clusters: 32,
        components: 4,
        printed: [at(0, 14, 0.492), at(3, 26, 0.432)],
        mesh: POLYGONS,
        spec: || diffuse(10),
    },
];

const fn at(minutes: u32, seconds: u32, error: f64) -> Printed {
    Printed { seconds: (60 * minutes + seconds) as f64, error }
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let lines = LINES.iter().map(|line| measured(stage, line)).collect::<anyhow::Result<Vec<Measured>>>()?;
    Ok(Drawing { beside: vec![beside(&lines)], ..Drawing::default() })
}

fn measured(stage: &Stage, line: &'static Line) -> anyhow::Result<Measured> {
    let subject = match stage.subject(&line.mesh, &(line.spec)()) {
        Ok(subject) => subject,
        Err(error) => {
            let subject = Err(format!("{error:#}"));
            return Ok(Measured { line, subject, clusters: line.clusters, outcomes: Vec::new() });
        }
    };
    let clusters = stage.clusters(line.clusters, &line.mesh, subject.samples());
    let outcomes = stage.measure(&subject, &[curve(clusters, line.components)])?;
    Ok(Measured { line, subject: Ok(subject.title()), clusters, outcomes })
}

/// Static and iterative.
pub(super) fn curve(clusters: usize, components: usize) -> Curve {
    Curve::new("static, iterative", [Mode::Static, Mode::Iterative].map(|mode| cpca(mode, clusters, components)))
}
