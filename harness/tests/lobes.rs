//! Lights of lobes as a user meets them: fitted, written, read, turned, relit with.

mod common;

use common::{difference, done, prt};
use serde_json::Value;

#[test]
fn a_fitted_light_relights_by_its_lobes_as_by_its_texels_and_turns() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let fit = ["fit-light", "room", "--lobes", "24", "--cubemap", "16", "--exchanges", "2", "--steps", "20"];
    let outputs = ["-o", "L.json", "--reconstruction", "L.exr", "--compare", "L.png", "--json"];
    let told: Value = serde_json::from_str(&done(&[&fit[..], &outputs[..]].concat(), folder)).unwrap();
    assert_eq!((&told["lobes"], &told["parameters"], &told["texels"]), (&24.into(), &144.into(), &1536.into()));
    let error = told["relative_squared_error"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.3, "{error}");
    let file: Value = serde_json::from_slice(&std::fs::read(folder.join("L.json")).unwrap()).unwrap();
    assert_eq!(file["fit"]["relative_squared_error"], told["relative_squared_error"]);
    assert_eq!(file["lobes"].as_array().unwrap().len(), 24);
    assert!(["L.exr", "L.png"].iter().all(|name| folder.join(name).metadata().unwrap().len() > 1000));

    done(&["precompute", "teapot", "--vertices", "60", "--signal", "diffuse", "-o", "T.npz"], folder);
    for (label, file) in [("srbf+dense", "S.prt"), ("csr", "C.prt")] {
        done(&["encode", label, "T.npz", "-o", file], folder);
        done(&["relight", file, "--light", "L.json", "-o", &format!("{file}.npy")], folder);
    }
    // Inner products of lobes beside sums over texels: what the projection of transfer loses lies between them.
    let apart = difference(folder, "S.prt.npy", "C.prt.npy");
    assert!(apart > 0.0 && apart < 2e-3, "{apart}");
    // A whole turn brings the light back, half a turn does not.
    for (degrees, file) in [("360", "same.npy"), ("180", "turned.npy")] {
        let turn = format!("0,0,1,{degrees}");
        done(&["relight", "S.prt", "--light", "L.json", "--rotate", &turn, "-o", file], folder);
    }
    assert!(difference(folder, "same.npy", "S.prt.npy") < 1e-10);
    assert!(difference(folder, "turned.npy", "S.prt.npy") > 1e-3);
}

#[test]
fn what_is_no_light_of_lobes_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(
        &["precompute", "teapot", "--vertices", "60", "--signal", "diffuse", "--basis", "cubemap:4", "-o", "T.npz"],
        folder,
    );
    done(&["encode", "csr", "T.npz", "-o", "T.prt"], folder);
    let lobe = |kernel: &str, bandwidth: &str| {
        format!(r#"{{"kernel":"{kernel}","lobes":[{{"centre":[0,0,1],"bandwidth":{bandwidth},"radiance":[1,1,1]}}]}}"#)
    };
    let cases = [
        ("{".to_string(), "prt fit-light"),
        (lobe("cosine", "3"), "gaussian, abel-poisson"),
        (lobe("gaussian", "-3"), "bandwidth"),
        (lobe("gaussian", "3").replace("0,0,1", "0,0,7"), "unit vector"),
    ];
    for (text, expected) in cases {
        std::fs::write(folder.join("L.json"), &text).unwrap();
        let output = prt(&["relight", "T.prt", "--light", "L.json", "-o", "y.npy"], folder);
        let message = String::from_utf8_lossy(&output.stderr).to_string();
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
    let output = prt(&["relight", "T.prt", "--light", "sky", "--rotate", "0,0,1,90", "-o", "y.npy"], folder);
    assert!(String::from_utf8_lossy(&output.stderr).contains("--rotate"));
}
