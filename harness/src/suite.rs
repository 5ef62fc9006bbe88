//! What `prt bench` measures when nobody says otherwise.

use crate::family;
use crate::registry::families::{Family, Kind, families};
use crate::scenes::Up;
use crate::signal::{Signal, Spec};
use crate::worlds;
use prt_transfer::responses::Directions;
use prt_transfer::scene::light_field::FieldParams;
use prt_transfer::scene::separable::Terms;
use prt_transfer::{LightBasis, Registry};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How much to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Half a minute: one tiny scene.
    Quick,
    /// Within five minutes on two cores, precomputation and pictures included.
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
        /// Which axis of a mesh file points up.
        up: Up,
        /// What is precomputed.
        spec: Spec,
    },
    /// The light field of a shape of a built-in world.
    Field {
        /// Name of the world.
        world: String,
        /// Name of the shape.
        shape: String,
        /// Texels, directions and paths.
        params: FieldParams,
    },
    /// A matrix file.
    Matrix(PathBuf),
}

/// What to measure, in order: every method on every origin.
pub struct Suite {
    /// Matrices, each with the labels that are measured on it.
    pub subjects: Vec<Subject>,
    /// Time for each of the four relighting figures of a row.
    pub budget: Duration,
}

/// A matrix and what is measured on it.
pub struct Subject {
    /// The matrix.
    pub origin: Origin,
    /// Labels.
    pub methods: Vec<String>,
}

/// What the user asks for; what is empty is the suite's own.
#[derive(Clone, Debug, Default)]
pub struct Wishes {
    /// Built-in scenes, worlds, meshes, matrix files.
    pub scenes: Vec<String>,
    /// Signals of the scenes among them.
    pub signals: Vec<Signal>,
    /// Labels in their shortest form.
    pub methods: Vec<String>,
    /// Which axis of mesh files points up.
    pub up: Up,
}

/// Built-in scenes with their signals: curved, flat, and curved with ears, the worst and the best case of methods that look for structure.
const SCENES: [(&str, &[Signal]); 3] = [
    ("teapot", &Signal::ALL),
    ("chair", &[Signal::Biscale, Signal::Diffuse]),
    ("blob", &[Signal::Biscale, Signal::Diffuse, Signal::Glossy]),
];
const QUICK_SCENES: [(&str, &[Signal]); 1] = [("teapot", &Signal::ALL)];
const FULL_SCENES: [(&str, &[Signal]); 7] = [
    ("teapot", &Signal::ALL),
    ("cornell-box", &Signal::ALL),
    ("two-polygons", &Signal::ALL),
    ("temple", &Signal::ALL),
    ("chair", &Signal::ALL),
    ("bumpy-sphere", &Signal::ALL),
    ("blob", &Signal::ALL),
];
/// What is precomputed of a mesh where nobody says.
const MESH_SIGNALS: [Signal; 3] = [Signal::Biscale, Signal::Diffuse, Signal::Glossy];
/// The world and the shape whose light field is compressed.
const FIELD: (&str, &str) = ("glossy-sphere", "sphere");

/// A dense matrix above this many bytes is not tried: it would measure the machine's swapping.
pub const DENSE_LIMIT: u64 = 1_000_000_000;

impl Suite {
    /// The usual suite of a size, with scenes, signals or methods of the user's in place of its own where there are any.
    pub fn new(size: Size, wishes: &Wishes, registry: &Registry) -> Suite {
        let origins = match wishes.scenes.is_empty() {
            true => size.origins(&wishes.signals),
            false => wishes.scenes.iter().flat_map(|scene| size.origins_of(scene, wishes)).collect(),
        };
        let subject = |origin: Origin| {
            let usual = || size.methods(&families(registry, origin.kind()));
            let methods = if wishes.methods.is_empty() { usual() } else { wishes.methods.clone() };
            Subject { origin, methods }
        };
        Suite { subjects: origins.into_iter().map(subject).collect(), budget: size.budget() }
    }

    /// Every family in the order in which the bench comes to it.
    pub fn families(&self) -> Vec<String> {
        let families: Vec<String> = self.subjects.iter().flat_map(|s| &s.methods).map(|m| family::of(m)).collect();
        family::in_order(families.iter().map(String::as_str))
    }

    /// How many rows that makes.
    pub fn rows(&self) -> usize {
        self.subjects.iter().map(|s| s.methods.len()).sum()
    }
}

