use super::super::{Reclassified, reclassify};
use super::{Case, cases, grid};
use proptest::prelude::*;
use std::collections::HashSet;
use std::sync::Mutex;

fn reclassified(case: &Case, budget: f64) -> Reclassified {
    reclassify(&case.triangles, &case.clusters, budget, |sample, cluster| case.error(sample, cluster)).unwrap()
}

/// The same search without a queue: every move of every sample is computed anew before each step, from overdraw itself.
fn plain(case: &Case, budget: f64) -> Vec<u32> {
    let (mut clusters, mut left) = (case.clusters.clone(), budget);
    loop {
        let mut best: Option<(bool, f64, f64, usize, u32)> = None;
        for sample in 0..clusters.len() {
            let mut targets: Vec<u32> = case.around(&clusters, sample as u32).into_iter().collect();
            targets.sort_unstable();
            for target in targets.into_iter().filter(|&t| t != clusters[sample]) {
                let mut moved = clusters.clone();
                moved[sample] = target;
                let reduction = case.total(&clusters) as f64 - case.total(&moved) as f64;
                let increase = case.error(sample, target) - case.error(sample, clusters[sample]);
                let free = increase <= 0.0;
                if reduction < 0.0 || (reduction == 0.0 && increase >= 0.0) || increase > left {
                    continue;
                }
                let (first, second) = if free { (reduction, -increase) } else { (reduction / increase, 0.0) };
                // Samples and clusters ascend, so that the first of equals stays.
                if best.is_none_or(|(f, a, b, ..)| (free, first, second) > (f, a, b)) {
                    best = Some((free, first, second, sample, target));
                }
            }
        }
        let Some((_, _, _, sample, target)) = best else { return clusters };
        left -= (case.error(sample, target) - case.error(sample, clusters[sample])).max(0.0);
        clusters[sample] = target;
    }
}

/// The least overdraw of all assignments whose error exceeds that of the case by `budget` at most.
fn optimum(case: &Case, budget: f64) -> u64 {
    let (count, limit) = (case.errors[0].len() as u32, case.total_error(&case.clusters) + budget);
    let mut clusters = vec![0; case.clusters.len()];
    let mut least = u64::MAX;
    loop {
        if case.total_error(&clusters) <= limit {
            least = least.min(case.total(&clusters));
        }
        let Some(digit) = clusters.iter().position(|&c| c + 1 < count) else { return least };
        clusters[..digit].fill(0);
        clusters[digit] += 1;
    }
}

proptest! {
    #[test]
    fn the_budget_is_kept_and_overdraw_never_grows(case in cases(), budget in 0.0..6.0f64) {
        let found = reclassified(&case, budget);
        let (before, after) = (case.total_error(&case.clusters), case.total_error(&found.clusters));
        prop_assert!(after <= before + budget, "{after} exceeds {before} by more than {budget}");
        prop_assert_eq!(found.increase, after - before);
        prop_assert_eq!(found.moved, found.clusters.iter().zip(&case.clusters).filter(|(a, b)| a != b).count());
        prop_assert!(case.total(&found.clusters) <= case.total(&case.clusters));
    }

    #[test]
    fn the_queue_makes_the_moves_of_a_search_that_computes_everything_anew(case in cases(), budget in 0..24u32) {
        let budget = f64::from(budget) / 4.0;
        prop_assert_eq!(reclassified(&case, budget).clusters, plain(&case, budget));
    }

    #[test]
    fn without_a_budget_no_sample_is_worse_off(case in cases()) {
        let found = reclassified(&case, 0.0);
        for (sample, (&from, &to)) in case.clusters.iter().zip(&found.clusters).enumerate() {
            prop_assert!(case.error(sample, to) <= case.error(sample, from), "sample {sample}");
        }
    }

    #[test]
    fn with_a_budget_for_everything_no_move_that_reduces_overdraw_is_left(case in cases()) {
        let found = reclassified(&case, 1e9).clusters;
        for sample in 0..found.len() {
            for target in case.around(&found, sample as u32) {
                let mut moved = found.clone();
                moved[sample] = target;
                prop_assert!(case.total(&moved) >= case.total(&found), "sample {sample} to {target}");
            }
        }
    }

    #[test]
    fn errors_are_asked_once_and_only_in_clusters_that_come_into_question(case in cases(), budget in 0.0..6.0f64) {
        let asked = Mutex::new(HashSet::new());
        let error = |sample: usize, cluster: u32| {
            assert!(asked.lock().unwrap().insert((sample, cluster)), "{sample} in {cluster} is asked twice");
            case.error(sample, cluster)
        };
        reclassify(&case.triangles, &case.clusters, budget, error).unwrap();
        let present: HashSet<u32> = case.clusters.iter().copied().collect();
        for (sample, cluster) in asked.into_inner().unwrap() {
            prop_assert!(present.contains(&cluster));
            prop_assert!(case.triangles.iter().any(|t| t.contains(&(sample as u32))));
        }
    }

    #[test]
    fn an_exhaustive_search_lies_between_greed_and_nothing(
        clusters in prop::collection::vec(0..3u32, 6),
        errors in prop::collection::vec(prop::collection::vec(0..5u8, 3), 6),
        budget in 0..8u32,
    ) {
        let errors = errors.iter().map(|row| row.iter().map(|&e| f64::from(e)).collect()).collect();
        let case = Case { triangles: grid(3, 2, |cell| cell == 0), clusters, errors };
        let budget = f64::from(budget);
        let greedy = case.total(&reclassified(&case, budget).clusters);
        prop_assert!(optimum(&case, budget) <= greedy && greedy <= case.total(&case.clusters));
    }
}

