//! `prt coherence`: the clusters of a compressed matrix, rearranged so that fewer triangles straddle them.

use crate::files::{self, Description};
use crate::interrupt::Unseen;
use crate::precompute::count;
use crate::registry::registry;
use crate::scenes::{self, Up};
use crate::{number, table, terminal};
use clap::Args;
use prt_cpca::coherence::{Optimised, Overdraw, clusters_by_registers, optimise, squared_error};
use prt_cpca::{EncodedCpca, Model};
use prt_transfer::{Compressed, Encoded, Error, Registry, Restore, Result, Sink, Source};
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `prt coherence`.
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  prt coherence bunny.prt --matrix bunny.npz --mesh bunny.ply --up y --budget 0.05 -o coherent.prt\n\nThe table is that of section 7 of Sloan et al. 2003: overdraw is how often a triangle is drawn on average where each cluster draws all that it has a vertex in; rec moves samples to clusters of their neighbours, sc draws several clusters at once."
)]
pub struct Coherence {
    /// Compressed matrix, by vq, pca or cpca without a light transform
    #[arg(value_name = "FILE.prt")]
    pub input: PathBuf,
    /// The transfer matrix that it came from: .npz, .npy or .mtx
    #[arg(long)]
    pub matrix: PathBuf,
    /// The mesh whose vertices are the samples (.ply, .obj), or a built-in scene
    #[arg(long, value_name = "SCENE|MESH")]
    pub mesh: String,
    /// Vertices of a built-in scene, as in prt precompute
    #[arg(long, value_name = "N", value_parser = count(1, 100_000_000))]
    pub vertices: Option<usize>,
    /// The axis of a mesh file that points up
    #[arg(long, value_name = "AXIS", default_value = "z")]
    pub up: Up,
    /// What moving samples may add to the squared error (of coefficients), as a fraction of it
    #[arg(long, value_name = "FRACTION", default_value_t = 0.05)]
    pub budget: f64,
    /// Clusters that are drawn at once at most [default: as many as registers hold]
    #[arg(long, value_name = "N", value_parser = count(1, 65_536))]
    pub members: Option<usize>,
    /// Registers of four channels that hold the constants of the clusters that are drawn at once
    #[arg(long, value_name = "N", value_parser = count(1, 1 << 20), default_value = "256", conflicts_with = "members")]
    pub registers: usize,
    /// Where to write the compressed matrix with its new clusters and their superclusters
    #[arg(short, long, value_name = "OUT.prt")]
    pub output: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// A column of the paper's table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Figures {
    /// How often a triangle is drawn on average.
    overdraw: f64,
    /// How often all triangles are drawn together.
    triangles_drawn: u64,
    /// Over all samples, in coefficients of the matrix.
    squared_error: f64,
    /// What of it has been added, as a fraction of the original's.
    error_increase: f64,
}

/// What is printed. The names are a promise to programs that read them.
#[derive(Clone, Debug, Serialize)]
struct Told {
    /// The method.
    label: String,
    samples: usize,
    triangles: usize,
    /// Of the compressed matrix as it came.
    clusters: usize,
    /// That have lost their last member.
    clusters_dropped: usize,
    samples_moved: usize,
    budget: f64,
    /// Clusters of a supercluster at most.
    members: usize,
    /// Of the reclassified matrix.
    superclusters: usize,
    original: Figures,
    rec: Figures,
    sc: Figures,
    sc_rec: Figures,
}

/// Runs the command.
pub fn run(arguments: &Coherence) -> anyhow::Result<()> {
    if let Some(output) = &arguments.output {
        files::expect_extension(output, "prt")?;
    }
    let registry = registry();
    let compressed = files::read_prt(&arguments.input, &registry)?;
    let Clustered { model, store } = clustered(&compressed, &registry)?;
    let description =
        Description { responses: Some(compressed.responses().clone()), basis: Some(compressed.basis().clone()) };
    let matrix = files::read_matrix(&arguments.matrix, &description)?;
    let triangles = triangles(arguments, compressed.shape().samples)?;
    let members = members(arguments, &model)?;
    let found = optimise(&model, &matrix, &triangles, arguments.budget, members)?;
    let (result, as_stored) = store(&found)?;
    let error = squared_error(&as_stored, &matrix)?;
    if let Some(output) = &arguments.output {
        files::write_prt(output, &result, &Unseen)?;
    }
    let told = Told::new(&compressed.label().to_string(), &model, &found, error, (arguments.budget, members));
    if arguments.json { terminal::say_json(&told) } else { terminal::say(told.text()) }
}

