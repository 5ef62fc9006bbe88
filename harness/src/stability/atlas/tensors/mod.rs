//! Tensors: Tsai and Shih 2006, §5, and the decompositions below it.

mod members;
mod noise;
mod rank;
mod swamp;

use super::case::Part;
use prt_transfer::{LightBasis, Result, TransferMatrix};

pub(super) const PART: Part =
    Part { name: "tensors", title: "Tensors", cases: &[members::CASE, rank::CASE, noise::CASE, swamp::CASE] };

const VIEWS: usize = 6;
const LIGHTS: usize = 20;

/// Samples x views x lights, of this number of matrices views x lights in random shares.
fn samples(samples: usize, rank: usize) -> Result<TransferMatrix> {
    let (shares, matrices) = (super::ground::noise(samples, rank, 41), super::ground::noise(rank, VIEWS * LIGHTS, 42));
    let rows = shares.dot(&matrices).into_shape_with_order((samples * VIEWS, LIGHTS));
    super::ground::on(rows.unwrap_or_default().view(), VIEWS, LightBasis::Plain { lights: LIGHTS })
}
