//! The triangles around each vertex.

use std::collections::BTreeSet;

/// Triangles by vertex; a triangle that names a vertex twice is around it once.
pub(crate) struct Fans<'a> {
    triangles: &'a [[u32; 3]],
    /// `vertices + 1` offsets into `around`.
    offsets: Vec<usize>,
    around: Vec<usize>,
}

impl<'a> Fans<'a> {
    /// Of triangles whose vertices are below `vertices`.
    pub(crate) fn new(triangles: &'a [[u32; 3]], vertices: usize) -> Fans<'a> {
        let mut offsets = vec![0; vertices + 1];
        triangles.iter().for_each(|&t| corners(t).for_each(|v| offsets[v + 1] += 1));
        for v in 0..vertices {
            offsets[v + 1] += offsets[v];
        }
        let (mut next, mut around) = (offsets.clone(), vec![0; offsets[vertices]]);
        for (i, &triangle) in triangles.iter().enumerate() {
            for v in corners(triangle) {
                around[next[v]] = i;
                next[v] += 1;
            }
        }
        Fans { triangles, offsets, around }
    }

    /// The triangles around a vertex.
    pub(crate) fn of(&self, vertex: usize) -> impl Iterator<Item = [u32; 3]> + Clone {
        self.around[self.offsets[vertex]..self.offsets[vertex + 1]].iter().map(|&i| self.triangles[i])
    }

    /// The vertex and those that share a triangle with it, ascending.
    pub(crate) fn ring(&self, vertex: usize) -> BTreeSet<u32> {
        self.of(vertex).flatten().chain([vertex as u32]).collect()
    }
}

/// The distinct vertices of a triangle.
fn corners([a, b, c]: [u32; 3]) -> impl Iterator<Item = usize> {
    [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)].into_iter().flatten().map(|v| v as usize)
}
