//! Lobes at random.

use crate::kernel::Kernel;
use crate::lobe::Lobe;
use prt_transfer::random::Random;
use std::f64::consts::PI;

/// Centres uniform over the sphere, a spread of half of what is between them on average.
pub(super) fn random(kernel: Kernel, bandwidths: [f64; 2], count: usize, random: &mut Random) -> Vec<Lobe> {
    let spread = 0.5 * (4.0 * PI / count as f64).sqrt();
    let bandwidth = kernel.bandwidth_of_spread(spread).clamp(bandwidths[0], bandwidths[1]);
    (0..count)
        .map(|_| {
            let (z, phi) = (2.0 * random.uniform() - 1.0, 2.0 * PI * random.uniform());
            let sine = (1.0 - z * z).sqrt();
            Lobe { centre: [sine * phi.cos(), sine * phi.sin(), z], bandwidth }
        })
        .collect()
}
