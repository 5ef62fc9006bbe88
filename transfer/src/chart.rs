//! Charts: a surface laid out in the unit square of its texture coordinates.

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::texels::Border;
use glam::Vec2;

/// How far beyond the unit square a texture coordinate may be: what files round.
const TOLERANCE: f32 = 1e-6;

/// A mesh whose surface is laid out in the unit square: the texture space of Miandji, Kronander and Unger, "Geometry
/// Independent Surface Light Fields for Real Time Rendering of Precomputed Global Illumination" (2011), section 3.1.
/// A surface that is cut open has two vertices where it is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Charted {
    /// The surface.
    pub mesh: Mesh,
    /// One place in \[0, 1\]² for each vertex; the chart is linear on each face.
    pub uv: Vec<Vec2>,
    /// How the surface goes on beyond the edges of the square.
    pub border: Border,
}

impl Charted {
    /// A mesh and its texture coordinates; those beyond the square by no more than rounding are taken to its edge.
    ///
    /// # Errors
    /// Those of [`Charted::check`].
    pub fn new(mesh: Mesh, uv: Vec<Vec2>, border: Border) -> Result<Charted> {
        let mut charted = Charted { mesh, uv, border };
        charted.check()?;
        charted.uv.iter_mut().for_each(|uv| *uv = uv.clamp(Vec2::ZERO, Vec2::ONE));
        Ok(charted)
    }

    /// Refuses a mesh that [`Mesh::check`] refuses or that has no face, a number of texture coordinates that is not that of
    /// the vertices, and those that are not numbers or not in the unit square, by the number of the vertex.
    pub fn check(&self) -> Result<()> {
        self.mesh.check()?;
        if self.mesh.faces.is_empty() {
            return Err(refused("mesh".into(), "at least one face", "none".into()));
        }
        Error::expect_size("texture coordinates of vertices", self.mesh.positions.len(), self.uv.len())?;
        let inside = |t: f32| (-TOLERANCE..=1.0 + TOLERANCE).contains(&t);
        match self.uv.iter().position(|uv| !(inside(uv.x) && inside(uv.y))) {
            None => Ok(()),
            Some(vertex) => {
                let what = format!("texture coordinates of vertex {vertex}");
                Err(refused(what, "two numbers from 0 to 1", self.uv[vertex].to_string()))
            }
        }
    }

    /// The point of the chart that has these weights of a face's second and third corner.
    ///
    /// # Panics
    /// Where there is no such face.
    pub fn uv_at(&self, face: u32, u: f32, v: f32) -> Vec2 {
        let [a, b, c] = self.mesh.faces[face as usize].map(|vertex| self.uv[vertex as usize]);
        (1.0 - u - v) * a + u * b + v * c
    }

    /// The least and the greatest ratio, over the faces, of a face's share of the area of the surface to its share of the area
    /// of the chart: 1 and 1 where all texels are of one area. Faces without area in the chart have no texels and are left out;
    /// without any other, these are infinity and 0.
    pub fn distortion(&self) -> [f64; 2] {
        let in_chart = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| self.uv[v as usize].as_dvec2());
            0.5 * (b - a).perp_dot(c - a).abs()
        };
        let faces = &self.mesh.faces;
        let scale = faces.iter().map(in_chart).sum::<f64>() / self.mesh.area();
        faces.iter().filter(|face| in_chart(face) > 0.0).fold([f64::INFINITY, 0.0], |[least, greatest], face| {
            let ratio = scale * self.mesh.area_vector(*face).length() / in_chart(face);
            [least.min(ratio), greatest.max(ratio)]
        })
    }
}

pub(crate) fn refused(what: String, expected: &str, found: String) -> Error {
    Error::Unsupported { what, expected: expected.into(), found }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn triangle() -> (Mesh, Vec<Vec2>) {
        let mesh = Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], normals: Vec::new(), faces: vec![[0, 1, 2]] };
        (mesh, vec![Vec2::ZERO, Vec2::X, Vec2::Y])
    }

    #[test]
    fn what_is_no_chart_is_refused_by_the_number_of_the_vertex() {
        let refused = |change: fn(&mut Mesh, &mut Vec<Vec2>)| {
            let (mut mesh, mut uv) = triangle();
            change(&mut mesh, &mut uv);
            Charted::new(mesh, uv, Border::Clamp).unwrap_err().to_string()
        };
        let outside = refused(|_, uv| uv[2].y = 1.5);
        assert_eq!(outside, "texture coordinates of vertex 2: expected two numbers from 0 to 1, found [0, 1.5]");
        assert!(
            refused(|_, uv| uv[1].x = f32::NAN).contains("vertex 1: expected two numbers from 0 to 1, found [NaN, 0]")
        );
        assert!(refused(|_, uv| uv[0].x = -2e-6).contains("vertex 0"));
        assert!(refused(|_, uv| uv.clear()).contains("texture coordinates of vertices: expected 3, found 0"));
        assert!(refused(|mesh, _| mesh.faces.clear()).contains("expected at least one face, found none"));
        assert!(refused(|mesh, _| mesh.faces[0][1] = 7).contains("face 0"));
    }

    #[test]
    fn rounding_beyond_the_square_is_taken_to_its_edge() {
        let (mesh, mut uv) = triangle();
        uv[0].y = -5e-7;
        uv[1].x = 1.0 + 5e-7;
        let charted = Charted::new(mesh, uv, Border::Clamp).unwrap();
        assert_eq!(charted.uv, triangle().1);
    }

    #[test]
    fn distortion_compares_shares_of_area_and_passes_over_faces_that_are_flat_in_the_chart() {
        // Two triangles of areas 1/2 and 3/2 that have one area in the chart.
        let (mut mesh, mut uv) = triangle();
        mesh.positions.push(Vec3::new(0.0, 0.0, 3.0));
        uv.push(Vec2::ONE);
        mesh.faces.push([0, 3, 1]);
        uv[3] = Vec2::new(0.0, 1.0);
        let charted = Charted::new(mesh, uv, Border::Clamp).unwrap();
        let [least, greatest] = charted.distortion();
        assert!((least - 0.5).abs() < 1e-12 && (greatest - 1.5).abs() < 1e-12, "{least} {greatest}");
        let flat = Charted { uv: vec![Vec2::ZERO; 4], ..charted };
        assert_eq!(flat.distortion(), [f64::INFINITY, 0.0]);
    }
}
