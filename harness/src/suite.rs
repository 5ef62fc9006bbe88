//! What `prt bench` measures when nobody says otherwise.

use crate::signal::{Signal, Spec};
use prt_transfer::LightBasis;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How much to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Half a minute: one tiny scene.
    Quick,
    /// Within three minutes on two cores, precomputation included.
    Standard,
    /// As long as it takes: every scene, denser, more parameters.
    Full,
}

/// Where a matrix comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Origin {
    /// A built-in scene with about so many vertices, or a mesh file with its own.
    Scene {
        /// Name or path.
        scene: String,
        /// Of a built-in scene.
        vertices: Option<usize>,
        /// What is precomputed.
        spec: Spec,
    },
    /// A matrix file.
    Matrix(PathBuf),
}

/// What to measure, in order: every method on every origin.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Matrices.
    pub origins: Vec<Origin>,
    /// Labels.
    pub methods: Vec<String>,
    /// Labels beside them for matrices whose signal is `biscale`.
    pub biscale_methods: Vec<String>,
    /// Labels beside them for all other matrices: a sample of `biscale`, D² x lights numbers, is too long a vector to be clustered.
    pub cluster_methods: Vec<String>,
    /// Time for each of the four relighting figures of a row.
    pub budget: Duration,
}

/// Curved, flat, and curved with ears: the worst and the best case of methods that look for structure.
const SCENES: [&str; 3] = ["teapot", "chair", "blob"];
const QUICK_SCENES: [&str; 1] = ["teapot"];
const FULL_SCENES: [&str; 7] = ["teapot", "cornell-box", "two-polygons", "temple", "chair", "bumpy-sphere", "blob"];

/// The rivals that a reader will think of, exact and not.
const RIVALS: [&str; 5] = ["dense", "csr", "compact", "runs", "f16"];
/// Archives of visibility, which know no other signal.
const BISCALE_METHODS: [&str; 1] = ["visibility"];
const QUICK_METHODS: [&str; 4] = ["bicluster", "haar+truncate:terms=16", "haar+truncate:terms=64", "sh:order=5+dense"];
const METHODS: [&str; 15] = [
    "bicluster",
    "bicluster:levels=1",
    "bicluster:max_error=0.01",
    "truncate:terms=64",
    "haar+truncate:terms=16",
    "haar+truncate:terms=32",
    "haar+truncate:terms=64",
    "haar+truncate:terms=128",
    "haar+truncate:terms=256",
    "sh:order=3+dense",
    "sh:order=5+dense",
    "sh:order=8+dense",
    "srbf:centers=162+dense",
    "srbf+dense",
    "srbf+f16",
];
/// Vectors and subspaces that samples share.
const QUICK_CLUSTERS: [&str; 3] = ["pca", "cpca:clusters=16", "srbf:centers=162+cta:clusters=4"];
const CLUSTERS: [&str; 10] = [
    "vq:clusters=32",
    "vq:clusters=128",
    "pca:components=32",
    "cpca:clusters=16",
    "cpca:clusters=16:mode=iterative",
    "cpca:clusters=16:mode=adaptive:weights=i16:representatives=i16",
    "cpca:clusters=auto:max_error=1e-2",
    "tucker:max_error=1e-2",
    "srbf+cta:clusters=16:light=24:sample=8",
    "srbf+cta:clusters=16:light=24:sample=8:numbers=coded",
];
const FULL_CLUSTERS: [&str; 11] = [
    "vq:clusters=512",
    "pca:components=128",
    "cpca:clusters=64",
    "cpca:clusters=64:mode=iterative",
    "cpca:clusters=64:mode=adaptive",
    "cpca:clusters=64:norm=radiance",
    "srbf+cpca:clusters=64",
    "srbf+cta",
    "srbf+cta:members=2",
    "haar:scale=sphere+cta",
    "srbf+tucker",
];
const FULL_METHODS: [&str; 11] = [
    "bicluster:objective=flops",
    "bicluster:levels=2",
    "bicluster:levels=1:seeds=random",
    "truncate:terms=16",
    "truncate:terms=256",
    "haar+csr",
    "haar+truncate:terms=512",
    "haar:scale=sphere+truncate:terms=64",
    "haar:scale=sphere+truncate:terms=256",
    "sh:order=10+dense",
    "srbf:centers=2562+dense",
];

/// A dense matrix above this many bytes is not tried: it would measure the machine's swapping.
pub const DENSE_LIMIT: u64 = 1_000_000_000;

