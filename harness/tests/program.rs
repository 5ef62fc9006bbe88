//! The program as a user meets it: exit codes, one sentence of failure, files that agree with each other.

mod common;

use common::{done, prt, refused};
use serde_json::Value;
use std::path::Path;

/// The first built-in scene.
fn scene(folder: &Path) -> String {
    let list: Value = serde_json::from_str(&done(&["scenes", "--json"], folder)).unwrap();
    list["scenes"][0]["name"].as_str().unwrap().to_string()
}

fn precompute(folder: &Path, signal: &str, file: &str) -> Value {
    let scene = scene(folder);
    let arguments =
        ["precompute", &scene, "--signal", signal, "--basis", "cubemap:8", "--vertices", "80", "-o", file, "--json"];
    serde_json::from_str(&done(&arguments, folder)).unwrap()
}

#[test]
fn a_matrix_goes_through_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let made = precompute(folder, "biscale", "T.npz");
    assert_eq!((&made["responses"], &made["lights"]), (&64.into(), &384.into()));
    let mut written: Value =
        serde_json::from_str(&done(&["encode", "csr", "T.npz", "-o", "T.prt", "--json"], folder)).unwrap();
    let told = done(&["info", "T.prt", "--json"], folder);
    let mut of_encoding = |name: &str| written.as_object_mut().unwrap().remove(name).unwrap();
    let (seconds, peak) = (of_encoding("encode_s"), of_encoding("peak_encode_bytes"));
    assert_eq!(written, serde_json::from_str::<Value>(&told).unwrap());
    // What was encoded is a part of what was held, and this codec needs little else.
    let size = written["resident_bytes"].as_u64().unwrap();
    assert!(seconds.as_f64() > Some(0.0) && (size..2 * size + 65_536).contains(&peak.as_u64().unwrap()), "{peak}");

    let info: Value = serde_json::from_str(&told).unwrap();
    assert_eq!(info["label"], "csr");
    for name in ["samples", "responses", "lights"] {
        assert_eq!(info[name], made[name]);
    }
    assert_eq!(info["file_bytes"], folder.join("T.prt").metadata().unwrap().len());
    let sections = info["sections"].as_object().unwrap();
    assert_eq!(info["resident_bytes"], sections.values().map(|v| v.as_u64().unwrap()).sum::<u64>());
    assert_eq!((&info["multiplications"], &info["additions"]), (&made["non_zeros"], &made["non_zeros"]));

    // What was decoded compresses to the same bytes.
    done(&["decode", "T.prt", "-o", "T2.npz"], folder);
    done(&["encode", "csr", "T2.npz", "-o", "T2.prt"], folder);
    let bytes = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(bytes("T.prt"), bytes("T2.prt"));

    done(&["relight", "T.prt", "--light", "sky", "-o", "y.npy"], folder);
    done(&["--threads", "1", "relight", "T.prt", "--light", "sky", "-o", "y1.npy"], folder);
    assert_eq!(bytes("y.npy"), bytes("y1.npy"), "any number of threads gives the same");
}

