//! Tensors as a user meets them: transfer that is never held as a whole, compressed and relit.

mod common;

use common::{difference, done, prt};
use serde_json::Value;

const LABEL: &str = "srbf:centers=42+cta:clusters=3:view=4:light=12:sample=8:numbers=f32";

#[test]
fn coefficients_that_were_streamed_are_compressed_as_those_of_the_matrix() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = ["precompute", "teapot", "--vertices", "60", "--signal", "terms", "--terms", "6"];
    let basis = ["--basis", "cubemap:8"];
    let streamed = ["--transform", "srbf:centers=42", "-o", "C.npy", "--json"];
    let told: Value = serde_json::from_str(&done(&[&scene[..], &basis, &streamed].concat(), folder)).unwrap();
    assert_eq!((&told["lights"], &told["basis"]), (&42.into(), &"lobes:42:orthonormal".into()));
    let lost = told["lost_by_transform"].as_f64().unwrap();
    done(&[&scene[..], &basis, &["-o", "T.npz"]].concat(), folder);

    let responses = told["response_basis"].as_str().unwrap();
    done(&["encode", LABEL, "T.npz", "-o", "T.prt"], folder);
    let described = ["--transformed", "--responses", responses, "--basis", "cubemap:8"];
    let said = done(&[&["encode", LABEL, "C.npy", "-o", "C.prt"][..], &described].concat(), folder);
    assert!(said.contains("3 clusters in") && said.contains("relative squared error"), "{said}");
    for name in ["T", "C"] {
        done(&["relight", &format!("{name}.prt"), "--light", "sky", "-o", &format!("{name}-lit.npy")], folder);
    }
    assert!(difference(folder, "C-lit.npy", "T-lit.npy") < 1e-8);

    // What is told to be lost is the error over the sphere of the projection alone.
    let bench = ["bench", "--scene", "T.npz", "--method", "srbf:centers=42+dense", "--out", "bench"];
    done(&bench, folder);
    let mut reader = csv::Reader::from_path(folder.join("bench/results.csv")).unwrap();
    let column = reader.headers().unwrap().iter().position(|name| name == "error_sphere").unwrap();
    let measured: f64 = reader.records().next().unwrap().unwrap()[column].parse().unwrap();
    assert!((measured / lost - 1.0).abs() < 1e-3, "{measured} {lost}");
}

#[test]
fn a_matrix_that_is_not_what_the_transform_makes_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(
        &["precompute", "teapot", "--vertices", "60", "--signal", "diffuse", "--basis", "cubemap:8", "-o", "T.npz"],
        folder,
    );
    let output = prt(&["encode", LABEL, "T.npz", "--transformed", "--basis", "cubemap:8", "-o", "T.prt"], folder);
    let message = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    let bounced =
        ["precompute", "teapot", "--vertices", "60", "--signal", "diffuse", "--bounces", "1", "--brdf", "lambert"];
    let output = prt(&[&bounced[..], &["--transform", "srbf", "-o", "C.npy"]].concat(), folder);
    assert!(String::from_utf8_lossy(&output.stderr).contains("without bounces"), "{output:?}");
}
