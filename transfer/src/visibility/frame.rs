//! Frames of samples as they are stored, and the little algebra that they need.

use bytemuck::{Pod, Zeroable};

/// A direction.
pub(super) type Vector = [f64; 3];

/// A quaternion w + xi + yj + zk that rotates the world into a sample's frame; only its direction counts.
pub(super) type Quaternion = [f64; 4];

/// A quaternion in fixed point, its largest component ± 32767.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Frame(pub(super) [i16; 4]);

impl Frame {
    /// The nearest that is stored.
    pub(super) fn of(q: Quaternion) -> Frame {
        let largest = q.iter().fold(0.0, |m: f64, c| if c.abs() > m.abs() { *c } else { m });
        // q and -q are one rotation: the largest component is positive.
        Frame(q.map(|c| (c / largest * f64::from(i16::MAX)).round() as i16))
    }

    /// Tangent, bitangent and normal in world coordinates: the rows of the rotation.
    pub(super) fn axes(&self) -> [Vector; 3] {
        rotation(self.0.map(f64::from))
    }
}

/// The rows of a quaternion's rotation matrix.
fn rotation([w, x, y, z]: Quaternion) -> [Vector; 3] {
    let s = 2.0 / (w * w + x * x + y * y + z * z);
    [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Coordinates in a frame.
pub(super) fn to_local(axes: &[Vector; 3], world: Vector) -> Vector {
    axes.map(|axis| dot(axis, world))
}

/// A direction below the horizon is taken to the horizon.
pub(super) fn above_horizon([x, y, z]: Vector) -> Vector {
    [x, y, z.max(0.0)]
}
