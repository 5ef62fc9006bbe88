//! A centre and a bandwidth.

use crate::kernel::Kernel;
use prt_transfer::basis::Direction;

/// Where a kernel sits on the sphere and how narrow it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Unit vector.
    pub centre: Direction,
    /// λ, within [`Kernel::bandwidths`].
    pub bandwidth: f64,
}

impl Lobe {
    /// The cosine between the centre and a unit direction.
    pub fn cosine(&self, direction: Direction) -> f64 {
        dot(self.centre, direction)
    }

    /// What is expected and what is there where this is no lobe of a kernel: a centre that is not a unit vector to within 1e-3, a
    /// bandwidth out of range.
    pub(crate) fn check(&self, kernel: Kernel) -> Result<(), (String, String)> {
        let [low, high] = kernel.bandwidths();
        let length = dot(self.centre, self.centre).sqrt();
        if !(0.999..=1.001).contains(&length) {
            return Err(("a unit vector as centre".into(), format!("one of length {length}")));
        }
        if !(low..=high).contains(&self.bandwidth) {
            return Err((format!("a bandwidth from {low} to {high}"), self.bandwidth.to_string()));
        }
        Ok(())
    }

    /// ⟨G_a, G_b⟩ / (‖G_a‖ ‖G_b‖): 1 for equal lobes.
    pub fn overlap(&self, other: &Lobe, kernel: Kernel) -> f64 {
        let bandwidths = [self.bandwidth, other.bandwidth];
        let norms = bandwidths.map(|b| kernel.norm(b));
        kernel.inner_product([self.centre, other.centre], bandwidths) / (norms[0] * norms[1])
    }

    /// Two unit vectors that complete the centre to a right-handed frame.
    pub(crate) fn tangents(&self) -> [Direction; 2] {
        // Duff et al. 2017: without a branch that loses precision near a pole.
        let [x, y, z] = self.centre;
        let sign = 1f64.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        [[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]]
    }
}

pub(crate) fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The unit vector along `v`; +z along zero.
pub(crate) fn normalised(v: Direction) -> Direction {
    let length = dot(v, v).sqrt();
    if length > 0.0 { v.map(|c| c / length) } else { [0.0, 0.0, 1.0] }
}
