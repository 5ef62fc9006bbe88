//! Figure 2: squared error against storage, static components, a curve for each number of components.

use super::{BIRD, CLUSTERS, claims, cpca, diffuse, uncompressed, vq};
use crate::charts::curves::Curves;
use crate::figures::outcome::{self, MEMORY, NUMBERS, Outcome, RELIGHT};
use crate::figures::plot::plot;
use crate::figures::setting::{Curve, Setting, Size};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use prt_cpca::Mode;

pub(super) const FIGURE: Figure = Figure {
    name: "figure2",
    table: Some("Figure 2: clusters and components, static, at equal numbers, bytes and time"),
    draw,
};

const TITLE: &str = "Figure 2: clusters and components, static (Sloan et al. 2003)";
/// n' of each curve.
const COMPONENTS: [usize; 6] = [0, 1, 2, 4, 8, 16];
/// Where the paper's curves end, m_c.
const MOST: usize = 16_384;

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let subject = stage.subject(&BIRD, &diffuse(5))?;
    // Powers of two as in the paper, or every other one.
    let step = if stage.is_paper_sized() { 2 } else { 4 };
    let curves = curves(subject.samples(), subject.dimension(), step);
    let outcomes = stage.measure(&subject, &curves)?;
    Ok(Drawing {
        text: outcome::table(TITLE, &subject, &outcomes),
        beside: vec![claims::figure2(subject.title(), &curves, &outcomes)],
        tables: vec![("", outcome::csv(&curves, &outcomes, &stage.machine)?)],
        chart: Some(chart(subject.title(), &curves, &outcomes)),
        measured: outcomes.iter().any(|o| o.row.is_ok()),
        ..Drawing::default()
    })
}

pub(super) fn chart(subject: String, curves: &[Curve], outcomes: &[Outcome]) -> Curves {
    plot((TITLE, subject, Some("256: at 256 clusters")), curves, outcomes, &[NUMBERS, MEMORY, RELIGHT], label)
}

/// Clusters 1, step, step², … on every curve, as far as two samples share a cluster and less is stored than the matrix itself.
pub(super) fn curves(samples: usize, dimension: usize, step: usize) -> Vec<Curve> {
    let curve = |components: usize| {
        let fits = |clusters: usize| {
            let numbers = Size { clusters, components }.numbers(samples, dimension);
            clusters <= MOST.min(samples / 2) && numbers < samples * dimension
        };
        let clusters = std::iter::successors(Some(1usize), |n| n.checked_mul(step)).take_while(|n| fits(*n));
        let setting = |clusters| if components == 0 { vq(clusters) } else { cpca(Mode::Static, clusters, components) };
        Curve::new(format!("n' = {components}"), clusters.map(setting))
    };
    COMPONENTS.into_iter().map(curve).chain([uncompressed()]).collect()
}

/// The clusters of the other figures.
fn label(setting: &Setting) -> String {
    setting.size.filter(|size| size.clusters == CLUSTERS).map_or(String::new(), |size| size.clusters.to_string())
}
