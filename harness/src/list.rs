//! `prt scenes` and `prt methods`: what there is.

use crate::registry::registry;
use crate::{lights, limits, number, scenes, terminal, worlds};
use clap::Args;
use prt_transfer::method::About;
use prt_transfer::scene::brdf::Brdf;
use serde_json::{Value, json};

/// Arguments of `prt scenes`.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  prt scenes --json")]
pub struct Scenes {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `prt methods`.
#[derive(Args, Debug)]
#[command(
    after_help = "A label joins a light transform and a codec, each with the parameters that differ from their defaults:\n  haar+truncate:terms=64\n\nExamples:\n  prt methods --json\n  prt methods --limits 16GB"
)]
pub struct Methods {
    /// Tell instead how large a matrix each family of methods takes in so much memory, on the threads of --threads
    #[arg(long, value_name = "BYTES", value_parser = number::parse_bytes)]
    pub limits: Option<u64>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Runs `prt scenes`.
pub fn scenes(arguments: &Scenes) -> anyhow::Result<()> {
    let (scenes, worlds, lights, brdfs) = (scenes::scenes(), worlds::built_in(), lights::all(), Brdf::all());
    if arguments.json {
        let brdfs = brdfs.iter().map(stage).collect::<Vec<_>>();
        return terminal::say_json(&json!({ "scenes": scenes, "worlds": worlds, "lights": lights, "brdfs": brdfs }));
    }
    let mut lines = Vec::new();
    for (title, list) in
        [("Scenes", scenes), ("Worlds (shapes, materials and lights: for slf and render)", worlds), ("Lights", lights)]
    {
        lines.push(title.to_string());
        lines.extend(list.iter().map(|a| format!("  {:<16}{}", a.name, a.about)));
    }
    lines.push("BRDFs".into());
    brdfs.iter().for_each(|brdf| lines.extend(described(brdf)));
    terminal::say(lines.join("\n"))
}

/// Runs `prt methods`.
pub fn methods(arguments: &Methods) -> anyhow::Result<()> {
    let registry = registry();
    if let Some(memory) = arguments.limits {
        let limits = limits::of(&registry, memory)?;
        return if arguments.json { terminal::say_json(&limits) } else { terminal::say(limits::text(&limits, memory)) };
    }
    let (transforms, codecs) = (registry.transforms(), registry.codecs());
    if arguments.json {
        let list = |list: &[About]| list.iter().map(stage).collect::<Vec<_>>();
        return terminal::say_json(&json!({ "transforms": list(&transforms), "codecs": list(&codecs) }));
    }
    let mut lines = Vec::new();
    for (title, list) in [("Light transforms", transforms), ("Codecs", codecs)] {
        lines.push(title.to_string());
        list.iter().for_each(|about| lines.extend(described(about)));
    }
    terminal::say(lines.join("\n"))
}

/// A stage or model and its parameters, a line each.
fn described(About { name, about, fields }: &About) -> impl Iterator<Item = String> {
    let parameters = fields.iter().map(|f| format!("    {}={}  {}", f.name, f.default, f.doc.trim()));
    std::iter::once(format!("  {name:<14}{about}")).chain(parameters)
}

fn stage(about: &About) -> Value {
    let fields = about.fields.iter().map(|f| json!({ "name": f.name, "default": f.default, "about": f.doc.trim() }));
    json!({ "name": about.name, "about": about.about, "parameters": fields.collect::<Vec<_>>() })
}
