//! Vertex frames that vary smoothly over the surface.
//!
//! Local directions are told in a vertex's own frame, so a frame that jumps between neighbours makes neighbouring rows
//! of the transfer matrix differ although the surface does not. No rule that looks at one normal alone can avoid jumps
//! (a continuous tangent field on a sphere does not exist); frames are therefore aligned from neighbour to neighbour.
//!
//! With R_ij the rotation that takes normal i to normal j the shortest way (discrete parallel transport), the tangents
//! minimise Σ over edges |t_j − R_ij t_i|²: a spanning tree gives the start, diffusion and Gauss-Seidel sweeps do the
//! rest. Flat scenes get exactly one frame a wall; on curved parts what twist the curvature forces is spread over the
//! surface, and the unavoidable singular points stay points. The energy is that of Knöppel, Crane, Pinkall and
//! Schröder, "Globally Optimal Direction Fields" (2013), for unit vectors; the minimum found is local.

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use glam::{DVec2, DVec3, Vec3};
use std::collections::{HashMap, VecDeque};

/// Sweeps of diffusion before the descent.
const DIFFUSIONS: usize = 200;

/// Most sweeps of the descent.
const SWEEPS: usize = 200;

/// The descent stops once a sweep lowers the energy by less than this fraction.
const SETTLED: f64 = 1e-3;

/// Over-relaxation of the descent: 1 would be plain Gauss-Seidel, and 2 no descent any more.
const RELAXATION: f64 = 1.6;

/// An orthonormal right-handed frame: `tangent × bitangent = normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x.
    pub tangent: Vec3,
    /// Local y.
    pub bitangent: Vec3,
    /// Local z, the vertex normal.
    pub normal: Vec3,
}

impl Frame {
    /// The direction with these local coordinates.
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        local.x * self.tangent + local.y * self.bitangent + local.z * self.normal
    }

    /// Local coordinates of a direction.
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(world.dot(self.tangent), world.dot(self.bitangent), world.dot(self.normal))
    }

    /// The frame that a rule on the normal alone gives: the tangent is the world axis least aligned with the normal (x
    /// before y before z), made perpendicular. It jumps where the least aligned axis changes; [`vertex_frames`] does
    /// not.
    pub fn by_axis(normal: Vec3) -> Frame {
        let n = normal.as_dvec3();
        frame(axis_tangent(n), n)
    }

    /// The frame at a point of a face with these barycentric weights: the mean of the corners' normals, and the mean of
    /// their tangents made perpendicular to it. Normals that cancel leave the first corner's frame, tangents that do a
    /// frame [by axis](Frame::by_axis).
    pub fn interpolated(corners: [Frame; 3], weights: [f32; 3]) -> Frame {
        let mean = |of: fn(&Frame) -> Vec3| {
            let terms = corners.iter().zip(weights).map(|(frame, weight)| f64::from(weight) * of(frame).as_dvec3());
            terms.sum::<DVec3>()
        };
        let Some(normal) = mean(|f| f.normal).try_normalize() else { return corners[0] };
        let tangent = mean(|f| f.tangent).reject_from_normalized(normal);
        let usable = tangent.length_squared() > 1e-12;
        frame(if usable { tangent } else { axis_tangent(normal) }, normal)
    }
}

fn frame(tangent: DVec3, normal: DVec3) -> Frame {
    // Twice, since the tangent went through roundings of its own: orthogonal to the last bit that f32 can hold.
    let tangent = tangent.reject_from_normalized(normal).normalize();
    Frame { tangent: tangent.as_vec3(), bitangent: normal.cross(tangent).as_vec3(), normal: normal.as_vec3() }
}

fn axis_tangent(normal: DVec3) -> DVec3 {
    let a = normal.abs();
    let axis = if a.x <= a.y && a.x <= a.z {
        DVec3::X
    } else if a.y <= a.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    axis.reject_from_normalized(normal).normalize()
}

