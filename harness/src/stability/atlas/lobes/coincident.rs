//! Two centres at one place: lobes that cannot be told apart.

use super::rows;
use crate::stability::atlas::case::{Case, Form};
use crate::stability::atlas::ground::{errors, reloaded};
use prt_srbf::icosphere::centers;
use prt_srbf::{Coordinates, Ridge, Srbf, SrbfParams};
use prt_transfer::basis::Direction;
use prt_transfer::{Configure, Method, Quiet, Result};
use prt_wavelet::{Truncate, TruncateParams};

pub(super) const CASE: Case = Case {
    name: "coincident",
    title: "Two lobes at one place, stored in 16 bits",
    source: "Tsai and Shih 2006, §4.1: least squares",
    parameter: "angle between their centres, rad",
    values: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-12],
    quantity: "squared error over the sphere, beyond that without the second lobe, relative",
    printed: Form {
        name: "coefficients of lobes, no ridge",
        figure: |angle| {
            added(angle, SrbfParams { ridge: Ridge::Share(0.0), coordinates: Coordinates::Lobes, ..Default::default() })
        },
    },
    here: Form { name: "orthonormal coordinates, ridge=auto", figure: |angle| added(angle, SrbfParams::default()) },
    bound: |_| 0.01,
    promise: "never worse than without it, to 1 %",
    breaks: Some(1e-6),
};

const LOBES: usize = 42;
const BANDWIDTH: f64 = 12.0;

fn added(angle: f64, params: SrbfParams) -> Result<f64> {
    let mut places = centers(LOBES).unwrap_or_default();
    let without = error(places.clone(), SrbfParams::default())?;
    let [x, y, z] = places[0];
    // Any direction across the first centre.
    let across = if x.abs() < 0.5 { [0.0, -z, y] } else { [-y, x, 0.0] };
    let length = across.iter().map(|c| c * c).sum::<f64>().sqrt();
    let (sin, cos) = angle.sin_cos();
    places.push(std::array::from_fn(|i| cos * places[0][i] + sin * across[i] / length));
    Ok((error(places, params)? / without - 1.0).max(0.0))
}

fn error(places: Vec<Direction>, params: SrbfParams) -> Result<f64> {
    let (matrix, count) = (rows()?, places.len());
    let srbf = Srbf::with_centers(params, places, vec![BANDWIDTH; count])?;
    let truncate = Truncate::new(TruncateParams { terms: Some(count), bits: 16, ..Default::default() })?;
    let compressed = Method::new(srbf, truncate).encode(&matrix, &Quiet)?;
    Ok(errors(&reloaded(&compressed)?, &matrix)?[1])
}
