//! report.html: charts, tables, pictures and selections in one page that needs nothing else.
//!
//! The tables are written here and are there without any script. What was measured lies in the page as JSON, of which a
//! few scripts (one noun each) draw the charts, filter and sort.

mod atlas;
mod data;
mod html;
mod quantity;
mod selections;
mod table;

pub(crate) use data::labelled;
pub use data::{Data, Selected, Selection};

use crate::charts::Marker;
use crate::stability::atlas::Atlas;
use html::{escape, fill, script};
use quantity::{Fields, Quantity, measured};
use serde::Serialize;

const PAGE: &str = include_str!("page.html");
const PICTURES: &str = include_str!("pictures.html");
const ATLAS: &str = include_str!("atlas.html");
const SELECTIONS: &str = include_str!("selections.html");
const STYLE: &str = include_str!("style.css");
const SCRIPTS: [&str; 20] = [
    include_str!("data.js"),
    include_str!("number.js"),
    include_str!("quantity.js"),
    include_str!("dom.js"),
    include_str!("state.js"),
    include_str!("points.js"),
    include_str!("frontier.js"),
    include_str!("axis.js"),
    include_str!("place.js"),
    include_str!("plane.js"),
    include_str!("chart.js"),
    include_str!("figure.js"),
    include_str!("tooltip.js"),
    include_str!("pointing.js"),
    include_str!("legend.js"),
    include_str!("controls.js"),
    include_str!("table.js"),
    include_str!("export.js"),
    include_str!("pictures.js"),
    include_str!("main.js"),
];

/// What the scripts find in the page.
#[derive(Serialize)]
struct Embedded<'a> {
    #[serde(flatten)]
    data: &'a Data,
    families: Vec<Family>,
    quantities: &'a [&'static Quantity],
    unsteady: f64,
}

/// A family and how it is drawn, here and on the charts beside the page.
#[derive(Serialize)]
struct Family {
    name: String,
    #[serde(flatten)]
    marker: Marker,
}

/// The page; with an atlas of failure where one was made.
pub fn page(data: &Data, failures: Option<&Atlas>) -> String {
    let names = data.families();
    let tables: String = data.groups.iter().enumerate().map(|(i, m)| table::table(i, m, &names)).collect();
    let families = names.into_iter().enumerate().map(|(i, name)| Family { name, marker: Marker::of(i) }).collect();
    let rows: Vec<Fields> = data.groups.iter().flat_map(|g| &g.rows).map(table::fields).collect();
    let quantities = measured(&rows);
    let embedded = Embedded { data, families, quantities: &quantities, unsteady: table::UNSTEADY };
    let json = serde_json::to_string(&embedded).expect("texts and numbers under names that are texts");
    let pictures = if data.groups.iter().any(|g| !g.pictures.is_empty()) { PICTURES } else { "" };
    let selections = match data.selections.as_slice() {
        [] => String::new(),
        some => fill(SELECTIONS, &[("tables", &selections::tables(some))]),
    };
    let values = [
        ("machine", &*escape(&data.machine.line())),
        ("date", &*escape(&data.machine.date)),
        ("style", STYLE),
        ("tables", &tables),
        ("pictures", pictures),
        ("selections", &selections),
        ("atlas", &failures.map_or(String::new(), |atlas| fill(ATLAS, &[("parts", &atlas::parts(atlas))]))),
        ("place", &place(data)),
        ("meanings", &meanings(&quantities)),
        ("data", &script(&json)),
        ("scripts", &SCRIPTS.join("\n")),
    ];
    fill(PAGE, &values)
}

/// Where it was measured, term by term.
fn place(data: &Data) -> String {
    let m = &data.machine;
    let threads = format!("{} of {} processors", m.threads, m.processors);
    let terms = [
        ("processor", &*m.cpu),
        ("threads", &threads),
        ("system", &m.system),
        ("compiler", m.compiler),
        ("program", &format!("prt {} {}", m.version, m.commit)),
        ("date", &m.date),
    ];
    terms.iter().map(|(term, text)| format!("<dt>{term}</dt><dd>{}</dd>\n", escape(text))).collect()
}

/// What the columns mean.
fn meanings(quantities: &[&Quantity]) -> String {
    let line = |q: &&Quantity| {
        let Quantity { key, head, axis, how, .. } = q;
        // The one figure that is no column of results.csv itself.
        let column = if *key == "flops" { "multiplications + additions" } else { key };
        let (head, axis, how) = (escape(head), escape(axis), escape(how));
        format!("<tr><th scope=\"row\">{head}</th><td><code>{column}</code></td><td>{axis}</td><td>{how}</td></tr>\n")
    };
    quantities.iter().map(line).collect()
}

#[cfg(test)]
mod tests;
