//! Mesh repair: what would spoil rays, frames or samples is mended, counted and said.

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use glam::{DVec3, Vec3};
use std::collections::HashSet;
use std::fmt;

/// A face is degenerate where its height over its longest side is below this fraction of that side: positions are f32,
/// and so flat a face has no normal that could be trusted.
const FLATNESS: f64 = 1e-7;

/// How far a squared length may be from 1 before a normal counts as not of unit length. Files store six or more digits.
const UNIT: f64 = 1e-4;

/// What [`repair`] did to a mesh, counted by kind. Prints as one sentence that says only what happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Faces dropped because two corners coincide or all three lie on a line.
    pub degenerate_faces: usize,
    /// Faces dropped because an earlier face has the same three vertices, in whatever order.
    pub duplicate_faces: usize,
    /// Vertices dropped because no remaining face uses them: each would have become a sample of no surface.
    pub unused_vertices: usize,
    /// Normals computed from the faces, where the mesh had none, or zero, NaN or infinite ones.
    pub computed_normals: usize,
    /// Normals scaled to unit length.
    pub scaled_normals: usize,
}

impl fmt::Display for Repairs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let say = |count: usize, verb: &str, one: &str, many: &str| match count {
            0 => None,
            1 => Some(format!("{verb} 1 {one}")),
            n => Some(format!("{verb} {n} {many}")),
        };
        let said: Vec<String> = [
            say(self.degenerate_faces, "dropped", "degenerate face", "degenerate faces"),
            say(self.duplicate_faces, "dropped", "duplicate face", "duplicate faces"),
            say(self.unused_vertices, "dropped", "unused vertex", "unused vertices"),
            say(self.computed_normals, "computed", "normal", "normals"),
            say(self.scaled_normals, "scaled", "normal to unit length", "normals to unit length"),
        ]
        .into_iter()
        .flatten()
        .collect();
        match said.as_slice() {
            [] => f.write_str("nothing to repair"),
            [one] => f.write_str(one),
            [first @ .., last] => write!(f, "{} and {last}", first.join(", ")),
        }
    }
}

/// Mends a mesh and counts what it did; repairing the result again changes nothing.
///
/// Faces keep their order and vertices theirs; vertices that share a position are never merged, so that a sound
/// file's vertex i is sample i. Missing normals are those of the faces around the vertex, weighted by their
/// angle there, so that the tessellation does not show; split vertices get those of their own side.
///
/// # Errors
/// Damage that cannot be mended without guessing: face indices beyond the vertices, NaN or infinite positions (with the
/// number of the face or the vertex), a wrong number of normals, and a mesh of which no face is left.
pub fn repair(mut mesh: Mesh) -> Result<(Mesh, Repairs)> {
    if !mesh.normals.is_empty() {
        Error::expect_size("vertex normals", mesh.positions.len(), mesh.normals.len())?;
    }
    mesh.check_positions()?;
    mesh.check_faces()?;
    let mut repairs = Repairs {
        degenerate_faces: drop_degenerate(&mut mesh),
        duplicate_faces: drop_duplicates(&mut mesh),
        ..Default::default()
    };
    if mesh.faces.is_empty() {
        return Err(Error::Unsupported {
            what: "mesh".into(),
            expected: "at least one face with an area".into(),
            found: repairs.to_string(),
        });
    }
    repairs.unused_vertices = drop_unused(&mut mesh);
    repairs.scaled_normals = scale_normals(&mut mesh.normals);
    repairs.computed_normals = compute_normals(&mut mesh);
    Ok((mesh, repairs))
}

/// Scales normals to unit length; those without a usable direction become zero, to be computed later.
fn scale_normals(normals: &mut [Vec3]) -> usize {
    let mut scaled = 0;
    for normal in normals {
        let length_squared = normal.as_dvec3().length_squared();
        if !(length_squared.is_finite() && length_squared > 1e-60) {
            *normal = Vec3::ZERO;
        } else if (length_squared - 1.0).abs() > UNIT {
            *normal = (normal.as_dvec3() / length_squared.sqrt()).as_vec3();
            scaled += 1;
        }
    }
    scaled
}

