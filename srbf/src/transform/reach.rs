//! Which lobes a texel sees, and how finely.

use super::lobes::Lobes;
use crate::kernel::Kernel;
use crate::lobe::dot;
use prt_transfer::basis::Direction;
use prt_transfer::quadrature::Texels;
use std::f64::consts::PI;

/// A Gaussian lobe is 0 on texels where it is below this share of its peak.
const NEGLIGIBLE: f64 = 1e-8;

/// Rules of 2, 4, … 256 nodes along an edge of a texel.
pub(super) const RULES: usize = 8;

/// Which lobes reach a texel, and how finely they are integrated over it.
pub(super) struct Reach<'a> {
    lobes: &'a Lobes,
    /// cos of the angle between a lobe's centre and that of the last texel that it reaches.
    cosines: Vec<f64>,
    edge: f64,
    radius: f64,
}

impl<'a> Reach<'a> {
    /// `None` where a lobe is too narrow for every rule.
    pub(super) fn new(lobes: &'a Lobes, texels: Texels) -> Option<Reach<'a>> {
        let (edge, radius) = (texels.edge(), texels.radius());
        let kernel = lobes.kernel;
        let cosines = lobes.bandwidths.iter().map(|&b| (angle(kernel, b) + radius).min(PI).cos()).collect();
        let reach = Reach { lobes, cosines, edge, radius };
        (0..lobes.len()).all(|j| reach.rule(j, 1.0) < RULES).then_some(reach)
    }

    /// The lobes that reach a texel with this centre, and which rule integrates each.
    pub(super) fn near(&self, texel: Direction) -> impl Iterator<Item = (usize, usize)> + '_ {
        let near = (0..self.lobes.len())
            .map(move |j| (j, dot(self.lobes.centers[j], texel)))
            .filter(|&(j, mu)| mu >= self.cosines[j]);
        near.map(|(j, mu)| (j, self.rule(j, mu)))
    }

    /// Lobes that reach a texel, and kernels to evaluate there.
    pub(super) fn count(&self, texel: Direction) -> [u64; 2] {
        self.near(texel).fold([0; 2], |sum, (_, rule)| [sum[0] + 1, sum[1] + (4 << (2 * rule))])
    }

    /// The number of a rule that is fine enough at cosine `mu` from centre `j`; [`RULES`] or more where there is none.
    fn rule(&self, j: usize, mu: f64) -> usize {
        let bandwidth = self.lobes.bandwidths[j];
        // Nodes for each length over which a kernel changes. Rules converge geometrically at the distance of a Poisson kernel's
        // singularity, which lies beside the centre at an imaginary angle, and faster for a Gaussian, which has none.
        let rate = match self.lobes.kernel {
            Kernel::Gaussian => 2.0 * bandwidth.sqrt(),
            Kernel::AbelPoisson => {
                let angle = (mu.clamp(-1.0, 1.0).acos() - self.radius).max(0.0);
                4.0 / angle.hypot((1.0 - bandwidth) / bandwidth.sqrt())
            }
        };
        // A few more for the projection of the cube.
        let nodes = 2.0 + self.edge * (rate + 4.0);
        (nodes.log2().ceil() as usize).saturating_sub(1)
    }
}

/// The angle from its centre, in rad, at which a kernel becomes negligible.
fn angle(kernel: Kernel, bandwidth: f64) -> f64 {
    match kernel {
        Kernel::Gaussian => (1.0 + NEGLIGIBLE.ln() / bandwidth).max(-1.0).acos(),
        Kernel::AbelPoisson => PI,
    }
}
