//! The bounding volume hierarchy that rays are traced through.
//!
//! obvhs builds a binary tree (locally ordered clustering, then reinsertion to lower the surface-area cost); it is collapsed
//! into nodes of eight boxes and leaves of up to eight triangles, both stored by coordinate, so that one vector register holds
//! the same coordinate of all eight.

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, ploc::PlocSearchDistance, ploc::SortPrecision};
use std::time::Duration;

/// Children of a node, triangles of a leaf: the lanes of a vector register.
pub(crate) const WIDTH: usize = 8;

/// A reference to a node, or to a leaf where this bit is set.
pub(crate) const LEAF: u32 = 1 << 31;

/// Eight child boxes. Unused places hold an inverted box, which nothing meets.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Node {
    /// Lower x, y, z, then upper x, y, z of the eight boxes.
    pub(crate) bounds: [[f32; WIDTH]; 6],
    /// Nodes or leaves.
    pub(crate) child: [u32; WIDTH],
}

/// Up to eight triangles.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Leaf {
    /// Corner, coordinate, triangle.
    pub(crate) corner: [[[f32; WIDTH]; 3]; 3],
    /// Faces of the mesh.
    pub(crate) face: [u32; WIDTH],
    /// Triangles in use, from lane 0.
    pub(crate) count: usize,
}

impl Leaf {
    /// The corners of one triangle relative to `origin`.
    pub(crate) fn triangle(&self, lane: usize, origin: Vec3) -> [Vec3; 3] {
        self.corner.map(|c| Vec3::new(c[0][lane], c[1][lane], c[2][lane]) - origin)
    }
}

/// Triangles that hide the light, ready to be traced.
///
/// Inside, coordinates are multiplied by a power of two that brings the mesh to about unit size, so that no product
/// underflows or overflows at any scale.
#[derive(Clone, Debug)]
pub struct Occluders {
    pub(crate) nodes: Vec<Node>,
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) root: Option<u32>,
    /// Bounding box, scaled.
    pub(crate) lower: Vec3,
    pub(crate) upper: Vec3,
    /// The power of two.
    pub(crate) scale: f32,
    /// Entries that a depth-first walk can leave waiting.
    pub(crate) stack: usize,
    faces: usize,
    diagonal: f32,
}

impl Occluders {
    /// Builds the hierarchy over all triangles of the mesh; normals are not looked at. Triangles with two equal corners are
    /// left out, since no ray hits them.
    ///
    /// Errors: [`Error::NotFinite`] for a coordinate (row = vertex), [`Error::TooLarge`] for a face that names a vertex
    /// which is not there, or for 2³¹ faces.
    pub fn new(mesh: &Mesh) -> Result<Occluders> {
        check(mesh)?;
        let (lower, upper) = bounds(&mesh.positions);
        let scale = unit_scale(lower.abs().max_element().max(upper.abs().max_element()));
        let (lower, upper) = (lower * scale, upper * scale);
        let (faces, triangles): (Vec<u32>, Vec<Triangle>) = (0u32..)
            .zip(&mesh.faces)
            .map(|(face, corners)| (face, corners.map(|i| mesh.positions[i as usize] * scale)))
            .filter(|(_, [a, b, c])| a != b && b != c && c != a)
            .map(|(face, [a, b, c])| (face, Triangle { v0: a.into(), v1: b.into(), v2: c.into() }))
            .unzip();
        let mut occluders = Occluders {
            nodes: Vec::new(),
            leaves: Vec::new(),
            root: None,
            lower,
            upper,
            scale,
            stack: 1,
            faces: faces.len(),
            diagonal: (upper - lower).length() / scale,
        };
        if !triangles.is_empty() {
            let tree = build_bvh2_from_tris(&triangles, BUILD, &mut Duration::default());
            Collapse { tree: &tree, triangles: &triangles, faces: &faces, into: &mut occluders }.run();
        }
        Ok(occluders)
    }

    /// Triangles that can be hit.
    pub fn faces(&self) -> usize {
        self.faces
    }

    /// The diagonal of the bounding box of all vertices, in the units of the mesh.
    pub fn diagonal(&self) -> f32 {
        self.diagonal
    }
}

/// Leaves of one triangle: the collapse below gathers them. No spatial splits, which would put a triangle in several leaves.
const BUILD: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    ploc_search_distance: PlocSearchDistance::High,
    search_depth_threshold: 2,
    reinsertion_batch_ratio: 0.2,
    post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
    sort_precision: SortPrecision::U64,
    max_prims_per_leaf: 1,
    collapse_traversal_cost: 1.0,
};

fn check(mesh: &Mesh) -> Result<()> {
    for (row, position) in mesh.positions.iter().enumerate() {
        if let Some(col) = position.to_array().iter().position(|x| !x.is_finite()) {
            return Err(Error::NotFinite { row, col, value: f64::from(position[col]) });
        }
    }
    if mesh.faces.len() >= LEAF as usize {
        let found = mesh.faces.len() as u64;
        return Err(Error::TooLarge { what: "faces of a mesh".into(), limit: u64::from(LEAF) - 1, found });
    }
    let vertices = mesh.positions.len();
    let outside = |face: &[u32; 3]| face.iter().copied().find(|&i| i as usize >= vertices);
    match mesh.faces.iter().enumerate().find_map(|(k, face)| outside(face).map(|i| (k, i))) {
        None => Ok(()),
        Some((face, index)) => Err(Error::TooLarge {
            what: format!("vertex of face {face}, counted from 0"),
            limit: (vertices as u64).saturating_sub(1),
            found: u64::from(index),
        }),
    }
}

