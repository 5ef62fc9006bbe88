//! Utah teapot from its Bézier patches: welded across patches, with the normals of the surface itself.

use super::teapot_table::{PATCHES, POINTS};
use crate::mesh::Mesh;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Patches that share their borders' vertices. Elsewhere parts may touch (the handle's end touches the body), but there
/// the surface is not smooth.
fn part(patch: usize) -> u8 {
    match patch {
        12..16 => 1,
        16..20 => 2,
        20..28 => 3,
        _ => 0,
    }
}

/// What identifies a vertex: patches that share a border have the same control points there, though perhaps in reverse.
#[derive(PartialEq, Eq, Hash)]
enum Place {
    /// Inside a patch, by row and column.
    Inside(usize, usize, usize),
    /// On a border, by its control points in the direction whose first is smaller, and the step along it.
    Border(u8, [u16; 4], usize),
    /// A corner, or a whole border that is one point (the lid's tip and the bottom's centre).
    Corner(u8, u16),
}

/// Rows of a patch run along the profile, columns around it; they are refined in turn, so that the numbers of vertices to
/// choose from lie twice as close.
pub(super) fn tessellate(steps: usize) -> Mesh {
    // Two columns at least: handle and spout are closed by two halves, which one column would lay flat onto each other.
    let (rows, cols) = (steps / 2 + 1, steps.div_ceil(2) + 1);
    let mut mesh = Mesh::default();
    let mut numbers = HashMap::new();
    for (patch, indices) in PATCHES.iter().enumerate() {
        let control = indices.map(|i| Vec3::from(POINTS[i as usize]).as_dvec3());
        let mut vertex = |i: usize, j: usize| {
            *numbers.entry(place(patch, i, j, rows, cols)).or_insert_with(|| {
                let (position, normal) = surface(&control, i as f64 / rows as f64, j as f64 / cols as f64);
                mesh.positions.push(position.as_vec3());
                mesh.normals.push(normal.as_vec3());
                mesh.positions.len() as u32 - 1
            })
        };
        for (i, j) in (0..rows * cols).map(|k| (k / cols, k % cols)) {
            let [a, b, c, d] = [vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)];
            // At a pole one side of the quadrilateral is a point, and one triangle is left.
            mesh.faces.extend([[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    mesh
}

fn place(patch: usize, i: usize, j: usize, rows: usize, cols: usize) -> Place {
    let p = &PATCHES[patch];
    let (part, end) = (part(patch), |k: usize, n: usize| k == 0 || k == n);
    let (border, k, n): ([u16; 4], _, _) = match (end(i, rows), end(j, cols)) {
        (false, false) => return Place::Inside(patch, i, j),
        (true, true) => return Place::Corner(part, p[12 * usize::from(i > 0) + 3 * usize::from(j > 0)]),
        (true, false) => (std::array::from_fn(|k| p[12 * usize::from(i > 0) + k]), j, cols),
        (false, true) => (std::array::from_fn(|k| p[3 * usize::from(j > 0) + 4 * k]), i, rows),
    };
    let [first, .., last] = border;
    match first.cmp(&last) {
        std::cmp::Ordering::Equal => Place::Corner(part, first),
        std::cmp::Ordering::Less => Place::Border(part, border, k),
        std::cmp::Ordering::Greater => Place::Border(part, [border[3], border[2], border[1], border[0]], n - k),
    }
}

/// Cubic Bernstein polynomials at `t` and their derivatives.
fn bernstein(t: f64) -> [[f64; 4]; 2] {
    let s = 1.0 - t;
    [
        [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t],
        [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t],
    ]
}

/// Position and outward unit normal of a patch at (u, v).
fn surface(control: &[DVec3; 16], u: f64, v: f64) -> (DVec3, DVec3) {
    let ([b_u, d_u], [b_v, d_v]) = (bernstein(u), bernstein(v));
    let sum = |f: &[f64; 4], g: &[f64; 4]| -> DVec3 { (0..16).map(|k| f[k / 4] * g[k % 4] * control[k]).sum() };
    let (along, around) = (sum(&d_u, &b_v), sum(&b_u, &d_v));
    // Where the border u = 0 is a single point, ∂S/∂v vanishes as u ∂²S/∂u∂v: its direction is that of the latter.
    let around = if around.length() > 1e-9 { around } else { sum(&d_u, &d_v) };
    (sum(&b_u, &b_v), around.cross(along).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control(patch: usize) -> [DVec3; 16] {
        PATCHES[patch].map(|i| Vec3::from(POINTS[i as usize]).as_dvec3())
    }

    #[test]
    fn patches_pass_through_their_corners() {
        for c in (0..32).map(control) {
            for (corner, u, v) in [(0, 0.0, 0.0), (3, 0.0, 1.0), (12, 1.0, 0.0), (15, 1.0, 1.0)] {
                assert!((surface(&c, u, v).0 - c[corner]).length() < 1e-12);
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_polynomials() {
        for t in [0.0, 0.2, 0.7, 1.0] {
            let ([values, slopes], h) = (bernstein(t), 1e-6);
            assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (k, slope) in slopes.into_iter().enumerate() {
                let difference = (bernstein(t + h)[0][k] - bernstein(t - h)[0][k]) / (2.0 * h);
                assert!((slope - difference).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn normals_have_a_limit_at_the_poles() {
        for patch in [20, 23, 28, 31] {
            let (position, pole) = surface(&control(patch), 0.0, 0.3);
            assert!(position.x.abs() + position.y.abs() < 1e-12);
            assert!((pole.z.abs() - 1.0).abs() < 1e-9, "{patch}: {pole}");
            assert!(pole.dot(surface(&control(patch), 1e-4, 0.3).1) > 0.99);
        }
    }

    #[test]
    fn smooth_joints_have_one_normal() {
        // Every border vertex gets its normal from the patch that came first; the others must agree.
        let (rows, cols) = (6, 4);
        let mut first: HashMap<Place, DVec3> = HashMap::new();
        for patch in 0..32 {
            for (i, j) in (0..(rows + 1) * (cols + 1)).map(|k| (k / (cols + 1), k % (cols + 1))) {
                let normal = surface(&control(patch), i as f64 / rows as f64, j as f64 / cols as f64).1;
                let kept = *first.entry(place(patch, i, j, rows, cols)).or_insert(normal);
                assert!(kept.dot(normal) > 0.995, "patch {patch} at {i}, {j}: {kept} {normal}");
            }
        }
    }

    #[test]
    fn patches_of_a_part_are_welded() {
        // Border edges (with one face) remain only at the rim's inner circle, the lid's edge, and the ends of handle and spout:
        // 4 quarter circles each of the first two, 2 halves of each of 4 ends.
        let (mesh, cols) = (tessellate(10), 6);
        let mut uses: HashMap<[u32; 2], usize> = HashMap::new();
        for [a, b, c] in &mesh.faces {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                *uses.entry([*a.min(b), *a.max(b)]).or_default() += 1;
            }
        }
        assert!(uses.values().all(|&n| n <= 2));
        assert_eq!(uses.values().filter(|&&n| n == 1).count(), (4 + 4 + 4 * 2) * cols);
    }

    #[test]
    fn the_area_settles_as_the_tessellation_refines() {
        let [coarse, fine] = [16, 32].map(|steps| tessellate(steps).area());
        assert!((fine / coarse - 1.0).abs() < 0.005, "{coarse} {fine}");
    }
}
