//! |x - x₀|² - Σ w² is a small difference of large numbers where components are good.

use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground;
use crate::stability::eigensolvers::spectra::Known;
use ndarray::Axis;
use prt_transfer::{Result, linalg};

pub(super) const CASE: Case = Case {
    name: "cancellation",
    title: "The squared error of a good fit",
    source: "Sloan et al. 2003, §4.2",
    parameter: "squared error as a part of the signal",
    values: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8],
    quantity: "relative error of the squared error",
    printed: Form { name: "|x - x₀|² - Σ w² in single precision", figure: printed },
    here: Form { name: "residuals of what was decoded, summed in double precision", figure: here },
    bound: |_| 1e-4,
    promise: "1e-4, down to errors of 1e-8, where f32 itself ends",
    breaks: Some(1e-5),
};

const COMPONENTS: usize = 4;
const SAMPLES: usize = 200;

/// Four components and next to nothing beside them.
fn known(share: f64) -> Known {
    // 60 more of equal size, which add up to the share.
    let rest = (share * COMPONENTS as f64 / 60.0).sqrt();
    Known::new(SAMPLES, 64, 5, |i| if i < COMPONENTS { 1.0 } else { rest })
}

/// Of what is stored, the optimum of which is known: the mean is one more component at no cost, so that it is taken out first.
fn centred(share: f64) -> Result<(ndarray::Array2<f64>, f64)> {
    let mut x = known(share).matrix;
    if let Some(mean) = x.mean_axis(Axis(0)) {
        x -= &mean;
    }
    let values = linalg::singular(x.view())?.values;
    let least = values[COMPONENTS..].iter().rev().map(|s| s * s).sum::<f64>();
    Ok((x, least))
}

fn printed(share: f64) -> Result<f64> {
    let (x, least) = centred(share)?;
    let vectors = prt_cpca::Solver::Svd.solver().leading(x.view(), COMPONENTS, None)?.vectors.mapv(|v| v as f32);
    let error: f32 = x.mapv(|v| v as f32).outer_iter().map(|x| x.dot(&x) - vectors.dot(&x).mapv(|w| w * w).sum()).sum();
    Ok((f64::from(error) / least - 1.0).abs())
}

fn here(share: f64) -> Result<f64> {
    let (x, least) = centred(share)?;
    let error = ground::error(&format!("pca:components={COMPONENTS}"), &ground::plain(x.view())?)?;
    Ok((error * ground::square(x.view()) / least - 1.0).abs())
}