/// The triangles of the mesh, whose vertices must be as many as there are samples.
fn triangles(arguments: &Coherence, samples: usize) -> Result<Vec<[u32; 3]>> {
    let (mesh, _) = scenes::load(&arguments.mesh, arguments.vertices, arguments.up)?;
    let what = format!("vertices of {}, one for each sample of the matrix", arguments.mesh);
    Error::expect_size(what, samples, mesh.positions.len())?;
    Ok(mesh.faces)
}

/// The most clusters of a supercluster: what is asked for, or what registers hold.
fn members(arguments: &Coherence, model: &Model) -> anyhow::Result<usize> {
    if let Some(members) = arguments.members {
        return Ok(members);
    }
    let components = (0..model.clusters.len()).map(|cluster| model.components(cluster)).max().unwrap_or(0);
    let (registers, responses) = (arguments.registers, model.shape.responses);
    match clusters_by_registers(registers, components, responses) {
        0 => {
            anyhow::bail!("{registers} registers hold no cluster of {components} components and {responses} responses")
        }
        members => Ok(members),
    }
}

/// The clusters of a compressed matrix, and the way back.
struct Clustered<'a> {
    model: Model,
    store: Box<Store<'a>>,
}

/// Compresses what was found as the matrix was compressed, and says what the model is as it is stored.
type Store<'a> = dyn Fn(&Optimised) -> Result<(Compressed, Model)> + 'a;

/// Takes a compressed matrix apart.
///
/// # Errors
/// Another method than vq, pca or cpca on the matrix itself: components of transformed columns are not those of its
/// samples.
fn clustered<'a>(compressed: &'a Compressed, registry: &'a Registry) -> Result<Clustered<'a>> {
    let label = compressed.label();
    if label.transform.name != "identity" || !["vq", "pca", "cpca"].contains(&label.codec.name.as_str()) {
        return Err(Error::Unsupported {
            what: "coherence of a compressed matrix".into(),
            expected: "vq, pca or cpca without a light transform".into(),
            found: label.to_string(),
        });
    }
    let encoded = EncodedCpca::read(compressed.shape(), &mut Source::new(compressed.sections().into_sections())?)?;
    let [weights, representatives] = encoded.widths();
    let store = move |found: &Optimised| {
        let stored = EncodedCpca::store(&found.model, weights, representatives);
        let model = stored.model();
        let (stored, mut sink) = (stored.with_superclusters(found.superclusters.clone())?, Sink::new());
        stored.write(&mut sink);
        Ok((registry.restore(&compressed.header(), sink.into_sections())?, model))
    };
    Ok(Clustered { model: encoded.model(), store: Box::new(store) })
}

impl Told {
    /// `error` is the squared error of the result as it is stored.
    fn new(label: &str, model: &Model, found: &Optimised, error: f64, (budget, members): (f64, usize)) -> Told {
        let (report, initial) = (&found.report, found.report.initial_error);
        let figures = |overdraw: Overdraw, squared_error: f64| Figures {
            overdraw: overdraw.factor(),
            triangles_drawn: overdraw.total,
            squared_error,
            error_increase: if squared_error == initial { 0.0 } else { squared_error / initial - 1.0 },
        };
        Told {
            label: label.into(),
            samples: model.shape.samples,
            triangles: report.original.triangles,
            clusters: model.clusters.len(),
            clusters_dropped: report.dropped,
            samples_moved: report.moved,
            budget,
            members,
            superclusters: found.superclusters.iter().max().map_or(0, |&last| last as usize + 1),
            original: figures(report.original, initial),
            rec: figures(report.reclassified, error),
            sc: figures(found.superclustered, initial),
            sc_rec: figures(found.both, error),
        }
    }

