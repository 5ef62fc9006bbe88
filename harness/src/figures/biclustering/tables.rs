//! A table: every method on every scene, each scene's printed figures above it.

use super::quantity::{Measured, QUANTITIES, cells, printed};
use super::scenes::{Scene, Table};
use super::{methods, spec};
use crate::figures::Drawing;
use crate::figures::stage::{Mesh, Stage, Subject};
use crate::labels::BASELINE;
use crate::row::Row;
use crate::tables::beside::{Beside, Line};

pub(super) fn draw(stage: &Stage, table: &'static Table) -> anyhow::Result<Drawing> {
    let methods = methods(stage)?;
    let is_chosen =
        |name: &&Scene| stage.chosen.scenes.is_empty() || stage.chosen.scenes.iter().any(|s| s == name.name);
    let mut lines = Vec::new();
    for scene in table.scenes.iter().filter(is_chosen) {
        if !scene.printed.is_empty() {
            lines.push(Line::printed(scene.name, printed(scene.printed)));
        }
        lines.extend(ours(stage, table, scene, &methods)?);
    }
    // None of its scenes was asked for.
    let beside = Some(beside(table, lines)).filter(|beside| !beside.lines.is_empty());
    Ok(Drawing { beside: beside.into_iter().collect(), ..Drawing::default() })
}

pub(super) fn beside(table: &'static Table, lines: Vec<Line>) -> Beside {
    let columns = QUANTITIES.map(|quantity| quantity.column).into();
    let (title, why) = (table.title.into(), table.why);
    Beside { addition: "", title, subjects: Vec::new(), head: "scene", columns, lines, why }
}

fn ours(stage: &Stage, table: &Table, scene: &'static Scene, methods: &[String]) -> anyhow::Result<Vec<Line>> {
    let Some(mesh) = &scene.mesh else {
        let reason = "the paper's model was not published, and no other mesh stands in for it";
        return Ok(vec![Line::ours(scene.name, (scene.name, ""), Err(reason.into()))]);
    };
    match subject(stage, table, mesh) {
        Ok(subject) => Ok(measured(&subject.name(), &stage.rows(&subject, methods)?)),
        Err(error) => Ok(vec![Line::ours(scene.name, (scene.name, ""), Err(format!("{error:#}")))]),
    }
}

/// A mesh, or a built-in scene: as large as the paper's, or so that the table's first has as many vertices as the user wants.
fn subject(stage: &Stage, table: &Table, mesh: &Mesh) -> anyhow::Result<Subject> {
    let (scene, wanted, up) = stage.place(mesh);
    let first = table.scenes.iter().find_map(|scene| scene.mesh).map_or(1, |mesh| mesh.vertices);
    let scaled = |n: usize| if stage.is_paper_sized() { n } else { (n * mesh.vertices).div_ceil(first) };
    stage.computed((scene, wanted.map(scaled), up), &spec())
}

/// A line for each method.
pub(super) fn measured(name: &str, rows: &[Row]) -> Vec<Line> {
    let baseline = rows.iter().find(|row| row.method == BASELINE && row.is_ok());
    let of = |row: &Row| {
        let cells = if row.is_ok() { Ok(cells(Measured { row, baseline })) } else { Err(row.reason.clone()) };
        Line::ours(format!("{name}, {}", row.method), (name, row.method.as_str()), cells)
    };
    rows.iter().map(of).collect()
}
