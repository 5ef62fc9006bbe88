//! Exact answers for rays that pass closer to an edge than `f32` can tell.
//!
//! With a triangle's corners `v_i` relative to the ray's origin, the ray hits iff `det(v_i, v_j, d)` has, for all three edges,
//! the sign of `det(v_0, v_1, v_2)` or is zero. The signs here are those of the real numbers (Shewchuk's adaptive expansions),
//! so the images of the triangles on the sphere of directions are what they are in geometry: those of a closed mesh around the
//! origin leave no gap, at edges and at vertices, whatever the rounding.

use glam::Vec3;
use robust::{Coord3D, orient3d};

/// The exact sign of `det(a, b, c) = a · (b × c)`: -1, 0 or 1.
pub(crate) fn orientation(a: Vec3, b: Vec3, c: Vec3) -> i32 {
    let point = |p: Vec3| Coord3D { x: p.x, y: p.y, z: p.z };
    let determinant = orient3d(point(a), point(b), point(c), point(Vec3::ZERO));
    i32::from(determinant > 0.0) - i32::from(determinant < 0.0)
}

/// Whether the ray from the origin along `d` hits the triangle, its border included, from either side, at a positive distance.
/// A triangle seen edge-on, or without an area, hides nothing.
#[cold]
pub(crate) fn hits([a, b, c]: [Vec3; 3], d: Vec3) -> bool {
    let facing = orientation(a, b, c);
    let inside = |a: Vec3, b: Vec3| orientation(a, b, d) * facing >= 0;
    facing != 0 && inside(a, b) && inside(b, c) && inside(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn integer_vector() -> impl Strategy<Value = [i32; 3]> {
        prop::array::uniform3(-4_000_000..4_000_000)
    }

    proptest! {
        /// Second way: integers. The third vector is a combination of the first two, moved by at most one unit, so that the
        /// determinant is zero or far below what `f32` resolves.
        #[test]
        fn orientation_is_the_sign_of_the_integer_determinant(a in integer_vector(), b in integer_vector(),
                                                              nudge in prop::array::uniform3(-1i32..=1)) {
            let c: [i32; 3] = std::array::from_fn(|i| (a[i] + b[i] + nudge[i]).clamp(-8_000_000, 8_000_000));
            let [x, y, z] = [a, b, c].map(|v| v.map(i128::from));
            let det = x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0])
                + x[2] * (y[0] * z[1] - y[1] * z[0]);
            let [a, b, c] = [a, b, c].map(|v| Vec3::from_array(v.map(|x| x as f32)));
            prop_assert_eq!(i128::from(orientation(a, b, c)), det.signum());
            prop_assert_eq!(orientation(b, a, c), -orientation(a, b, c));
        }
    }
}