fn drop_degenerate(mesh: &mut Mesh) -> usize {
    let before = mesh.faces.len();
    let mut faces = std::mem::take(&mut mesh.faces);
    faces.retain(|&face| {
        let [a, b, c] = mesh.corners(face);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        2.0 * mesh.area_vector(face).length() > FLATNESS * longest
    });
    mesh.faces = faces;
    before - mesh.faces.len()
}

fn drop_duplicates(mesh: &mut Mesh) -> usize {
    let before = mesh.faces.len();
    let mut seen = HashSet::with_capacity(before);
    mesh.faces.retain(|face| {
        let mut key = *face;
        key.sort_unstable();
        seen.insert(key)
    });
    before - mesh.faces.len()
}

fn drop_unused(mesh: &mut Mesh) -> usize {
    let mut used = vec![false; mesh.positions.len()];
    mesh.faces.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut number = 0;
    let renumbered: Vec<u32> = used
        .iter()
        .map(|&used| {
            number += u32::from(used);
            number.wrapping_sub(1)
        })
        .collect();
    let dropped = used.len() - number as usize;
    if dropped > 0 {
        let mut keep = used.iter();
        mesh.positions.retain(|_| *keep.next().unwrap_or(&false));
        let mut keep = used.iter();
        mesh.normals.retain(|_| *keep.next().unwrap_or(&false));
        mesh.faces.iter_mut().flatten().for_each(|v| *v = renumbered[*v as usize]);
    }
    dropped
}

