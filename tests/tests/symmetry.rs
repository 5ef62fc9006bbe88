//! What changes nothing in a matrix changes nothing that comes back: another order of samples, a sample or a column of zeros, another
//! scene beside it.

use ndarray::{Array2, ArrayView2, Axis, concatenate};
use prt_harness::registry::registry;
use prt_tests::*;
use prt_transfer::{Label, LightBasis, TransferMatrix};

/// Whether every row comes back as it would alone. What has a model of all samples, or a bound on the error of all, has not.
fn is_row_by_row(label: &Label) -> bool {
    let exact = ["dense", "csr", "compact", "f16", "runs", "visibility", "bicluster", "truncate"];
    let bounded = label.codec.params.iter().any(|(name, _)| name == "max_error");
    exact.contains(&label.codec.name.as_str()) && !bounded
}

/// What a method makes of a matrix, rows x lights; `None` where it is not defined on it.
fn made_of(label: &Label, matrix: TransferMatrix) -> Option<Array2<f32>> {
    let case = Case { name: "a variant", matrix };
    encode_where_defined(&registry(), label, &case).map(|(_, compressed)| decoded(&compressed))
}

/// Every label on every harmless case, with the elements and what the method makes of them. Noise has no clusters: which of them are found
/// is chance, and rows alone are tried on it.
fn for_every_method(mut law: impl FnMut(&Label, &Case, &Array2<f32>, &Array2<f32>)) {
    for label in labels(&registry()) {
        let mut tried = 0;
        for case in harmless().into_iter().filter(|case| case.name != "noise" || is_row_by_row(&label)) {
            let plain = with(&case.matrix, elements(&case.matrix));
            if let Some(made) = made_of(&label, plain) {
                law(&label, &case, &elements(&case.matrix), &made);
                tried += 1;
            }
        }
        assert!(tried > 0, "{label} is defined on no case");
    }
}

/// How many times as much a search may leave that began elsewhere, and what it may leave in any case: of a handful of clusters, each is a large
/// part of the error.
const LUCK: (f64, f64) = (2.0, 1e-3);

/// Draws of which the best counts, where a method draws.
const DRAWS: usize = 3;

/// The error of a method on a matrix: of the best of some draws where it draws.
fn least_error(label: &Label, matrix: &TransferMatrix) -> f64 {
    let draws = ["vq", "cpca", "slf", "cta"].contains(&label.codec.name.as_str());
    let of = |seed: usize| {
        let mut label = label.clone();
        if draws {
            label.codec.params.retain(|(name, _)| name != "seed");
            label.codec.params.push(("seed".into(), seed.to_string()));
        }
        let made = made_of(&label, matrix.clone()).expect("defined before");
        relative_error(made.view(), elements(matrix).view())
    };
    (0..if draws { DRAWS } else { 1 }).map(of).fold(f64::INFINITY, f64::min)
}

/// What a variant may leave where the original left `old`: no more than its bound where it has one.
fn allowed(label: &Label, old: f64) -> f64 {
    let bound = label.codec.params.iter().find(|(name, _)| name == "max_error");
    bound.and_then(|(_, value)| value.parse().ok()).unwrap_or(LUCK.0 * old + LUCK.1)
}

#[test]
fn permuting_samples_permutes_what_comes_back_or_costs_no_accuracy() {
    for_every_method(|label, case, exact, made| {
        let (samples, responses) = (case.matrix.shape().samples, case.matrix.shape().responses);
        // A step that is prime to all numbers of samples of the cases, which no sample is kept in its place by.
        let order: Vec<usize> = (0..samples).map(|i| (i * 7 + 3) % samples).collect();
        let rows: Vec<usize> = order.iter().flat_map(|s| s * responses..(s + 1) * responses).collect();
        assert!(rows.iter().collect::<std::collections::HashSet<_>>().len() == exact.nrows());
        let permuted = with(&case.matrix, exact.select(Axis(0), &rows));
        if is_row_by_row(label) {
            let found = made_of(label, permuted).expect("defined before");
            return assert!(found == made.select(Axis(0), &rows), "{label} on {}", case.name);
        }
        let [new, old] = [&permuted, &with(&case.matrix, exact.clone())].map(|matrix| least_error(label, matrix));
        assert!(new <= allowed(label, old), "{label} on {}: {new:e} {old:e}", case.name);
    });
}

