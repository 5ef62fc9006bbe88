//! Triangle meshes, `.ply` and `.obj`.
//!
//! Polygons become fans of triangles around their first vertex. Normals are kept where every vertex has one of non-zero
//! length, scaled to length 1; otherwise the mesh has none. Positions must be finite. Faces are kept as they are, degenerate
//! ones included: repair is the caller's.

use super::{broken, bytes_of, extension, obj, ply, unknown_extension};
use crate::chart::Charted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::texels::Border;
use glam::{Vec2, Vec3};
use std::path::Path;

/// Reads `.ply` or `.obj`.
pub fn read(path: impl AsRef<Path>) -> Result<Mesh> {
    either(path.as_ref(), read_ply, read_obj)
}

/// Reads `.ply` or `.obj` with texture coordinates: a chart that ends at the edges of the unit square, which it must not leave.
/// Nothing is flipped: u is the first coordinate, v the second, as the file has them.
pub fn read_charted(path: impl AsRef<Path>) -> Result<Charted> {
    either(path.as_ref(), read_charted_ply, read_charted_obj)
}

type Parser<T> = fn(&[u8]) -> Result<T>;

fn either<T>(path: &Path, ply: Parser<T>, obj: Parser<T>) -> Result<T> {
    let parse = match extension(path).as_str() {
        "ply" => ply,
        "obj" => obj,
        _ => return Err(unknown_extension(path, "mesh file extension", ".ply, .obj")),
    };
    parse(&bytes_of(path)?).map_err(|e| e.in_file(path))
}

/// Reads PLY 1.0: ascii, binary little- and big-endian; elements `vertex` (x, y, z and perhaps nx, ny, nz of any scalar
/// type) and `face` (a list `vertex_indices` or `vertex_index`). Other elements and properties are skipped.
pub fn read_ply(bytes: &[u8]) -> Result<Mesh> {
    ply::read(bytes)
}

/// Reads Wavefront OBJ: `v`, `vn` and `f`, indices from the end included. Groups, objects, materials and texture
/// coordinates are skipped; a vertex used with several normals becomes several vertices.
pub fn read_obj(bytes: &[u8]) -> Result<Mesh> {
    obj::read(bytes)
}

/// [`read_ply`] of vertices with the scalar properties s, t or u, v or texture_u, texture_v. Texture coordinates that are
/// lists of faces are not read.
pub fn read_charted_ply(bytes: &[u8]) -> Result<Charted> {
    ply::read_charted(bytes)
}

/// [`read_obj`] with `vt`, of which every corner of every face has one; a vertex used with several of them, or with several
/// normals, becomes several vertices.
pub fn read_charted_obj(bytes: &[u8]) -> Result<Charted> {
    obj::read_charted(bytes)
}

/// The one door of both readers: checks indices and positions, scales normals.
pub(super) fn build(
    format: &'static str,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
) -> Result<Mesh> {
    if let Some(at) = positions.iter().position(|p| !p.is_finite()) {
        return Err(broken(format, format!("vertex {at}"), "finite coordinates", positions[at].to_string()));
    }
    let outside = |face: &[u32; 3]| face.iter().any(|&v| v as usize >= positions.len());
    if let Some(at) = faces.iter().position(outside) {
        let limit = format!("indices below {}", positions.len());
        return Err(broken(format, format!("triangle {at}"), limit, format!("{:?}", faces[at])));
    }
    if !normals.is_empty() {
        Error::expect_size("normals beside positions", positions.len(), normals.len())?;
    }
    let units: Option<Vec<Vec3>> = normals.into_iter().map(Vec3::try_normalize).collect();
    Ok(Mesh { positions, normals: units.unwrap_or_default(), faces })
}

/// The mesh with its texture coordinates, of which there are none or as many as vertices.
pub(super) fn chart(format: &'static str, mesh: Mesh, uv: Vec<Vec2>) -> Result<Charted> {
    if uv.is_empty() { Err(without_chart(format)) } else { Charted::new(mesh, uv, Border::Clamp) }
}

pub(super) fn without_chart(format: &'static str) -> Error {
    let expected = "texture coordinates (vt in f v/vt/vn of .obj, s t or u v of .ply vertices)";
    broken(format, "vertices", expected, "none; unwrap the mesh in a modelling program and export it with them")
}

/// Triangles of a polygon around its first vertex; none for fewer than three.
pub(super) fn fan(polygon: &[u32], faces: &mut Vec<[u32; 3]>) {
    if let [first, rest @ ..] = polygon {
        faces.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
    }
}
