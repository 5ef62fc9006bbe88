//! Samples that are alike: clusters that start on two of a kind leave one of them empty.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use ndarray::{Array2, Axis};
use prt_transfer::Result;
use prt_transfer::random::Random;

pub(super) const CASE: Case = Case {
    name: "duplicates",
    title: "Duplicate samples, empty clusters",
    source: "Sloan et al. 2003, §4.1 (LBG from samples drawn at random)",
    parameter: "clusters, of samples of which 12 are distinct",
    values: &[64.0, 48.0, 32.0, 24.0, 16.0, 12.0],
    quantity: "Σ(T-T̃)²/ΣT²",
    printed: Form { name: "Lloyd's iteration; who is empty stays so", figure: printed },
    here: Form { name: "vq", figure: here },
    bound: |_| 1e-12,
    promise: "exact to single precision: a representative for each distinct sample",
    breaks: Some(24.0),
};

const DISTINCT: usize = 12;
const COPIES: usize = 20;

fn samples() -> Array2<f64> {
    let distinct = ground::noise(DISTINCT, 20, 9);
    Array2::from_shape_fn((DISTINCT * COPIES, 20), |(i, j)| distinct[[i % DISTINCT, j]])
}

fn printed(clusters: f64) -> Result<f64> {
    let (x, mut random) = (samples(), Random(3));
    let mut means: Array2<f64> = Array2::zeros((clusters as usize, x.ncols()));
    means.outer_iter_mut().for_each(|mut mean| mean.assign(&x.row(random.below(x.nrows()))));
    let mut of = vec![0; x.nrows()];
    for _ in 0..50 {
        for (of, x) in of.iter_mut().zip(x.outer_iter()) {
            let far = |c: &usize| (&x - &means.row(*c)).mapv(|d| d * d).sum();
            *of = (0..means.nrows()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0);
        }
        for (c, mut mean) in means.outer_iter_mut().enumerate() {
            let members: Vec<usize> = (0..of.len()).filter(|&i| of[i] == c).collect();
            if let Some(found) = x.select(Axis(0), &members).mean_axis(Axis(0)) {
                mean.assign(&found);
            }
        }
    }
    Ok(ground::distance(means.select(Axis(0), &of).view(), x.view()))
}

fn here(clusters: f64) -> Result<f64> {
    ground::error(&format!("vq:clusters={clusters}"), &ground::plain(samples().view())?)
}
