//! Mesh repair: what would spoil rays, frames or samples is mended, counted and said.

use crate::chart::Charted;
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
pub fn repair(mesh: Mesh) -> Result<(Mesh, Repairs)> {
    repair_beside(mesh, &mut Vec::<()>::new())
}

impl Charted {
    /// [`repair`] of the mesh, with the chart kept. Vertices on both sides of a cut stay apart; where normals are computed, each has
    /// that of its own side.
    ///
    /// # Errors
    /// Those of [`repair`] and of [`Charted::check`].
    pub fn repaired(mut self) -> Result<(Charted, Repairs)> {
        Error::expect_size("texture coordinates of vertices", self.mesh.positions.len(), self.uv.len())?;
        let (mesh, repairs) = repair_beside(self.mesh, &mut self.uv)?;
        Ok((Charted::new(mesh, self.uv, self.border)?, repairs))
    }
}

/// Also drops what `beside` has of the vertices that are dropped.
fn repair_beside<T>(mut mesh: Mesh, beside: &mut Vec<T>) -> Result<(Mesh, Repairs)> {
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
    repairs.unused_vertices = drop_unused(&mut mesh, beside);
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
    faces.retain(|&face| !is_degenerate(mesh, face));
    mesh.faces = faces;
    before - mesh.faces.len()
}

/// Whether two corners of a face coincide or all three lie on a line.
pub(crate) fn is_degenerate(mesh: &Mesh, face: [u32; 3]) -> bool {
    let [a, b, c] = mesh.corners(face);
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    2.0 * mesh.area_vector(face).length() <= FLATNESS * longest
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

fn drop_unused<T>(mesh: &mut Mesh, beside: &mut Vec<T>) -> usize {
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
        keep(&mut mesh.positions, &used);
        keep(&mut mesh.normals, &used);
        keep(beside, &used);
        mesh.faces.iter_mut().flatten().for_each(|v| *v = renumbered[*v as usize]);
    }
    dropped
}

/// Keeps of a list, which may be empty, what has a `true` beside it.
fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    list.retain(|_| *kept.next().unwrap_or(&false));
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
mod tests;