#[test]
fn failures_are_one_sentence_with_the_place_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "T.npz");
    std::fs::write(folder.join("broken.prt"), "nothing of the kind").unwrap();
    for (arguments, part) in [
        (&["encode", "csr", "absent.npz", "-o", "out.prt"][..], "absent.npz"),
        (&["encode", "nothing", "T.npz", "-o", "out.prt"], "unknown codec 'nothing'"),
        (&["encode", "csr:terms=3", "T.npz", "-o", "out.prt"], "terms"),
        (&["encode", "a+b+c", "T.npz", "-o", "out.prt"], "3 stages"),
        (&["encode", "csr", "T.npz", "-o", "out.prt", "--basis", "sh:5"], "sh:5"),
        (&["info", "broken.prt"], "broken.prt"),
        (&["decode", "broken.prt", "-o", "out.npz"], "broken.prt"),
        (&["precompute", "nowhere", "--signal", "diffuse", "-o", "out.npz"], "nowhere"),
        (&["bench", "--scene", "nowhere"], "unknown scene 'nowhere'"),
        (&["bench", "--method", "nothing"], "unknown codec 'nothing'"),
        (&["tables", "biclustering", "--method", "nothing"], "unknown codec 'nothing'"),
        (&["tables", "biclustering", "--method", "csr", "--scene", "nowhere"], "nowhere"),
        (&["tables", "biclustering", "--method", "csr", "--assets", "absent"], "absent"),
        (&["tables", "biclustering", "--full"], "leave --full out"),
        (&["tables", "slf", "--scene", "torus"], "leave --scene"),
        (&["tables", "tensor", "--table", "bytes"], "table1, table2, figure4, figure5"),
        (&["stability", "biclustering", "--method", "nothing"], "unknown codec 'nothing'"),
        (&["stability", "biclustering", "--method", "csr", "--sweep", "nothing"], "unknown sweep 'nothing'"),
        (&["figures", "clustered-pca", "--figure", "nothing"], "unknown figure 'nothing'"),
        (&["figures", "clustered-pca", "--figure", "figure2", "--assets", "absent"], "absent"),
    ] {
        let message = refused(1, arguments, folder);
        assert!(message.starts_with("prt: ") && message.contains(part), "{arguments:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    let left: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().starts_with("out")), "{left:?}");
}

#[test]
fn wrong_usage_is_told_apart_from_failure() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["unknown"][..],
        &["bench", "--unknown"],
        &["bench", "--quick", "--full"],
        &["--threads", "0", "scenes"],
        &["precompute", "x", "-o", "T.npz"],
        &["precompute", "x", "--signal", "glass", "-o", "T.npz"],
        &["precompute", "x", "--signal", "diffuse", "--vertices", "0", "-o", "T.npz"],
        &["encode", "csr", "T.npz", "-o", "T.prt", "--basis", "cube"],
        &["info"],
        &["tables", "unwritten"],
        &["tables", "srbf"],
        &["tables", "--table", "table1"],
        &["tables", "--out", "x"],
        &["tables", "--full"],
        &["tables", "biclustering", "--assets", ".", "--vertices", "100"],
        &["stability", "unwritten"],
        &["figures", "unwritten"],
        &["figures", "clustered-pca", "--assets", ".", "--vertices", "100"],
    ] {
        assert!(refused(2, arguments, folder.path()).contains("--help"), "{arguments:?}");
    }
}

#[test]
fn every_command_helps_with_an_example() {
    let folder = tempfile::tempdir().unwrap();
    for command in [
        "bench",
        "precompute",
        "encode",
        "decode",
        "export",
        "import",
        "relight",
        "coherence",
        "render",
        "info",
        "tables",
        "stability",
        "figures",
        "scenes",
        "methods",
    ] {
        let help = done(&[command, "--help"], folder.path());
        assert!(help.contains("Example") && help.contains(&format!("prt {command}")), "{help}");
    }
}

#[test]
fn a_relit_scene_is_rendered_beside_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "T.npz");
    done(&["encode", "csr", "T.npz", "-o", "T.prt"], folder);
    let scene = scene(folder);
    let common = ["render", &scene, "--vertices", "80", "--size", "40x30", "--samples", "1", "--light", "room"];
    let render = |more: &[&str]| done(&[&common[..], more].concat(), folder);
    render(&["--reference", "--basis", "cubemap:8", "-o", "exact.exr"]);
    render(&["T.npz", "-o", "relit.exr"]);
    let maps = ["--error-map", "error.png", "--beside", "row.png"];
    let compare = [&["T.prt", "--compare", "exact.exr", "-o", "relit.png", "--json"][..], &maps].concat();
    let told: Value = serde_json::from_str(&render(&compare)).unwrap();
    let figure = |name: &str| told[name].as_f64().unwrap();
    assert!((0.0..0.5).contains(&figure("relative_squared_error")) && figure("psnr_db") > 10.0, "{told}");
    assert!((0.1..1.0).contains(&figure("filled")) && figure("seconds") > 0.0 && figure("exposure").is_finite());
    for name in ["relit.png", "error.png", "row.png"] {
        assert!(std::fs::read(folder.join(name)).unwrap().starts_with(b"\x89PNG"), "{name}");
    }
    // Against itself there is no error, and a decibel without one is no number.
    let same: Value =
        serde_json::from_str(&render(&["T.npz", "--compare", "relit.exr", "-o", "same.exr", "--json"])).unwrap();
    assert_eq!((&same["relative_squared_error"], &same["psnr_db"]), (&0.0.into(), &Value::Null));
    let bytes = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(bytes("same.exr"), bytes("relit.exr"));

    let fails = |more: &[&str], part: &str| {
        let message = refused(1, &[&common[..], more].concat(), folder);
        assert!(message.contains(part) && message.lines().count() == 1, "{message}");
    };
    fails(&["T.npz", "-o", "out.jpg"], ".png or .exr");
    fails(&["T.npz", "-o", "out.exr", "--tone", "filmic"], "--tone");
    fails(&["T.npz", "-o", "out.exr", "--exposure", "-1"], "--exposure");
    fails(&["T.prt", "-o", "out.png", "--basis", "cubemap:4"], "--basis");
    fails(&["T.npz", "-o", "out.png", "--compare", "absent.exr"], "absent.exr");
    fails(&["T.npz", "-o", "out.png", "--brdf", "phong"], "lambert");
    fails(&["--reference", "--basis", "sh:5", "-o", "out.png"], "cubemap:EDGE");
    let finer = ["render", &scene, "T.npz", "--vertices", "300", "-o", "out.png"];
    let message = refused(1, &finer, folder);
    assert!(message.contains("samples of T.npz") && message.contains("found "), "{message}");
    for wrong in [&["T.npz", "--reference"][..], &[], &["T.npz", "--size", "40"], &["T.npz", "--brdf", "velvet"]] {
        refused(2, &[&["render", &scene, "-o", "out.png"], wrong].concat(), folder);
    }
    assert!(!folder.join("out.png").exists() && !folder.join("out.exr").exists());
}

