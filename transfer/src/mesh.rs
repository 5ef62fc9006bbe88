//! Triangle meshes.

use crate::error::{Error, Result};
use glam::{DVec3, Vec3};

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

impl Mesh {
    /// The corners of the smallest axis-aligned box around all vertices; `None` without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p))))
    }

    /// The diagonal of [`Mesh::bounds`], in units of the positions; 0 without vertices.
    pub fn extent(&self) -> f32 {
        self.bounds().map_or(0.0, |(low, high)| (high.as_dvec3() - low.as_dvec3()).length() as f32)
    }

    /// The corners of a face, in f64 so that areas of small faces keep their digits.
    pub fn corners(&self, face: [u32; 3]) -> [DVec3; 3] {
        face.map(|v| self.positions[v as usize].as_dvec3())
    }

    /// Normal of a face, of the face's area as length, outward where the corners run counter-clockwise.
    pub fn area_vector(&self, face: [u32; 3]) -> DVec3 {
        let [a, b, c] = self.corners(face);
        0.5 * (b - a).cross(c - a)
    }

    /// Area of all faces, in squared units of the positions.
    pub fn area(&self) -> f64 {
        self.faces.iter().map(|&f| self.area_vector(f).length()).sum()
    }

    /// Volume that the faces enclose (divergence theorem), positive where they face outward. For an open mesh it is the
    /// volume of the cone from the origin and means nothing.
    pub fn volume(&self) -> f64 {
        self.faces.iter().map(|&f| self.corners(f)[0].dot(self.area_vector(f)) / 3.0).sum()
    }

    /// Refuses what no algorithm here can work with: face indices beyond the vertices, positions or normals that are
    /// NaN or infinite, and a number of normals that is neither 0 nor that of the positions. Each error names the face
    /// or the vertex.
    pub fn check(&self) -> Result<()> {
        if !self.normals.is_empty() {
            Error::expect_size("vertex normals", self.positions.len(), self.normals.len())?;
        }
        self.check_positions()?;
        check_finite("normal", &self.normals)?;
        self.check_faces()
    }

    /// Refuses vertices with NaN or infinite positions, by number.
    pub(crate) fn check_positions(&self) -> Result<()> {
        check_finite("position", &self.positions)
    }

    /// Refuses faces with an index beyond the vertices, by number.
    pub(crate) fn check_faces(&self) -> Result<()> {
        let vertices = self.positions.len();
        let beyond = |face: &[u32; 3]| face.iter().copied().find(|&v| v as usize >= vertices);
        match self.faces.iter().enumerate().find_map(|(i, face)| Some((i, beyond(face)?))) {
            None => Ok(()),
            Some((face, vertex)) => Err(Error::Unsupported {
                what: format!("mesh: face {face}"),
                expected: format!("vertex indices below {vertices}"),
                found: vertex.to_string(),
            }),
        }
    }

    /// The mesh with every position and normal taken through a rotation.
    pub fn turned(mut self, rotation: impl Fn(Vec3) -> Vec3) -> Mesh {
        self.positions.iter_mut().chain(&mut self.normals).for_each(|v| *v = rotation(*v));
        self
    }

    /// The mesh moved and scaled (without distortion) so that its bounds are centred on the origin and the longest side
    /// runs from -1 to 1.
    pub fn fitted(mut self) -> Mesh {
        if let Some((low, high)) = self.bounds() {
            let (centre, scale) = (0.5 * (low + high), 2.0 / (high - low).max_element());
            self.positions.iter_mut().for_each(|p| *p = (*p - centre) * scale);
        }
        self
    }
}

fn check_finite(what: &str, vectors: &[Vec3]) -> Result<()> {
    match vectors.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(vertex) => Err(Error::Unsupported {
            what: format!("mesh: {what} of vertex {vertex}"),
            expected: "finite numbers".into(),
            found: vectors[vertex].to_string(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tetrahedron of the origin and the unit points of the axes.
    fn tetrahedron() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            normals: Vec::new(),
            faces: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        }
    }

    #[test]
    fn a_tetrahedron_has_its_area_volume_and_bounds() {
        let mesh = tetrahedron();
        mesh.check().unwrap();
        assert!((mesh.area() - (1.5 + 0.75_f64.sqrt())).abs() < 1e-12);
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-12);
        assert_eq!(mesh.bounds(), Some((Vec3::ZERO, Vec3::ONE)));
        assert_eq!(Mesh::default().bounds(), None);
        assert_eq!(Mesh::default().extent(), 0.0);
    }

    #[test]
    fn volume_does_not_depend_on_the_place_of_a_closed_mesh() {
        let mut mesh = tetrahedron();
        mesh.positions.iter_mut().for_each(|p| *p += Vec3::new(4.0, -8.0, 16.0));
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn fitted_meshes_fill_the_unit_cube_along_their_longest_side() {
        let mut mesh = tetrahedron();
        mesh.positions.iter_mut().for_each(|p| *p = *p * Vec3::new(3.0, 5.0, 1.0) + 7.0);
        let (low, high) = mesh.fitted().bounds().unwrap();
        assert!((low + Vec3::new(0.6, 1.0, 0.2)).length() < 1e-6 && (high + low).length() < 1e-6, "{low} {high}");
    }

    #[test]
    fn the_check_names_the_face_or_the_vertex() {
        let refused = |change: fn(&mut Mesh)| {
            let mut mesh = tetrahedron();
            change(&mut mesh);
            mesh.check().unwrap_err().to_string()
        };
        assert_eq!(refused(|m| m.faces[2][1] = 4), "mesh: face 2: expected vertex indices below 4, found 4");
        assert!(refused(|m| m.positions[3].y = f32::NAN).contains("position of vertex 3"));
        assert!(refused(|m| m.normals = vec![Vec3::X; 3]).contains("expected 4, found 3"));
        assert!(refused(|m| m.normals = vec![Vec3::INFINITY; 4]).contains("normal of vertex 0"));
    }
}
