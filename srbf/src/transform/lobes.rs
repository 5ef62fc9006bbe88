//! Lobes of one kernel, checked.

use super::params::{Centers, SrbfParams};
use crate::icosphere::{centers, least_angle};
use crate::kernel::Kernel;
use ndarray::Array2;
use prt_transfer::basis::Direction;
use prt_transfer::sections::broken;
use prt_transfer::{Error, Params, Result, Sink, Source};
use std::f64::consts::PI;

/// Most lobes of one transform: their Gram matrix then takes 128 MiB.
const MAX_LOBES: usize = 1 << 12;

/// The paper's standard deviation of a lobe, in rad, among [`PAPER_COUNT`] of them.
const PAPER_SPREAD: f64 = PI / 40.0;
const PAPER_COUNT: usize = 642;

/// Unit centres, and a bandwidth of each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lobes {
    pub(super) kernel: Kernel,
    pub(super) centers: Vec<Direction>,
    pub(super) bandwidths: Vec<f64>,
}

impl Lobes {
    /// At least one centre, unit within 1e-6 (and made so), each with a bandwidth that the kernel accepts.
    pub(super) fn new(kernel: Kernel, mut centers: Vec<Direction>, bandwidths: Vec<f64>) -> Result<Lobes> {
        Error::expect_size("bandwidths beside centers", centers.len(), bandwidths.len())?;
        if centers.is_empty() {
            return Err(refuse("centers", "none", "at least one direction"));
        }
        if centers.len() > MAX_LOBES {
            return Err(Error::TooLarge {
                what: "centers of srbf".into(),
                limit: MAX_LOBES as u64,
                found: centers.len() as u64,
            });
        }
        for (i, center) in centers.iter_mut().enumerate() {
            let square = center.iter().map(|c| c * c).sum::<f64>();
            if square.is_nan() || (square - 1.0).abs() > 2e-6 {
                return Err(refuse("centers", format!("{center:?} at {i}"), "directions of length 1"));
            }
            // What is unit to rounding stays as it is, so that a file that is saved again has the same bytes.
            if (square - 1.0).abs() > 4.0 * f64::EPSILON {
                *center = center.map(|c| c / square.sqrt());
            }
        }
        let [low, high] = kernel.bandwidths();
        match bandwidths.iter().position(|b| !(low..=high).contains(b)) {
            Some(i) => {
                Err(refuse("bandwidth", format!("{} of center {i}", bandwidths[i]), format!("from {low} to {high}")))
            }
            None => Ok(Lobes { kernel, centers, bandwidths }),
        }
    }

    /// Those that a label describes by itself.
    pub(super) fn of(params: &SrbfParams) -> Result<Lobes> {
        let Centers::Count(count) = params.centers else {
            let expected =
                "a number in a label: a label does not say where given ones are, a file and Srbf::with_centers do";
            return Err(refuse("centers", "given", expected));
        };
        let expected = "a number of vertices of a subdivided icosahedron";
        let centers = centers(count).ok_or_else(|| refuse("centers", count.to_string(), expected))?;
        let bandwidth = params.bandwidth.unwrap_or_else(|| spaced(params.kernel, &centers));
        let bandwidths = vec![bandwidth; count];
        Lobes::new(params.kernel, centers, bandwidths)
    }

    pub(super) fn len(&self) -> usize {
        self.centers.len()
    }

    /// ∫ G_i H_j dω: lobes x others.
    pub(super) fn inner_products(&self, others: &Lobes) -> Array2<f64> {
        Array2::from_shape_fn((self.len(), others.len()), |(i, j)| {
            self.kernel.inner_product([self.centers[i], others.centers[j]], [self.bandwidths[i], others.bandwidths[j]])
        })
    }

    /// Writes centres and bandwidths.
    pub(super) fn write(&self, sink: &mut Sink) {
        sink.put(CENTERS, &self.centers);
        sink.put(BANDWIDTHS, &self.bandwidths);
    }

    /// What [`Lobes::write`] wrote.
    pub(super) fn read(kernel: Kernel, source: &mut Source) -> Result<Lobes> {
        let centers: Vec<Direction> = source.take(CENTERS)?;
        let bandwidths = source.take_exact(BANDWIDTHS, centers.len())?;
        Lobes::new(kernel, centers, bandwidths)
            .map_err(|e| broken(CENTERS, "unit centres, and bandwidths within the kernel's range", e.to_string()))
    }
}

const CENTERS: &str = "basis/srbf-centers";
const BANDWIDTHS: &str = "basis/srbf-bandwidths";

/// The bandwidth whose spread is to the least angle between the centres as the paper's is to that of its 642.
fn spaced(kernel: Kernel, directions: &[Direction]) -> f64 {
    let paper = centers(PAPER_COUNT).map_or(PI, |paper| least_angle(&paper));
    kernel.bandwidth_of_spread(PAPER_SPREAD * least_angle(directions) / paper)
}

fn refuse(name: &str, value: impl Into<String>, expected: impl Into<String>) -> Error {
    SrbfParams::refuse(name, value.into(), expected)
}
