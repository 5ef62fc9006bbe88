//! `prt bench` as a user meets it: what it writes, what it repeats, what it survives.

mod common;

use common::{done, prt, refused, untimed};
use prt_harness::files;
use prt_transfer::image::Image;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn precompute(folder: &Path, signal: &str, file: &str) {
    done(&["precompute", "teapot", "--signal", signal, "--basis", "cubemap:8", "--vertices", "80", "-o", file], folder);
}

#[test]
fn a_bench_writes_everything_and_never_measures_a_row_twice() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "T.npz");
    let arguments = ["bench", "--quick", "--scene", "T.npz", "--method", "csr", "--out", "out", "--json"];
    let first: Value = serde_json::from_str(&done(&arguments, folder)).unwrap();
    let row = &first[0];
    assert_eq!((row["status"].as_str(), row["error"].as_f64()), (Some("ok"), Some(0.0)));
    let path = |name: &str| folder.join("out").join(name);
    let csv = std::fs::read_to_string(path("results.csv")).unwrap();
    assert_eq!(csv.lines().count(), 2, "{csv}");
    for name in ["machine.json", "report.html"] {
        assert!(path(name).metadata().unwrap().len() > 0, "{name}");
    }
    for name in ["speed", "storage", "encode"] {
        for extension in ["svg", "png", "csv"] {
            assert!(path("charts").join(format!("T.npz-{name}.{extension}")).exists(), "{name}.{extension}");
        }
    }
    // Times differ from run to run: the same file means that nothing was measured.
    let second: Value = serde_json::from_str(&done(&arguments, folder)).unwrap();
    assert_eq!(first, second);
    assert_eq!(std::fs::read_to_string(path("results.csv")).unwrap(), csv);
    // Another matrix under the same name is another measurement.
    precompute(folder, "biscale", "T.npz");
    let third: Value = serde_json::from_str(&done(&arguments, folder)).unwrap();
    assert_ne!(first[0]["fingerprint"], third[0]["fingerprint"]);
    assert_ne!(first[0]["relight_1_ms"], third[0]["relight_1_ms"]);
}

#[test]
fn what_fails_is_a_row_with_its_reason_and_nothing_but_failures_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "T.npz");
    std::fs::write(folder.join("bad.npz"), "no archive").unwrap();
    let bad = ["bench", "--quick", "--scene", "bad.npz", "--method", "csr", "--out", "out"];
    let output = prt(&bad, folder);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(String::from_utf8(output.stderr).unwrap().lines().count(), 1);
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("failed") && table.contains("csr: bad.npz"), "{table}");

    let table = done(&[&bad[..], &["--scene", "T.npz"]].concat(), folder);
    assert!(table.contains("csr: bad.npz") && table.contains("T.npz · file · cubemap:8"), "{table}");
    let csv = std::fs::read_to_string(folder.join("out/results.csv")).unwrap();
    assert!(csv.contains(",failed,") && csv.contains(",ok,"), "{csv}");
}

