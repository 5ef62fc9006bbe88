//! Relight speed, storage and encode time against error: one chart of each for every matrix.

mod axis;
pub mod curves;
mod figure;
mod grid;
mod marker;
pub mod panels;
mod pen;
mod place;
mod style;

pub use marker::Marker;

use crate::bench::Group;
use crate::family::distinction;
use crate::files;
use crate::frontier::frontier;
use crate::machine::Machine;
use crate::row::Row;
use kuva::RasterBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::render::Scene;
use std::path::Path;

/// What a method costs.
struct Cost {
    /// For file names.
    name: &'static str,
    title: &'static str,
    /// Quantity and unit.
    axis: &'static str,
    figure: fn(&Row) -> Option<f64>,
}

const COSTS: [Cost; 3] = [
    Cost {
        name: "speed",
        title: "Relight time against error",
        axis: "relighting one channel on one thread, ms (median)",
        figure: |r| r.relight_1_ms,
    },
    Cost {
        name: "storage",
        title: "Storage against error",
        axis: "resident storage, MB",
        figure: |r| r.resident_bytes.map(|b| b as f64 / 1e6),
    },
    Cost {
        name: "encode",
        title: "Encode time against error",
        axis: "encoding on all threads, s",
        figure: |r| r.encode_s,
    },
];

/// A method on a chart.
#[derive(Clone, Debug)]
pub struct Point {
    /// The whole label.
    pub method: String,
    /// Decides the marker.
    pub family: String,
    /// What is written beside the marker.
    pub label: String,
    /// Relative squared error; 0 is exact.
    pub error: f64,
    /// In the unit of the chart's axis.
    pub cost: f64,
    /// Whether no other method beats it.
    pub on_frontier: bool,
}

/// One chart, ready to be drawn.
pub struct Chart {
    cost: &'static Cost,
    subject: String,
    points: Vec<Point>,
    /// Every family of the bench in order, so that a family looks the same on all charts and in the report.
    families: Vec<String>,
    /// Indices of points, ascending in error.
    frontier: Vec<usize>,
}

/// The three charts of a matrix; none for a cost that no method has.
fn of(group: &Group, families: &[String]) -> Vec<Chart> {
    COSTS.iter().map(|cost| Chart::new(group, families, cost)).filter(|chart| !chart.points.is_empty()).collect()
}

/// Writes each chart of a matrix into `folder`: .svg, .png, and the points as .csv. A family's place decides its marker.
pub fn draw(group: &Group, families: &[String], folder: &Path, machine: &Machine) -> anyhow::Result<()> {
    for chart in of(group, families) {
        let path = |extension| folder.join(format!("{}-{}.{extension}", group.file_name, chart.cost.name));
        files::write_beside(&path("svg"), chart.svg(Some(machine)).as_bytes())?;
        files::write_beside(&path("png"), &chart.png(machine)?)?;
        files::write_beside(&path("csv"), &chart.csv(machine)?)?;
    }
    Ok(())
}

impl Chart {
    fn new(group: &Group, families: &[String], cost: &'static Cost) -> Chart {
        let mut points: Vec<Point> = group.rows.iter().filter_map(|row| point(row, cost)).collect();
        let frontier = frontier(&points.iter().map(|p| (p.error, p.cost)).collect::<Vec<_>>());
        frontier.iter().for_each(|&i| points[i].on_frontier = true);
        Chart { cost, subject: group.title.clone(), points, families: families.to_vec(), frontier }
    }

    /// As SVG; with a line that says where it was measured.
    pub fn svg(&self, machine: Option<&Machine>) -> String {
        svg(&figure::scene(self, machine))
    }

    /// As PNG of twice the SVG's size in pixels.
    pub fn png(&self, machine: &Machine) -> anyhow::Result<Vec<u8>> {
        png(&figure::scene(self, Some(machine)))
    }

    /// The points, with the machine in every line.
    fn csv(&self, machine: &Machine) -> anyhow::Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(["method", "family", "error", self.cost.axis, "on_frontier", "machine"])?;
        let machine = machine.line();
        for p in &self.points {
            let (error, cost) = (p.error.to_string(), p.cost.to_string());
            writer.write_record([&p.method, &p.family, &error, &cost, &p.on_frontier.to_string(), &machine])?;
        }
        Ok(writer.into_inner()?)
    }
}

fn svg(scene: &Scene) -> String {
    // Without a viewBox a browser that scales the picture would cut or pad it.
    let view_box = format!("<svg viewBox=\"0 0 {} {}\" ", scene.width, scene.height);
    SvgBackend.render_scene(scene).replacen("<svg ", &view_box, 1)
}

fn png(scene: &Scene) -> anyhow::Result<Vec<u8>> {
    RasterBackend::new().with_scale(2.0).render_scene(scene).map_err(anyhow::Error::msg)
}

/// A row's place on a chart; none where the figure is missing, or is no positive number for a logarithmic axis.
fn point(row: &Row, cost: &Cost) -> Option<Point> {
    let (error, cost) = (row.error?, (cost.figure)(row)?);
    let label = row.method.parse().map_or_else(|_| row.method.clone(), |label| distinction(&label));
    let drawable = row.is_ok() && error.is_finite() && cost.is_finite() && cost > 0.0;
    drawable.then(|| Point {
        method: row.method.clone(),
        family: row.family.clone(),
        label,
        error,
        cost,
        on_frontier: false,
    })
}

#[cfg(test)]
mod tests;
