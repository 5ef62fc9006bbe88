//! A folder of meshes and lights of the user's.

use anyhow::{Context, ensure};
use std::path::{Path, PathBuf};

/// What lies in a folder, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assets {
    /// .ply and .obj.
    pub meshes: Vec<String>,
    /// .exr and .hdr.
    pub lights: Vec<String>,
}

impl Assets {
    /// Looks into a folder, not into folders within it.
    ///
    /// # Errors
    /// A folder that cannot be read, or has neither a mesh nor a light.
    pub fn read(folder: &Path) -> anyhow::Result<Assets> {
        let place = || format!("cannot read the folder of assets {}", folder.display());
        let entries = std::fs::read_dir(folder).with_context(place)?;
        let mut paths =
            entries.map(|e| Ok(e?.path())).collect::<std::io::Result<Vec<PathBuf>>>().with_context(place)?;
        paths.sort();
        let of = |extensions: [&str; 2]| -> Vec<String> {
            let known =
                |p: &&PathBuf| extensions.iter().any(|e| p.extension().is_some_and(|x| x.eq_ignore_ascii_case(e)));
            paths.iter().filter(known).map(|p| p.display().to_string()).collect()
        };
        let assets = Assets { meshes: of(["ply", "obj"]), lights: of(["exr", "hdr"]) };
        let found = assets.meshes.len() + assets.lights.len();
        ensure!(found > 0, "{} has no mesh (.ply, .obj) and no light (.exr, .hdr)", folder.display());
        Ok(assets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_and_lights_are_told_by_their_extension_in_the_order_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Assets::read(folder.path()).unwrap_err().to_string().contains("has no mesh"));
        for name in ["b.ply", "a.OBJ", "hall.exr", "notes.txt"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let path = |name: &str| folder.path().join(name).display().to_string();
        let assets = Assets::read(folder.path()).unwrap();
        assert_eq!(assets, Assets { meshes: vec![path("a.OBJ"), path("b.ply")], lights: vec![path("hall.exr")] });
        let missing = folder.path().join("missing");
        assert!(Assets::read(&missing).unwrap_err().to_string().contains("missing"));
    }
}