/// Rotates `v` by the shortest rotation that takes the unit vector `from` to `to`; `None` where they are opposite.
fn transport(from: DVec3, to: DVec3, v: DVec3) -> Option<DVec3> {
    let cosine = from.dot(to);
    // v − (v·(from + to)) / (1 + cos) (from + to) mirrors and rotates back; valid for v perpendicular to `from`.
    (cosine > -1.0 + 1e-9).then(|| v - (v.dot(to) / (1.0 + cosine)) * (from + to))
}

/// One smooth frame for each vertex of a mesh with unit normals (see the module). Depends on nothing but the mesh.
///
/// # Errors
/// A mesh without normals, or with normals that are not of unit length: [`crate::scene::repair::repair`] computes them.
pub fn vertex_frames(mesh: &Mesh) -> Result<Vec<Frame>> {
    mesh.check()?;
    if let Some(v) = mesh.normals.iter().position(|n| (n.length() - 1.0).abs() > 1e-3) {
        return Err(Error::Unsupported {
            what: format!("frames: normal of vertex {v}"),
            expected: "length 1".into(),
            found: mesh.normals[v].length().to_string(),
        });
    }
    Error::expect_size("frames: vertex normals", mesh.positions.len(), mesh.normals.len())?;
    let normals: Vec<DVec3> = mesh.normals.iter().map(|n| n.as_dvec3().normalize()).collect();
    let neighbours = Neighbours::of(mesh, &mesh.normals);
    let mut tangents = spanning_tree(mesh, &normals, &neighbours);
    smooth(&normals, &neighbours, &mut tangents);
    let same = &neighbours.same;
    Ok(normals.iter().zip(same).map(|(&n, &first)| frame(tangents[first as usize], n)).collect())
}

/// The mean angle in radians between a vertex's tangent and its neighbour's, transported to it, over all edges: 0 where
/// frames agree, π/2 where they are random.
///
/// # Errors
/// A number of frames that is not that of the vertices, or a mesh that fails [`Mesh::check`].
pub fn roughness(mesh: &Mesh, frames: &[Frame]) -> Result<f64> {
    mesh.check()?;
    Error::expect_size("vertex frames", mesh.positions.len(), frames.len())?;
    let neighbours = Neighbours::of(mesh, &frames.iter().map(|f| f.normal).collect::<Vec<_>>());
    let (mut sum, mut edges) = (0.0, 0usize);
    for (i, frame) in frames.iter().enumerate() {
        for &j in neighbours.at(i).iter().filter(|&&j| j as usize > i) {
            let other = &frames[j as usize];
            let (from, to) = (frame.normal.as_dvec3().normalize(), other.normal.as_dvec3().normalize());
            if let Some(t) = transport(from, to, frame.tangent.as_dvec3()) {
                sum += t.angle_between(other.tangent.as_dvec3());
                edges += 1;
            }
        }
    }
    Ok(sum / edges.max(1) as f64)
}

/// Vertices that share an edge, ascending, each once. Vertices of one position and one normal, such as a texture seam
/// has, are one: the first of them has the neighbours of all, and the others have none.
struct Neighbours {
    /// The first vertex of the same position and normal.
    same: Vec<u32>,
    starts: Vec<usize>,
    list: Vec<u32>,
}

