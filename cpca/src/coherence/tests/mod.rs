//! What a user of coherence may rely on.

mod model;
mod reclassify;
mod supercluster;

use super::overdraw;
use proptest::prelude::*;
use std::collections::HashSet;

/// A triangulation with the cluster of each vertex, and the squared error of each vertex in each cluster.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) clusters: Vec<u32>,
    /// By vertex, then cluster.
    pub(super) errors: Vec<Vec<f64>>,
}

impl Case {
    pub(super) fn error(&self, sample: usize, cluster: u32) -> f64 {
        self.errors[sample][cluster as usize]
    }
    pub(super) fn total_error(&self, clusters: &[u32]) -> f64 {
        clusters.iter().enumerate().map(|(sample, &cluster)| self.error(sample, cluster)).sum()
    }
    pub(super) fn total(&self, clusters: &[u32]) -> u64 {
        overdraw(&self.triangles, clusters).unwrap().total
    }
    /// Clusters of the neighbours of a vertex, its own too.
    pub(super) fn around(&self, clusters: &[u32], vertex: u32) -> HashSet<u32> {
        let fan = self.triangles.iter().filter(|t| t.contains(&vertex));
        fan.flatten().map(|&v| clusters[v as usize]).collect()
    }
}

/// The triangles of a grid, each cell cut along the diagonal that `diagonals` says.
pub(super) fn grid(width: usize, height: usize, diagonals: impl Fn(usize) -> bool) -> Vec<[u32; 3]> {
    let at = |x: usize, y: usize| (y * width + x) as u32;
    let cells = (0..height - 1).flat_map(|y| (0..width - 1).map(move |x| (x, y)));
    let cut = |(x, y): (usize, usize)| {
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        if diagonals(y * width + x) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    };
    cells.flat_map(cut).collect()
}

/// Grids with random diagonals and a few triangles across, some of them degenerate or double; errors with many ties.
pub(super) fn cases() -> impl Strategy<Value = Case> {
    (2..6usize, 2..5usize, 1..6u32).prop_flat_map(|(width, height, clusters)| {
        let vertices = width * height;
        let across = prop::collection::vec(prop::array::uniform3(0..vertices as u32), 0..4);
        let errors = prop::collection::vec(prop::collection::vec(0..9u8, clusters as usize), vertices);
        let of_vertices = prop::collection::vec(0..clusters, vertices);
        let diagonals = prop::collection::vec(any::<bool>(), vertices);
        (across, errors, of_vertices, diagonals).prop_map(move |(across, errors, clusters, diagonals)| {
            let mut triangles = grid(width, height, |cell| diagonals[cell]);
            triangles.extend(across);
            let exact = |row: &Vec<u8>| row.iter().map(|&e| f64::from(e) / 4.0).collect();
            Case { triangles, clusters, errors: errors.iter().map(exact).collect() }
        })
    })
}

proptest! {
    #[test]
    fn overdraw_is_the_number_of_distinct_clusters_summed_over_triangles(case in cases()) {
        let sets = case.triangles.iter().map(|t| t.iter().map(|&v| case.clusters[v as usize]).collect::<HashSet<_>>());
        let found = overdraw(&case.triangles, &case.clusters).unwrap();
        prop_assert_eq!(found.total, sets.map(|s| s.len() as u64).sum::<u64>());
        prop_assert_eq!(found.triangles, case.triangles.len());
        prop_assert!((1.0..=3.0).contains(&found.factor()));
    }
}

#[test]
fn overdraw_of_nothing_is_1_and_a_vertex_without_a_cluster_is_named() {
    assert_eq!(overdraw(&[], &[]).unwrap().factor(), 1.0);
    assert_eq!(overdraw(&[[0, 1, 2]], &[7, u32::MAX, 0]).unwrap().factor(), 3.0);
    let refused = overdraw(&[[0, 1, 2], [1, 2, 3]], &[0, 0, 0]).unwrap_err().to_string();
    assert_eq!(refused, "vertices of triangle 1: expected indices below 3, the number of samples, found 3");
}
