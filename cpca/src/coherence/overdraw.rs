//! Overdraw: how often a mesh's triangles are drawn where each cluster draws every triangle that it has a vertex in.

use prt_transfer::{Error, Result};

/// Triangles that the clusters draw (paper §5). Of several assignments on one mesh the one with the smaller total is
/// drawn faster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overdraw {
    /// The distinct clusters of a triangle's vertices, summed over triangles: what is sent to the graphics hardware.
    pub total: u64,
    /// Triangles of the mesh.
    pub triangles: usize,
}

impl Overdraw {
    /// How often a triangle is drawn on average, as in the table of §7: 1 to 3, and 1 where there are no triangles.
    pub fn factor(&self) -> f64 {
        if self.triangles == 0 { 1.0 } else { self.total as f64 / self.triangles as f64 }
    }
}

/// The overdraw of `triangles` whose vertex i is of cluster `clusters[i]`. Cluster ids may be any numbers.
///
/// # Errors
/// A triangle with a vertex that has no cluster, by number.
pub fn overdraw(triangles: &[[u32; 3]], clusters: &[u32]) -> Result<Overdraw> {
    check(triangles, clusters.len())?;
    let drawn = |triangle: &[u32; 3]| u64::from(distinct(triangle.map(|v| clusters[v as usize])));
    Ok(Overdraw { total: triangles.iter().map(drawn).sum(), triangles: triangles.len() })
}

/// How many of three numbers are distinct.
pub(crate) fn distinct([a, b, c]: [u32; 3]) -> u32 {
    1 + u32::from(b != a) + u32::from(c != a && c != b)
}

/// Refuses triangles with vertices beyond the samples.
pub(crate) fn check(triangles: &[[u32; 3]], samples: usize) -> Result<()> {
    let beyond = |triangle: &[u32; 3]| triangle.iter().copied().find(|&v| v as usize >= samples);
    match triangles.iter().enumerate().find_map(|(i, triangle)| Some((i, beyond(triangle)?))) {
        None => Ok(()),
        Some((triangle, vertex)) => Err(Error::Unsupported {
            what: format!("vertices of triangle {triangle}"),
            expected: format!("indices below {samples}, the number of samples"),
            found: vertex.to_string(),
        }),
    }
}
