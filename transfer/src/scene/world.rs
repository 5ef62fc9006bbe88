//! Objects of a material each, under a sky: what light travels through.
//!
//! Surfaces are one-sided. The front is where the corners of a face run counter-clockwise; the back is black.

use super::bvh::Occluders;
use super::environment::Environment;
use super::frames::Frame;
use super::material::Material;
use super::ray::Hit;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::texels::Border;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// A mesh of one material.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name; no other object of the world has it.
    pub name: String,
    /// Its surface. Without normals it is shaded flat.
    pub mesh: Mesh,
    /// Texture coordinates, one for each vertex, or empty.
    pub uv: Vec<Vec2>,
    /// How they go on beyond the edges of the unit square.
    pub border: Border,
    /// What it is made of.
    pub material: Material,
}

/// A point of the front of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is.
    pub position: Vec3,
    /// Unit normal of the face.
    pub geometric: Vec3,
    /// Unit normal for shading: interpolated between those of the vertices where there are any, else that of the face.
    pub normal: Vec3,
    /// Unit vector perpendicular to `normal`, x of the BRDF: where u of the texture grows, and by a rule on the normal where there is none.
    pub tangent: Vec3,
    /// Texture coordinates; zero where the object has none.
    pub uv: Vec2,
    /// Which object.
    pub object: u32,
}

impl SurfacePoint {
    /// The coordinates in which the BRDF is told.
    pub fn frame(&self) -> Frame {
        Frame { tangent: self.tangent, bitangent: self.normal.cross(self.tangent), normal: self.normal }
    }
}

/// Objects, a sky, and the hierarchy that rays are traced through.
pub struct World {
    objects: Vec<Object>,
    sky: Option<Environment>,
    mesh: Mesh,
    occluders: Occluders,
    /// The first face of each object in the merged mesh.
    starts: Vec<u32>,
}

impl World {
    /// Without a sky it is dark beyond the objects.
    ///
    /// # Errors
    /// No objects, two of one name, a mesh that fails [`Mesh::check`], texture coordinates that are not one a vertex or not finite, a
    /// material that fails [`Material::check`], and more faces or vertices than [`Occluders::new`] takes.
    pub fn new(objects: Vec<Object>, sky: Option<Environment>) -> Result<World> {
        if objects.is_empty() {
            let (what, found) = ("world".into(), "none".into());
            return Err(Error::Unsupported { what, expected: "at least one object".into(), found });
        }
        for (k, object) in objects.iter().enumerate() {
            check(object).map_err(|error| in_object(&object.name, &error))?;
            if objects[..k].iter().any(|other| other.name == object.name) {
                let (what, expected) = (format!("world: object {k}"), "a name of its own".into());
                return Err(Error::Unsupported { what, expected, found: object.name.clone() });
            }
        }
        let mesh = merge(&objects)?;
        let occluders = Occluders::new(&mesh)?;
        let starts = objects.iter().scan(0, |next, object| {
            let start = *next;
            *next += object.mesh.faces.len() as u32;
            Some(start)
        });
        let starts = starts.collect();
        Ok(World { objects, sky, mesh, occluders, starts })
    }

    /// The objects.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The light from beyond them.
    pub fn sky(&self) -> Option<&Environment> {
        self.sky.as_ref()
    }

    /// All objects in one mesh, faces and vertices in the order of the objects; without normals unless every object has them.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The hierarchy of the merged mesh.
    pub fn occluders(&self) -> &Occluders {
        &self.occluders
    }

    /// The object of a face of the merged mesh, and which of its own faces that is.
    pub fn place(&self, face: u32) -> (usize, u32) {
        // Objects without faces start where the next one does: the last of them has the face.
        let object = self.starts.partition_point(|&start| start <= face) - 1;
        (object, face - self.starts[object])
    }

