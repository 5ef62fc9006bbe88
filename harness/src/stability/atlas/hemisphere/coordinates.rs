//! The least error of harmonic coefficients is not the least error of the function.

use super::{harmonics, rule};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{self, direction, dot};
use ndarray::{Array2, Axis};
use prt_transfer::random::Random;
use prt_transfer::{Result, linalg};

pub(super) const CASE: Case = Case {
    name: "coordinates",
    title: "Components of lobes on the hemisphere",
    source: "Sloan et al. 2003, §4: components of harmonic coefficients",
    parameter: "components",
    values: &[1.0, 2.0, 4.0, 8.0, 12.0, 16.0],
    quantity: "∫_H (f - f̃)² as a multiple of the least, less 1",
    printed: Form { name: "components of harmonic coefficients c", figure: |n| beyond(n, false) },
    here: Form { name: "components of orthonormal coordinates d", figure: |n| beyond(n, true) },
    bound: |_| 1e-3,
    promise: "the least, to 1e-3",
    breaks: Some(1.0),
};

const SAMPLES: usize = 300;

/// d of lobes in all directions above the horizon, samples x functions.
fn lobes() -> Result<Array2<f64>> {
    let (harmonics, mut random) = (harmonics(5.0)?, Random(6));
    let mut d = Array2::zeros((SAMPLES, harmonics.coefficients()));
    let (mut q, rule) = (vec![0.0; harmonics.coefficients()], rule());
    for mut row in d.outer_iter_mut() {
        let centre = direction(&mut random).map(f64::abs);
        let shine = 2.0 + 30.0 * random.uniform();
        for &(v, weight) in &rule {
            harmonics.evaluate_orthonormal(v, &mut q);
            let f = dot(centre, v).max(0.0).powf(shine);
            row.iter_mut().zip(&q).for_each(|(d, q)| *d += weight * f * q);
        }
    }
    Ok(d)
}

fn beyond(components: f64, orthonormal: bool) -> Result<f64> {
    let (harmonics, d) = (harmonics(5.0)?, lobes()?);
    let centred = &d - &d.mean_axis(Axis(0)).unwrap_or_default();
    let least: f64 = linalg::singular(centred.view())?.values.iter().skip(components as usize).map(|s| s * s).sum();
    let mut rows = d.clone();
    if !orthonormal {
        for mut row in rows.outer_iter_mut() {
            harmonics.to_harmonic(row.as_slice_mut().expect("rows of a new array"))?;
        }
    }
    let compressed = ground::encoded(&format!("pca:components={components}"), &ground::plain(rows.view())?)?;
    let mut found = ground::decoded(&compressed).mapv(f64::from);
    if !orthonormal {
        for mut row in found.outer_iter_mut() {
            harmonics.to_orthonormal(row.as_slice_mut().expect("rows of a new array"))?;
        }
    }
    Ok((ground::square((&found - &d).view()) / least - 1.0).max(0.0))
}