#[test]
fn a_sample_of_zeros_comes_back_as_zeros_and_changes_no_other() {
    for_every_method(|label, case, exact, made| {
        let zeros = Array2::zeros((case.matrix.shape().responses, exact.ncols()));
        let more = concatenate![Axis(0), *exact, zeros];
        let more = with(&case.matrix, more);
        if is_row_by_row(label) {
            let found = made_of(label, more).expect("defined before");
            let (others, last) = found.view().split_at(Axis(0), exact.nrows());
            return assert!(others == made && last.iter().all(|v| *v == 0.0), "{label} on {}", case.name);
        }
        // It may take what one sample takes of a model, which leaves no more than the energy of one sample.
        let [new, old] = [&more, &with(&case.matrix, exact.clone())].map(|matrix| least_error(label, matrix));
        let one = 1.0 / case.matrix.shape().samples as f64;
        assert!(new <= allowed(label, old) + one, "{label} on {}: {new:e} {old:e}", case.name);
    });
}

#[test]
fn a_column_of_zeros_comes_back_as_zeros_and_changes_no_other() {
    for_every_method(|label, case, exact, _| {
        if label.transform.name != "identity" {
            return; // which are of the sphere, and know no column beside it
        }
        let plain = |elements: &Array2<f32>| {
            let (rows, lights) = elements.dim();
            let values = elements.iter().copied().collect();
            TransferMatrix::from_dense(values, rows, case.matrix.shape().responses, LightBasis::Plain { lights })
        };
        let more = plain(&concatenate![Axis(1), *exact, Array2::zeros((exact.nrows(), 1))]).expect("a case is valid");
        let exact = plain(exact).expect("a case is valid");
        let Some(made) = made_of(label, exact.clone()) else { return };
        let found = made_of(label, more.clone()).expect("defined before");
        let (others, last) = found.view().split_at(Axis(1), exact.lights());
        let most = |rows: ArrayView2<f32>| rows.iter().fold(0f32, |most, v| most.max(v.abs()));
        // The mean that a light field keeps of a sample is over all directions, one that is dark included.
        let kept = label.codec.name == "slf" || most(last) < 1e-5 * most(made.view());
        assert!(kept, "{label} on {}", case.name);
        // Sums of one number more round otherwise, which decides between clusters that are as near.
        if is_row_by_row(label) {
            let distance = far(others, made.view());
            return assert!(distance < 1e-5, "{label} on {}: {distance:e}", case.name);
        }
        let [new, old] = [&more, &exact].map(|matrix| least_error(label, matrix));
        assert!(new <= allowed(label, old), "{label} on {}: {new:e} {old:e}", case.name);
    });
}

/// With room for two matrices in its model, where it has one of a given size.
fn doubled(label: &Label) -> Label {
    let sizes: &[&str] = match label.codec.name.as_str() {
        "vq" | "cpca" | "slf" | "cta" => &["clusters"],
        "pca" => &["components"],
        "tucker" => &["view", "light", "sample"],
        _ => &[],
    };
    let mut label = label.clone();
    if label.codec.name == "pca"
        && label.codec.params.iter().all(|(name, _)| !["components", "max_error"].contains(&name.as_str()))
    {
        label.codec.params.push(("components".into(), "8".into())); // the default
    }
    for (name, value) in &mut label.codec.params {
        if let Some(size) = value.parse::<usize>().ok().filter(|_| sizes.contains(&name.as_str())) {
            // One component more, since two means are one and a direction.
            *value = (2 * size + usize::from(name == "components")).to_string();
        }
    }
    label
}

#[test]
fn two_unrelated_scenes_in_one_matrix_are_no_worse_than_each_alone() {
    let cases = harmless();
    let of = |name: &str| cases.iter().find(|case| case.name == name).expect("a case");
    for label in labels(&registry()) {
        for [first, second] in [["visibility", "windows"], ["smooth", "noise"]].map(|pair| pair.map(of)) {
            let exact = [first, second].map(|case| elements(&case.matrix));
            let both = concatenate![Axis(0), exact[0], exact[1]];
            let both = with(&first.matrix, both);
            let Some(found) = made_of(&doubled(&label), both.clone()) else { continue };
            let name = || format!("{label} on {} and {}", first.name, second.name);
            let alone = exact.map(|rows| with(&first.matrix, rows));
            if is_row_by_row(&label) {
                let alone = alone.map(|matrix| made_of(&label, matrix).expect("defined on both"));
                assert!(found == concatenate![Axis(0), alone[0], alone[1]], "{}", name());
                continue;
            }
            let energy = |matrix: &TransferMatrix| elements(matrix).iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
            let lost: f64 = alone.iter().map(|matrix| least_error(&label, matrix) * energy(matrix)).sum();
            let (new, old) = (least_error(&doubled(&label), &both), lost / energy(&both));
            assert!(new <= allowed(&label, old), "{}: {new:e} {old:e}", name());
        }
    }
}
