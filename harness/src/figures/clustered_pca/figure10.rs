//! Figures 10 and 11: components of all samples, vector quantisation and clustered components on a glossy signal.

use super::matched;
use super::{ANISOTROPIC, BIRD, BUDDHA, CLUSTERS, cpca, glossy, pca, uncompressed, vq};
use crate::charts::curves::Curves;
use crate::figures::outcome::{self, ENCODE, MEMORY, Outcome, RELIGHT};
use crate::figures::plot::plot;
use crate::figures::setting::{Curve, Setting};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use prt_cpca::Mode;

pub(super) const FIGURE: Figure = Figure {
    name: "figure10",
    table: Some("Figures 10 and 11: PCA, VQ and clustered PCA at equal time and equal bytes, and over components"),
    draw,
};

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
    let (title, csv) = (subject.title(), outcome::csv(&curves, &outcomes, &stage.machine)?);
    let text = outcome::table(TITLE, &subject, &outcomes);
    let chart = chart(subject.title(), &curves, &outcomes);
    let ten = matched::figure10(title.clone(), &curves, &outcomes);
    let measured = outcomes.iter().any(|o| o.row.is_ok());
    let models = [buddha(stage).map_err(|error| format!("{error:#}")), Ok((title, curves, outcomes))];
    let beside = vec![ten, matched::figure11(&models)];
    Ok(Drawing { text, beside, tables: vec![("", csv)], chart: Some(chart), measured, ..Drawing::default() })
}

/// The bumpier model of Figure 11, which has clustered PCA alone.
fn buddha(stage: &Stage) -> anyhow::Result<(String, Vec<Curve>, Vec<Outcome>)> {
    let subject = stage.subject(&BUDDHA, &glossy(ANISOTROPIC, 24))?;
    let samples = subject.samples();
    let curves = curves(samples, stage.clusters(CLUSTERS, &BUDDHA, samples));
    let only: Vec<Curve> = curves.into_iter().filter(|curve| curve.name == "CPCA").collect();
    let outcomes = stage.measure(&subject, &only)?;
    Ok((subject.title(), only, outcomes))
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