/// Fills in the normals that are missing or zero.
fn compute_normals(mesh: &mut Mesh) -> usize {
    mesh.normals.resize(mesh.positions.len(), Vec3::ZERO);
    let missing = mesh.normals.iter().filter(|n| **n == Vec3::ZERO).count();
    if missing == 0 {
        return 0;
    }
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    let mut firsts = vec![DVec3::ZERO; mesh.positions.len()];
    for &face in &mesh.faces {
        let (corners, normal) = (mesh.corners(face), mesh.area_vector(face).normalize());
        for (i, &v) in face.iter().enumerate() {
            let (p, next, previous) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
            sums[v as usize] += (next - p).angle_between(previous - p) * normal;
            if firsts[v as usize] == DVec3::ZERO {
                firsts[v as usize] = normal;
            }
        }
    }
    for (normal, (sum, first)) in mesh.normals.iter_mut().zip(sums.iter().zip(&firsts)) {
        if *normal == Vec3::ZERO {
            // Faces that cancel (both sides of a sheet on the same vertices) leave no sum: the first face decides.
            let direction = if sum.length() > 1e-6 { sum.normalize() } else { *first };
            *normal = direction.as_vec3();
        }
    }
    missing
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            normals: vec![Vec3::Z; 4],
            faces: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    #[test]
    fn a_sound_mesh_is_returned_bit_for_bit() {
        let (mesh, repairs) = repair(square()).unwrap();
        assert_eq!(mesh, square());
        assert_eq!(repairs.to_string(), "nothing to repair");
    }

    #[test]
    fn every_kind_of_damage_is_counted_as_what_it_is() {
        let mut mesh = square();
        mesh.positions.extend([Vec3::splat(9.0), Vec3::new(0.5, 0.0, 0.0)]);
        mesh.normals.extend([Vec3::Z, Vec3::Z]);
        mesh.normals[1] = Vec3::Z * 2.0;
        mesh.normals[3] = Vec3::ZERO;
        // Vertex 4 belongs to no face; vertex 5 lies on the line from 0 to 1.
        mesh.faces.extend([[1, 1, 2], [0, 5, 1], [2, 0, 1], [2, 0, 3], [3, 2, 0]]);
        let (mesh, repairs) = repair(mesh).unwrap();
        let expected = Repairs {
            degenerate_faces: 2,
            duplicate_faces: 3,
            unused_vertices: 2,
            computed_normals: 1,
            scaled_normals: 1,
        };
        assert_eq!(repairs, expected);
        assert_eq!(mesh, square());
        assert_eq!(
            repairs.to_string(),
            "dropped 2 degenerate faces, dropped 3 duplicate faces, dropped 2 unused vertices, \
             computed 1 normal and scaled 1 normal to unit length"
        );
    }

    #[test]
    fn vertices_that_share_a_position_stay_apart() {
        let mut mesh = square();
        mesh.positions.extend([Vec3::ZERO, Vec3::X, Vec3::Z]);
        mesh.normals.extend([Vec3::NEG_Y; 3]);
        mesh.faces.push([4, 5, 6]);
        let (kept, repairs) = repair(mesh.clone()).unwrap();
        assert_eq!((kept, repairs), (mesh.clone(), Repairs::default()));
        // Without normals, the split vertices get those of their own side.
        let normals = std::mem::take(&mut mesh.normals);
        let (computed, repairs) = repair(mesh).unwrap();
        assert_eq!((computed.normals, repairs.computed_normals), (normals, 7));
    }

    #[test]
    fn computed_normals_do_not_depend_on_how_a_side_is_cut() {
        // A cube's corner: three squares, of which one contributes two triangles, meet under equal angles.
        let (o, x, y, z) = (Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z);
        let mesh = Mesh {
            positions: vec![o, x, y, z, x + y],
            normals: Vec::new(),
            faces: vec![[0, 4, 1], [0, 2, 4], [0, 1, 3], [0, 3, 2]],
        };
        let (mesh, _) = repair(mesh).unwrap();
        assert!((mesh.normals[0] - Vec3::splat(-1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn both_sides_of_a_sheet_leave_a_unit_normal() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.0, 0.0, 1e-9)],
            normals: Vec::new(),
            faces: vec![[0, 1, 2], [3, 2, 1]],
        };
        let (mesh, _) = repair(mesh).unwrap();
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
    }

    #[test]
    fn damage_beyond_repair_is_refused_with_its_place() {
        let refused = |change: fn(&mut Mesh)| {
            let mut mesh = square();
            change(&mut mesh);
            repair(mesh).unwrap_err().to_string()
        };
        assert!(refused(|m| m.positions[2].z = f32::INFINITY).contains("vertex 2"));
        assert!(refused(|m| m.faces[1] = [0, 7, 1]).contains("face 1: expected vertex indices below 4, found 7"));
        assert!(refused(|m| m.normals.truncate(1)).contains("expected 4, found 1"));
        assert!(refused(|m| m.faces = vec![[0, 0, 1]]).contains("dropped 1 degenerate face"));
        assert!(refused(|m| *m = Mesh::default()).contains("at least one face"));
    }

    proptest! {
        #[test]
        fn repairing_twice_is_repairing_once(
            cells in prop::collection::vec((0..3i8, 0..3i8, 0..2i8), 3..12),
            normals in prop::option::of(prop::collection::vec((-2..3i8, -2..3i8, -2..3i8), 12)),
            faces in prop::collection::vec((0..12u32, 0..12u32, 0..12u32), 1..20),
        ) {
            let vector = |&(x, y, z): &(i8, i8, i8)| Vec3::new(x.into(), y.into(), z.into());
            let n = cells.len();
            let mesh = Mesh {
                positions: cells.iter().map(vector).collect(),
                normals: normals.map_or(Vec::new(), |list| list[..n].iter().map(vector).collect()),
                faces: faces.iter().map(|&(a, b, c)| [a, b, c].map(|v| v % n as u32)).collect(),
            };
            if let Ok((once, _)) = repair(mesh) {
                once.check().unwrap();
                prop_assert!(once.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4));
                let (twice, repairs) = repair(once.clone()).unwrap();
                prop_assert_eq!(repairs, Repairs::default());
                prop_assert_eq!(twice, once);
            }
        }
    }
}