    /// The point of an object's own face with weight `u` of its second corner and `v` of its third.
    ///
    /// # Panics
    /// Where there is no such object or face.
    pub fn point(&self, object: usize, face: u32, u: f32, v: f32) -> SurfacePoint {
        let Object { mesh, uv, .. } = &self.objects[object];
        let corners = mesh.faces[face as usize];
        let weights = [1.0 - u - v, u, v];
        let mix = |of: &[Vec3]| -> Vec3 { (0..3).map(|k| weights[k] * of[corners[k] as usize]).sum() };
        let flat = mesh.area_vector(corners).try_normalize().unwrap_or(DVec3::ZERO);
        let smooth = if mesh.normals.is_empty() { flat } else { mix(&mesh.normals).as_dvec3().normalize_or_zero() };
        // Vertex normals that cancel or lean to the back mean nothing; a face without area has nothing but them.
        let normal = if smooth.dot(flat) > 0.0 { smooth } else { flat };
        let normal = [normal, smooth].into_iter().find(|n| *n != DVec3::ZERO).unwrap_or(DVec3::Z);
        let geometric = if flat == DVec3::ZERO { normal } else { flat };
        let place = if uv.is_empty() { Vec2::ZERO } else { (0..3).map(|k| weights[k] * uv[corners[k] as usize]).sum() };
        SurfacePoint {
            position: mix(&mesh.positions),
            geometric: geometric.as_vec3(),
            normal: normal.as_vec3(),
            tangent: self.tangent(object, corners, normal),
            uv: place,
            object: object as u32,
        }
    }

    /// The point that a ray met.
    pub fn met(&self, hit: &Hit) -> SurfacePoint {
        let (object, face) = self.place(hit.face);
        self.point(object, face, hit.u, hit.v)
    }

    fn tangent(&self, object: usize, corners: [u32; 3], normal: DVec3) -> Vec3 {
        let Object { mesh, uv, .. } = &self.objects[object];
        let along_u =
            (!uv.is_empty()).then(|| along_u(mesh.corners(corners), corners.map(|v| uv[v as usize].as_dvec2())));
        let tangent = along_u.and_then(|t| t.try_normalize()?.reject_from_normalized(normal).try_normalize());
        tangent.map_or_else(|| Frame::by_axis(normal.as_vec3()).tangent, DVec3::as_vec3)
    }
}

/// ∂p/∂u over a face, of any length; zero where all corners have the same v.
fn along_u([a, b, c]: [DVec3; 3], [s, t, r]: [DVec2; 3]) -> DVec3 {
    // p - a = x (b - a) + y (c - a) and (u, v) - s = x (t - s) + y (r - s): Cramer's rule for the change of (x, y) with u.
    let (t, r) = (t - s, r - s);
    t.perp_dot(r).signum() * (r.y * (b - a) - t.y * (c - a))
}

fn check(object: &Object) -> Result<()> {
    object.mesh.check()?;
    if !object.uv.is_empty() {
        Error::expect_size("texture coordinates, one for each vertex", object.mesh.positions.len(), object.uv.len())?;
    }
    if let Some(vertex) = object.uv.iter().position(|uv| !uv.is_finite()) {
        return Err(Error::Unsupported {
            what: format!("texture coordinates of vertex {vertex}"),
            expected: "finite numbers".into(),
            found: object.uv[vertex].to_string(),
        });
    }
    object.material.check()
}

fn in_object(name: &str, error: &Error) -> Error {
    Error::Unsupported {
        what: format!("object '{name}'"),
        expected: "one that can be lit".into(),
        found: error.to_string(),
    }
}

