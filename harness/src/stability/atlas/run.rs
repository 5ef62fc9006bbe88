//! The command without a study, and what a bench asks for.

use super::{Atlas, chart, chosen, csv, measure, table};
use crate::machine::Machine;
use crate::measure::Pools;
use crate::progress::Steps;
use crate::{cache, files, terminal};
use anyhow::ensure;
use std::path::Path;

/// Cases of a part or of a name, or all of them: a table, and files in `out`.
pub(in crate::stability) fn run(names: &[String], out: &Path, threads: usize) -> anyhow::Result<()> {
    let chosen = chosen(names)?;
    let (out, machine, pools) = (cache::make(out.to_path_buf())?, Machine::here(threads), Pools::new(threads)?);
    let steps = Steps::new(0);
    let atlas = pools.everywhere(|| measure(chosen, &steps))?;
    steps.finish();
    write(&atlas, &out, &machine)?;
    terminal::say(table::text(&atlas))?;
    let (legend, machine) = (table::LEGEND, machine.line());
    terminal::say(format!(
        "\n{legend}\n{machine}\nstability.csv, stability.md and charts as .svg and .png are in {}",
        out.display()
    ))?;
    let broken = atlas.violated().count();
    ensure!(broken == 0, "{broken} of {} cases are beyond their bounds", atlas.outcomes().count());
    Ok(())
}

/// The whole atlas: of `out`, where this program has made it there; else it is made, and written there.
pub fn whole(out: &Path, machine: &Machine, pools: &Pools, steps: &Steps) -> anyhow::Result<Atlas> {
    let kept = std::fs::read(out.join(CSV)).ok().and_then(|bytes| csv::from_csv(&bytes, machine));
    if let Some(atlas) = kept {
        return Ok(atlas);
    }
    let chosen = chosen(&[])?;
    let atlas = pools.everywhere(|| measure(chosen, steps))?;
    write(&atlas, &cache::make(out.to_path_buf())?, machine)?;
    Ok(atlas)
}

const CSV: &str = "stability.csv";

fn write(atlas: &Atlas, out: &Path, machine: &Machine) -> anyhow::Result<()> {
    files::write_beside(&out.join(CSV), &csv::to_csv(atlas, machine)?)?;
    files::write_beside(&out.join("stability.md"), table::markdown(atlas, &machine.line()).as_bytes())?;
    for (part, outcomes) in &atlas.parts {
        let (path, chart) = (|extension| out.join(format!("{}.{extension}", part.name)), chart::chart(part, outcomes));
        files::write_beside(&path("svg"), chart.svg(Some(machine)).as_bytes())?;
        files::write_beside(&path("png"), &chart.png(machine)?)?;
    }
    Ok(())
}
