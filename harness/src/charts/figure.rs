//! Draws a chart: axes, frontier, reference line, markers, labels, legend.

use super::axis::LogAxis;
use super::pen::{self, FAINT, INK, SMALL, line, machine_line, marker, poly_line, rectangle, text};
use super::place::{self, Box2};
use super::style::Style;
use super::{Chart, Point};
use crate::machine::Machine;
use kuva::render::render::{Scene, TextAnchor};

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 600.0;
/// The plot's frame.
const FRAME: Box2 = Box2 { left: 76.0, top: 92.0, right: 756.0, bottom: 510.0 };
/// The strip for methods without error: a logarithm has no place for 0.
const EXACT: f64 = 84.0;
/// Between the strip and the axis of what has an error.
const GAP: f64 = 12.0;

const STRIP: &str = "#f1f4f8";
const FRONTIER: &str = "#8a8a8a";

/// Where things are.
struct Frame<'a> {
    chart: &'a Chart,
    /// The log axis of errors, if any method has one.
    errors: Option<LogAxis>,
    costs: LogAxis,
    /// The left end of the log axis of errors.
    errors_from: f64,
}

/// The chart; with a line at the bottom that says where it was measured.
pub(super) fn scene(chart: &Chart, machine: Option<&Machine>) -> Scene {
    let frame = Frame::new(chart);
    let mut scene = pen::page(WIDTH, HEIGHT);
    frame.ground(&mut scene);
    frame.frontier(&mut scene);
    frame.reference(&mut scene);
    frame.points(&mut scene);
    frame.legend(&mut scene);
    text(&mut scene, (FRAME.left, 32.0), 18, INK, TextAnchor::Start, chart.cost.title);
    text(&mut scene, (FRAME.left, 54.0), 12, FAINT, TextAnchor::Start, &chart.subject);
    machine_line(&mut scene, FRAME.left, machine);
    scene
}