impl Subject {
    /// What the measurement of each method may take, s, the matrix counted with the first, and then its pictures: a guess from two cores that the
    /// run corrects.
    pub fn guesses(&self, shown: bool) -> Vec<f64> {
        let [matrix, method, pictures] = match self.origin.kind() {
            Kind::Biscale => [1.0, 1.1, 4.0],
            Kind::Terms => [3.0, 1.1, 4.0],
            Kind::Diffuse => [1.0, 0.5, 10.0],
            Kind::Other => [1.0, 0.5, 0.0],
            Kind::Glossy => [0.5, 0.4, 5.0],
            Kind::Field => [3.0, 0.9, 6.0],
        };
        let scale = match &self.origin {
            Origin::Scene { vertices: Some(vertices), .. } => (*vertices as f64 / 400.0).max(0.5),
            _ => 1.0,
        };
        let mut guesses = vec![scale * method; self.methods.len()];
        guesses.iter_mut().take(1).for_each(|first| *first += scale * matrix);
        guesses.extend(shown.then_some(scale * pictures));
        guesses
    }
}

impl Origin {
    /// What its matrix will hold; a file may hold anything.
    pub fn kind(&self) -> Kind {
        match self {
            Origin::Scene { spec, .. } => match spec.signal {
                Signal::Biscale => Kind::Biscale,
                Signal::Diffuse => Kind::Diffuse,
                Signal::Glossy => Kind::Glossy,
                Signal::Terms => Kind::Terms,
            },
            Origin::Field { .. } => Kind::Field,
            Origin::Matrix(_) => Kind::Other,
        }
    }
}

impl Size {
    /// Vertices of built-in scenes, about.
    fn vertices(self) -> usize {
        match self {
            Size::Quick => 150,
            Size::Standard => 400,
            Size::Full => 3000,
        }
    }

    fn budget(self) -> Duration {
        Duration::from_millis(match self {
            Size::Quick | Size::Standard => 30,
            Size::Full => 500,
        })
    }

    /// What is precomputed of a scene.
    fn spec(self, signal: Signal) -> Spec {
        let resolution = if self == Size::Quick { 16 } else { 32 };
        let basis = match signal {
            Signal::Glossy => signal.usual_basis(),
            _ => LightBasis::Cubemap { resolution },
        };
        let terms = if self == Size::Full { Terms::Count(16) } else { Terms::Count(8) };
        Spec { terms, ..Spec::new(signal, basis) }
    }

    /// A small field: tracing must not take longer than all methods together.
    fn field(self) -> FieldParams {
        let (edge, around) = match self {
            Size::Quick => (16, 16),
            Size::Standard => (48, 32),
            Size::Full => (128, 64),
        };
        let frame = Directions::Reflected;
        FieldParams { width: edge, height: edge, around, down: around / 2, frame, ..FieldParams::default() }
    }

    /// The usual matrices, of these signals where any are given.
    fn origins(self, signals: &[Signal]) -> Vec<Origin> {
        let scenes: &[(&str, &[Signal])] = match self {
            Size::Quick => &QUICK_SCENES,
            Size::Standard => &SCENES,
            Size::Full => &FULL_SCENES,
        };
        let wanted = |signal: &&Signal| signals.is_empty() || signals.contains(signal);
        let of = |(scene, usual): &(&str, &[Signal])| -> Vec<Origin> {
            usual.iter().filter(wanted).map(|&signal| self.scene(scene, signal, Up::Z)).collect()
        };
        let mut origins: Vec<Origin> = scenes.iter().flat_map(of).collect();
        if signals.is_empty() {
            origins.push(self.world(FIELD.0, FIELD.1));
        }
        origins
    }

    /// The signals of a scene of the user's; a matrix file as it is.
    fn origins_of(self, scene: &str, wishes: &Wishes) -> Vec<Origin> {
        let path = Path::new(scene);
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        if ["npz", "npy", "mtx"].contains(&extension.as_str()) {
            return vec![Origin::Matrix(path.into())];
        }
        if let Some((world, shape)) = scene.split_once('/').filter(|(world, _)| worlds::is_built_in(world)) {
            return vec![self.world(world, shape)];
        }
        // All terms of a large mesh are gigabytes: whoever wants them says so.
        let usual = if extension.is_empty() { &Signal::ALL[..] } else { &MESH_SIGNALS };
        let signals = if wishes.signals.is_empty() { usual } else { &wishes.signals };
        signals.iter().map(|&signal| self.scene(scene, signal, wishes.up)).collect()
    }

