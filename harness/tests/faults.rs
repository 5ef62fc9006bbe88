//! What goes wrong around the program: disks that are full, folders that are none, files that change, memory that is short. Old files stay,
//! nothing is left half, and one sentence names the place and says what to do.
#![cfg(unix)]

mod common;

use common::{done, prt, refused};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Blocks of 512 bytes (1 kB in some shells) that a file may have, of what a disk that is nearly full still takes.
const BLOCKS: usize = 1;

/// A run whose files cannot grow: writing fails, as on a full disk.
fn on_a_full_disk(arguments: &[&str], folder: &Path) -> Output {
    let script = format!("trap '' XFSZ; ulimit -f {BLOCKS}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command
        .args(["-c", &script, env!("CARGO_BIN_EXE_prt")])
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("sh runs")
}

/// Everything in a folder and those below it: path and content.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => all.extend(contents(&path)),
            false => all.push((path.display().to_string(), std::fs::read(&path).unwrap())),
        }
    }
    all.sort();
    all
}

fn precompute(folder: &Path, signal: &str, file: &str) {
    done(
        &["precompute", "teapot", "--signal", signal, "--basis", "cubemap:16", "--vertices", "150", "-o", file],
        folder,
    );
}

/// Commands that write one file, which is there already: its name is the last argument.
fn writing() -> Vec<Vec<&'static str>> {
    let commands = [
        "precompute blob --signal diffuse --basis cubemap:16 --vertices 100 -o T.npz",
        "precompute blob --signal diffuse --basis cubemap:16 --vertices 100 -o T.npy",
        "precompute blob --signal terms --terms 2 --basis cubemap:16 --vertices 100 --transform srbf -o C.npy",
        "encode csr S.npz -o T.prt",
        "decode S.prt -o T.npz",
        "decode S.prt -o T.npy",
        "decode S.prt -o T.mtx",
        "relight S.prt --light sky -o y.npy",
        "render teapot S.npz --vertices 150 --size 320x240 -o T.png",
        "render teapot S.npz --vertices 150 --size 320x240 --background 0,0,0 -o T.exr",
        "fit-light sky --lobes 40 --cubemap 8 --steps 1 --exchanges 0 -o lobes.json",
        "select S.npz --max-error 0.5 --method csr -o T.prt",
    ];
    commands.map(|command| command.split(' ').collect()).to_vec()
}

#[test]
fn a_full_disk_leaves_every_old_file_and_one_sentence_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "S.npz");
    done(&["encode", "csr", "S.npz", "-o", "S.prt"], folder);
    for arguments in writing() {
        let name = *arguments.last().unwrap();
        std::fs::write(folder.join(name), "old").unwrap();
        let before = contents(folder);
        let output = on_a_full_disk(&arguments, folder);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
        assert!(said.starts_with(&format!("prt: cannot write {name}: ")) && said.lines().count() == 1, "{said}");
        assert!(contents(folder) == before, "{arguments:?} changed a file or left one");
        std::fs::remove_file(folder.join(name)).unwrap();
    }
}

#[test]
fn folders_of_results_survive_a_full_disk_and_go_on_afterwards() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "S.npz");
    let bench = ["bench", "--quick", "--scene", "S.npz", "--no-pictures", "--method", "csr", "--out", "bench"];
    let more = [&bench[..], &["--method", "f16", "--method", "truncate:terms=16"]].concat();
    let select = ["select", "S.npz", "--max-error", "1e-2", "--method", "pca", "--method", "vq", "--out", "select"];
    let stability =
        ["stability", "biclustering", "--sweep", "columns", "--vertices", "20", "--out", "sweeps", "--method", "csr"];
    let slf = ["slf", "glossy-sphere", "--shape", "sphere", "--texels", "16x16", "--directions", "16x8", "-o", "field"];
    done(&bench, folder);
    let rows = |file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
    let finished = rows("bench/results.csv");
    for arguments in [&more[..], &select, &stability, &slf] {
        let output = on_a_full_disk(arguments, folder);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.starts_with("prt: ") && said.lines().count() <= 1 && !said.contains("panicked"), "{said}");
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
        assert!(contents(folder).iter().all(|(path, _)| !path.contains("/.prt-")), "{arguments:?} left a part");
    }
    let after = rows("bench/results.csv");
    assert!(finished.lines().all(|line| after.lines().any(|other| other == line)), "{after}");
    let told: Vec<Value> = serde_json::from_str(&done(&[&more[..], &["--json"]].concat(), folder)).unwrap();
    assert!(told.len() == 3 && told.iter().all(|row| row["status"] == "ok"), "{told:?}");
    done(&select, folder);
}