/// What every signal makes of a scene of one BRDF is what the light traced by itself makes of it, to what vertices far
/// apart allow.
#[test]
fn every_signal_is_computed_compressed_and_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (scene, common) =
        ("bumpy-sphere", ["--vertices", "400", "--size", "24x24", "--samples", "1", "--light", "room"]);
    let rough = "cook-torrance:roughness=0.6:f0=0.5:diffuse=0.5:specular=0.5";
    let cases: [(&str, &str, &[&str], &[&str]); 6] = [
        ("diffuse", "lambert", &[], &["--brdf", "lambert"]),
        ("biscale", rough, &[], &["--brdf", rough]),
        ("glossy", rough, &["--brdf", rough], &[]),
        ("glossy", rough, &["--brdf", rough, "--orthonormal", "--coefficients", "36", "--incident", "8"], &[]),
        ("terms", rough, &["--brdf", rough, "--terms", "24"], &[]),
        ("terms", "lambert", &["--brdf", "lambert", "--terms", "90%"], &[]),
    ];
    for (signal, brdf, options, shown) in cases {
        let precompute = ["precompute", scene, "--vertices", "400", "--signal", signal, "--json", "-o", "T.npz"];
        let basis: &[&str] = if signal == "glossy" { &["--basis", "sh:8"] } else { &["--basis", "cubemap:16"] };
        let told: Value = serde_json::from_str(&done(&[&precompute, basis, options].concat(), folder)).unwrap();
        done(&["encode", "csr", "T.npz", "-o", "T.prt"], folder);
        let info: Value = serde_json::from_str(&done(&["info", "T.prt", "--json"], folder)).unwrap();
        assert_eq!(info["response_basis"], told["response_basis"]);
        let render = |more: &[&str]| done(&[&["render", scene][..], &common, more].concat(), folder);
        render(&["--reference", "--basis", "cubemap:16", "--brdf", brdf, "-o", "exact.exr"]);
        let compare = [&["T.prt", "--compare", "exact.exr", "-o", "relit.exr", "--json"][..], shown].concat();
        let told: Value = serde_json::from_str(&render(&compare)).unwrap();
        let error = told["relative_squared_error"].as_f64().unwrap();
        assert!(error < 0.03, "{signal} {options:?}: {error}");
    }
    let foreign = |arguments: &[&str], part: &str| {
        let message = refused(1, &[&["precompute", scene, "-o", "X.npz"][..], arguments].concat(), folder);
        assert!(message.contains(part) && message.lines().count() == 1, "{message}");
    };
    foreign(&["--signal", "diffuse", "--terms", "4"], "--terms belongs to --signal terms");
    foreign(&["--signal", "diffuse", "--brdf", "phong"], "--bounces");
    foreign(&["--signal", "diffuse", "--brdf", "phong", "--bounces", "1"], "lambert");
    foreign(&["--signal", "terms", "--bounces", "1"], "--bounces belongs to --signal diffuse or glossy");
    foreign(&["--signal", "glossy", "--basis", "cubemap:8"], "sh:ORDER");
    foreign(&["--signal", "glossy", "--coefficients", "17"], "17");
    foreign(&["--signal", "terms", "--brdf", "lambert", "--terms", "2"], "terms");
    foreign(&["--signal", "diffuse", "--up", "y"], "z, as of every built-in scene");
    refused(2, &["precompute", scene, "--signal", "glossy", "--brdf", "velvet", "-o", "X.npz"], folder);
    assert!(!folder.join("X.npz").exists());
}