    fn scene(self, scene: &str, signal: Signal, up: Up) -> Origin {
        let built_in = Path::new(scene).extension().is_none();
        let (vertices, up) = if built_in { (Some(self.vertices()), Up::Z) } else { (None, up) };
        Origin::Scene { scene: scene.into(), vertices, up, spec: self.spec(signal) }
    }

    fn world(self, world: &str, shape: &str) -> Origin {
        Origin::Field { world: world.into(), shape: shape.into(), params: self.field() }
    }

    /// The points of all families, each once.
    fn methods(self, families: &[Family]) -> Vec<String> {
        let mut methods: Vec<String> = Vec::new();
        for family in families {
            let points: &[&[&str]] = match self {
                Size::Quick => &[family.quick],
                Size::Standard => &[family.quick, family.standard],
                Size::Full => &[family.quick, family.standard, family.full],
            };
            let alone = [family.base];
            let named = !family.is_alone();
            let points = points.concat();
            for point in if named { &points[..] } else { &alone[..] } {
                if !methods.iter().any(|m| m == point) {
                    methods.push(point.to_string());
                }
            }
        }
        methods
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::registry;
    use prt_transfer::Label;

    #[test]
    fn every_label_of_every_suite_is_in_its_shortest_form_and_there_once() {
        for size in [Size::Quick, Size::Standard, Size::Full] {
            for Subject { methods, .. } in Suite::new(size, &Wishes::default(), &registry()).subjects {
                for (i, method) in methods.iter().enumerate() {
                    let label: Label = method.parse().unwrap();
                    assert_eq!(&registry().method(&label).unwrap().label().to_string(), method);
                    assert!(!methods[..i].contains(method), "{method}");
                }
                assert!(methods.iter().any(|m| m == "csr"), "the exact reference");
            }
        }
    }

    #[test]
    fn every_registered_codec_is_measured_on_some_matrix_and_each_only_where_it_fits() {
        let registry = registry();
        let suite = Suite::new(Size::Standard, &Wishes::default(), &registry);
        let measured = |codec: &str| -> Vec<Kind> {
            let names = |s: &&Subject| s.methods.iter().any(|m| m.parse::<Label>().unwrap().codec.name == codec);
            suite.subjects.iter().filter(names).map(|s| s.origin.kind()).collect()
        };
        for codec in registry.codecs() {
            assert!(!measured(codec.name).is_empty(), "{}", codec.name);
        }
        assert!(measured("visibility").iter().all(|kind| *kind == Kind::Biscale));
        assert_eq!(measured("slf"), [Kind::Field]);
        assert!(!measured("cpca").contains(&Kind::Biscale));
    }

    #[test]
    fn a_scene_of_the_user_replaces_the_usual_ones_and_a_matrix_needs_no_signal() {
        let scenes = ["bunny.ply", "T.NPZ", "cornell-spheres/torus"].map(String::from);
        let wishes = Wishes { scenes: scenes.into(), methods: vec!["csr".into()], ..Wishes::default() };
        let Suite { subjects, .. } = Suite::new(Size::Quick, &wishes, &registry());
        assert!(subjects.iter().all(|subject| subject.methods == ["csr"]));
        assert_eq!(subjects.len(), 5, "three signals of the mesh");
        assert_eq!(subjects[3].origin, Origin::Matrix("T.NPZ".into()));
        let Origin::Scene { vertices: None, .. } = &subjects[0].origin else { panic!("a mesh keeps its vertices") };
        let Origin::Field { world, shape, .. } = &subjects[4].origin else { panic!("a world's shape is a field") };
        assert_eq!((world.as_str(), shape.as_str()), ("cornell-spheres", "torus"));
    }

    #[test]
    fn only_the_signals_that_are_asked_for_are_precomputed() {
        let wishes = Wishes { signals: vec![Signal::Glossy], ..Wishes::default() };
        let Suite { subjects, .. } = Suite::new(Size::Standard, &wishes, &registry());
        assert!(subjects.len() == 2 && subjects.iter().all(|s| s.origin.kind() == Kind::Glossy));
    }
}
