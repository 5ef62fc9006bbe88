//! pictures.csv: the figures of all pictures.

use crate::bench::Group;
use crate::files;
use crate::machine::Machine;
use serde::Serialize;
use std::path::Path;

/// A line of the file. The names are a promise to programs that read them.
#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    signal: &'a str,
    light: &'a str,
    budget_bytes: u64,
    method: &'a str,
    family: &'a str,
    file_bytes: u64,
    resident_bytes: u64,
    relative_squared_error: f64,
    psnr_db: Option<f64>,
    flip: f64,
    flicker: Option<f64>,
    machine: &'a str,
}

/// Writes the figures of the pictures of each group beside its PNGs, in a bench's folder; no file where there is none.
pub fn write_csv(groups: &[Group], out: &Path, machine: &Machine) -> anyhow::Result<()> {
    if groups.iter().all(|group| group.pictures.is_empty()) {
        return Ok(());
    }
    Ok(files::write_beside(&out.join("pictures").join("pictures.csv"), &csv(groups, machine)?)?)
}

fn csv(groups: &[Group], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let machine = machine.line();
    let mut writer = csv::Writer::from_writer(Vec::new());
    for group in groups {
        let (scene, signal) = group.rows.first().map_or(("", ""), |row| (&row.scene, &row.signal));
        for under in &group.pictures {
            for shown in &under.shown {
                writer.serialize(Line {
                    scene,
                    signal,
                    light: &under.light,
                    budget_bytes: under.budget_bytes,
                    method: &shown.method,
                    family: &shown.family,
                    file_bytes: shown.file_bytes,
                    resident_bytes: shown.resident_bytes,
                    relative_squared_error: shown.relative_squared_error,
                    psnr_db: shown.psnr_db,
                    flip: shown.flip,
                    flicker: shown.flicker,
                    machine: &machine,
                })?;
            }
        }
    }
    Ok(writer.into_inner()?)
}
