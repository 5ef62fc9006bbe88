//! Ctrl-C as a user meets it: what is finished is kept, nothing is left half, and the same command goes on.
#![cfg(unix)]

mod common;

use common::{done, prt, untimed};
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn start(arguments: &[&str], folder: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_prt"));
    command.args(arguments).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("prt runs")
}

/// Sends SIGINT; exit code and what was said.
fn interrupt(child: Child) -> (Option<i32>, String) {
    let kill = Command::new("sh").arg("-c").arg(format!("kill -INT {}", child.id())).status().unwrap();
    assert!(kill.success(), "it ended before it was interrupted");
    let output = child.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// Waits until a file has so many lines.
fn wait_for_lines(path: &Path, lines: usize) -> usize {
    let began = Instant::now();
    loop {
        let there = std::fs::read_to_string(path).unwrap_or_default().lines().count();
        if there >= lines {
            return there;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "{there} lines in a minute");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Files in a folder and those below it that begin with a dot.
fn left(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of = |path: std::path::PathBuf| match path.is_dir() {
        true => left(&path),
        false => vec![path.file_name().unwrap().to_string_lossy().into_owned()],
    };
    entries.flat_map(of).filter(|name| name.starts_with('.')).collect()
}

#[test]
fn an_interrupted_bench_keeps_its_rows_and_goes_on_to_the_figures_of_one_that_was_not() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // On one thread even the peak of memory is no matter of luck.
    let bench = |out| {
        ["bench", "--threads", "1", "--quick", "--signal", "diffuse,glossy", "--no-pictures", "--out", out, "--json"]
    };
    let child = start(&bench("out"), folder);
    let csv = folder.join("out/results.csv");
    wait_for_lines(&csv, 4);
    let (code, said) = interrupt(child);
    assert_eq!(code, Some(130), "{said}");
    let kept = std::fs::read_to_string(&csv).unwrap();
    let rows = kept.lines().count() - 1;
    assert!(!kept.contains(",failed,"), "an interrupted row is no failure of its method: {kept}");
    let sentence = format!("prt: interrupted: {rows} of ");
    assert!(said.starts_with(&sentence) && said.ends_with("rows are in out; the same command goes on from there\n"));
    assert_eq!((left(folder), said.lines().count()), (Vec::new(), 1), "{said}");

    let resumed = untimed(&done(&bench("out"), folder));
    let after = std::fs::read_to_string(&csv).unwrap();
    assert!(kept.lines().all(|line| after.lines().any(|other| other == line)), "a finished row was measured again");
    assert!(resumed == untimed(&done(&bench("whole"), folder)), "a row differs");
}

#[test]
fn an_interrupted_search_keeps_its_trials_and_finds_what_one_finds_that_was_not() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = ["teapot", "--signal", "glossy", "--vertices", "400"];
    done(&[&["precompute"], &scene[..], &["-o", "T.npz"]].concat(), folder);
    let select = |out| ["select", "T.npz", "--max-error", "1e-4", "--out", out, "--json"];
    let child = start(&select("out"), folder);
    let trials = folder.join("out/trials.csv");
    wait_for_lines(&trials, 5);
    let (code, said) = interrupt(child);
    assert_eq!(code, Some(130), "{said}");
    assert_eq!(said, "prt: interrupted: what was tried is in out; the same command goes on from there\n");
    assert_eq!(left(folder), Vec::<String>::new());
    let kept = std::fs::read_to_string(&trials).unwrap();
    assert!(!kept.contains("interrupted") && !kept.contains("cancelled"), "{kept}");

    let found = |out| -> Vec<Value> {
        let told: Value = serde_json::from_str(&done(&select(out), folder)).unwrap();
        let figures = ["family", "method", "bytes", "error", "encodes"];
        let of = |row: &Value| figures.map(|name| row[name].clone()).to_vec().into();
        told["rows"].as_array().unwrap().iter().map(of).collect()
    };
    let resumed = found("out");
    let after = std::fs::read_to_string(&trials).unwrap();
    assert!(after.starts_with(&kept), "a model was tried again");
    assert_eq!(resumed, found("whole"));
}

#[test]
fn an_interrupted_encode_leaves_the_old_file_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = ["teapot", "--signal", "diffuse", "--vertices", "3000"];
    done(&[&["precompute"], &scene[..], &["-o", "T.npz"]].concat(), folder);
    done(&["encode", "f16", "T.npz", "-o", "T.prt"], folder);
    let read = || std::fs::read(folder.join("T.prt")).unwrap();
    let (old, encode) = (read(), ["encode", "cpca:mode=iterative:sweeps=1000", "T.npz", "-o", "T.prt"]);
    let child = start(&encode, folder);
    std::thread::sleep(Duration::from_millis(500));
    let (code, said) = interrupt(child);
    assert_eq!(said, "prt: interrupted: T.prt is as it was; the same command begins anew\n");
    assert_eq!((code, read() == old, left(folder)), (Some(130), true, Vec::new()));
    assert_eq!(prt(&["info", "T.prt"], folder).status.code(), Some(0));
}
