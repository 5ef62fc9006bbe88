//! A paper's tables as data: which scenes they are of, and what is printed there.

use crate::signal::Spec;

/// A paper whose tables are measured anew.
pub struct Paper {
    /// Its name on the command line.
    pub name: &'static str,
    /// Subject of the paper and which tables.
    pub source: &'static str,
    /// What is measured when nobody says otherwise.
    pub methods: &'static [&'static str],
    /// The signal of all of its scenes.
    pub spec: fn() -> Spec,
    /// Its tables.
    pub tables: &'static [PaperTable],
    /// What a reader must know before comparing.
    pub notes: &'static [&'static str],
}

/// One table: a column for each scene.
pub struct PaperTable {
    /// For file names.
    pub name: &'static str,
    /// What stands above it.
    pub title: &'static str,
    /// Scenes in the paper's order, ours among them.
    pub scenes: &'static [PaperScene],
}

/// A scene of a table.
pub struct PaperScene {
    /// The paper's name for it, or ours.
    pub name: &'static str,
    /// Where a mesh like it comes from.
    pub origin: SceneOrigin,
    /// Quantities that the paper prints for it, by [`super::quantity::Quantity::name`]; none for a scene that it does not have.
    pub printed: &'static [(&'static str, f64)],
}

/// Where the mesh of a scene comes from.
pub enum SceneOrigin {
    /// A file among the user's assets, or a built-in scene where there are no assets.
    Mesh {
        /// Name of the file.
        file: &'static str,
        /// Name of the built-in scene that stands in.
        built_in: &'static str,
        /// Vertices of the same, about.
        vertices: usize,
    },
    /// From nowhere, and why.
    Unavailable(&'static str),
}

impl PaperScene {
    /// Vertices of the built-in scene that stands in.
    pub fn vertices(&self) -> Option<usize> {
        match self.origin {
            SceneOrigin::Mesh { vertices, .. } => Some(vertices),
            SceneOrigin::Unavailable(_) => None,
        }
    }

    /// What the paper prints for a quantity.
    pub fn printed(&self, quantity: &str) -> Option<f64> {
        self.printed.iter().find(|(name, _)| *name == quantity).map(|(_, figure)| *figure)
    }
}