/// A matrix that is written as it is computed is the one that is computed as a whole, and a bare file is read by its
/// description.
#[test]
fn a_streamed_matrix_is_the_same_and_must_be_described() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let of = ["precompute", "blob", "--vertices", "300", "--signal", "terms", "--terms", "3", "--basis", "cubemap:4"];
    let said = done(&[&of[..], &["-o", "T.npy"]].concat(), folder);
    assert!(
        said.contains("--responses terms:3:cook-torrance:roughness=0.3:") && said.contains("--basis cubemap:4"),
        "{said}"
    );
    done(&[&of[..], &["-o", "T.npz"]].concat(), folder);
    let described = ["--responses", "terms:3:cook-torrance", "--basis", "cubemap:4"];
    done(&[&["encode", "dense", "T.npy", "-o", "streamed.prt"][..], &described].concat(), folder);
    done(&["encode", "dense", "T.npz", "-o", "whole.prt"], folder);
    for name in ["streamed", "whole"] {
        let (file, out) = (format!("{name}.prt"), format!("{name}.npy"));
        done(&["relight", &file, "--light", "sky", "-o", &out], folder);
    }
    let bytes = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(bytes("streamed.npy"), bytes("whole.npy"));
    let render = ["render", "blob", "T.npy", "--vertices", "300", "--size", "8x8", "-o", "x.png"];
    assert!(refused(1, &render, folder).contains("--basis"));
    assert!(refused(1, &[&render[..], &described[2..]].concat(), folder).contains("--responses"));
    done(&[&render[..], &described].concat(), folder);
}

#[test]
fn a_table_stands_beside_the_paper_s_and_a_mesh_that_is_missing_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let usual = ["tables", "biclustering", "--method", "csr", "--vertices", "40"];
    let text = done(&[&usual[..], &["--scene", "bunny,armor", "--out", "built-in"]].concat(), folder);
    assert!(
        text.contains("bunny, the paper's") && text.contains("blob, compact") && text.contains("armor: "),
        "{text}"
    );
    let csv = std::fs::read_to_string(folder.join("built-in/table1.csv")).unwrap();
    // What is printed of both, two methods on the bunny's stand-in, and a line that says why there is no armor.
    assert_eq!(csv.lines().count(), 1 + 2 + 2 + 1, "{csv}");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let names = reader.headers().unwrap().clone();
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let figure =
        |line: usize, name: &str| records[line][names.iter().position(|n| n == name).unwrap()].parse::<f64>().unwrap();
    let part = "computation_percent";
    assert_eq!((figure(0, part), figure(1, part), figure(1, "error")), (27.4, 100.0, 0.0));
    assert!(figure(1, "peak_encode_mb") > figure(1, "resident_mb") && figure(1, "times_compact") > 0.0);
    // None of the scenes of Figure 6.
    assert!(!folder.join("built-in/figure6.csv").exists());

    let mesh = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                element face 4\nproperty list uchar int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
    std::fs::create_dir(folder.join("meshes")).unwrap();
    std::fs::write(folder.join("meshes/bunny_3k.ply"), mesh).unwrap();
    let assets = ["tables", "biclustering", "--method", "csr", "--assets", "meshes", "--scene"];
    let text = done(&[&assets[..], &["bunny,bunny_12k", "--out", "some"]].concat(), folder);
    assert!(text.contains("bunny_12k: ") && text.contains("meshes/bunny_12k.ply"), "{text}");
    let page = std::fs::read_to_string(folder.join("some/tables.md")).unwrap();
    assert!(page.contains("| bunny_3k, csr | 4 |") && page.contains("meshes/bunny_12k.ply"), "{page}");
    let message =
        refused_with_tables(&[&assets[..], &["chair", "--table", "table1", "--out", "none"]].concat(), folder);
    assert_eq!(message.lines().count(), 1, "{message}");
}

/// As [`refused`] with 1, where the tables have been printed before.
fn refused_with_tables(arguments: &[&str], folder: &Path) -> String {
    let output = prt(arguments, folder);
    assert_eq!(output.status.code(), Some(1));
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_sweep_has_its_figures_and_its_chart() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let arguments = ["stability", "biclustering", "--method", "csr", "--sweep", "vertices", "--vertices", "40"];
    let text = done(&[&arguments[..], &["--out", "out"]].concat(), folder);
    let csv = std::fs::read_to_string(folder.join("out/vertices.csv")).unwrap();
    assert!(text.contains("compact") && csv.lines().count() > 2 * 4 && !csv.contains(",failed,"), "{csv}");
    for extension in ["svg", "png"] {
        assert!(folder.join(format!("out/vertices.{extension}")).metadata().unwrap().len() > 0);
    }
    assert!(!folder.join("out/values.csv").exists());
}