    /// For a person: the paper's table.
    fn text(&self) -> String {
        let columns = [self.original, self.rec, self.sc, self.sc_rec];
        let line = |name: &str, figure: fn(Figures) -> String| {
            std::iter::once(name.to_string()).chain(columns.map(figure)).collect::<Vec<_>>()
        };
        let lines = [
            line("overdraw", |f| format!("{:.3}", f.overdraw)),
            line("triangles drawn", |f| number::count(f.triangles_drawn)),
            line("squared error", |f| number::short(f.squared_error)),
            line("error increase", |f| format!("{:+.2} %", 100.0 * f.error_increase)),
        ];
        let Told { samples, samples_moved, clusters, clusters_dropped, superclusters, members, .. } = self;
        let rest = clusters - clusters_dropped;
        format!(
            "{}\n{samples_moved} of {samples} samples moved; {rest} of {clusters} clusters remain, \
             in {superclusters} superclusters of at most {members}",
            table::aligned(&["", "original", "rec", "sc", "sc+rec"], lines.into_iter())
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use prt_cpca::Cluster;
    use prt_transfer::{LightBasis, TransferMatrix};

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        coherence: Coherence,
    }

    fn arguments(more: &[&str]) -> Coherence {
        let usual = ["coherence", "T.prt", "--matrix", "T.npz", "--mesh", "teapot", "--vertices", "200"];
        Line::try_parse_from(usual.iter().chain(more)).unwrap().coherence
    }

    /// Constant clusters on a smooth signal, their borders ragged.
    fn ragged(samples: usize) -> (Model, TransferMatrix) {
        let level = |sample: usize| (sample * 6 / samples) as f32;
        let values: Vec<f32> = (0..samples).flat_map(|s| [level(s) + 0.5, s as f32 * 0.01]).collect();
        let matrix = TransferMatrix::from_dense(values, samples, 1, LightBasis::Plain { lights: 2 }).unwrap();
        let cluster = |k: usize| Cluster { mean: vec![k as f32, 1.0], components: vec![0.0, 1.0] };
        let stray = |s: usize| u32::from(s.is_multiple_of(5) && s * 6 / samples > 0);
        let members = (0..samples).map(|s| (s * 6 / samples) as u32 - stray(s)).collect();
        let weights = (0..samples).map(|s| s as f32 * 0.01 - 1.0).collect();
        (Model { shape: matrix.shape(), clusters: (0..6).map(cluster).collect(), members, weights }, matrix)
    }

    #[test]
    fn the_table_says_what_was_found_and_orders_as_the_paper_s() {
        let mesh = scenes::load("teapot", Some(200), Up::Z).unwrap().0;
        let samples = mesh.positions.len();
        let arguments = arguments(&["--budget", "0.2"]);
        assert_eq!(triangles(&arguments, samples).unwrap(), mesh.faces);
        let (model, matrix) = ragged(samples);
        let members = members(&arguments, &model).unwrap();
        assert_eq!(members, 128);
        let found = optimise(&model, &matrix, &mesh.faces, arguments.budget, 2).unwrap();
        let error = squared_error(&found.model, &matrix).unwrap();
        let told = Told::new("cpca", &model, &found, error, (arguments.budget, 2));
        let [original, rec, sc, both] = [told.original, told.rec, told.sc, told.sc_rec].map(|f| f.overdraw);
        assert!(original > rec && original > sc && rec > both && both >= 1.0, "{original} {rec} {sc} {both}");
        assert!((-1.0..=0.2).contains(&told.rec.error_increase) && told.sc.error_increase == 0.0);
        assert_eq!(told.original.triangles_drawn as f64, original * told.triangles as f64);
        let text = told.text();
        let lines: Vec<&str> = text.lines().collect();
        let words = |line: &str| line.split_whitespace().map(str::to_string).collect::<Vec<_>>();
        assert_eq!(words(lines[0]), ["original", "rec", "sc", "sc+rec"]);
        let printed = [original, rec, sc, both].map(|overdraw| format!("{overdraw:.3}"));
        assert_eq!(words(lines[2])[1..], printed, "{text}");
        let json = serde_json::to_value(&told).unwrap();
        assert_eq!(json["sc_rec"]["overdraw"], both);
    }

    #[test]
    fn another_mesh_and_too_few_registers_are_refused_with_their_numbers() {
        let samples = scenes::load("teapot", Some(200), Up::Z).unwrap().0.positions.len();
        let refused = triangles(&arguments(&[]), samples + 1).unwrap_err().to_string();
        assert!(
            refused.contains("teapot") && refused.contains(&format!("{}, found {samples}", samples + 1)),
            "{refused}"
        );
        let (model, _) = ragged(20);
        let refused = members(&arguments(&["--registers", "1"]), &model).unwrap_err().to_string();
        assert_eq!(refused, "1 registers hold no cluster of 1 components and 1 responses");
        assert_eq!(members(&arguments(&["--members", "3"]), &model).unwrap(), 3);
        assert!(Line::try_parse_from(["coherence", "T.prt", "--members", "3", "--registers", "9"]).is_err());
    }

    #[test]
    fn a_method_without_clusters_is_refused_by_name() {
        let (_, matrix) = ragged(20);
        let compressed =
            crate::registry::method(&registry(), "csr").unwrap().encode(&matrix, &prt_transfer::Quiet).unwrap();
        let refused = clustered(&compressed, &registry()).err().unwrap().to_string();
        assert!(refused.contains("csr") && refused.contains("vq, pca or cpca"), "{refused}");
    }
}