fn bounds(positions: &[Vec3]) -> (Vec3, Vec3) {
    let Some(&first) = positions.first() else { return (Vec3::ZERO, Vec3::ZERO) };
    positions.iter().fold((first, first), |(lower, upper), &p| (lower.min(p), upper.max(p)))
}

/// The power of two that brings `size` to [1, 2), as far as `f32` has one.
pub(crate) fn unit_scale(size: f32) -> f32 {
    let exponent = size.to_bits() >> 23;
    if size == 0.0 { 1.0 } else { f32::from_bits(254u32.saturating_sub(exponent).clamp(1, 253) << 23) }
}

/// The collapse of the binary tree.
struct Collapse<'a> {
    tree: &'a Bvh2,
    triangles: &'a [Triangle],
    faces: &'a [u32],
    into: &'a mut Occluders,
}

impl Collapse<'_> {
    fn run(mut self) {
        let sizes = self.sizes();
        // Work is kept in a list, not on the call stack: a hostile mesh can make the binary tree as deep as it is large.
        // An entry is a binary node, the wide node and place that will refer to it, and its depth.
        let mut work = vec![(0usize, None, 1usize)];
        while let Some((at, parent, depth)) = work.pop() {
            let reference = if sizes[at] as usize <= WIDTH {
                self.leaf(at)
            } else {
                let children = self.widen(at, &sizes);
                let node = self.node(&children);
                work.extend(children.iter().enumerate().map(|(place, &child)| (child, Some((node, place)), depth + 1)));
                node as u32
            };
            match parent {
                None => self.into.root = Some(reference),
                Some((node, place)) => self.into.nodes[node].child[place] = reference,
            }
            self.into.stack = self.into.stack.max(depth * (WIDTH - 1) + 1);
        }
    }

    /// Triangles below each binary node.
    fn sizes(&self) -> Vec<u32> {
        let mut order = vec![0usize];
        let mut next = 0;
        while next < order.len() {
            let node = &self.tree.nodes[order[next]];
            if !node.is_leaf() {
                order.extend([node.first_index as usize, node.first_index as usize + 1]);
            }
            next += 1;
        }
        let mut sizes = vec![0; self.tree.nodes.len()];
        for &at in order.iter().rev() {
            let node = &self.tree.nodes[at];
            let child = node.first_index as usize;
            sizes[at] = if node.is_leaf() { node.prim_count } else { sizes[child] + sizes[child + 1] };
        }
        sizes
    }

    /// Opens the largest box that is not yet a leaf until there are eight.
    fn widen(&self, at: usize, sizes: &[u32]) -> Vec<usize> {
        let mut children = vec![at];
        while children.len() < WIDTH {
            let area = |&place: &usize| self.tree.nodes[children[place]].aabb().half_area();
            let open = (0..children.len())
                .filter(|&place| sizes[children[place]] as usize > WIDTH)
                .max_by(|a, b| area(a).total_cmp(&area(b)));
            let Some(open) = open else { break };
            let first = self.tree.nodes[children[open]].first_index as usize;
            children[open] = first;
            children.push(first + 1);
        }
        children
    }

    fn node(&mut self, children: &[usize]) -> usize {
        let mut node = Node { bounds: [[f32::INFINITY; WIDTH]; 6], child: [LEAF; WIDTH] };
        node.bounds[3..].fill([f32::NEG_INFINITY; WIDTH]);
        for (place, &child) in children.iter().enumerate() {
            let aabb = self.tree.nodes[child].aabb();
            for axis in 0..3 {
                node.bounds[axis][place] = aabb.min[axis];
                node.bounds[3 + axis][place] = aabb.max[axis];
            }
        }
        self.into.nodes.push(node);
        self.into.nodes.len() - 1
    }

    fn leaf(&mut self, at: usize) -> u32 {
        let mut leaf = Leaf { corner: Default::default(), face: [0; WIDTH], count: 0 };
        let mut work = vec![at];
        while let Some(at) = work.pop() {
            let (node, first) = (&self.tree.nodes[at], self.tree.nodes[at].first_index as usize);
            if !node.is_leaf() {
                work.extend([first + 1, first]);
                continue;
            }
            for &k in &self.tree.primitive_indices[first..first + node.prim_count as usize] {
                let Triangle { v0, v1, v2 } = self.triangles[k as usize];
                for (corner, v) in leaf.corner.iter_mut().zip([v0, v1, v2]) {
                    corner.iter_mut().zip(v.to_array()).for_each(|(lanes, x)| lanes[leaf.count] = x);
                }
                leaf.face[leaf.count] = self.faces[k as usize];
                leaf.count += 1;
            }
        }
        self.into.leaves.push(leaf);
        (self.into.leaves.len() - 1) as u32 | LEAF
    }
}