#[test]
fn a_folder_that_is_a_file_and_a_device_that_is_full_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "S.npz");
    done(&["encode", "csr", "S.npz", "-o", "S.prt"], folder);
    std::fs::write(folder.join("file"), "old").unwrap();
    let before = contents(folder);
    for arguments in writing() {
        let (name, rest) = arguments.split_last().unwrap();
        let below = format!("file/{name}");
        let said = refused(1, &[rest, &[&below]].concat(), folder);
        assert!(said.starts_with(&format!("prt: cannot create {below}: ")) && said.lines().count() == 1, "{said}");
    }
    for folders in [
        &["bench", "--quick", "--scene", "S.npz", "--method", "csr", "--out", "file"][..],
        &["select", "S.npz", "--max-error", "0.5", "--method", "csr", "--out", "file/select"],
        &["stability", "biclustering", "--sweep", "columns", "--vertices", "20", "--out", "file"],
        &["slf", "glossy-sphere", "-o", "file"],
        &["tables", "tensor", "--table", "table1", "--out", "file/tables"],
        &["figures", "srbf", "--figure", "bandwidth", "--out", "file"],
    ] {
        let said = refused(1, folders, folder);
        assert!(said.starts_with("prt: cannot create file") && said.lines().count() == 1, "{said}");
    }
    assert!(contents(folder) == before);
    if Path::new("/dev/full").exists() {
        // What is no regular file is written in place.
        std::os::unix::fs::symlink("/dev/full", folder.join("full.npy")).unwrap();
        let said = refused(1, &["relight", "S.prt", "--light", "sky", "-o", "full.npy"], folder);
        assert!(said.starts_with("prt: cannot write full.npy: "), "{said}");
        let to_full = Command::new("sh").args(["-c", "\"$0\" methods > /dev/full", env!("CARGO_BIN_EXE_prt")]).output();
        let output = to_full.unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1));
        assert!(said.starts_with("prt: cannot write to standard output: ") && said.lines().count() == 1, "{said}");
    }
}

#[test]
fn a_reader_that_has_had_enough_is_no_failure() {
    for arguments in ["methods", "scenes --json", "tables", "--help"] {
        let script = format!("{{ \"$0\" {arguments}; echo \"$?\" >&2; }} | head -1");
        let output = Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_prt")]).output().unwrap();
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "0\n", "{arguments}");
    }
}

/// Every run ends whole or leaves what was there; what the last killed one left is gone with the next.
#[test]
fn a_dozen_kills_leave_whole_files_and_rows_and_no_parts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "S.npz");
    let encode = ["encode", "cpca:clusters=8", "S.npz", "-o", "T.prt"];
    let bench = ["bench", "--quick", "--signal", "glossy", "--no-pictures", "--out", "bench", "--json"];
    let select =
        ["select", "S.npz", "--max-error", "1e-2", "--method", "pca", "--method", "vq", "--out", "select", "--json"];
    done(&["encode", "cpca:clusters=8", "S.npz", "-o", "new.prt"], folder);
    done(&["encode", "f16", "S.npz", "-o", "T.prt"], folder);
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap_or_default();
    let [old, new] = ["T.prt", "new.prt"].map(read);
    let whole_lines = |name: &str| {
        let text = String::from_utf8(read(name)).unwrap();
        text.lines().filter(|line| line.split(',').count() > 5).count()
    };
    let mut rows = [0, 0];
    for round in 0..4u64 {
        for (arguments, unit) in [(&encode[..], 23), (&bench, 61), (&select, 37)] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_prt"));
            let child = command.args(arguments).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
            let mut child = child.spawn().unwrap();
            std::thread::sleep(Duration::from_millis(unit * (1 + 3 * round)));
            child.kill().unwrap();
            child.wait().unwrap();
            let file = read("T.prt");
            assert!(file == old || file == new, "{arguments:?}: neither the old file nor the new one");
            let now = ["bench/results.csv", "select/trials.csv"].map(whole_lines);
            assert!(now[0] >= rows[0] && now[1] >= rows[1], "{arguments:?}: {rows:?} rows became {now:?}");
            rows = now;
        }
    }
    done(&encode, folder);
    assert!(read("T.prt") == new);
    let told: Vec<Value> = serde_json::from_str(&done(&bench, folder)).unwrap();
    assert!(told.iter().all(|row| row["status"] == "ok"), "{told:?}");
    done(&select, folder);
    let left = contents(folder).into_iter().map(|(path, _)| path).filter(|path| path.contains("/.prt-"));
    assert_eq!(left.collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn a_matrix_that_is_another_or_damaged_is_never_mixed_with_what_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "S.npz");
    let select = ["select", "S.npz", "--max-error", "1e-2", "--method", "vq", "--out", "select", "--json"];
    let found = |arguments: &[&str]| -> Value {
        let told: Value = serde_json::from_str(&done(arguments, folder)).unwrap();
        let row = &told["rows"][0];
        ["method", "bytes", "error"].map(|name| row[name].clone()).to_vec().into()
    };
    let first = found(&select);
    // Another matrix under the same name.
    precompute(folder, "biscale", "other.npz");
    done(
        &["precompute", "blob", "--signal", "diffuse", "--basis", "cubemap:16", "--vertices", "150", "-o", "S.npz"],
        folder,
    );
    let second = found(&select);
    assert_ne!(first, second);
    let fresh = [&select[..6], &["--out", "fresh", "--json"]].concat();
    assert_eq!(second, found(&fresh), "trials of the other matrix were taken");

    // Matrices, models and rows that a bench keeps.
    let bench = ["bench", "--quick", "--signal", "diffuse", "--no-pictures", "--out", "bench", "--method", "csr"];
    done(&bench, folder);
    let matrix = contents(folder)
        .into_iter()
        .map(|(path, _)| path)
        .find(|path| path.contains("/matrices/") && path.ends_with(".npy"));
    let matrix = matrix.unwrap();
    let whole = std::fs::read(&matrix).unwrap();
    let more = [&bench[..], &["--method", "f16"]].concat();
    let mut changed = whole.clone();
    *changed.last_mut().unwrap() ^= 64;
    for damaged in [&changed[..], &whole[..whole.len() / 2], b""] {
        std::fs::write(&matrix, damaged).unwrap();
        let said = refused(1, &more, folder);
        assert!(said.contains("bench/matrices/") && said.contains("delete") && said.lines().count() == 1, "{said}");
    }
    std::fs::remove_file(&matrix).unwrap();
    done(&more, folder);
    assert!(std::fs::read(&matrix).unwrap() == whole, "computed again");
    // A model that is gone or cut short is made again.
    let model = Path::new(&matrix).parent().unwrap().with_file_name("encoded");
    let model = std::fs::read_dir(model)
        .unwrap()
        .map(|e| e.unwrap().path())
        .find(|p| p.to_string_lossy().ends_with("-f16.prt"));
    let model = model.unwrap();
    let bytes = std::fs::read(&model).unwrap();
    std::fs::write(&model, &bytes[..bytes.len() / 2]).unwrap();
    done(&more, folder);
    assert!(std::fs::read(&model).unwrap() == bytes);
}

