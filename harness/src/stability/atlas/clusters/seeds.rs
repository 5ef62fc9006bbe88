//! What chance decides: the same search from 20 seeds.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::Array2;
use prt_transfer::Result;
use prt_transfer::random::Random;

pub(super) const CASE: Case = Case {
    name: "seeds",
    title: "Luck: the same clusters from 20 seeds",
    source: "Sloan et al. 2003, §4.1 (samples drawn at random)",
    parameter: "clusters",
    values: &[4.0, 8.0, 16.0, 32.0],
    quantity: "error of the worst of 20 seeds beyond that of the luckiest random start, relative",
    printed: Form { name: "start=random", figure: |clusters| worst(clusters, "random") },
    here: Form { name: "start=splitting, which draws nothing", figure: |clusters| worst(clusters, "splitting") },
    bound: |_| 3.0,
    promise: "four times the luckiest, with no draw at all",
    breaks: Some(16.0),
};

const SEEDS: usize = 20;
const GROUPS: usize = 16;

/// Groups of planes of very different sizes, as surfaces of a scene are: 400 samples of 12 numbers.
fn samples() -> Array2<f64> {
    let (centres, axes) = (ground::noise(GROUPS, 12, 21) * 4.0, ground::noise(2 * GROUPS, 12, 22));
    let mut random = Random(23);
    let mut x = ground::noise(400, 12, 24) * 0.1;
    for mut row in x.outer_iter_mut() {
        // Halves of what is left, but for the last ones.
        let group = (-(random.uniform().max(1e-9)).log2() * 2.0).min(GROUPS as f64 - 1.0) as usize;
        row += &centres.row(group);
        (0..2).for_each(|axis| row.scaled_add(random.normal(), &axes.row(2 * group + axis)));
    }
    x
}

fn worst(clusters: f64, start: &str) -> Result<f64> {
    let matrix = ground::plain(samples().view())?;
    let errors = |start: &str| -> Result<Vec<f64>> {
        let label = |seed| format!("cpca:clusters={clusters}:components=2:mode=iterative:start={start}:seed={seed}");
        (0..SEEDS).map(|seed| ground::error(&label(seed), &matrix)).collect()
    };
    let best = errors("random")?.into_iter().fold(f64::INFINITY, f64::min);
    let worst = errors(start)?.into_iter().fold(0.0, f64::max);
    Ok((worst / best - 1.0).max(0.0))
}
