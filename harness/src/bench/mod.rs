//! `prt bench`: every method on every scene, measured on what came back from its file.

mod album;
mod matched;
mod run;
mod selections;

use crate::assets::Assets;
use crate::cache;
use crate::charts;
use crate::forecast::Forecast;
use crate::lights::{LIGHTS, Light};
use crate::machine::Machine;
use crate::measure::{Bench as Measure, Pools};
use crate::pictures::{self, Pictures};
use crate::progress::Steps;
use crate::results::Results;
use crate::row::Row;
use crate::scenes::Up;
use crate::signal::Signal;
use crate::stability::{self, atlas::Atlas};
use crate::suite::{Size, Subject, Suite, Wishes};
use crate::timing::Budget;
use crate::verify::Verify;
use crate::{files, interrupt, labels, registry, report, scenes, table, terminal, worlds};
use anyhow::ensure;
use clap::Args;
use prt_transfer::{Error, Registry};
use run::Run;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Arguments of `prt bench`.
#[derive(Args, Debug)]
#[command(
    after_help = "A finished row is never measured twice: run the same command again to resume.\n\nExamples:\n  prt bench\n  prt bench --quick --out quick --verify\n  prt bench --scene bunny.ply --method csr --method haar+truncate:terms=64\n  prt bench --full --assets assets"
)]
pub struct Bench {
    /// A built-in scene, a shape of a built-in world (WORLD/SHAPE), a mesh (.ply, .obj) or a matrix (.npz, .npy, .mtx), instead of the usual scenes; may be repeated
    #[arg(long = "scene", value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// What is precomputed of scenes; may be repeated [default: all of built-in scenes; of a mesh all but terms, which can be gigabytes]
    #[arg(long = "signal", value_name = "SIGNAL", value_delimiter = ',')]
    pub signals: Vec<Signal>,
    /// Folder of meshes (.ply, .obj) and lights (.exr, .hdr): meshes in place of the usual scenes, unless --scene names others; lights for pictures
    #[arg(long, value_name = "DIR")]
    pub assets: Option<PathBuf>,
    /// The axis of mesh files that points up [default: z; y of those of --assets]
    #[arg(long, value_name = "AXIS")]
    pub up: Option<Up>,
    /// A method, instead of the usual ones; may be repeated
    #[arg(long = "method", value_name = "LABEL")]
    pub methods: Vec<String>,
    /// Half a minute: one small scene, few methods
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Every scene, denser, more parameters
    #[arg(long)]
    pub full: bool,
    /// Folder for results.csv, machine.json, charts, report.html and the compressed files
    #[arg(long, value_name = "DIR", default_value = "prt-bench")]
    pub out: PathBuf,
    /// Take no pictures
    #[arg(long, conflicts_with = "lights")]
    pub no_pictures: bool,
    /// Print the rows as one JSON array instead of tables
    #[arg(long)]
    pub json: bool,
    /// A light of the pictures, built in or a lat-long image (.exr, .hdr); may be repeated [default: sky; those of --assets]
    #[arg(long = "light", value_name = "LIGHT")]
    pub lights: Vec<String>,
    /// Verification by another program.
    #[command(flatten)]
    pub verify: Verify,
}

/// All rows of one matrix.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Group {
    /// Scene, signal and basis, for people.
    pub title: String,
    /// The same for file names.
    #[serde(skip)]
    pub file_name: String,
    /// One for each method, in the order of the suite.
    #[serde(serialize_with = "report::labelled")]
    pub rows: Vec<Row>,
    /// One for each light; empty where nothing is known of a scene.
    pub pictures: Vec<Pictures>,
}