#[test]
fn what_needs_more_memory_than_there_is_is_refused_before_it_begins_and_says_what_helps() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    precompute(folder, "diffuse", "S.npz");
    precompute(folder, "diffuse", "S.npy");
    let basis = ["--basis", "cubemap:16"];
    let npy = |label: &'static str, memory: &'static str| {
        [&["encode", label, "S.npy", "-o", "T.prt", "--max-memory", memory][..], &basis].concat()
    };
    for (arguments, what) in [
        (npy("csr", "500kB"), "csr on 138 x 1 x 1536 needs about "),
        (npy("pca", "3MB"), "pca on 138 x 1 x 1536 needs about "),
        (npy("haar+truncate", "1MB"), "haar+truncate on 138 x 1 x 1536 needs about "),
        (vec!["select", "S.npz", "--max-error", "0.5", "--max-memory", "500kB"], "S.npz needs about "),
        (vec!["precompute", "teapot", "--signal", "biscale", "-o", "T.npz", "--max-memory", "20MB"], "needs about "),
    ] {
        let said = refused(1, &arguments, folder);
        assert!(said.contains(what) && said.lines().count() == 1, "{arguments:?}: {said}");
        assert!(said.contains(" of memory, and ") && said.contains(" are free: "), "{arguments:?}: {said}");
    }
    assert!(!folder.join("T.prt").exists() && !folder.join("T.npz").exists());
    done(&npy("csr", "100MB"), folder);
    // What is streamed is never held.
    let streamed =
        ["precompute", "teapot", "--signal", "diffuse", "--vertices", "300", "-o", "D.npy", "--max-memory", "10MB"];
    done(&streamed, folder);
    assert!(folder.join("D.npy").metadata().unwrap().len() > 5_000_000);

    // In a bench it is a row with its reason, and others go on.
    let bench =
        ["bench", "--quick", "--scene", "S.npz", "--no-pictures", "--out", "bench", "--json", "--max-memory", "7MB"];
    let rows: Vec<Value> = serde_json::from_str(&done(
        &[&bench[..], &["--method", "csr", "--method", "bicluster:max_error=0.1", "--method", "truncate:terms=16"]]
            .concat(),
        folder,
    ))
    .unwrap();
    let status: Vec<&str> = rows.iter().map(|row| row["status"].as_str().unwrap()).collect();
    assert_eq!(status, ["ok", "failed", "ok"], "{rows:?}");
    let reason = rows[1]["reason"].as_str().unwrap();
    assert!(reason.contains("bicluster") && reason.contains("of memory"), "{reason}");

    let limits = done(&["methods", "--limits", "16GB"], folder);
    assert!(["csr", "cpca", "cta", "bicluster"].iter().all(|name| limits.contains(name)), "{limits}");
    assert_eq!(prt(&["methods", "--limits", "nothing"], folder).status.code(), Some(2));
}
