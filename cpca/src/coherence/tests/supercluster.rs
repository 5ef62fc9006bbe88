use super::super::{clusters_by_registers, overdraw, supercluster_of_samples, superclusters};
use super::{Case, cases, grid};
use proptest::prelude::*;

fn drawn(case: &Case, groups: &[u32]) -> u64 {
    case.total(&supercluster_of_samples(&case.clusters, groups).unwrap())
}

/// The same search without a queue: every pair's reduction is computed anew before each merge, from overdraw itself.
fn plain(case: &Case, count: usize, members: usize) -> Vec<u32> {
    // A supercluster goes by its first cluster.
    let mut groups: Vec<u32> = (0..count as u32).collect();
    let size = |groups: &[u32], group: u32| groups.iter().filter(|g| **g == group).count();
    loop {
        let (now, mut best) = (drawn(case, &groups), (0, [0, 0]));
        for a in 0..count as u32 {
            for b in a + 1..count as u32 {
                let (size_a, size_b) = (size(&groups, a), size(&groups, b));
                if size_a == 0 || size_b == 0 || size_a + size_b > members {
                    continue;
                }
                let merged: Vec<u32> = groups.iter().map(|&g| if g == b { a } else { g }).collect();
                let reduction = now - drawn(case, &merged);
                // Pairs ascend, so that the first of equals stays.
                if reduction > best.0 {
                    best = (reduction, [a, b]);
                }
            }
        }
        let (reduction, [a, b]) = best;
        if reduction == 0 {
            let mut firsts = groups.clone();
            firsts.sort_unstable();
            firsts.dedup();
            return groups.iter().map(|g| firsts.binary_search(g).unwrap() as u32).collect();
        }
        groups.iter_mut().filter(|g| **g == b).for_each(|g| *g = a);
    }
}

/// As `cases`, but with a cluster for each few vertices.
fn many_clusters() -> impl Strategy<Value = Case> {
    (cases(), 1..20u32).prop_map(|(case, count)| {
        let clusters = case.clusters.iter().enumerate().map(|(i, c)| (c + 5 * i as u32 * i as u32) % count).collect();
        Case { clusters, ..case }
    })
}

proptest! {
    #[test]
    fn the_queue_makes_the_merges_of_a_search_that_computes_everything_anew(
        case in many_clusters(),
        members in 1..9usize,
    ) {
        let found = superclusters(&case.triangles, &case.clusters, 20, members).unwrap();
        prop_assert_eq!(found, plain(&case, 20, members));
    }

    #[test]
    fn no_supercluster_has_more_members_than_allowed_and_overdraw_never_grows(
        case in many_clusters(),
        members in 1..9usize,
    ) {
        let found = superclusters(&case.triangles, &case.clusters, 20, members).unwrap();
        prop_assert!((0..20).all(|group| found.iter().filter(|g| **g == group).count() <= members));
        prop_assert!(drawn(&case, &found) <= case.total(&case.clusters));
    }

    #[test]
    fn where_everything_may_merge_each_triangle_is_drawn_once(case in many_clusters()) {
        let found = superclusters(&case.triangles, &case.clusters, 20, 20).unwrap();
        prop_assert_eq!(drawn(&case, &found), case.triangles.len() as u64);
    }
}

#[test]
fn a_large_mesh_with_a_cluster_for_each_vertex_becomes_one_supercluster() {
    let (triangles, clusters) = (grid(100, 100, |cell| cell % 7 < 3), (0..10_000).collect::<Vec<u32>>());
    let one = superclusters(&triangles, &clusters, 10_000, 10_000).unwrap();
    assert!(one.iter().all(|&group| group == 0));
    let few = superclusters(&triangles, &clusters, 10_000, 28).unwrap();
    let found = overdraw(&triangles, &few).unwrap().factor();
    // Squares of 28 vertices would be about 1.4.
    assert!(found < 1.8, "{found}");
}

#[test]
fn superclusters_of_one_cluster_are_the_clusters_and_nothing_else_is_accepted_below() {
    let (triangles, clusters) = (grid(3, 2, |_| true), [2, 0, 1, 1, 0, 2]);
    assert_eq!(superclusters(&triangles, &clusters, 4, 1).unwrap(), [0, 1, 2, 3]);
    assert!(superclusters(&triangles, &clusters, 4, 0).unwrap_err().to_string().contains("at least 1"));
    let refused = superclusters(&triangles, &clusters, 2, 8).unwrap_err().to_string();
    assert_eq!(refused, "cluster of sample 0: expected a number below 2, found 2");
    let refused = supercluster_of_samples(&clusters, &[0, 0]).unwrap_err().to_string();
    assert!(refused.starts_with("cluster of sample 0") && refused.ends_with("found 2"), "{refused}");
    assert!(superclusters(&[[0, 1, 6]], &clusters, 4, 2).is_err());
}

#[test]
fn registers_hold_as_many_clusters_as_the_paper_says() {
    // m_s (n'+1) N_r/4 for glossy and m_s (n'+1) for diffuse transfer, of 256 registers.
    for (components, responses) in [(8, 24), (8, 16), (6, 16), (0, 24), (8, 1), (0, 1), (4, 1)] {
        let members = clusters_by_registers(256, components, responses);
        let taken = |members: usize| members * (components + 1) * if responses == 1 { 4 } else { responses } / 4;
        assert!(taken(members) <= 256 && taken(members + 1) > 256, "{components} {responses}: {members}");
    }
    // 25 responses take 7 registers, not 6.25.
    assert_eq!(clusters_by_registers(256, 3, 25), 9);
    assert_eq!(clusters_by_registers(256, 256, 1), 0);
    assert_eq!(clusters_by_registers(256, usize::MAX, usize::MAX), 0);
}