impl Neighbours {
    fn of(mesh: &Mesh, normals: &[Vec3]) -> Neighbours {
        let mut first = HashMap::with_capacity(mesh.positions.len());
        let places = mesh.positions.iter().zip(normals).enumerate();
        let same: Vec<u32> = places.map(|(v, (&p, &n))| *first.entry((bits(p), bits(n))).or_insert(v as u32)).collect();
        let mut edges: Vec<[u32; 2]> = mesh
            .faces
            .iter()
            .map(|face| face.map(|v| same[v as usize]))
            .flat_map(|[a, b, c]| [[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges.retain(|[a, b]| a != b);
        let mut starts = vec![0; mesh.positions.len() + 1];
        edges.iter().for_each(|[a, _]| starts[*a as usize + 1] += 1);
        (1..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        Neighbours { same, starts, list: edges.iter().map(|[_, b]| *b).collect() }
    }

    fn at(&self, vertex: usize) -> &[u32] {
        &self.list[self.starts[vertex]..self.starts[vertex + 1]]
    }
}

/// A key that takes 0 and -0 for the same.
fn bits(v: Vec3) -> [u32; 3] {
    (v + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// Tangents carried along a breadth-first tree. A component starts with a tangent carried across a hard edge, from a
/// vertex of the same position, where there is one; else with that of the axis rule.
fn spanning_tree(mesh: &Mesh, normals: &[DVec3], neighbours: &Neighbours) -> Vec<DVec3> {
    let place = |v: usize| bits(mesh.positions[v]);
    let mut twins: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    (0..normals.len()).for_each(|v| twins.entry(place(v)).or_default().push(v));
    let mut tangents = vec![DVec3::ZERO; normals.len()];
    let reached = |tangents: &[DVec3], v: usize| tangents[v] != DVec3::ZERO;
    // Steps to take: along edges first; across hard edges once a component is complete.
    let (mut along, mut across) = (VecDeque::new(), VecDeque::new());
    let mut rest = 0..normals.len();
    while let Some((from, to)) = along
        .pop_front()
        .or_else(|| across.pop_front())
        .or_else(|| Some((None, rest.find(|&v| !reached(&tangents, v))?)))
    {
        if !reached(&tangents, to) {
            let carried = from.and_then(|from: usize| transport(normals[from], normals[to], tangents[from]));
            let tangent = carried.unwrap_or_else(|| axis_tangent(normals[to]));
            tangents[to] = tangent.reject_from_normalized(normals[to]).normalize();
            along.extend(neighbours.at(to).iter().map(|&v| (Some(to), v as usize)));
            // Once for each position: the first vertex to be reached hands its tangent on to all.
            across.extend(twins.remove(&place(to)).into_iter().flatten().map(|v| (Some(to), v)));
        }
    }
    tangents
}

/// Lowers Σ |t_j − R_ij t_i|². First tangents lose their length and diffuse: where they disagree they cancel, and
/// singular points that the spanning tree left in excess meet and vanish. Then, unit vectors again, they descend.
fn smooth(normals: &[DVec3], neighbours: &Neighbours, tangents: &mut [DVec3]) {
    // Tangents as unit complex numbers in each vertex's own axes; then R_ij is a complex number too.
    let axes: Vec<[DVec3; 2]> =
        normals.iter().map(|&n| axis_tangent(n)).zip(normals).map(|(t, n)| [t, n.cross(t)]).collect();
    let in_axes = |v: usize, t: DVec3| DVec2::new(t.dot(axes[v][0]), t.dot(axes[v][1]));
    let rotation = |v: usize, j: usize| {
        let carried = transport(normals[j], normals[v], axes[j][0]);
        carried.map_or(DVec2::ZERO, |t| in_axes(v, t).normalize())
    };
    let rotations: Vec<DVec2> = (0..normals.len())
        .flat_map(|v| neighbours.at(v).iter().map(move |&j| (v, j as usize)))
        .map(|(v, j)| rotation(v, j))
        .collect();
    let mut field: Vec<DVec2> = tangents.iter().enumerate().map(|(v, &t)| in_axes(v, t)).collect();
    let from_neighbours = |field: &[DVec2], v: usize| -> DVec2 {
        let edges = neighbours.starts[v]..neighbours.starts[v + 1];
        edges.map(|e| rotations[e].rotate(field[neighbours.list[e] as usize])).sum()
    };
    // Σ_j |t_v − R t_j|² / 2 of unit tangents, each edge from both ends.
    let energy = |field: &[DVec2]| -> f64 {
        let disagreement = |v: usize| neighbours.at(v).len() as f64 - from_neighbours(field, v).dot(field[v]);
        (0..field.len()).map(disagreement).sum()
    };
    let mut before = energy(&field);
    if before <= 1e-12 * rotations.len() as f64 {
        return;
    }
    let start = field.clone();
    for v in (0..DIFFUSIONS).flat_map(|_| 0..start.len()).filter(|&v| !neighbours.at(v).is_empty()) {
        field[v] = from_neighbours(&field, v) / neighbours.at(v).len() as f64;
    }
    field.iter_mut().zip(&start).for_each(|(t, &start)| *t = t.try_normalize().unwrap_or(start));
    for _ in 0..SWEEPS {
        for v in 0..field.len() {
            // Where the neighbours cancel, any direction is as good.
            if let Some(mean) = from_neighbours(&field, v).try_normalize() {
                field[v] = field[v].lerp(mean, RELAXATION).try_normalize().unwrap_or(mean);
            }
        }
        let after = energy(&field);
        if after > (1.0 - SETTLED) * before {
            break;
        }
        before = after;
    }
    for (v, t) in tangents.iter_mut().enumerate() {
        *t = field[v].x * axes[v][0] + field[v].y * axes[v][1];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;
    use std::f64::consts::PI;

    fn by_axis(mesh: &Mesh) -> Vec<Frame> {
        mesh.normals.iter().map(|&n| Frame::by_axis(n)).collect()
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed_at_every_vertex() {
        for scene in shapes::all() {
            let mesh = scene.build(800).unwrap();
            for (frame, normal) in vertex_frames(&mesh).unwrap().iter().zip(&mesh.normals) {
                let Frame { tangent, bitangent, normal: n } = *frame;
                assert!((n - *normal).length() < 1e-6 && tangent.is_normalized() && bitangent.is_normalized());
                assert!((tangent.cross(bitangent) - n).length() < 1e-6, "{}: {frame:?}", scene.name);
                let v = Vec3::new(0.3, -0.5, 0.8);
                assert!((frame.to_local(frame.to_world(v)) - v).length() < 1e-6);
            }
        }
    }

    #[test]
    fn interpolated_frames_are_orthonormal_and_those_of_the_corners_at_the_corners() {
        let mesh = shapes::find("blob").unwrap().build(400).unwrap();
        let frames = vertex_frames(&mesh).unwrap();
        for face in &mesh.faces {
            let corners = face.map(|v| frames[v as usize]);
            for weights in [[0.2, 0.3, 0.5], [0.0, 0.5, 0.5], [1.0 / 3.0; 3]] {
                let Frame { tangent, bitangent, normal } = Frame::interpolated(corners, weights);
                assert!((tangent.cross(bitangent) - normal).length() < 1e-6 && tangent.is_normalized());
            }
            let [a, b] = [Frame::interpolated(corners, [0.0, 1.0, 0.0]), corners[1]];
            assert!((a.normal - b.normal).length() + (a.tangent - b.tangent).length() < 1e-6);
        }
        // What cancels leaves a frame all the same.
        let [up, down] = [Vec3::Z, Vec3::NEG_Z].map(Frame::by_axis);
        assert_eq!(Frame::interpolated([up, down, up], [0.5, 0.5, 0.0]), up);
        let turned = Frame { tangent: -up.tangent, bitangent: -up.bitangent, ..up };
        assert_eq!(Frame::interpolated([up, turned, up], [0.5, 0.5, 0.0]), up);
    }

    #[test]
    fn aligned_frames_are_smoother_than_those_of_the_axis_rule() {
        for scene in shapes::all() {
            let mesh = scene.build(2000).unwrap();
            let aligned = roughness(&mesh, &vertex_frames(&mesh).unwrap()).unwrap();
            let ruled = roughness(&mesh, &by_axis(&mesh)).unwrap();
            // On flat walls both are constant, up to rounding to f32.
            let flat = ["cornell-box", "two-polygons", "temple", "chair"].contains(&scene.name);
            let smooth = if flat { aligned < 1e-3 } else { aligned < 0.6 * ruled };
            assert!(smooth, "{}: aligned {aligned}, axis rule {ruled}", scene.name);
        }
    }

    #[test]
    fn flat_walls_have_one_frame_bit_for_bit() {
        let mesh = shapes::find("temple").unwrap().build(5000).unwrap();
        let frames = vertex_frames(&mesh).unwrap();
        for face in &mesh.faces {
            let [a, b, c] = face.map(|v| frames[v as usize].tangent.to_array().map(f32::to_bits));
            assert!(a == b && b == c);
        }
    }

    #[test]
    fn a_cylinder_can_be_combed_and_is() {
        // No curvature: frames without any twist exist. It lies askew, so that the axis rule changes its mind.
        let (around, along, askew) = (24, 10, glam::Quat::from_axis_angle(Vec3::ONE.normalize(), 0.7));
        let normal = |k: usize| askew * Vec3::X.rotate_z(k as f32 * (PI / 12.0) as f32);
        let mut mesh = Mesh::default();
        for (k, z) in (0..around * along).map(|i| (i % around, i / around)) {
            mesh.positions.push(normal(k) + askew * Vec3::new(0.0, 0.0, z as f32 * 0.25));
            mesh.normals.push(normal(k));
            let at = |k: usize, z: usize| (z * around + k % around) as u32;
            if z + 1 < along {
                let [a, b, c, d] = [at(k, z), at(k + 1, z), at(k + 1, z + 1), at(k, z + 1)];
                mesh.faces.extend([[a, b, c], [a, c, d]]);
            }
        }
        let aligned = roughness(&mesh, &vertex_frames(&mesh).unwrap()).unwrap();
        let ruled = roughness(&mesh, &by_axis(&mesh)).unwrap();
        assert!(aligned < 1e-3 && ruled > 0.05, "{aligned} {ruled}");
    }

    #[test]
    fn a_seam_between_identical_vertices_leaves_no_trace() {
        let whole = shapes::sphere(5);
        // Every face gets vertices of its own, in order: frames must be those of the welded sphere, up to where one
        // starts.
        let corners = || whole.faces.iter().flatten().map(|&v| v as usize);
        let torn = Mesh {
            positions: corners().map(|v| whole.positions[v]).collect(),
            normals: corners().map(|v| whole.normals[v]).collect(),
            faces: (0..whole.faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
        };
        let (welded, frames) = (vertex_frames(&whole).unwrap(), vertex_frames(&torn).unwrap());
        let mut seen = vec![None; whole.positions.len()];
        for (v, frame) in corners().zip(&frames) {
            assert_eq!(seen[v].get_or_insert(*frame), frame);
        }
        let [a, b] = [roughness(&whole, &welded).unwrap(), roughness(&torn, &frames).unwrap()];
        assert!((a / b - 1.0).abs() < 0.05, "{a} {b}");
    }

    #[test]
    fn transport_is_a_rotation_that_keeps_tangents_tangent() {
        let (a, b) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.48, 0.6, 0.64));
        let t = axis_tangent(a);
        let carried = transport(a, b, t).unwrap();
        assert!((carried.length() - 1.0).abs() < 1e-12 && carried.dot(b).abs() < 1e-12);
        let axis = a.cross(b).normalize();
        assert!((carried.dot(axis) - t.dot(axis)).abs() < 1e-12, "the axis of the rotation stays");
        assert!((transport(b, a, carried).unwrap() - t).length() < 1e-12);
        assert_eq!(transport(a, -a, t), None);
    }

    #[test]
    fn parts_beyond_a_hard_edge_continue_their_neighbours_frame() {
        // Floor and wall with split vertices along the x axis: the floor's x tangent is the wall's too.
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, Vec3::ZERO, Vec3::Z],
            normals: vec![Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Y, Vec3::Y, Vec3::Y],
            faces: vec![[0, 1, 2], [3, 4, 5]],
        };
        let frames = vertex_frames(&mesh).unwrap();
        let rotated = transport(DVec3::Z, DVec3::Y, frames[0].tangent.as_dvec3()).unwrap();
        assert!((frames[4].tangent.as_dvec3() - rotated).length() < 1e-6);
        assert_eq!(vertex_frames(&mesh).unwrap(), frames);
        mesh.normals[3] *= 1.1;
        assert!(vertex_frames(&mesh).unwrap_err().to_string().contains("vertex 3"));
        mesh.normals.clear();
        assert!(vertex_frames(&mesh).is_err());
    }
}
