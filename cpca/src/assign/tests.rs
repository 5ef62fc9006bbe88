use super::*;
use crate::residual::explicit;
use crate::subspaces::Subspace;
use prt_transfer::{LightBasis, Quiet, TransferMatrix};

/// Curves in n dimensions, from smooth to rough.
fn matrix(samples: usize, n: usize) -> TransferMatrix {
    let value = |i: usize| {
        let (p, k) = ((i / n) as f32, (i % n) as f32);
        (0.37 * p + 0.05 * k).sin() + (0.011 * p * k).cos() / (1.0 + 0.2 * k)
    };
    TransferMatrix::from_dense((0..samples * n).map(value).collect(), samples, 1, LightBasis::Plain { lights: n })
        .unwrap()
}

/// Subspaces of different numbers of components around some of the samples.
fn subspaces(samples: &Samples, clusters: usize, turn: usize) -> Subspaces {
    let n = samples.dimension();
    let subspace = |cluster: usize| {
        let near = |i: usize| samples.row((cluster * 5 + i * 3 + turn) % samples.count()).to_vec();
        let group: Vec<u32> = (0..6).map(|i| ((cluster * 7 + i + turn) % samples.count()) as u32).collect();
        match cluster % 4 {
            0 => Subspace { mean: near(0), components: Vec::new() },
            components => crate::refit::fit(samples, &group, components, &[]).unwrap(),
        }
    };
    Subspaces::new(n, (0..clusters).map(subspace).collect())
}

/// The nearest of all by the explicit residual, the first of several.
fn brute_force(samples: &Samples, subspaces: &Subspaces) -> Vec<u32> {
    let distance = |p: usize, s: &Subspace| explicit(samples.row(p), &s.mean, &s.components);
    let nearest = |p: usize| {
        let all = subspaces.all().iter().map(|s| distance(p, s)).enumerate();
        all.fold((0, f64::INFINITY), |best, (k, d)| if d < best.1 { (k, d) } else { best }).0 as u32
    };
    (0..samples.count()).map(nearest).collect()
}

#[test]
fn every_sample_is_with_the_nearest_subspace_of_all() {
    for (count, n, clusters) in [(300, 7, 9), (300, 60, 20), (700, 130, 40), (50, 200, 50), (5, 3, 1)] {
        let matrix = matrix(count, n);
        let samples = Samples::of(&matrix, crate::Norm::Coefficients).unwrap();
        let head = Head::of(&samples).unwrap();
        let subspaces = subspaces(&samples, clusters, 0);
        let found = first(&samples, &head, &subspaces, &Quiet).unwrap();
        assert_eq!(found.members, brute_force(&samples, &subspaces), "{count} x {n}, {clusters} clusters");
    }
}

#[test]
fn subspaces_that_have_moved_are_looked_at_anew_and_those_that_have_not_need_not_be() {
    let matrix = matrix(400, 80);
    let samples = Samples::of(&matrix, crate::Norm::Coefficients).unwrap();
    let head = Head::of(&samples).unwrap();
    let (before, after) = (subspaces(&samples, 24, 0), subspaces(&samples, 24, 11));
    let mut state = first(&samples, &head, &before, &Quiet).unwrap();
    let mut mixed = before.clone();
    // One more subspace moves anywhere in each round; the drift of the others is nothing.
    for moved in [3usize, 0, 17, 5, 5, 23] {
        let mut drifts = vec![0.0; 24];
        drifts[moved] = f32::INFINITY;
        mixed.set(
            moved,
            if mixed.of(moved) == after.of(moved) { before.of(moved).clone() } else { after.of(moved).clone() },
        );
        state = again(&samples, &head, &mixed, &drifts, &state, &Quiet).unwrap();
        assert_eq!(state.members, brute_force(&samples, &mixed), "{moved}");
    }
    // Means that move a little, all at once.
    let means = |shift: f32| {
        let mean = |k: usize| {
            samples.row(k * 16).iter().enumerate().map(|(i, x)| x + shift * ((i * k) as f32).sin()).collect()
        };
        let subspace = |k| Subspace { mean: mean(k), components: Vec::new() };
        Subspaces::new(80, (0..24).map(subspace).collect())
    };
    let mut state = first(&samples, &head, &means(0.0), &Quiet).unwrap();
    let mut at = 0.0;
    for shift in [0.001, 0.01, 0.02, 0.05, 0.3] {
        let (old, new) = (means(at), means(shift));
        let drift = |k: usize| explicit(&old.of(k).mean, &new.of(k).mean, &[]).sqrt() as f32 * 1.000_001;
        state = again(&samples, &head, &new, &(0..24).map(drift).collect::<Vec<_>>(), &state, &Quiet).unwrap();
        assert_eq!(state.members, brute_force(&samples, &new), "{shift}");
        at = shift;
    }
}

#[test]
fn of_equal_subspaces_the_first_has_the_sample() {
    let matrix = matrix(100, 70);
    let samples = Samples::of(&matrix, crate::Norm::Coefficients).unwrap();
    let head = Head::of(&samples).unwrap();
    let one = subspaces(&samples, 6, 0);
    let twice = Subspaces::new(70, one.all().iter().rev().chain(one.all()).cloned().collect());
    let found = first(&samples, &head, &twice, &Quiet).unwrap();
    assert!(found.members.iter().all(|&k| k < 6));
    assert_eq!(found.members, brute_force(&samples, &twice));
}