/// Runs the command.
pub fn run(arguments: &Bench, threads: usize) -> anyhow::Result<()> {
    let registry = registry::registry();
    let assets = arguments.assets.as_deref().map_or_else(|| Ok(Assets::default()), Assets::read)?;
    let suite = suite(arguments, &assets, &registry)?;
    let lights = lights(&arguments.lights, &assets)?;
    let out = cache::make(arguments.out.clone())?;
    let machine = Machine::here(threads);
    files::write_beside(&out.join("machine.json"), &serde_json::to_vec_pretty(&machine)?)?;
    let pools = Pools::new(threads)?;
    let mut run = Run {
        measure: Measure { registry: &registry, pools: &pools, budget: Budget::of(suite.budget) },
        out: &out,
        results: Results::open(out.join("results.csv"))?,
        steps: Steps::new(suite.rows()),
        finished: 0,
        forecast: Forecast::new(
            suite.subjects.iter().flat_map(|subject| subject.guesses(!arguments.no_pictures)).collect(),
        ),
        given: !arguments.methods.is_empty(),
        shown: !arguments.no_pictures,
        lights,
    };
    let (mut groups, mut selections, families) = (Vec::new(), selections::read(&out)?, suite.families());
    for Subject { origin, methods } in &suite.subjects {
        let group = run.group(origin, methods);
        let (group, selection) = interrupt::keeping(group, || kept(&run, &suite))?;
        if !arguments.json {
            run.steps.suspend(|| terminal::say(table::of(&group)))?;
        }
        charts::draw(&group, &families, &cache::make(out.join("charts"))?, &machine)?;
        groups.push(group);
        selections.extend(selection);
    }
    let failures = atlas(arguments, &out.join("stability"), &machine, &run);
    let failures = interrupt::keeping(failures, || kept(&run, &suite))?;
    run.steps.finish();
    pictures::write_csv(&groups, &out, &machine)?;
    let data = report::Data { machine: machine.clone(), groups: groups.clone(), selections };
    let page = report::page(&data, failures.as_ref());
    files::write_beside(&out.join("report.html"), page.as_bytes())?;
    let rows: Vec<&Row> = groups.iter().flat_map(|g| &g.rows).collect();
    if arguments.json {
        terminal::say_json(&rows)?;
    } else {
        let (legend, machine) = (table::LEGEND, machine.line());
        terminal::say(format!("\n{legend}\n{machine}\nresults.csv, charts and report.html are in {}", out.display()))?;
    }
    // One failed method is a row; nothing but failures is a failure.
    ensure!(
        rows.iter().any(|row| row.is_ok()),
        "no method could be measured; {} says why",
        run.results.path().display()
    );
    match arguments.verify.verify {
        true => arguments.verify.run(&out, &groups, run.results.rows(), threads, arguments.json),
        false => Ok(()),
    }
}

/// Where methods fail, beside the usual suite: whoever asks for a scene or a method of his own asks for nothing else.
fn atlas(arguments: &Bench, out: &Path, machine: &Machine, run: &Run) -> anyhow::Result<Option<Atlas>> {
    let Bench { scenes, signals, assets, methods, quick, .. } = arguments;
    if *quick || assets.is_some() || ![scenes.len(), signals.len(), methods.len()].iter().all(|&given| given == 0) {
        return Ok(None);
    }
    stability::atlas::run::whole(out, machine, run.measure.pools, &run.steps).map(Some)
}

/// What an interruption leaves.
fn kept(run: &Run, suite: &Suite) -> String {
    let (finished, all, out) = (run.finished, suite.rows(), run.out.display());
    format!("{finished} of {all} rows are in {out}; the same command goes on from there")
}

/// The lights of the pictures, read before anything is measured.
fn lights(names: &[String], assets: &Assets) -> anyhow::Result<Vec<(String, Light)>> {
    let usual = [LIGHTS[0].to_string()];
    let names = [names, &assets.lights, &usual].into_iter().find(|names| !names.is_empty()).unwrap_or_default();
    names.iter().map(|name| Ok((name.clone(), Light::named(name)?))).collect()
}

/// Scene, signal, basis and shape of what rows measure, as far as they are known.
fn title_of(rows: &[Row]) -> String {
    let Some(row) = rows.first() else { return String::new() };
    let Row { scene, signal, basis, samples, responses, lights, .. } = row;
    let shape = if row.fingerprint.is_empty() { String::new() } else { format!("{samples} x {responses} x {lights}") };
    let parts = [scene, signal, basis, &shape].into_iter().filter(|part| !part.is_empty());
    parts.map(String::as_str).collect::<Vec<_>>().join(" · ")
}

/// The suite with the user's scenes and methods, all of them known: a slip of the keyboard should not cost minutes.
fn suite(arguments: &Bench, assets: &Assets, registry: &Registry) -> anyhow::Result<Suite> {
    for scene in &arguments.scenes {
        if Path::new(scene).extension().is_none() {
            known(scene)?;
        }
    }
    let methods = labels::shortest(registry, &arguments.methods)?;
    let size = match (arguments.quick, arguments.full) {
        (true, _) => Size::Quick,
        (_, true) => Size::Full,
        _ => Size::Standard,
    };
    let (scenes, usual_up) = match arguments.scenes.is_empty() {
        true => (assets.meshes.clone(), Up::Y),
        false => (arguments.scenes.clone(), Up::Z),
    };
    let (signals, up) = (arguments.signals.clone(), arguments.up.unwrap_or(usual_up));
    Ok(Suite::new(size, &Wishes { scenes, signals, methods, up }, registry))
}

/// Refuses the name of what is not built in: a scene, or WORLD/SHAPE.
fn known(scene: &str) -> prt_transfer::Result<()> {
    let name = scene.split_once('/').map_or(scene, |(world, _)| world);
    let (scenes, worlds) = (scenes::scenes(), worlds::built_in());
    let of = if name == scene { &scenes } else { &worlds };
    let names: Vec<&str> = of.iter().map(|about| about.name).collect();
    match names.contains(&name) {
        true => Ok(()),
        false => Err(Error::Unknown { what: "scene", name: scene.into(), known: names.join(", ") }),
    }
}