/// 5 x 3 vertices of cluster 0, on which `strays` are of others; a sample's own cluster has no error, cluster 0 the
/// stated one.
fn with_strays(strays: &[(usize, u32, f64)]) -> Case {
    let mut case =
        Case { triangles: grid(5, 3, |_| true), clusters: vec![0; 15], errors: vec![vec![0.0, 9.0, 9.0]; 15] };
    for &(sample, cluster, price) in strays {
        case.clusters[sample] = cluster;
        case.errors[sample] = vec![price, 9.0, 9.0];
        case.errors[sample][cluster as usize] = 0.0;
    }
    case
}

#[test]
fn strays_come_home_as_far_as_the_budget_goes_those_with_the_best_quotient_first() {
    // Sample 6 has six triangles around it, sample 4 a corner of the grid with two.
    let case = with_strays(&[(6, 1, 1.0), (4, 2, 0.5)]);
    assert_eq!(reclassified(&case, 1.5).clusters, [0; 15]);
    assert_eq!(reclassified(&case, 1.5).increase, 1.5);
    let one = reclassified(&case, 1.25);
    assert_eq!((one.clusters[6], one.clusters[4], one.moved), (0, 2, 1));
    // What is left over pays for the second where the first is too dear.
    let other = reclassified(&case, 0.75);
    assert_eq!((other.clusters[6], other.clusters[4], other.increase), (1, 0, 0.5));
    assert_eq!(reclassified(&case, 0.25).clusters, case.clusters);
}

#[test]
fn the_optimum_is_found_where_strays_are_alone() {
    for (strays, budget) in [
        (&[(1, 1, 1.0)][..], 1.0),
        (&[(1, 1, 1.0)], 0.5),
        (&[(1, 1, 0.0), (3, 2, 2.0)], 0.0),
        (&[(0, 1, 3.0), (4, 2, 2.0)], 5.0),
        (&[(1, 1, 1.0), (5, 2, 1.0)], 1.0),
    ] {
        let mut case = with_strays(strays);
        case.triangles = grid(3, 2, |_| true);
        case.clusters.truncate(6);
        case.errors.truncate(6);
        let found = reclassified(&case, budget);
        assert_eq!(case.total(&found.clusters), optimum(&case, budget), "{strays:?} with {budget}");
    }
}

#[test]
fn a_move_that_reduces_error_and_not_overdraw_is_made_and_its_gain_not_spent() {
    // Two halves of a grid; the samples of the middle column would rather be of the other.
    let mut case = Case { triangles: grid(4, 2, |_| true), clusters: vec![], errors: vec![vec![1.0, 9.0]; 8] };
    case.clusters = vec![0, 0, 1, 1, 0, 0, 1, 1];
    for sample in [2, 3, 6, 7] {
        case.errors[sample] = vec![9.0, 1.0];
    }
    assert_eq!(reclassified(&case, 0.0).moved, 0);
    case.errors[2] = vec![0.5, 1.0];
    case.errors[6] = vec![0.5, 1.0];
    let found = reclassified(&case, 0.0);
    assert_eq!((found.clusters.as_slice(), found.increase), (&[0, 0, 0, 1, 0, 0, 0, 1][..], -1.0));
    // Merging all would take 2 x 8, of which 1 has been saved.
    assert_eq!(reclassified(&case, 15.5).moved, 3);
    assert_eq!(reclassified(&case, 16.0).clusters, [0; 8]);
}

#[test]
fn a_cluster_may_lose_its_last_member() {
    let case = with_strays(&[(7, 2, 0.0)]);
    assert_eq!(reclassified(&case, 0.0).clusters, [0; 15]);
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    // Hashed clusters and errors on a grid large enough to be shared out.
    let hash = |i: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33) as u32;
    let clusters: Vec<u32> = (0..3600).map(|i| hash(i) % 7).collect();
    let errors = (0..3600).map(|i| (0..7).map(|c| f64::from(hash(7 * i + c) % 97)).collect()).collect();
    let case = Case { triangles: grid(60, 60, |cell| cell % 3 == 0), clusters, errors };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| reclassified(&case, 2_000.0))
    };
    let one = on(1);
    assert_eq!(one, on(3));
    assert!(one.moved > 100, "{}", one.moved);
}

#[test]
fn what_is_not_an_error_or_a_budget_is_refused_with_its_place() {
    let case = with_strays(&[(6, 1, 1.0)]);
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        let refused = reclassify(&case.triangles, &case.clusters, bad, |_, _| 0.0).unwrap_err().to_string();
        assert!(refused.contains("budget") && refused.contains(&bad.to_string()), "{refused}");
        let error = |sample, cluster| if (sample, cluster) == (6, 0) { bad } else { 1.0 };
        let refused = reclassify(&case.triangles, &case.clusters, 1.0, error).unwrap_err().to_string();
        assert!(refused.contains("sample 6 in cluster 0") && refused.contains(&bad.to_string()), "{refused}");
    }
    assert!(reclassify(&[[0, 1, 2]], &[0, 0], 1.0, |_, _| 0.0).is_err());
}
