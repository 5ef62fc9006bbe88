//! The pictures of a matrix, kept from one run to the next.

use crate::files;
use crate::pictures::Pictures;
use crate::report::Selection;
use crate::row::Row;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Pictures, and the models that were searched for them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Album {
    /// What they are of.
    key: Key,
    /// One for each light.
    pub(super) pictures: Vec<Pictures>,
    /// Where a search found the models.
    pub(super) selection: Option<Selection>,
}

/// What decides how pictures look.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Key {
    program: String,
    fingerprint: String,
    /// Methods and what their models hold.
    models: Vec<(String, Option<u64>)>,
    /// Names, and checksums of what they shed on the matrix.
    lights: Vec<(String, u32)>,
}

impl Key {
    /// Of the rows of a matrix and of lights with their checksums.
    pub(super) fn new(rows: &[Row], lights: Vec<(String, u32)>) -> Key {
        let [program, fingerprint] =
            rows.first().map_or_else(Default::default, |row| [&row.program, &row.fingerprint].map(String::clone));
        let models = rows.iter().map(|row| (row.method.clone(), row.resident_bytes)).collect();
        Key { program, fingerprint, models, lights }
    }
}

impl Album {
    /// What a run came to.
    pub(super) fn new(key: Key, pictures: Vec<Pictures>, selection: Option<Selection>) -> Album {
        Album { key, pictures, selection }
    }

    /// What an earlier run left at a path, of the same. What cannot be read is taken again.
    pub(super) fn read(path: &Path, key: &Key) -> Option<Album> {
        let album: Album = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
        (album.key == *key).then_some(album)
    }

    /// Keeps it.
    pub(super) fn write(&self, path: &Path) -> anyhow::Result<()> {
        Ok(files::write_beside(path, &serde_json::to_vec(self)?)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_album_is_found_again_for_the_same_models_and_lights_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("album.json");
        let row = |bytes| Row { method: "csr".into(), resident_bytes: Some(bytes), ..Row::default() };
        let key = |bytes, sum| Key::new(&[row(bytes)], vec![("sky".into(), sum)]);
        assert!(Album::read(&path, &key(1, 1)).is_none());
        let pictures = vec![Pictures { light: "sky".into(), ..Pictures::default() }];
        Album::new(key(1, 1), pictures, None).write(&path).unwrap();
        assert_eq!(Album::read(&path, &key(1, 1)).unwrap().pictures[0].light, "sky");
        assert!(Album::read(&path, &key(2, 1)).is_none() && Album::read(&path, &key(1, 2)).is_none());
        std::fs::write(&path, "{").unwrap();
        assert!(Album::read(&path, &key(1, 1)).is_none());
    }
}
