//! Figure 3: error against the number of components, for each way of finding clusters.

use super::{BIRD, CLUSTERS, adaptive_by_the_paper, claims, cpca, diffuse, uncompressed};
use crate::charts::curves::Curves;
use crate::figures::outcome::{self, COMPONENTS, MEMORY, Outcome, RELIGHT};
use crate::figures::plot::plot;
use crate::figures::setting::Curve;
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use prt_cpca::Mode;

pub(super) const FIGURE: Figure = Figure {
    name: "figure3",
    table: Some("Figure 3: what iterative and adaptive clusters are worth in components"),
    draw,
};

const TITLE: &str = "Figure 3: static, iterative and adaptive (Sloan et al. 2003)";

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let subject = stage.subject(&BIRD, &diffuse(5))?;
    let components: &[usize] = if stage.is_paper_sized() { &[1, 2, 3, 4, 6, 8, 12, 16] } else { &[1, 2, 4, 8] };
    let curves = curves(stage.clusters(CLUSTERS, &BIRD, subject.samples()), components);
    let outcomes = stage.measure(&subject, &curves)?;
    Ok(Drawing {
        text: outcome::table(TITLE, &subject, &outcomes),
        beside: vec![claims::figure3(subject.title(), &curves, &outcomes)],
        tables: vec![("", outcome::csv(&curves, &outcomes, &stage.machine)?)],
        chart: Some(chart(subject.title(), &curves, &outcomes)),
        measured: outcomes.iter().any(|o| o.row.is_ok()),
        ..Drawing::default()
    })
}

pub(super) fn chart(subject: String, curves: &[Curve], outcomes: &[Outcome]) -> Curves {
    plot((TITLE, subject, None), curves, outcomes, &[COMPONENTS, MEMORY, RELIGHT], |_| String::new())
}

/// So many clusters on every curve.
pub(super) fn curves(clusters: usize, components: &[usize]) -> Vec<Curve> {
    let of = |mode| components.iter().map(move |&n| cpca(mode, clusters, n));
    vec![
        Curve::new("static", of(Mode::Static)),
        Curve::new("iterative", of(Mode::Iterative)),
        Curve::new("adaptive, the paper's rule", components.iter().map(|&n| adaptive_by_the_paper(clusters, n))),
        Curve::new("adaptive, by bytes", of(Mode::Adaptive)),
        uncompressed(),
    ]
}
