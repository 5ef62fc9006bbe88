//! What `prt select` left in folders of a bench's folder, for the report.

use crate::report::{Selected, Selection};
use anyhow::Context;
use serde::Deserialize;
use std::path::Path;

/// What is taken of select.json.
#[derive(Deserialize)]
struct File {
    title: String,
    bound: String,
    rows: Vec<Line>,
}

/// A family of it.
#[derive(Deserialize)]
struct Line {
    kept: bool,
    #[serde(flatten)]
    selected: Option<Selected>,
}

/// The selections of every OUT/FOLDER/select.json, in the order of their folders.
pub(super) fn read(out: &Path) -> anyhow::Result<Vec<Selection>> {
    let place = || format!("cannot read {}", out.display());
    let entries = std::fs::read_dir(out).with_context(place)?;
    let mut paths =
        entries.map(|e| Ok(e?.path().join("select.json"))).collect::<std::io::Result<Vec<_>>>().with_context(place)?;
    paths.sort();
    paths.iter().filter(|path| path.is_file()).map(|path| selection(path)).collect()
}

fn selection(path: &Path) -> anyhow::Result<Selection> {
    let what = || format!("{} is not what prt select writes", path.display());
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let File { title, bound, rows } = serde_json::from_slice(&bytes).with_context(what)?;
    Ok(Selection {
        title,
        bound,
        rows: rows.into_iter().filter(|line| line.kept).filter_map(|line| line.selected).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_selected_in_a_folder_is_found_and_anything_else_there_is_named() {
        let out = tempfile::tempdir().unwrap();
        assert!(read(out.path()).unwrap().is_empty());
        let folder = out.path().join("select-glossy");
        std::fs::create_dir(&folder).unwrap();
        let row = r#"{"family":"pca","method":"pca","kept":KEPT,"bytes":9,"error":0.5,"encodes":4,"grid_method":null,"grid_bytes":8,"grid_error":0.25,"gap_percent":-1.5,"grid_encodes":99,"relight_ms":null,"reason":""}"#;
        let rows = ["true", "false"].map(|kept| row.replace("KEPT", kept)).join(",");
        std::fs::write(folder.join("select.json"), format!(r#"{{"title":"T","bound":"B","rows":[{rows}]}}"#)).unwrap();
        let selections = read(out.path()).unwrap();
        assert_eq!((selections.len(), selections[0].rows.len(), selections[0].rows[0].gap_percent), (1, 1, Some(-1.5)));
        std::fs::write(folder.join("select.json"), "[]").unwrap();
        assert!(read(out.path()).unwrap_err().to_string().contains("select-glossy"));
    }
}
