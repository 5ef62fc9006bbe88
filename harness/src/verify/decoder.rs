//! The decoder, which is a part of this program's text, and the Python that runs it.

use super::plan::Work;
use crate::lights::{self, LIGHTS};
use crate::{files, interrupt};
use anyhow::{Context, bail};
use prt_transfer::LightBasis;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

macro_rules! peers {
    ($($name:literal)*) => { [$(($name, include_str!(concat!("../../../benches/peers/", $name)))),*] };
}

/// The decoder's files.
const SOURCES: [(&str, &str); 13] = peers!(
    "decode.py" "prtfile/__init__.py" "prtfile/archive.py" "prtfile/bicluster.py" "prtfile/clusters.py" "prtfile/codecs.py" "prtfile/container.py"
    "prtfile/elements.py" "prtfile/figures.py" "prtfile/rows.py" "prtfile/sphere.py" "prtfile/transforms.py" "prtfile/visibility.py"
);

/// What is asked of the decoder.
#[derive(Serialize)]
struct Job<'a> {
    file: &'a Path,
    matrix: &'a Path,
    /// Lights of radiance by name.
    relit: &'a BTreeMap<String, PathBuf>,
}

/// What it answers. Figures are those of results.csv.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Answer {
    pub(super) job: usize,
    /// Why there is nothing else.
    pub(super) failure: Option<String>,
    pub(super) label: String,
    pub(super) codec: String,
    pub(super) file_bytes: u64,
    /// None where it does not follow from the file.
    pub(super) resident_bytes: Option<u64>,
    pub(super) non_zeros: u64,
    pub(super) error: f64,
    /// None where lights have no place on the sphere.
    pub(super) error_sphere: Option<f64>,
    pub(super) error_max: f64,
    /// max |T|.
    pub(super) matrix_max: f64,
    /// By the names of the lights; none where relighting is not linear.
    pub(super) relit: BTreeMap<String, f64>,
}

/// Runs the decoder on `works`, so many at once; `take` gets its answers as they come.
pub(super) fn run(
    python: &Path,
    works: &[Work],
    processes: usize,
    mut take: impl FnMut(Answer) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let folder = folder.path();
    std::fs::create_dir(folder.join("prtfile"))?;
    for (name, text) in SOURCES {
        files::write_beside(&folder.join(name), text.as_bytes())?;
    }
    let (jobs, errors) = (folder.join("jobs.json"), folder.join("errors"));
    files::write_beside(&jobs, &serde_json::to_vec(&described(works, folder)?)?)?;
    let mut command = Command::new(python);
    // Files in place of pipes: neither side waits for the other.
    command.arg(folder.join("decode.py")).arg("--jobs").arg(processes.to_string()).env("PYTHONDONTWRITEBYTECODE", "1");
    command.stdin(File::open(&jobs)?).stderr(File::create(&errors)?).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(|error| match error.kind() {
        ErrorKind::NotFound => anyhow::anyhow!("{}", missing(python)),
        _ => anyhow::Error::new(error).context(format!("cannot run {}", python.display())),
    })?;
    let answers = child.stdout.take().context("a pipe from decode.py")?;
    for line in BufReader::new(answers).lines() {
        let line = line.context("cannot read what decode.py says")?;
        interrupt::check()?;
        take(serde_json::from_str(&line).with_context(|| format!("decode.py said '{line}'"))?)?;
    }
    if child.wait()?.success() {
        return Ok(());
    }
    // Ctrl-C reaches every process of a terminal.
    interrupt::check()?;
    let said = std::fs::read_to_string(&errors).unwrap_or_default();
    bail!("{}: {}", python.display(), said.lines().last().unwrap_or("decode.py failed without a word"))
}

fn missing(python: &Path) -> String {
    format!(
        "there is no {}: --verify needs Python 3.9 or later with NumPy and zstandard (pip install numpy zstandard), which --python PATH names",
        python.display()
    )
}

/// A job for each work, with the lights of its basis written to `folder`.
fn described<'a>(works: &'a [Work], folder: &Path) -> anyhow::Result<serde_json::Value> {
    let mut lights: BTreeMap<&str, BTreeMap<String, PathBuf>> = BTreeMap::new();
    for Work { row, .. } in works {
        if !lights.contains_key(row.basis.as_str()) {
            let number = lights.len();
            lights.insert(&row.basis, written(&row.basis.parse()?, folder, number)?);
        }
    }
    let job = |w: &'a Work| Job { file: &w.encoded, matrix: &w.matrix, relit: &lights[w.row.basis.as_str()] };
    Ok(serde_json::to_value(works.iter().map(job).collect::<Vec<_>>())?)
}

/// The lights that `prt bench` relights with, in a basis; none where it has no place on the sphere.
fn written(basis: &LightBasis, folder: &Path, number: usize) -> anyhow::Result<BTreeMap<String, PathBuf>> {
    let mut paths = BTreeMap::new();
    for name in LIGHTS {
        let Ok(light) = lights::light(name, basis) else { break };
        let path = folder.join(format!("{name}-{number}.npy"));
        files::write_array(&path, light.view())?;
        paths.insert(name.to_string(), path);
    }
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_module_of_the_decoder_is_carried_along() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../benches/peers/prtfile"));
        let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
        let mut modules: Vec<String> =
            files.filter(|name| name.ends_with(".py")).map(|n| format!("prtfile/{n}")).collect();
        modules.push("decode.py".into());
        modules.sort();
        assert_eq!(SOURCES.map(|(name, _)| name).to_vec(), modules);
    }

    #[test]
    fn a_python_that_is_not_there_is_a_sentence_that_says_what_is_needed() {
        let error = run(Path::new("/nowhere/python3"), &[], 1, |_| Ok(())).unwrap_err().to_string();
        assert!(error.contains("/nowhere/python3") && error.contains("pip install numpy zstandard"), "{error}");
    }

    #[test]
    fn lights_are_written_where_a_basis_has_a_place_on_the_sphere() {
        let folder = tempfile::tempdir().unwrap();
        let of = |basis: &str| written(&basis.parse().unwrap(), folder.path(), 0).unwrap();
        assert_eq!(of("plain:9").len(), 0);
        let paths = of("cubemap:2");
        assert_eq!(paths.keys().collect::<Vec<_>>(), ["room", "sky"]);
        assert_eq!(
            files::read_lights(&paths["sky"]).unwrap(),
            lights::light("sky", &"cubemap:2".parse().unwrap()).unwrap()
        );
    }
}