impl Suite {
    /// The usual suite of a size, with scenes or methods of the user's in place of its own where there are any.
    pub fn new(size: Size, scenes: &[String], methods: &[String]) -> Suite {
        let (usual, vertices, resolution, budget) = match size {
            Size::Quick => (&QUICK_SCENES[..], 150, 16, 40),
            Size::Standard => (&SCENES[..], 400, 32, 90),
            Size::Full => (&FULL_SCENES[..], 3000, 32, 500),
        };
        let scenes = if scenes.is_empty() { owned(usual) } else { scenes.to_vec() };
        let basis = LightBasis::Cubemap { resolution };
        let origins = scenes.iter().flat_map(|scene| origins(scene, vertices, &basis)).collect();
        let budget = Duration::from_millis(budget);
        if !methods.is_empty() {
            let (biscale_methods, cluster_methods) = (Vec::new(), Vec::new());
            return Suite { origins, methods: methods.to_vec(), biscale_methods, cluster_methods, budget };
        }
        let (biscale_methods, cluster_methods) = (owned(&BISCALE_METHODS), clusters(size));
        Suite { origins, methods: usual_methods(size), biscale_methods, cluster_methods, budget }
    }

    /// What is measured on one matrix.
    pub fn methods_on(&self, origin: &Origin) -> Vec<String> {
        let biscale = matches!(origin, Origin::Scene { spec, .. } if spec.signal == Signal::Biscale);
        let more = if biscale { &self.biscale_methods } else { &self.cluster_methods };
        [&self.methods[..], more].concat()
    }
}

fn usual_methods(size: Size) -> Vec<String> {
    let mut methods = owned(&RIVALS);
    match size {
        Size::Quick => methods.extend(owned(&QUICK_METHODS)),
        Size::Standard => methods.extend(owned(&METHODS)),
        Size::Full => methods.extend(owned(&[&METHODS[..], &FULL_METHODS[..]].concat())),
    }
    methods
}

fn clusters(size: Size) -> Vec<String> {
    match size {
        Size::Quick => owned(&QUICK_CLUSTERS),
        Size::Standard => owned(&CLUSTERS),
        Size::Full => owned(&[&CLUSTERS[..], &FULL_CLUSTERS[..]].concat()),
    }
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.into()).collect()
}

/// Both signals of a scene; a matrix file as it is.
fn origins(scene: &str, vertices: usize, basis: &LightBasis) -> Vec<Origin> {
    let path = Path::new(scene);
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "npz" | "npy" | "mtx" => vec![Origin::Matrix(path.into())],
        mesh => [Signal::Biscale, Signal::Diffuse]
            .map(|signal| Origin::Scene {
                scene: scene.into(),
                vertices: mesh.is_empty().then_some(vertices),
                spec: Spec::new(signal, basis.clone()),
            })
            .into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_transfer::Label;

    #[test]
    fn every_label_of_every_suite_is_in_its_shortest_form_and_there_once() {
        for size in [Size::Quick, Size::Standard, Size::Full] {
            let suite = Suite::new(size, &[], &[]);
            let methods = [&suite.methods[..], &suite.biscale_methods[..], &suite.cluster_methods[..]].concat();
            for (i, method) in methods.iter().enumerate() {
                assert_eq!(&method.parse::<Label>().unwrap().to_string(), method);
                assert!(!methods[..i].contains(method), "{method}");
            }
            assert!(methods.iter().any(|m| m == "csr"), "the exact reference");
        }
    }

    #[test]
    fn visibility_is_measured_on_biscale_alone() {
        let suite = Suite::new(Size::Quick, &[], &[]);
        let on = suite.origins.iter().map(|o| suite.methods_on(o).iter().any(|m| m == "visibility"));
        assert_eq!(on.collect::<Vec<_>>(), [true, false], "biscale, diffuse");
    }

    #[test]
    fn a_scene_of_the_user_replaces_the_usual_ones_and_a_matrix_needs_no_signal() {
        let suite = Suite::new(Size::Quick, &["bunny.ply".into(), "T.NPZ".into()], &["csr".into()]);
        assert!(suite.origins.iter().all(|origin| suite.methods_on(origin) == ["csr"]));
        assert_eq!(suite.origins.len(), 3);
        assert_eq!(suite.origins[2], Origin::Matrix("T.NPZ".into()));
        let Origin::Scene { vertices: None, .. } = &suite.origins[0] else { panic!("a mesh keeps its vertices") };
    }
}