impl Frame<'_> {
    fn new(chart: &Chart) -> Frame<'_> {
        let exact = chart.points.iter().any(|p| p.error == 0.0);
        let errors_from = if exact { FRAME.left + EXACT + GAP } else { FRAME.left };
        let errors = || chart.points.iter().map(|p| p.error).filter(|&e| e > 0.0);
        let axis = errors().next().map(|_| LogAxis::new(errors(), errors_from, FRAME.right));
        let costs = LogAxis::new(chart.points.iter().map(|p| p.cost), FRAME.bottom, FRAME.top);
        Frame { chart, errors: axis, costs, errors_from }
    }

    /// A point's pixel: exact ones in the middle of their strip.
    fn place(&self, point: &Point) -> (f64, f64) {
        let x = match &self.errors {
            Some(axis) if point.error > 0.0 => axis.pixel(point.error),
            _ => FRAME.left + EXACT / 2.0,
        };
        (x, self.costs.pixel(point.cost))
    }

    /// Grid, strip, axes and their labels.
    fn ground(&self, scene: &mut Scene) {
        let exact = self.errors_from > FRAME.left;
        if exact {
            rectangle(scene, FRAME.left, FRAME.top, EXACT, FRAME.bottom - FRAME.top, STRIP);
            text(scene, (FRAME.left + EXACT / 2.0, FRAME.bottom + 20.0), 12, INK, TextAnchor::Middle, "exact");
        }
        pen::upright(scene, &self.costs, &FRAME);
        if let Some(errors) = &self.errors {
            pen::level(scene, errors, &Box2 { left: self.errors_from, ..FRAME });
        }
        if exact {
            // The axis is broken: the strip is no distance away from the smallest error.
            let strip = FRAME.left + EXACT;
            line(scene, (FRAME.left, FRAME.bottom), (strip, FRAME.bottom), INK, 1.0, None);
            for x in [strip, self.errors_from] {
                line(scene, (x - 3.0, FRAME.bottom + 6.0), (x + 3.0, FRAME.bottom - 6.0), INK, 1.0, None);
            }
        }
        text(scene, (FRAME.left, FRAME.top - 14.0), 12, INK, TextAnchor::Start, self.chart.cost.axis);
        let middle = (FRAME.left + FRAME.right) / 2.0;
        let title = "relative squared error of the transfer matrix";
        text(scene, (middle, FRAME.bottom + 44.0), 12, INK, TextAnchor::Middle, title);
    }

    /// The least cost at which each error can be had: level from a method to the next worse one, then down to it.
    fn steps(&self) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for &i in &self.chart.frontier {
            let (x, y) = self.place(&self.chart.points[i]);
            if let Some(&(_, above)) = points.last() {
                points.push((x, above));
            }
            points.push((x, y));
        }
        if let Some(&(_, last)) = points.last() {
            points.push((FRAME.right, last));
        }
        points
    }

    fn frontier(&self, scene: &mut Scene) {
        poly_line(scene, self.steps(), FRONTIER, 1.8);
    }

    /// The cost of the exact sparse matrix.
    fn reference(&self, scene: &mut Scene) {
        if let Some(y) = self.csr() {
            line(scene, (FRAME.left, y), (FRAME.right, y), INK, 1.0, Some("5,4"));
            text(scene, (FRAME.right - 4.0, y - 5.0), SMALL, INK, TextAnchor::End, "csr, exact");
        }
    }

    fn csr(&self) -> Option<f64> {
        let csr = self.chart.points.iter().find(|p| p.method == "csr")?;
        Some(self.costs.pixel(csr.cost))
    }

    fn points(&self, scene: &mut Scene) {
        let points = &self.chart.points;
        let places: Vec<(f64, f64)> = points.iter().map(|p| self.place(p)).collect();
        for (point, &(x, y)) in points.iter().zip(&places) {
            marker(scene, self.style(&point.family), x, y);
        }
        let texts: Vec<&str> = points.iter().map(|p| p.label.as_str()).collect();
        let lines = self.lines();
        let labels = place::labels(&places, &texts, SMALL.into(), FRAME, &lines);
        for (place, label) in labels.into_iter().zip(texts) {
            text(scene, place, SMALL, INK, TextAnchor::Start, label);
        }
    }

    /// What labels should not cover.
    fn lines(&self) -> Vec<Box2> {
        let box_of = |a: (f64, f64), b: (f64, f64)| Box2 {
            left: a.0.min(b.0) - 1.0,
            top: a.1.min(b.1) - 1.0,
            right: a.0.max(b.0) + 1.0,
            bottom: a.1.max(b.1) + 1.0,
        };
        let steps = self.steps();
        let mut lines: Vec<Box2> = steps.iter().zip(steps.iter().skip(1)).map(|(&a, &b)| box_of(a, b)).collect();
        if let Some(y) = self.csr() {
            lines.push(box_of((FRAME.left, y), (FRAME.right, y)));
            // The name of the line.
            lines.push(box_of((FRAME.right - 70.0, y - 16.0), (FRAME.right, y)));
        }
        lines
    }

    fn style(&self, family: &str) -> Style {
        Style::of(self.chart.families.iter().position(|f| f == family).unwrap_or_default())
    }

    fn legend(&self, scene: &mut Scene) {
        let left = FRAME.right + 24.0;
        let mut y = FRAME.top + 8.0;
        // Only what is on the chart.
        for family in self.chart.families.iter().filter(|f| self.chart.points.iter().any(|p| &p.family == *f)) {
            marker(scene, self.style(family), left + 9.0, y);
            text(scene, (left + 26.0, y + 4.0), 12, INK, TextAnchor::Start, family);
            y += 21.0;
        }
        let lines = [(FRONTIER, 1.8, None, "Pareto frontier"), (INK, 1.0, Some("5,4"), "exact reference")];
        let shown = if self.csr().is_some() { 2 } else { 1 };
        for (colour, width, dashes, name) in &lines[..shown] {
            line(scene, (left, y), (left + 18.0, y), colour, *width, *dashes);
            text(scene, (left + 26.0, y + 4.0), 12, INK, TextAnchor::Start, name);
            y += 21.0;
        }
        text(scene, (left, y + 12.0), SMALL, FAINT, TextAnchor::Start, "Better is left and down.");
    }
}
