//! Figures 10 and 11: components of all samples, vector quantisation and clustered components on a glossy signal.

use super::matched;
use super::{ANISOTROPIC, BIRD, CLUSTERS, cpca, glossy, pca, uncompressed, vq};
use crate::charts::curves::Curves;
use crate::figures::outcome::{self, ENCODE, MEMORY, Outcome, RELIGHT};
use crate::figures::plot::plot;
use crate::figures::setting::{Curve, Setting};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use prt_cpca::Mode;

pub(super) const FIGURE: Figure = Figure { name: "figure10", draw };

const TITLE: &str = "Figures 10 and 11: PCA, VQ and clustered PCA (Sloan et al. 2003)";
/// Figures 10 and 11 have 20 for PCA, and 2, 4, 8, 12 for CPCA.
const PCA_COMPONENTS: [usize; 9] = [1, 2, 4, 8, 16, 20, 32, 64, 128];
const CPCA_COMPONENTS: [usize; 7] = [1, 2, 4, 6, 8, 12, 16];
/// Of VQ where the meshes are as large as the paper's; Figure 10 has 1792.
const VQ_CLUSTERS: [usize; 8] = [16, 64, 256, 512, 1024, 1792, 4096, 8192];

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let subject = stage.subject(&BIRD, &glossy(ANISOTROPIC, 24))?;
    let samples = subject.samples();
    let curves = curves(samples, stage.clusters(CLUSTERS, &BIRD, samples));
    let outcomes = stage.measure(&subject, &curves)?;
    let beside = matched::beside(&curves, &outcomes);
    Ok(Drawing {
        text: [outcome::table(TITLE, &subject, &outcomes), matched::table(&beside)].join("\n"),
        tables: vec![
            ("", outcome::csv(&curves, &outcomes, &stage.machine)?),
            ("-paper", matched::csv(&beside, &stage.machine)?),
        ],
        chart: Some(chart(subject.title(), &curves, &outcomes)),
        pictures: Vec::new(),
        measured: outcomes.iter().any(|o| o.row.is_ok()),
    })
}

pub(super) fn chart(subject: String, curves: &[Curve], outcomes: &[Outcome]) -> Curves {
    plot(
        (TITLE, subject, Some("numbers: components of PCA and CPCA, clusters of VQ")),
        curves,
        outcomes,
        &[RELIGHT, MEMORY, ENCODE],
        label,
    )
}

/// PCA and CPCA over their components, VQ over its clusters as far as two samples share one.
pub(super) fn curves(samples: usize, clusters: usize) -> Vec<Curve> {
    // A cluster of few samples has no more components than those.
    let most = |n: &usize| n * clusters < samples / 2;
    vec![
        Curve::new("PCA", PCA_COMPONENTS.into_iter().map(pca)),
        Curve::new("VQ", VQ_CLUSTERS.into_iter().filter(|n| n * 2 <= samples).map(vq)),
        Curve::new("CPCA", CPCA_COMPONENTS.into_iter().filter(most).map(|n| cpca(Mode::Iterative, clusters, n))),
        uncompressed(),
    ]
}

/// What differs between the points of a curve.
fn label(setting: &Setting) -> String {
    let Some(size) = setting.size else { return String::new() };
    let number = if size.components == 0 { size.clusters } else { size.components };
    number.to_string()
}