/// Pictures of a bench are those of `prt render`, with the same errors.
#[test]
fn a_bench_of_a_scene_takes_its_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let pixels = (0..32 * 16).map(|i| [(i % 37) as f32, (i % 5) as f32, 1.0]).collect();
    files::write_radiance(&folder.join("hall.exr"), &Image { width: 32, height: 16, pixels }).unwrap();
    let bench = ["bench", "--quick", "--scene", "teapot", "--signal", "diffuse,biscale", "--out", "out", "--json"];
    let more = ["--method", "csr", "--method", "sh:order=2+dense", "--light", "room", "--light", "hall.exr"];
    let rows: Vec<Value> = serde_json::from_str(&done(&[&bench[..], &more].concat(), folder)).unwrap();
    let figure = |row: &Value, name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} of {row}"));
    for pair in rows.chunks(2) {
        let [exact, coarse] = pair else { panic!("two rows a matrix") };
        for name in ["picture_error", "picture_flip", "flicker"] {
            assert!(figure(exact, name) < 1e-3 && figure(coarse, name) > 0.02, "{name} {pair:?}");
        }
        assert!(figure(coarse, "picture_psnr_db") < 40.0 && exact["picture_psnr_db"].as_f64().is_none_or(|p| p > 70.0));
    }
    for (row, brdf) in rows.chunks(2).map(|pair| &pair[1]).zip([&[][..], &["--brdf", "cook-torrance"]]) {
        let stem = if brdf.is_empty() { "diffuse-cubemap16-m1" } else { "biscale-cubemap16-m1-d8" };
        let file = |method: &str| format!("out/encoded/teapot-150-{stem}-{method}.prt");
        let alike =
            ["--vertices", "150", "--crop", "--size", "256x192", "--background", "0.03,0.03,0.03", "-o", "x.exr"];
        let render = |method: &str, more: &[&str]| {
            done(&[&["render", "teapot", &file(method)][..], &alike, brdf, more].concat(), folder)
        };
        render("csr", &[]);
        std::fs::rename(folder.join("x.exr"), folder.join("exact.exr")).unwrap();
        let told = render("sh_order_2_dense", &["--compare", "exact.exr", "--json"]);
        let told: Value = serde_json::from_str(&told).unwrap();
        let columns =
            [("relative_squared_error", "picture_error"), ("psnr_db", "picture_psnr_db"), ("flip", "picture_flip")];
        for (a, b) in columns.map(|(of_render, of_bench)| (figure(&told, of_render), figure(row, of_bench))) {
            assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}: {told} {row}");
        }
    }
    let pictures = folder.join("out/pictures");
    let csv = std::fs::read_to_string(pictures.join("pictures.csv")).unwrap();
    // Two matrices under two lights, one method each.
    assert_eq!(csv.lines().count(), 1 + 4, "{csv}");
    for light in ["room", "hall"] {
        for kind in
            ["reference", "reference-strip", "sh_order_2_dense", "sh_order_2_dense-flip", "sh_order_2_dense-strip"]
        {
            let png =
                std::fs::read(pictures.join(format!("teapot-150-diffuse-cubemap16-m1-{light}-{kind}.png"))).unwrap();
            assert!(png.starts_with(b"\x89PNG"));
        }
    }
    let message = refused(1, &["bench", "--light", "moon"], folder);
    assert!(message.contains("unknown light 'moon'") && message.lines().count() == 1, "{message}");
}

/// Errors, bytes and operations are no matter of luck, nor of threads. The peak of memory is one of how threads share their work, of which one
/// alone has no choice.
#[test]
fn what_no_clock_measures_is_the_same_in_every_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = |threads: &str, out: &str| {
        let arguments =
            ["bench", "--threads", threads, "--quick", "--signal", "diffuse,glossy", "--out", out, "--json"];
        let mut rows = untimed(&done(&arguments, folder));
        let taken = |row: &mut Value, name: &str| row.as_object_mut().and_then(|row| row.remove(name)?.as_u64());
        let peaks: Vec<u64> = rows.iter_mut().filter_map(|row| taken(row, "peak_encode_bytes")).collect();
        assert!(peaks.len() > 15 && rows.iter_mut().all(|row| taken(row, "threads").is_some()));
        (rows, peaks)
    };
    let (first, second, both) = (run("1", "first"), run("1", "second"), run("2", "both"));
    assert!(first.0 == second.0 && first.0 == both.0, "a row differs");
    assert_eq!(first.1, second.1, "peaks of memory");
    // What each thread works with counts twice, and the model once.
    assert!(
        first.1.iter().zip(&both.1).all(|(one, two)| two < &(3 * one) && one < &(2 * two)),
        "{:?}",
        (first.1, both.1)
    );
}

#[test]
fn a_run_that_is_killed_keeps_its_rows_and_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let arguments = ["bench", "--quick", "--signal", "diffuse", "--out", "out", "--json"];
    let csv = || std::fs::read_to_string(folder.join("out/results.csv")).unwrap_or_default();
    let mut child = Command::new(env!("CARGO_BIN_EXE_prt"))
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while csv().lines().count() < 4 && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // The file is whole at every moment: a header and one line a row.
    let kept = csv();
    let before: Vec<&str> = kept.lines().collect();
    assert!(before.len() >= 4, "three rows within a minute\n{kept}");
    let rows: Vec<Value> = serde_json::from_str(&done(&arguments, folder)).unwrap();
    assert!(rows.len() >= before.len() && rows.iter().all(|row| row["status"] == "ok"));
    // With their times, which no second measurement would have met again.
    let after = csv();
    assert!(before.iter().all(|line| after.lines().any(|l| l == *line)), "a finished row was measured again");
}
