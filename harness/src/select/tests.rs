use super::*;
use crate::compute::precompute;
use crate::signal::Spec;
use prt_transfer::{Quiet, TransferMatrix};

fn diffuse(vertices: usize) -> TransferMatrix {
    let spec = Spec::new(Signal::Diffuse, LightBasis::Cubemap { resolution: 8 });
    precompute("bumpy-sphere", Some(vertices), &spec, &Quiet).unwrap().matrix
}

fn glossy(vertices: usize) -> TransferMatrix {
    let spec = Spec::new(Signal::Glossy, LightBasis::SphericalHarmonics { order: 4 });
    precompute("bumpy-sphere", Some(vertices), &spec, &Quiet).unwrap().matrix
}

fn goal(bound: Bound) -> Goal {
    Goal { bound, storage: Storage::File, norm: Norm::Coefficients }
}

/// Runs `work` with a search of a matrix on so many threads.
fn searching<T>(matrix: TransferMatrix, goal: Goal, threads: usize, work: impl FnOnce(&mut Search) -> T) -> T {
    let (registry, pools) = (registry(), Pools::new(threads).unwrap());
    let reference = Reference::new(matrix).unwrap();
    let bench = Bench { registry: &registry, pools: &pools, budget: Budget::of(Duration::ZERO) };
    work(&mut Search::new(&bench, &reference, goal).unwrap())
}

fn candidates(matrix: &TransferMatrix) -> Vec<Candidate> {
    fitting(&registry(), Kind::of_matrix(matrix)).unwrap()
}

/// Of every family that has a grid: the search beside the whole grid.
fn compared(matrix: TransferMatrix, bounds: &[Bound]) {
    let candidates = candidates(&matrix);
    let search_of = |search: &mut Search, bound: Bound| {
        let goal = goal(bound);
        search.set_bound(bound);
        for (family, base) in &candidates {
            if search.grid_of(family, base) == 1 {
                continue;
            }
            let found = search.best_of(family, base, None).unwrap();
            let all = search.best_of_all(family, base, &mut || ()).unwrap();
            let name = format!("{base} {bound:?}: {:?} of {}", found.encodes, found.grid);
            if found.grid >= 20 {
                assert!(10 * found.encodes <= found.grid, "{name}");
            }
            if let Some(of_grid) = &all.found {
                let trial =
                    &found.found.as_ref().unwrap_or_else(|| panic!("{name}: grid has {:?}", of_grid.trial)).trial;
                let gap = goal.gap(trial, &of_grid.trial);
                assert!(gap <= 0.05, "{name}: {trial:?}\n{:?}", of_grid.trial);
            }
        }
    };
    searching(matrix, goal(bounds[0]), 2, |search| bounds.iter().for_each(|&bound| search_of(search, bound)));
}

#[test]
fn a_search_of_diffuse_transfer_is_within_a_twentieth_of_the_whole_grid_for_a_tenth_of_its_encodes() {
    compared(diffuse(40), &[Bound::Error(1e-2), Bound::Error(1e-3), Bound::Bytes(20_000)]);
}

#[test]
fn a_search_of_glossy_transfer_is_within_a_twentieth_of_the_whole_grid_for_a_tenth_of_its_encodes() {
    compared(glossy(40), &[Bound::Error(1e-2), Bound::Error(1e-3), Bound::Bytes(20_000)]);
}

#[test]
fn every_model_that_is_found_keeps_its_bound_when_it_is_read_back() {
    let matrix = diffuse(40);
    for (bound, storage, norm) in [
        (Bound::Error(3e-3), Storage::File, Norm::Coefficients),
        (Bound::Error(3e-3), Storage::Resident, Norm::Sphere),
        (Bound::Bytes(12_000), Storage::File, Norm::Coefficients),
        (Bound::Bytes(40_000), Storage::Resident, Norm::Sphere),
    ] {
        let goal = Goal { bound, storage, norm };
        searching(matrix.clone(), goal, 2, |search| {
            let mut found = 0;
            for (family, base) in candidates(&matrix) {
                let outcome = search.best_of(&family, &base, Some(8)).unwrap();
                assert!(outcome.encodes <= 8);
                match outcome.found {
                    Some(Found { trial, file }) => {
                        let compressed = files::prt_from_bytes(&file, &registry()).unwrap();
                        let (error, over_sphere) = Reference::new(matrix.clone()).unwrap().error_of(&compressed);
                        assert_eq!((error, over_sphere), (trial.error, trial.error_sphere));
                        assert!(goal.keeps(&trial), "{base}: {trial:?}");
                        found += 1;
                    }
                    // What cannot keep it is told by how much.
                    None => assert!(outcome.reason.is_some() || !goal.keeps(outcome.trial().unwrap()), "{base}"),
                }
            }
            assert!(found > 4, "{bound:?}: {found}");
        });
    }
}

#[test]
fn the_same_model_is_found_on_any_number_of_threads() {
    let of = |threads| {
        let matrix = glossy(40);
        let candidates = candidates(&matrix);
        searching(matrix, goal(Bound::Error(5e-3)), threads, |search| {
            let best = candidates.iter().map(|(family, base)| search.best_of(family, base, Some(9)).unwrap());
            best.map(|outcome| (outcome.encodes, outcome.found.map(|found| found.file))).collect::<Vec<_>>()
        })
    };
    assert!(of(1) == of(2));
}

#[test]
fn the_tail_energy_of_the_spectrum_is_exactly_what_principal_components_need() {
    let matrix = diffuse(40);
    for bound in [0.1, 1e-2, 1e-3, 1e-4] {
        searching(matrix.clone(), goal(Bound::Error(bound)), 1, |search| {
            let (family, base) = families::named(&registry(), "pca").unwrap();
            let outcome = search.best_of(&family, &base, None).unwrap();
            let components = outcome.estimates[0].number;
            assert_eq!(outcome.estimates[0].by, "tail energy");
            for (components, enough) in [(components, true), (components - 1, false)] {
                let label = format!("pca:components={components}");
                let (family, base) = families::named(&registry(), &label).unwrap();
                let outcome = search.best_of(&family, &base, None).unwrap();
                assert_eq!(outcome.found.is_some(), enough, "{label} {bound}");
            }
        });
    }
}

#[test]
fn a_method_that_does_not_exist_is_refused_and_parameters_that_are_given_stay() {
    let registry = registry();
    assert!(families::named(&registry, "zpca").unwrap_err().to_string().contains("'zpca'"));
    assert!(families::named(&registry, "pca:clusters=3").is_err());
    let matrix = diffuse(40);
    searching(matrix, goal(Bound::Error(1e-2)), 1, |search| {
        let (family, base) = families::named(&registry, "cpca:mode=iterative:clusters=2").unwrap();
        let (whole, any) = families::named(&registry, "cpca").unwrap();
        let [left, all] = [search.grid_of(&family, &base), search.grid_of(&whole, &any)];
        assert!((2..=all / 2).contains(&left), "components and numbers are left: {left} of {all}");
        let trial = search.best_of(&family, &base, Some(6)).unwrap().found.unwrap().trial;
        assert!(trial.label.contains("clusters=2") && trial.label.contains("mode=iterative"), "{}", trial.label);
    });
}
