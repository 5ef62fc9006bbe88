//! Centres and bandwidths as free variables, three for each lobe, in which a step of 1 is about a lobe's width.

use crate::kernel::Kernel;
use crate::lobe::{Lobe, dot, normalised};
use prt_transfer::basis::Direction;

/// Variables of one lobe.
pub(super) const VARIABLES: usize = 3;

/// The farthest that a centre may move from where it was, as the tangent of the angle.
const REACH: f64 = 3.0;

/// A map from variables to a lobe, around the lobe at which they are 0.
pub(super) struct Chart {
    centre: Direction,
    /// Tangents at the centre, as long as the lobe is wide.
    axes: [Direction; 2],
    coordinate: f64,
    width: f64,
    kernel: Kernel,
}

impl Chart {
    pub(super) fn new(lobe: &Lobe, kernel: Kernel) -> Chart {
        let width = kernel.spread(lobe.bandwidth).min(1.0);
        let axes = lobe.tangents().map(|t| t.map(|c| c * width));
        Chart { centre: lobe.centre, axes, coordinate: kernel.coordinate(lobe.bandwidth), width, kernel }
    }

    /// The lobe's half-plane and the bandwidths: lower and upper bounds of the variables.
    pub(super) fn bounds(&self, bandwidths: [f64; 2]) -> [[f64; VARIABLES]; 2] {
        let reach = REACH / self.width;
        let ends = bandwidths.map(|b| self.kernel.coordinate(b) - self.coordinate);
        [[-reach, -reach, ends[0]], [reach, reach, ends[1]]]
    }

    /// The tangents, in units of the variables: the derivatives of the centre at 0.
    pub(super) fn axes(&self) -> [Direction; 2] {
        self.axes
    }

    pub(super) fn lobe(&self, variables: &[f64]) -> Lobe {
        let [a, b] = self.axes;
        let centre = [0, 1, 2].map(|i| self.centre[i] + variables[0] * a[i] + variables[1] * b[i]);
        Lobe { centre: normalised(centre), bandwidth: self.kernel.bandwidth_at(self.coordinate + variables[2]) }
    }

    /// A gradient in the centre and the bandwidth's coordinate becomes one in the variables.
    pub(super) fn gradient(&self, variables: &[f64], gradient: [f64; 4]) -> [f64; VARIABLES] {
        let [x, y, z, by_coordinate] = gradient;
        let centre = self.lobe(variables).centre;
        // The centre is v/|v|: its derivative along an axis is the tangential part, over |v|; v is the chart's centre plus tangents.
        let length = 1.0 / dot(centre, self.centre);
        let along = self.axes.map(|axis| {
            let radial = dot(axis, centre);
            dot([0, 1, 2].map(|i| axis[i] - radial * centre[i]), [x, y, z]) / length
        });
        [along[0], along[1], by_coordinate]
    }
}

/// Every lobe's chart.
pub(super) fn charts(lobes: &[Lobe], kernel: Kernel) -> Vec<Chart> {
    lobes.iter().map(|lobe| Chart::new(lobe, kernel)).collect()
}

/// The lobes at all variables.
pub(super) fn lobes_at(charts: &[Chart], variables: &[f64]) -> Vec<Lobe> {
    charts.iter().zip(variables.chunks(VARIABLES)).map(|(chart, v)| chart.lobe(v)).collect()
}
