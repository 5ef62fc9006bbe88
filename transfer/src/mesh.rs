//! Triangle meshes.

use glam::Vec3;

/// Triangles over shared vertices. Normals are unit vectors, one per vertex, or none where the file had none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// One unit normal per vertex, or empty.
    pub normals: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
}