fn merge(objects: &[Object]) -> Result<Mesh> {
    let vertices: u64 = objects.iter().map(|object| object.mesh.positions.len() as u64).sum();
    if vertices > u64::from(u32::MAX) {
        return Err(Error::TooLarge { what: "vertices of a world".into(), limit: u32::MAX.into(), found: vertices });
    }
    let smooth = objects.iter().all(|object| object.mesh.normals.len() == object.mesh.positions.len());
    let mut merged = Mesh::default();
    for Object { mesh, .. } in objects {
        let first = merged.positions.len() as u32;
        merged.positions.extend(&mesh.positions);
        merged.normals.extend(mesh.normals.iter().filter(|_| smooth));
        merged.faces.extend(mesh.faces.iter().map(|face| face.map(|v| first + v)));
    }
    Ok(merged)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    fn object(name: &str, mesh: Mesh) -> Object {
        Object {
            name: name.into(),
            mesh,
            uv: Vec::new(),
            border: Border::Clamp,
            material: Material::grey("lambert".parse().unwrap()),
        }
    }

    /// A triangle in the plane z = 0, its corners (0, 0), (2, 0), (0, 1).
    fn triangle() -> Mesh {
        let positions = vec![Vec3::ZERO, 2.0 * Vec3::X, Vec3::Y];
        Mesh { positions, normals: Vec::new(), faces: vec![[0, 1, 2]] }
    }

    #[test]
    fn every_face_of_the_merged_mesh_is_found_at_its_object() {
        let empty = Mesh::default();
        let meshes = [empty.clone(), triangle(), shapes::sphere(2), empty.clone(), triangle(), empty];
        let objects = meshes.iter().enumerate().map(|(k, mesh)| object(&k.to_string(), mesh.clone())).collect();
        let world = World::new(objects, None).unwrap();
        let mut places = (0..).map(|face| world.place(face));
        for (k, mesh) in meshes.iter().enumerate() {
            for own in 0..mesh.faces.len() as u32 {
                assert_eq!(places.next().unwrap(), (k, own));
                let corners = world.mesh().corners(world.mesh().faces[world.starts[k] as usize + own as usize]);
                assert_eq!(corners, mesh.corners(mesh.faces[own as usize]));
                assert_eq!(world.point(k, own, 0.0, 1.0).position.as_dvec3(), corners[2]);
            }
        }
        assert_eq!(world.occluders().faces(), world.mesh().faces.len());
        assert!(world.mesh().normals.is_empty() && world.sky().is_none());
    }

    #[test]
    fn points_of_a_face_have_its_normal_and_the_mixture_of_its_corners() {
        let mut textured = object("a", triangle());
        // u grows along +y, v along -x.
        textured.uv = vec![Vec2::new(0.0, 1.0), Vec2::ZERO, Vec2::ONE];
        let mut smooth = object("b", triangle());
        smooth.mesh.normals = vec![Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::Z];
        let world = World::new(vec![textured, smooth], None).unwrap();
        let point = world.point(0, 0, 0.25, 0.5);
        assert_eq!(point.position, Vec3::new(0.5, 0.5, 0.0));
        assert_eq!([point.geometric, point.normal, point.tangent], [Vec3::Z, Vec3::Z, Vec3::Y]);
        assert_eq!((point.uv, point.object), (Vec2::new(0.5, 0.75), 0));
        let point = world.point(1, 0, 0.5, 0.0);
        assert!((point.normal - Vec3::new(0.3, 0.0, 0.9).normalize()).length() < 1e-6);
        assert!(point.tangent.dot(point.normal).abs() < 1e-6 && point.geometric == Vec3::Z);
        let frame = point.frame();
        assert!((frame.tangent.cross(frame.bitangent) - frame.normal).length() < 1e-6);
    }

    #[test]
    fn faces_without_area_and_normals_without_meaning_give_unit_vectors() {
        let line = Mesh { positions: vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X, Vec3::X], ..triangle() };
        let dot = Mesh { faces: vec![[1, 3, 1]], ..line.clone() };
        let backward = Mesh { normals: vec![Vec3::NEG_Z; 3], ..triangle() };
        let cancelled = Mesh { normals: vec![Vec3::X, Vec3::NEG_X, Vec3::ZERO], ..triangle() };
        let upright = Mesh { normals: vec![Vec3::Y; 4], ..line.clone() };
        for (k, mesh) in [line, dot, backward, cancelled, upright].into_iter().enumerate() {
            let uv = vec![Vec2::ONE; mesh.positions.len()];
            let world = World::new(vec![Object { uv, ..object("a", mesh) }], None).unwrap();
            let point = world.point(0, 0, 0.5, 0.0);
            for unit in [point.geometric, point.normal, point.tangent] {
                assert!(unit.is_normalized(), "{k}: {point:?}");
            }
            assert!(point.normal.dot(point.geometric) > 0.0, "{k}: {point:?}");
        }
    }

    #[test]
    fn what_cannot_be_lit_is_refused_with_its_name() {
        let refused = |objects: Vec<Object>, part: &str| {
            let message = World::new(objects, None).err().unwrap().to_string();
            assert!(message.contains(part), "{message}");
        };
        refused(Vec::new(), "at least one object");
        refused(vec![object("lamp", triangle()), object("lamp", triangle())], "name of its own, found lamp");
        refused(vec![Object { uv: vec![Vec2::ZERO; 2], ..object("b", triangle()) }], "expected 3, found 2");
        refused(vec![Object { uv: vec![Vec2::ZERO, Vec2::NAN, Vec2::ZERO], ..object("b", triangle()) }], "vertex 1");
        refused(vec![object("c", Mesh { faces: vec![[0, 1, 3]], ..triangle() })], "object 'c'");
        let bright = Material { specular: 2.0 * Vec3::ONE, ..Material::grey("lambert".parse().unwrap()) };
        refused(vec![Object { material: bright, ..object("d", triangle()) }], "specular");
    }
}
